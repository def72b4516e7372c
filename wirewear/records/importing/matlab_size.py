"""What a MATLAB file of version 5 to 7 would take in memory, found before it is read."""

import struct
import zlib
from pathlib import Path

from wirewear.base.budget import HARMLESS, MOST_EXPANSION, require_room
from wirewear.base.errors import RecordError

#: The head of a file, whose last four bytes say the version and how numbers are ordered.
_HEAD, _TAG = 128, 8
_ORDER = {b"\x00\x01IM": "<", b"\x01\x00MI": ">"}

#: Type of an element that holds another one compressed, and of one that holds an array.
_COMPRESSED, _MATRIX = 15, 14

#: Classes of arrays whose numbers are kept in as many bytes; others hold arrays of their own.
_BYTES = {6: 8, 7: 4, 8: 1, 9: 1, 10: 2, 11: 2, 12: 4, 13: 4, 14: 8, 15: 8}

#: What an array, a text or a structure within others takes, beside the bytes of the file: an object of its own.
INSIDE_OTHERS = 16

_CHUNK = 1 << 20


def require_room_for(path: Path) -> None:
    """See that a file's arrays can be held and can be true; what is no MATLAB file is left to the reader.

    Raises:
        RecordError: they cannot.
    """
    data = path.read_bytes()
    order = _ORDER.get(data[124:_HEAD])
    if order is None:
        return
    place, need = _HEAD, 0.0
    most = max(HARMLESS, MOST_EXPANSION * len(data))
    while place + _TAG <= len(data) and need <= most:
        kind, size = struct.unpack_from(f"{order}II", data, place)
        body = memoryview(data)[place + _TAG : place + _TAG + size]
        if kind == _COMPRESSED:
            head, whole = _inflated(body, most)
            need += _taken(head, whole, order)
        elif kind == _MATRIX:
            need += _taken(bytes(data[place : place + 256]), size, order)
        # Compressed elements stand without padding.
        place += _TAG + size
    require_room(path, need, RecordError)


def _inflated(body: memoryview, most: float) -> tuple[bytes, int]:
    """The first bytes of a compressed element and its whole size, counted no further than `most`."""
    inflater, head, whole = zlib.decompressobj(), b"", 0
    rest: bytes = bytes(body)
    while rest and not inflater.eof and whole <= most:
        part = inflater.decompress(rest, _CHUNK)
        rest = inflater.unconsumed_tail
        head = head or part[:256]
        whole += len(part)
        if not part:
            break
    return head, whole


def _taken(head: bytes, whole: int, order: str) -> float:
    """Bytes that an array takes: its dimensions by its class, or what its parts may at most."""
    try:
        kind = struct.unpack_from(f"{order}I", head, 16)[0] & 0xFF
        (length,) = struct.unpack_from(f"{order}I", head, 28)
        dimensions = struct.unpack_from(f"{order}{min(length // 4, 32)}i", head, 32)
    except struct.error:
        return float(whole)
    if kind not in _BYTES:
        return float(INSIDE_OTHERS * whole)
    count = 1.0
    for own in dimensions:
        count *= max(own, 0)
    # Read once in the bytes of the file, then once more as numbers of the record.
    return whole + (_BYTES[kind] + 8.0) * count
