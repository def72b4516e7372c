"""Simulated and measured loops of the same cycle, brought to one phase."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wirewear.loops import LoopError, LoopFigures, analyse_loop
from wirewear.loops.drive import period_of
from wirewear.records import AnyRecord
from wirewear.records.remarks import listed
from wirewear.records.values import Array, MeasuredLoop
from wirewear.results import Loop, RunResult, read_loops

#: A simulated cycle stands for a measured one if neither is more than this many times the other.
NEAR = 1.1

#: Points of a loop on one phase, from mid-stroke towards +x.
PHASES = 400


@dataclass(frozen=True, eq=False)
class LoopPair:
    """One measured cycle and the simulated one that stands for it.

    `simulated` (2, PHASES) and `measured` (repeats, 2, PHASES) hold displacement [µm] and tangential force [N] over
    the phase; the figures are those of `analyse_loop`.
    """

    cycle: int
    simulated_cycle: int
    repeats: tuple[int, ...]
    simulated: Array
    measured: Array
    simulated_figures: LoopFigures
    measured_figures: tuple[LoopFigures, ...]


def loop_pairs(result: RunResult, record: AnyRecord) -> tuple[tuple[LoopPair, ...], tuple[str, ...]]:
    """Pairs of all cycles that both have, and sentences about what was left out.

    Simulated loops are those that the study's sensors read.
    """
    pairs, notes, missing = [], [], []
    loops = read_loops(result)
    for cycle in record.cycles:
        simulated = _near(loops, cycle)
        if simulated is None:
            missing.append(cycle)
            continue
        pair, left_out = _pair(simulated, record.loops_at(cycle), record.tables.conditions.normal_load_N)
        notes += left_out
        if pair is not None:
            pairs.append(pair)
    if missing:
        notes.insert(
            0,
            f"the result has no loops near the record's cycles {listed(missing)}: `wirewear run --cycles-of RECORD` "
            "logs them",
        )
    return tuple(pairs), tuple(notes)


def _near(loops: Sequence[Loop], cycle: int) -> Loop | None:
    def distance(loop: Loop) -> float:
        low, high = sorted((max(loop.cycle, 0.5), max(cycle, 0.5)))
        return high / low

    best = min(loops, key=distance, default=None)
    return best if best is not None and distance(best) <= NEAR else None


def _pair(simulated: Loop, measured: Sequence[MeasuredLoop], load_N: float) -> tuple[LoopPair | None, list[str]]:
    notes, repeats, figures, curves = [], [], [], []
    for raw in measured:
        loop = raw.complete
        try:
            own = loop.figures(load_N)
        except LoopError as error:
            notes.append(f"the loop of {raw.name} was left out: {error}")
            continue
        repeats.append(loop.repeat)
        figures.append(own)
        curves.append(_on_phase(loop, own))
    if not curves:
        return None, notes
    try:
        own = analyse_loop(
            simulated.displacement_um, simulated.tangential_force_N, simulated.normal_force_N, time_s=simulated.time_s
        )
    except LoopError as error:
        return None, [*notes, f"the simulated loop of cycle {simulated.cycle} was left out: {error}"]
    pair = LoopPair(
        cycle=measured[0].cycle,
        simulated_cycle=simulated.cycle,
        repeats=tuple(repeats),
        simulated=_on_phase(simulated, own),
        measured=np.stack(curves),
        simulated_figures=own,
        measured_figures=tuple(figures),
    )
    return pair, notes


def _on_phase(loop: Loop | MeasuredLoop, figures: LoopFigures) -> Array:
    """Both channels at even phases, counted from where the drive's first harmonic passes its middle upwards."""
    time, displacement, force = (
        np.delete(channel, figures.outlier_samples)
        for channel in (loop.time_s, loop.displacement_um, loop.tangential_force_N)
    )
    angle = 2.0 * np.pi * (time - time[0]) / period_of(time, displacement)
    harmonics = np.column_stack([np.ones_like(angle), np.sin(angle), np.cos(angle)])
    _, sine, cosine = np.linalg.lstsq(harmonics, displacement, rcond=None)[0]
    start = -float(np.arctan2(cosine, sine))
    wanted = start + 2.0 * np.pi * np.arange(PHASES) / PHASES
    return np.stack([np.interp(wanted, angle, channel, period=2.0 * np.pi) for channel in (displacement, force)])
