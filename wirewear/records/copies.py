"""What stands twice in a record: no two readings of a noisy sensor are alike sample by sample."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from hashlib import sha256
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wirewear.records.remarks import CheckedRecord, Remark
from wirewear.records.values import MeasuredScar

Array = NDArray[np.float64]


def copied_loops(checked: CheckedRecord) -> Iterator[Remark]:
    """Channels of one loop that are those of another; without noise, as simulations are, two cycles may be alike."""
    record, noise = checked.record, checked.record.tables.noise
    for name, stated in (
        ("displacement_um", noise.displacement_um),
        ("tangential_force_N", noise.tangential_force_N),
        ("normal_force_N", noise.normal_force_N),
    ):
        channels = ((loop.name, getattr(loop, name)) for loop in record.loops)
        if pair := _first_copy((called, (channel,)) for called, channel in channels if channel is not None):
            level: Literal["problem", "note"] = "problem" if stated else "note"
            text = f"{pair[1]} has the same {name}, sample by sample, as {pair[0]}: one is a copy"
            yield Remark(level, "copies", f"{text[:1].upper()}{text[1:]}, or the channel has no noise.")
            return


def copied_evolution(checked: CheckedRecord) -> Iterator[Remark]:
    """Repeats whose evolutions are the same in every figure."""
    parts = ((f"repeat {part.repeat}", tuple(part.columns.values())) for part in checked.record.evolution)
    if pair := _first_copy(parts):
        tables = checked.record.tables
        noisy = tables.noise.tangential_force_N and tables.metadata.source != "simulated"
        level: Literal["problem", "note"] = "problem" if noisy else "note"
        text = f"The evolution of {pair[1]} is that of {pair[0]}, figure by figure: one is a copy, or without noise."
        yield Remark(level, "copies", text)


def copied_scars(scars: Iterable[MeasuredScar]) -> Iterator[str]:
    """Maps that are those of another repeat or wire, a sentence."""
    if pair := _first_copy((f"the {scar.wire} wire's of repeat {scar.repeat}", (scar.depth_um,)) for scar in scars):
        yield f"A scar stands twice: {pair[1]} is {pair[0]}, point by point, so that one is a copy, or without noise."


def _first_copy(named: Iterable[tuple[str, tuple[Array, ...]]]) -> tuple[str, str] | None:
    """The names of the first two that hold the same numbers, not all of them alike."""
    seen: dict[bytes, str] = {}
    for name, arrays in named:
        if not any(array.size and np.nanmax(array) > np.nanmin(array) for array in arrays if np.isfinite(array).any()):
            continue
        digest = sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).digest()
        if digest in seen:
            return seen[digest], name
        seen[digest] = name
    return None
