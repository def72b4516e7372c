"""LabVIEW's measurement files (TDMS)."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from geometry.arrays import Array
from wirewear.base.delimited import DelimitedLayout
from wirewear.base.errors import RecordError
from wirewear.base.quantity import nearest, shown
from wirewear.records.importing.reader import DAMAGED_FILE_ERRORS, Channel, Reader, reason_of


class TdmsReader(Reader):
    """Channels of a TDMS file, named by group and channel: ``Loops/Force``, or by the channel alone if it is one."""

    kind = "tdms"

    def reads(self, head: bytes) -> bool:
        """Whether a file begins as these do."""
        return head.startswith(b"TDSm")

    def channels(self, path: Path) -> tuple[Channel, ...]:
        """Channels of numbers, with the unit and the rate that their properties state."""
        return tuple(
            Channel(name, str(own.properties.get("unit_string", "")), _rate(own.properties))
            for name, own in _channels(path).items()
            if own.dtype is not None and np.issubdtype(own.dtype, np.number)
        )

    def columns(self, path: Path, layout: DelimitedLayout, wanted: Mapping[str, str | int]) -> dict[str, Array]:  # noqa: ARG002
        """The channels by their names; ``layout`` says nothing of such a file."""
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
