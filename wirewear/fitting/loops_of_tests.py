"""The loops of a record as figures of each test and cycle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wirewear.base.errors import RecordError
from wirewear.loops import LoopError, LoopFigures, Measured
from wirewear.records import AnyRecord

if TYPE_CHECKING:
    pass

Array = NDArray[np.float64]

#: Records that parameters are fitted to.
#: Figures that are fitted, and the relative deviation of the model that they are compared with.
FITTED = {
    "friction_geometry_independent": 0.01,
    "slip_amplitude_um": 0.005,
    "dissipated_energy_mJ": 0.01,
    "measured_stiffness_N_per_um": 0.03,
}

#: Friction that a fit looks for, up to the most that a study may state.
FRICTIONS = (1e-3, 2.0)

#: Cycles that are fitted at most: loops change slowly.
MOST_CYCLES = 8

#: A rig has free play where so large a share of its loops shows one.
SHARE_WITH_PLAY = 0.5

#: Figures that a loop shows otherwise where its shelf is seen, and taken out of it.
_OF_SHELF = [list(FITTED).index(name) for name in ("slip_amplitude_um", "measured_stiffness_N_per_um")]

#: Scatter between tests where one test alone is known.
EXPECTED_SCATTER = 0.03


@dataclass(frozen=True, eq=False)
class LoopsOfTests:
    """Figures (repeats, cycles, FITTED) of the loops, NaN where one is missing, and standard deviations of one test.

    `plays` (repeats, cycles, 2) are the free plays that were found and their standard deviations, NaN where none was;
    where most loops show one, figures that a shelf changes are those of these loops alone, and else of the others.
    `samples` are those of most loops.
    """

    repeats: tuple[int, ...]
    cycles: Array
    figures: Array
    deviations: Array
    plays: Array
    samples: int

    @property
    def has_play(self) -> bool:
        """Whether the rig has free play."""
        return _has_play(self.plays, self.figures)

    @property
    def mean(self) -> Array:
        """Means of all tests (cycles, FITTED)."""
        known = np.isfinite(self.figures)
        total = np.where(known, self.figures, 0.0).sum(axis=0)
        return np.where(known.any(axis=0), total / np.maximum(known.sum(axis=0), 1), np.nan)


def loops_of_tests(record: AnyRecord) -> LoopsOfTests:
    """Figures of at most MOST_CYCLES cycles, evenly chosen in their logarithm.

    Raises:
        RecordError: no loop tells friction: none can be analysed, or slides as a whole, or is sampled densely enough.
    """
    cycles = _chosen(record.cycles)
    repeats = tuple(sorted({loop.repeat for loop in record.loops}))
    figures = np.full((len(repeats), len(cycles), len(FITTED)), np.nan)
    deviations, plays = np.zeros_like(figures), np.full((*figures.shape[:2], 2), np.nan)
    sliding = 0
    for i, repeat in enumerate(repeats):
        for j, cycle in enumerate(cycles):
            found = _figures(record, repeat, cycle)
            if found is None:
                continue
            sliding += found.regime == "gross slip"
            if (play := found.free_play_um) is not None:
                plays[i, j] = play.value, play.deviation
            for k, measured in _told(found).items():
                figures[i, j, k], deviations[i, j, k] = measured.value, measured.deviation
    if not np.isfinite(figures[:, :, 0]).any():
        raise RecordError(f"{_why_not(record, sliding)}, so that neither friction nor wear can be fitted.")
    friction = float(np.nanmean(figures[:, :, 0]))
    if not FRICTIONS[0] <= friction <= FRICTIONS[1]:
        raise RecordError(
            f"the loops of the record {record.name!r} give a coefficient of friction of {friction:.3g}, where one from "
            f"{FRICTIONS[0]:g} to {FRICTIONS[1]:g} can be fitted: check the units of tangential and normal force."
        )
    other = np.isfinite(plays[:, :, 0]) != _has_play(plays, figures)
    for place in _OF_SHELF:
        figures[other, place] = np.nan
    samples = int(np.median([loop.time_s.size for loop in record.loops]))
    return LoopsOfTests(repeats, np.array(cycles, float), figures, _of_one_test(figures, deviations), plays, samples)


def _has_play(plays: Array, figures: Array) -> bool:
    seen = int(np.isfinite(plays[:, :, 0]).sum())
    return seen > 0 and seen >= SHARE_WITH_PLAY * np.isfinite(figures[:, :, 0]).sum()


def _why_not(record: AnyRecord, sliding: int) -> str:
    """Why no loop of a record tells friction, of which so many slide as a whole."""
    if sliding:
        return (
            f"the loops of the record {record.name!r} have fewer than five samples a direction in the middle of "
            "the sliding, do not resist the motion both ways, as a rectified force or one of a wrong zero does not, or "
            "lose their normal force within the cycle"
        )
    known = [loop for loop in record.loops if loop.cycle > 0]
    if known:
        first = min(known, key=lambda loop: loop.cycle)
        try:
            first.figures(record.tables.conditions.normal_load_N)
        except LoopError as problem:
            return f"no loop of the record {record.name!r} can be analysed (first, cycle {first.cycle}: {problem})"
    return f"no loop of the record {record.name!r} slides as a whole"


def _chosen(cycles: tuple[int, ...]) -> list[int]:
    known = [cycle for cycle in cycles if cycle > 0]
    if len(known) <= MOST_CYCLES:
        return known
    wanted = np.geomspace(known[0], known[-1], MOST_CYCLES)
    return sorted({min(known, key=lambda cycle: abs(np.log(cycle / at))) for at in wanted})


def _figures(record: AnyRecord, repeat: int, cycle: int) -> LoopFigures | None:
    try:
        return record.loop(repeat, cycle).figures(record.tables.conditions.normal_load_N)
    except (LoopError, RecordError):
        return None


def _told(found: LoopFigures) -> dict[int, Measured]:
    """Those of FITTED, by their place, that a loop tells which slides and resists the motion both ways."""
    keeps_sign = found.asymmetry is not None and abs(found.asymmetry.value) >= 1.0
    if found.regime != "gross slip" or keeps_sign:
        return {}
    known = ((k, getattr(found, name)) for k, name in enumerate(FITTED))
    return {k: one for k, one in known if one is not None and one.value > 0.0 and np.isfinite(one.deviation)}


def _of_one_test(figures: Array, deviations: Array) -> Array:
    """Standard deviations (cycles, FITTED) of one test: its analysis, the scatter between tests, and the model."""
    known = np.isfinite(figures)
    count = known.sum(axis=0)
    mean = np.where(known, figures, 0.0).sum(axis=0) / np.maximum(count, 1)
    squares = np.where(known, (figures - mean) ** 2, 0.0).sum(axis=(0, 1))
    free = np.maximum(count - 1, 0).sum(axis=0)
    size = np.where(known, figures, 0.0).sum(axis=(0, 1)) / np.maximum(known.sum(axis=(0, 1)), 1)
    scatter = np.where(free > 0, np.sqrt(squares / np.maximum(free, 1)), EXPECTED_SCATTER * size)
    analysed = np.where(known, deviations, 0.0).max(axis=0)
    model = np.array(list(FITTED.values())) * size
    return np.asarray(np.sqrt(scatter**2 + analysed**2 + model**2))
