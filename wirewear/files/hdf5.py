"""HDF5 files as bytes: built in memory, so that a disk that is full or gone meets an ordinary write and not HDF5."""

from __future__ import annotations

from collections.abc import Callable

import h5py


def hdf5_image(fill: Callable[[h5py.File], None], *, track_order: bool = False) -> bytes:
    """The bytes of an HDF5 file that `fill` has filled; groups keep the order of their making with `track_order`."""
    with h5py.File("in memory", "w", driver="core", backing_store=False, track_order=track_order) as file:
        fill(file)
        file.flush()
        image: bytes = file.id.get_file_image()
    return image
