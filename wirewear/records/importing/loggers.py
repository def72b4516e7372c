"""Readers of MATLAB's and LabVIEW's files, and the list of all readers, including those of installed packages.

A channel is one recorded signal; `layout` describes delimited text and has no effect in binary files.
"""

import re
import struct
import zlib
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from geometry.arrays import Array
from solvers.laws.plugins import by_name
from wirewear.base.delimited import DelimitedLayout
from wirewear.base.errors import RecordError, ended
from wirewear.base.files import is_special
from wirewear.base.hdf5 import require_self_contained
from wirewear.base.memory import HARMLESS, MOST_EXPANSION, require_room
from wirewear.base.words import nearest, shown
from wirewear.records.importing.text_reader import DAMAGED_FILE_ERRORS, Channel, Reader, TextReader, reason_of

#: The head of a file, whose last four bytes say the version and how numbers are ordered.
_HEAD, _TAG = 128, 8
_ORDER = {b"\x00\x01IM": "<", b"\x01\x00MI": ">"}

_COMPRESSED, _MATRIX = 15, 14  #: Type of an element that holds another one compressed, and of one that holds an array.

#: Classes of arrays whose numbers are kept in as many bytes; others hold arrays of their own.
_BYTES = {6: 8, 7: 4, 8: 1, 9: 1, 10: 2, 11: 2, 12: 4, 13: 4, 14: 8, 15: 8}


_CHUNK = 1 << 20

Wanted = Mapping[str, str | int]

MOST_CHANNELS = 12  #: A matrix with no more columns, or rows, than this may hold a channel in each.

#: A column ``hyst(:,2)`` or row ``hyst(2,:)`` of a matrix, spelled as in MATLAB.
_PART = re.compile(r"(.+)\((?::\s*,\s*(\d+)|(\d+)\s*,\s*:)\)")


#: Kinds of matrices in files of version 4 by the order of bytes: 1000 for big-endian, tens for the type of numbers.
_TYPES_OF_4 = {"<": range(0, 60, 10), ">": range(1000, 1060, 10)}

ENTRY_POINT_GROUP = "wirewear.readers"  #: Entry point group in which a package names its subclasses of `Reader`.


def require_room_for(path: Path) -> None:
    """Raise RecordError if the arrays of a MATLAB file are implausibly large or do not fit into memory; other files
    pass.
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
    """First bytes of a compressed element and its whole size, counted up to about `most` bytes."""
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
    """Memory in bytes that an array takes, from its dimensions and class, or an upper bound for nested ones."""
    try:
        kind = struct.unpack_from(f"{order}I", head, 16)[0] & 0xFF
        (length,) = struct.unpack_from(f"{order}I", head, 28)
        dimensions = struct.unpack_from(f"{order}{min(length // 4, 32)}i", head, 32)
    except struct.error:
        return float(whole)
    if kind not in _BYTES:
        # What an array, a text or a structure within others takes, beside the bytes of the file: an object of its own.
        return float(16 * whole)
    count = 1.0
    for own in dimensions:
        count *= max(own, 0)
    # Read once in the bytes of the file, then once more as numbers of the record.
    return whole + (_BYTES[kind] + 8.0) * count


class MatlabReader(Reader):
    """Reader of a MATLAB file's variables by their paths, such as Loops.force, or of a matrix's column, such as
    hyst(:,2).
    """

    kind = "matlab"

    def reads(self, head: bytes) -> bool:
        return head.startswith(b"MATLAB ") or _of_version_4(head)

    def channels(self, path: Path) -> tuple[Channel, ...]:
        """Numeric variables of more than one number, and the columns or rows of long and narrow matrices."""
        return tuple(Channel(name) for own in _arrays(path, _contents(path)) for name in _parts(*own))

    def columns(self, path: Path, layout: DelimitedLayout, wanted: Wanted) -> dict[str, Array]:  # noqa: ARG002
        contents = _contents(path, {_whole(column) for column in wanted.values()})
        _require_one_channel_each(path, contents, wanted)
        return {name: _variable(path, contents, str(column)) for name, column in wanted.items()}


def _of_version_4(head: bytes) -> bool:
    """True for five integers (order and type, rows, columns, complex or not, length of the name) and a name that ends
    in 0.
    """
    for order in "<>":
        kind, rows, columns, imaginary, length = struct.unpack(f"{order}5i", head[:20].ljust(20, b"\xff"))
        if (
            kind in _TYPES_OF_4[order]
            and min(rows, columns) > 0
            and imaginary in (0, 1)
            and 1 < length <= len(head) - 20
        ):
            name = head[20 : 20 + length]
            return name.endswith(b"\0") and name[:-1].decode("latin-1").isidentifier()
    return False


def _contents(path: Path, wanted: Collection[str] | None = None) -> Any:
    """Variables of a MATLAB file by name, with structures as objects or mappings. wanted: names to read of a file of
    version 7.3, where others are None; None: all.
    """
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        require_room_for(path)
        return loadmat(path, squeeze_me=True, struct_as_record=False)
    except NotImplementedError:
        return _matlab_73(path, wanted)
    except (MatReadError, *DAMAGED_FILE_ERRORS) as problem:
        raise _no_matlab_file(path, problem) from None


def _no_matlab_file(path: Path, problem: Exception) -> RecordError:
    return RecordError(f"{path} cannot be read as a MATLAB file ({reason_of(problem)}).")


def _matlab_73(path: Path, wanted: Collection[str] | None) -> dict[str, Any]:
    def held(group: h5py.Group, above: str = "") -> dict[str, object]:
        return {name: read(item, above + name) for name, item in group.items() if not name.startswith("#")}

    def read(item: h5py.Group | h5py.Dataset, name: str) -> object:
        if isinstance(item, h5py.Group):
            return held(item, f"{name}.")
        text = item.attrs.get("MATLAB_class", b"double") == b"char"
        # MATLAB stores columns first, which HDF5 shows as the transpose.
        return None if text or (wanted is not None and name not in wanted) else np.squeeze(item[()].T)

    try:
        with h5py.File(path, "r") as file:
            require_self_contained(file, path, RecordError, path.stat().st_size)
            return held(file)
    except DAMAGED_FILE_ERRORS as problem:
        raise _no_matlab_file(path, problem) from None


def _arrays(path: Path, contents: Any, above: str = "") -> Iterator[tuple[str, Array]]:
    """Paths and values of all numeric variables with more than one number."""
    members = contents if isinstance(contents, dict) else {name: getattr(contents, name) for name in _fields(contents)}
    for name, value in members.items():
        if name.startswith("__"):
            continue
        if isinstance(value, dict) or _fields(value):
            yield from _arrays(path, value, f"{above}{name}.")
        elif isinstance(value, np.ndarray) and value.dtype.kind in "iuf" and value.ndim in (1, 2) and value.size > 1:
            yield f"{above}{name}", np.asarray(value, dtype=np.float64)


def _fields(value: object) -> tuple[str, ...]:
    return tuple(getattr(value, "_fieldnames", ()))


def _parts(name: str, array: Array) -> list[str]:
    """Name of a variable, followed by those of its columns or rows if they may be channels."""
    if array.ndim == 1:
        return [name]
    rows, columns = array.shape
    if columns <= MOST_CHANNELS < rows:
        return [name, *(f"{name}(:,{place + 1})" for place in range(columns))]
    if rows <= MOST_CHANNELS < columns:
        return [name, *(f"{name}({place + 1},:)" for place in range(rows))]
    return [name]


def _require_one_channel_each(path: Path, contents: Any, wanted: Wanted) -> None:
    """Check that no whole variable is used for two channels.

    Raises RecordError, saying how its columns are named, if one is.
    """
    for variable in dict.fromkeys(map(str, wanted.values())):
        several = [name for name, column in wanted.items() if str(column) == variable]
        if len(several) > 1:
            parts = _parts(variable, _variable(path, contents, variable))[1:] or [f"{variable}(:,1)"]
            raise RecordError(
                f"{path}: the variable {variable!r} stands for {' and '.join(several)}: say which part of it each one "
                f"is, such as {', '.join(map(repr, parts[:4]))}."
            )


def _variable(path: Path, contents: Any, name: str) -> Array:
    part = _PART.fullmatch(name)
    value = contents
    for key in _whole(name).split("."):
        value = value.get(key) if isinstance(value, dict) else getattr(value, key, None)
        if value is None:
            known = ", ".join(key for key in contents if not key.startswith("__"))
            raise RecordError(f"{path}: there is no variable {name!r}; its variables are {shown(known)}.")
    array = _numeric(path, name, value)
    if part is None:
        return array
    try:
        return np.atleast_2d(array)[:, int(part[2]) - 1] if part[2] else np.atleast_2d(array)[int(part[3]) - 1]
    except IndexError:
        size = " × ".join(map(str, array.shape))
        raise RecordError(f"{path}: {name!r} lies outside of the variable, which is {size}.") from None


def _whole(name: str | int) -> str:
    part = _PART.fullmatch(str(name))
    return part[1] if part else str(name)


def _numeric(path: Path, name: str, value: object) -> Array:
    try:
        array = np.atleast_1d(np.asarray(value, dtype=np.float64))
    except (TypeError, ValueError):
        raise RecordError(f"{path}: the variable {name!r} holds no numbers.") from None
    if array.ndim > 2:
        raise RecordError(f"{path}: the variable {name!r} has {array.ndim} dimensions, where 1 or 2 are read.")
    return array


class TdmsReader(Reader):
    """Reader of a TDMS file's channels, named by group and channel, such as Loops/Force, or by the channel alone if
    unique.
    """

    kind = "tdms"

    def reads(self, head: bytes) -> bool:
        return head.startswith(b"TDSm")

    def channels(self, path: Path) -> tuple[Channel, ...]:
        return tuple(
            Channel(name, str(own.properties.get("unit_string", "")), _rate(own.properties))
            for name, own in _channels(path).items()
            if own.dtype is not None and np.issubdtype(own.dtype, np.number)
        )

    def columns(self, path: Path, layout: DelimitedLayout, wanted: Mapping[str, str | int]) -> dict[str, Array]:  # noqa: ARG002
        channels = _channels(path)
        return {name: _numbers(path, channels, str(column)) for name, column in wanted.items()}


def _channels(path: Path) -> dict[str, Any]:
    from nptdms import TdmsFile

    try:
        file = TdmsFile.read(path)
        channels = {f"{group.name}/{channel.name}": channel for group in file.groups() for channel in group.channels()}
    except (*DAMAGED_FILE_ERRORS,) as problem:
        raise RecordError(f"{path} cannot be read as a TDMS file ({reason_of(problem)}).") from None
    if not channels:
        raise RecordError(f"{path} cannot be read as a TDMS file (it holds no channel).")
    return channels


def _rate(properties: Mapping[str, Any]) -> float | None:
    try:
        step = float(properties.get("wf_increment", 0.0))
    except (TypeError, ValueError):
        return None
    return 1.0 / step if np.isfinite(step) and step > 0.0 else None


def _numbers(path: Path, channels: Mapping[str, Any], column: str) -> Array:
    found = [name for name in channels if column in {name, name.rpartition("/")[2]}]
    if len(found) != 1:
        what = "several channels" if found else "no channel"
        hint = f"; did you mean {like!r}?" if not found and (like := nearest(column, channels)) else "."
        raise RecordError(f"{path}: there is {what} {column!r} among {shown(', '.join(channels))}{hint}")
    try:
        return np.asarray(channels[found[0]][:], dtype=np.float64)
    except (*DAMAGED_FILE_ERRORS,):
        raise RecordError(f"{path}: the channel {column!r} holds no numbers.") from None


LIBRARY: tuple[type[Reader], ...] = (TextReader, MatlabReader, TdmsReader)


@cache
def readers() -> Mapping[str, Reader]:
    """One instance of each reader by its kind.

    Raises RecordError if a package's entry point is not a reader, or its kind is already used.
    """
    home, problem = "wirewear.records.importing.text_reader", ended(RecordError)
    known = by_name(LIBRARY, ENTRY_POINT_GROUP, Reader, "reader", home, ("kind",), problem, key="kind")
    return {kind: reader() for kind, reader in known.items()}


def kind_of(path: Path) -> str:
    """Kind of the reader for a file, by its first bytes: "text" if no other reader recognises them. Raises RecordError
    if the file cannot be read, or is not an ordinary one.
    """
    # A pipe or a device may have no end.
    if is_special(path):
        raise RecordError(f"{path} is no ordinary file.")
    try:
        with path.open("rb") as file:
            head = file.read(512)
    except OSError as problem:
        raise RecordError(f"{path} cannot be read ({problem.strerror}).") from None
    return next((kind for kind, reader in readers().items() if reader.reads(head)), TextReader.kind)
