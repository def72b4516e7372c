"""Figures of an evolution that another program defined otherwise, as the record's own loops tell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from wirewear.loops import LoopFigures
from wirewear.records.values import MeasuredEvolution, MeasuredLoop

#: Relative difference from the loops, as a median, from which on a figure is another one. In forty records of other
#: solvers, with noise, hum, drift and steps of sensors, figures of the same definition differ by at most 0.025 (0.002
#: but for the largest force), a plateau's force and a rectangle's slip by 0.09.
OTHERWISE = 0.04

#: Loops that must have their figure in the evolution to say so.
FEWEST_LOOPS = 3


@dataclass(frozen=True)
class OtherDefinition:
    """A column whose figures differ from those of the record's loops by this share (median, with its sign)."""

    column: str
    share: float

    @property
    def text(self) -> str:
        """What to know of it."""
        return (
            f"the evolution's {self.column} differs by {100.0 * self.share:+.0f} % from that of the record's own "
            "loops: it is defined otherwise"
        )


def other_definitions(
    loops: Mapping[tuple[int, int], tuple[MeasuredLoop, LoopFigures]], evolution: Sequence[MeasuredEvolution]
) -> tuple[OtherDefinition, ...]:
    """The columns that contradict the loops, which are named (repeat, cycle).

    The largest force may be max |Q| or half the range of Q; an offset of the force tells them apart.
    """
    shares: dict[str, list[float]] = {}
    for part in evolution:
        for (repeat, cycle), (loop, figures) in loops.items():
            if repeat == part.repeat and cycle > 0:
                for column, own in _figures(loop, figures).items():
                    stated = figure_at(part, column, cycle)
                    if np.isfinite(stated) and stated > 0.0 and min(own) > 0.0:
                        away = np.log(stated / np.array(own))
                        shares.setdefault(column, []).append(float(away[np.abs(away).argmin()]))
    medians = {column: float(np.median(away)) for column, away in shares.items() if len(away) >= FEWEST_LOOPS}
    found = {column: float(np.expm1(away)) for column, away in medians.items() if abs(away) > OTHERWISE}
    return tuple(OtherDefinition(column, share) for column, share in found.items())


def _figures(loop: MeasuredLoop, figures: LoopFigures) -> dict[str, tuple[float, ...]]:
    """What a column may hold of a loop."""
    force = loop.tangential_force_N[np.isfinite(loop.tangential_force_N)]
    # A few samples may be spikes.
    low, high = np.quantile(force, [0.01, 0.99])
    return {
        "dissipated_energy_mJ": (figures.dissipated_energy_mJ.value,),
        "slip_amplitude_um": (figures.slip_amplitude_um.value,),
        "max_tangential_force_N": (float(max(-low, high)), 0.5 * float(high - low)),
    }


def figure_at(part: MeasuredEvolution, column: str, cycle: float) -> float:
    """A figure at a cycle, straight over the cycles' logarithm; NaN outside those that are known."""
    if column not in part.columns:
        return np.nan
    known = np.isfinite(part.columns[column]) & (part.columns["cycle"] > 0)
    times, values = np.log(part.columns["cycle"][known]), part.columns[column][known]
    if times.size == 0:
        return np.nan
    return float(np.interp(np.log(cycle), times, values, left=np.nan, right=np.nan))
