"""LabVIEW's measurement files (TDMS)."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from wirewear.errors import RecordError
from wirewear.files.delimited import Layout
from wirewear.quantity import nearest, shown
from wirewear.records.importing.damage import DAMAGED_FILE_ERRORS, reason_of
from wirewear.records.importing.readers.reader import Reader
from wirewear.records.values import Array


class TdmsReader(Reader):
    """Channels of a TDMS file, named by group and channel: ``Loops/Force``, or by the channel alone if it is one."""

    kind = "tdms"

    def columns(self, path: Path, layout: Layout, wanted: Mapping[str, str | int]) -> dict[str, Array]:  # noqa: ARG002
        """The channels by their names; ``layout`` says nothing of such a file."""
        try:
            from nptdms import TdmsFile
        except ImportError:
            raise RecordError(
                f"{path}: TDMS files are read by npTDMS, which is not installed: pip install 'wirewear[tdms]'."
            ) from None
        try:
            file = TdmsFile.read(path)
            channels = {
                f"{group.name}/{channel.name}": channel[:] for group in file.groups() for channel in group.channels()
            }
        except (*DAMAGED_FILE_ERRORS,) as problem:
            raise RecordError(f"{path} cannot be read as a TDMS file ({reason_of(problem)}).") from None
        if not channels:
            raise RecordError(f"{path} cannot be read as a TDMS file (it holds no channel).")
        return {name: _numbers(path, channels, str(column)) for name, column in wanted.items()}


def _numbers(path: Path, channels: Mapping[str, object], column: str) -> Array:
    found = [name for name in channels if column in {name, name.rpartition("/")[2]}]
    if len(found) != 1:
        what = "several channels" if found else "no channel"
        hint = f"; did you mean {like!r}?" if not found and (like := nearest(column, channels)) else "."
        raise RecordError(f"{path}: there is {what} {column!r} among {shown(', '.join(channels))}{hint}")
    try:
        return np.asarray(channels[found[0]], dtype=np.float64)
    except (TypeError, ValueError):
        raise RecordError(f"{path}: the channel {column!r} holds no numbers.") from None
