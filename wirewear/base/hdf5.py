"""HDF5 files with a checksum, built and read in memory.

Building in memory lets ordinary writes and reads meet a full or missing disk instead of HDF5. Behind the HDF5 data
stands a line with their SHA-256, which other programs ignore and which reveals any later change.
"""

import hashlib
import itertools
import re
import struct
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

import h5py
import numpy as np
from h5py import h5d, h5p, h5s, h5t
from numpy.typing import ArrayLike

from wirewear.base.errors import WirewearError
from wirewear.base.files import read_bytes
from wirewear.base.memory import MOST_EXPANSION
from wirewear.base.words import counted

_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_SEAL = re.compile(rb"\nwirewear sha256 ([0-9a-f]{64})\n\Z")
_NUMBERS = itertools.count()
_SEAL_LENGTH = len("\nwirewear sha256 \n") + 64


def hdf5_image(fill: Callable[[h5py.File], None], *, track_order: bool = False) -> bytes:
    """Bytes of a new HDF5 file, sealed, that `fill` writes to; track_order: groups keep the order of creation."""
    with _in_memory(track_order=track_order) as file:
        return _filled(file, fill)


class GrowingImage:
    """HDF5 file in memory, empty at first, whose bytes are taken repeatedly while it grows."""

    def __init__(self) -> None:
        self._file = _in_memory()

    def filled(self, fill: Callable[[h5py.File], None]) -> bytes:
        """Bytes of the file, sealed, after `fill` has added to it."""
        return _filled(self._file, fill)


def _in_memory(*, track_order: bool = False) -> h5py.File:
    # HDF5 knows open files by their names.
    return h5py.File(f"in memory {next(_NUMBERS)}", "w", driver="core", backing_store=False, track_order=track_order)


def _filled(file: h5py.File, fill: Callable[[h5py.File], None]) -> bytes:
    fill(file)
    file.flush()
    return sealed(file.id.get_file_image())


def write_arrays(group: h5py.Group | h5py.File, arrays: Mapping[str, ArrayLike]) -> None:
    """Write arrays as new data sets of a group, without time stamps, so that equal results make equal files.

    It uses HDF5's low-level functions: a run writes a thousand small arrays, for which h5py takes twice as long.
    """
    untimed = h5p.create(h5p.DATASET_CREATE)
    untimed.set_obj_track_times(False)
    for name, values in arrays.items():
        array = np.asarray(values, order="C")
        own = h5d.create(group.id, name.encode(), h5t.py_create(array.dtype), h5s.create_simple(array.shape), untimed)
        own.write(h5s.ALL, h5s.ALL, array)


def sealed(image: bytes) -> bytes:
    """File contents with the line of their checksum appended, replacing an earlier one."""
    image = _SEAL.sub(b"", image)
    return image + f"\nwirewear sha256 {hashlib.sha256(image).hexdigest()}\n".encode()


@contextmanager
def opened_hdf5(
    path: Path, kind: type[WirewearError], what: str, *, unsealed: tuple[int, ...] = ()
) -> Iterator[h5py.File]:
    """Open an HDF5 file made by `hdf5_image` for reading, checking its checksum.

    what: kind of file in messages, such as "result file". unsealed: values of the attribute `format` of older files,
    which have no checksum. Raises an error of class `kind` if there is no such file, it is damaged or truncated, or it
    refers to other files.
    """
    data = read_bytes(path, kind, what)
    if not data.startswith(_SIGNATURE):
        raise kind(f"{path} is no wirewear {what}.")
    seal = _SEAL.search(data, max(len(data) - _SEAL_LENGTH, 0))
    if seal and hashlib.sha256(data[: seal.start()]).hexdigest().encode() != seal[1]:
        raise kind(f"{path} is damaged: it is not as it was written.")
    if not seal and (whole := _stated_size(data)) > len(data):
        raise kind(f"{path} is cut off: {counted(len(data))} of at least {counted(whole)} bytes are left.")
    try:
        with h5py.File(BytesIO(data), "r") as file:
            if not seal and (own := file.attrs.get("format")) not in unsealed:
                raise kind(f"{path} is {f'no wirewear {what}' if own is None else 'damaged: its checksum is missing'}.")
            require_self_contained(file, path, kind, len(data))
            yield file
    except WirewearError:
        raise
    except Exception as problem:
        # h5py reports damage through a dozen exception types, depending on the byte that is wrong.
        reason = " ".join(str(problem).split())[:120] or type(problem).__name__
        raise kind(f"{path} is damaged: {reason}.") from problem


def require_self_contained(file: h5py.File, path: Path, kind: type[WirewearError], size: int) -> None:
    """Check that an open file of `size` bytes contains all that it refers to.

    Raises an error of class `kind` if it refers to other files, or states arrays larger than a hundred times its size.
    """
    total, ahead, seen = 0, [file["/"]], {hash(file["/"].id)}
    while ahead:
        group = ahead.pop()
        for name in group:
            link = group.get(name, getlink=True)
            if not isinstance(link, h5py.HardLink):
                raise kind(f"{path} refers to another place by {name!r}, which is not followed.")
            item = group[name]
            if isinstance(item, h5py.Group):
                # A hard link may lead back up.
                if hash(item.id) not in seen:
                    seen.add(hash(item.id))
                    ahead.append(item)
            elif isinstance(item, h5py.Dataset):
                if item.external or item.is_virtual:
                    raise kind(f"{path} keeps {name!r} in another file, which is not followed.")
                total += item.nbytes
                if total > MOST_EXPANSION * size:
                    raise kind(f"{path} of {counted(size)} bytes cannot hold the arrays that it states.")


def _stated_size(data: bytes) -> int:
    """Size of an HDF5 file in bytes by its superblock; the superblock's own end if that is truncated."""
    place = {0: 40, 1: 44}.get(data[8], 28) if len(data) > 8 else 28
    return int(struct.unpack_from("<Q", data, place)[0]) if len(data) >= place + 8 else place + 8
