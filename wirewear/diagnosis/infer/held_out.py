"""What is left out of a fit, so that an explanation can be held against what it has not seen."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.observable import AlongBranch

#: Left out of profiles that are all there is.
STRETCHES = "every second stretch"

#: Share of the logged cycles, counted from the end, that is left out of the fit.
HELD_OUT_SHARE = constants("infer.shrink").number("held_out_share")


def held_out_cycles(loop_cycles: NDArray[np.int64]) -> list[tuple[int, ...]]:
    """Cycles to leave out, in order of preference: the last third, every second one; none if there are fewer than two.

    What only shows early in a test cannot be predicted from what comes before it, but from its neighbours.
    """
    cycles = [int(cycle) for cycle in np.unique(loop_cycles)]
    if len(cycles) < 2:
        return []
    late = tuple(cycles[len(cycles) - max(round(HELD_OUT_SHARE * len(cycles)), 1) :])
    return [late, tuple(cycles[::2])] if len(cycles) > 2 else [late]


@dataclass(frozen=True, eq=False)
class Split:
    """Observables of the cycles left out, `test`, and those that are fitted, `train`.

    `scar`: whose scar is left out, `STRETCHES` of profiles, or nothing of either.
    """

    held_out: tuple[int, ...]
    test: NDArray[np.bool_]
    train: NDArray[np.bool_]
    scar: str = ""


def splits(layout: Layout) -> Iterator[Split]:
    """Ways to leave something out, in order of preference: late loops, every second one, the scar of one wire.

    Scars are no part of what loops are scored by: only a fit that knows them can tell a rate of wear.
    """
    loops = layout.of_kind(AlongBranch)
    scars = layout.marked(part for part in layout if part.observable.of_scars)
    if scars.all():
        yield from _of_profiles(layout)
        return
    chosen = held_out_cycles(layout.cycle[loops])
    for place, held in enumerate(chosen):
        test = np.isin(layout.cycle, held) & ~scars
        train = ~test & (layout.cycle < min(held)) if place == 0 else ~test
        if (train & loops).any():
            yield Split(held, test, train)
    if not chosen:
        everything = np.ones(len(layout), dtype=bool)
        yield Split((), everything, everything)
    for name in ("fixed", "specimen"):
        fixed = scars & layout.wire(name)
        if fixed.any() and (scars & ~fixed).any():
            yield Split((int(layout.cycle[fixed].max()),), fixed, ~fixed, scar=name)


def _of_profiles(layout: Layout) -> Iterator[Split]:
    """Every second stretch of the profiles, where nothing but these is known."""
    level = np.concatenate([part.sites.level for part in layout])
    order = np.argsort(np.argsort(level, kind="stable"), kind="stable")
    test = order // 2 % 2 == 1
    yield Split((int(layout.cycle.max()),), test, ~test, scar=STRETCHES)
