"""From a record to observables: what is read of its loops, its evolution and its scars, and where."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wirewear.diagnosis.model.scar_figures import SCAR_FIGURES, scar_figures, scar_skew
from wirewear.diagnosis.model.wear_states import WIRES
from wirewear.diagnosis.observe.knee import peak_N
from wirewear.diagnosis.observe.layout import Array, Layout
from wirewear.diagnosis.observe.measured_loops import (
    FORCE_WINDOW,
    POSITION_WINDOW,
    Branch,
    ReducedLoop,
    displacement_at,
    force_at,
    of_one_recorder,
    reduced_loop,
)
from wirewear.errors import RecordError
from wirewear.loops import LoopError
from wirewear.records import ExperimentRecord

#: Logged cycles that are used at most, and cycles of the evolution beside them.
MOST_CYCLES, MOST_EVOLUTION = 10, 8

#: Levels: positions as shares of the reading's amplitude, forces as shares of the force at mid-stroke.
POSITIONS = (-0.6, -0.45, -0.3, -0.15, 0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.86, 0.94)
FORCES = (-0.85, -0.65, -0.45, -0.28, -0.12, 0.12, 0.28, 0.42, 0.58, 0.74)

#: With at most this many samples on a stick branch, it is read at them: nothing is known between.
FEW_SAMPLES, SHELF_SHARE = 6, 0.05

#: Errors of figures that were read by another program, and of a profilometer's map, relative.
EVOLUTION_ERROR = {"energy": 0.004, "slip": 0.004, "force": 0.006}
SCAR_ERROR = 0.03

#: A map knows depths within this; figures of a scar that is hardly deeper mean little.
DEPTH_ERROR_um = 0.1

#: Error of a scar's skew in rad, and what a shallow one adds in units of its relative error of depth.
SKEW_ERROR, SHALLOW_SKEW = 0.002, 0.2

#: A figure is misread if it leaves the median of so many neighbours on either side by more than this share of it.
NEIGHBOURS, JUMP = 4, 0.03

_COLUMNS = {"energy": "dissipated_energy_mJ", "slip": "slip_amplitude_um", "force": "max_tangential_force_N"}


@dataclass(frozen=True, eq=False)
class Observations:
    """Observables of every repeat: values and standard deviations of their noise (r, n); NaN where missing.

    `loops` are those used, for pictures; `notes` say what was left out.
    """

    layout: Layout
    repeats: tuple[int, ...]
    values: Array
    noise: Array
    loops: tuple[ReducedLoop, ...]
    notes: tuple[str, ...]


def reduce(record: ExperimentRecord) -> Observations:
    """All that is observed of a record.

    Raises:
        RecordError: no loop of the record slides as a whole, or none can be read.
    """
    notes: list[str] = []
    loops = list(_loops(record, notes))
    if not loops:
        raise RecordError(f"no loop of the record {record.name!r} can be diagnosed: {notes[0] if notes else 'none'}")
    loops = of_one_recorder(loops)
    layout = _layout(record, loops)
    repeats = tuple(sorted({loop.repeat for loop in loops}))
    values, noise = np.full((2, len(repeats), len(layout)), np.nan)
    for loop in loops:
        _observe(loop, layout, values[repeats.index(loop.repeat)], noise[repeats.index(loop.repeat)])
    for row, repeat in enumerate(repeats):
        _observe_evolution(record, repeat, layout, values[row], noise[row])
        _observe_scars(record, repeat, layout, values[row], noise[row])
    known = np.isfinite(values) & np.isfinite(noise) & (noise > 0.0)
    values[~known], noise[~known] = np.nan, np.nan
    seen = known.any(axis=0)
    return Observations(layout.taken(seen), repeats, values[:, seen], noise[:, seen], tuple(loops), tuple(notes))


def _chosen(cycles: list[int], most: int) -> list[int]:
    """At most so many cycles, spread evenly over their logarithm, first and last among them."""
    if len(cycles) <= most:
        return cycles
    wanted = np.linspace(np.log(max(cycles[0], 1)), np.log(max(cycles[-1], 1)), most)
    known = np.log(np.maximum(cycles, 1))
    return sorted({cycles[int(np.argmin(np.abs(known - at)))] for at in wanted})


def _loops(record: ExperimentRecord, notes: list[str]) -> Iterator[ReducedLoop]:
    for cycle in _chosen([cycle for cycle in record.cycles if cycle > 0], MOST_CYCLES):
        for loop in record.loops_at(cycle):
            try:
                yield reduced_loop(loop, record.tables.noise)
            except (LoopError, ValueError, IndexError) as error:
                notes.append(f"the loop of {loop.name} was left out: {error}")


def _layout(record: ExperimentRecord, loops: list[ReducedLoop]) -> Layout:
    rows: list[tuple[str, int, int, float]] = []
    amplitude = float(np.median([loop.amplitude_um for loop in loops]))
    force = float(np.median([loop.mid_force_N for loop in loops]))
    for cycle in sorted({loop.cycle for loop in loops}):
        here = [loop for loop in loops if loop.cycle == cycle]
        for side, sign in enumerate((1, -1)):
            knee = max(loop.branches[side].knee_um for loop in here) / amplitude
            top = min(loop.branches[side].stick_top_N for loop in here)
            rows += [("plateau", cycle, sign, sign * at * amplitude) for at in POSITIONS if at > knee + 0.1]
            rows += [
                ("stick", cycle, sign, at) for at in _stick_levels([loop.branches[side] for loop in here], top, force)
            ]
        rows += [("knee", cycle, sign, 0.0) for sign in (1, -1)]
        rows.append(("amplitude", cycle, 0, 0.0))
        if any(loop.normal_N for loop in here):
            rows += [("normal", cycle, 0, 0.0), ("normal_direction", cycle, 0, 0.0)]
    rows += [(kind, cycle, 0, 0.0) for cycle in _evolution_cycles(record, loops) for kind in _COLUMNS]
    last = int(record.tables.conditions.cycles)
    for side, wire in enumerate(WIRES):
        if record.scars_of(wire):
            rows += [("scar", last, 0, 10.0 * side + place) for place in range(len(SCAR_FIGURES))]
            rows.append(("skew", last, 0, 10.0 * side))
    return Layout.of_rows(rows)


def _stick_levels(branches: list[Branch], top_N: float, force_N: float) -> list[float]:
    """Forces at which stick branches are read: even ones, or those of the samples themselves where these are few."""
    lowest = FORCES[0] * force_N
    seen = [branch.force_N[: branch.knee + 1] for branch in branches]
    samples = [q[(q > lowest) & (q < min(top_N, FORCES[-1] * force_N))] for q in seen]
    count = min(q.size for q in samples)
    if count > FEW_SAMPLES:
        return [at * force_N for at in FORCES if at * force_N < top_N]
    if count == 0:
        return []
    levels = np.median([q[:count] for q in samples], axis=0)
    # Of a shelf at Q = 0 one sample may catch any place.
    return sorted(float(at) for at in levels if abs(at) > SHELF_SHARE * force_N)


def _evolution_cycles(record: ExperimentRecord, loops: list[ReducedLoop]) -> list[int]:
    """Cycles of the evolution that lie far from all logged loops: the others would count them twice."""
    logged = np.array(sorted({loop.cycle for loop in loops}), dtype=float)
    known = sorted({int(c) for part in record.evolution for c in part.columns["cycle"] if c > 0})
    far = [cycle for cycle in known if np.all(np.abs(np.log(cycle / logged)) > np.log(1.35))]
    return _chosen(far, MOST_EVOLUTION) if far else []


def _observe(loop: ReducedLoop, layout: Layout, values: Array, noise: Array) -> None:
    for place in np.flatnonzero(layout.cycle == loop.cycle):
        kind, level = str(layout.kind[place]), float(layout.level[place])
        branch = loop.branches[0 if layout.branch[place] >= 0 else 1]
        if kind == "plateau":
            window = POSITION_WINDOW * loop.amplitude_um
            force, weight = force_at(branch, branch.sign * level, window)
            values[place], noise[place] = branch.sign * force, loop.force_noise_N * weight
        elif kind == "stick":
            at, error = displacement_at(branch, level, FORCE_WINDOW * loop.mid_force_N, loop)
            values[place], noise[place] = branch.sign * at, error
        elif kind == "knee":
            x = branch.displacement_um[branch.knee :]
            peak, weight = peak_N(x - x[0], branch.force_N[branch.knee :], loop.amplitude_um)
            values[place], noise[place] = branch.sign * peak, loop.force_noise_N * weight
        elif kind == "amplitude":
            values[place], noise[place] = loop.amplitude_um, loop.amplitude_error_um
        elif kind == "normal" and loop.normal_N:
            values[place], noise[place] = float(np.mean(loop.normal_N)), loop.normal_error_N
        elif kind == "normal_direction" and loop.normal_N:
            values[place], noise[place] = loop.normal_N[0] - loop.normal_N[1], 2.0 * loop.normal_error_N


def _observe_evolution(record: ExperimentRecord, repeat: int, layout: Layout, values: Array, noise: Array) -> None:
    for part in record.evolution:
        if part.repeat != repeat:
            continue
        for kind, column in _COLUMNS.items():
            if column not in part.columns:
                continue
            figures = _without_jumps(part.columns[column])
            for place in np.flatnonzero(layout.kind == kind):
                here = np.flatnonzero(part.columns["cycle"] == layout.cycle[place])
                value = float(figures[here[0]]) if here.size else np.nan
                values[place], noise[place] = value, EVOLUTION_ERROR[kind] * abs(value)


def _without_jumps(values: Array) -> Array:
    """Figures over the cycles with NaN where one leaves its neighbours: a loop that was misread."""
    kept = values.copy()
    for i in range(values.size):
        near = values[max(0, i - NEIGHBOURS) : i + NEIGHBOURS + 1]
        near = near[np.isfinite(near)]
        if near.size > NEIGHBOURS:
            centre = float(np.median(near))
            spread = 1.4826 * float(np.median(np.abs(near - centre)))
            if abs(values[i] - centre) > 6.0 * spread + JUMP * abs(centre):
                kept[i] = np.nan
    return kept


def _observe_scars(record: ExperimentRecord, repeat: int, layout: Layout, values: Array, noise: Array) -> None:
    for side, wire in enumerate(WIRES):
        for scar in record.scars_of(wire):
            if scar.repeat != repeat or scar.depth_um.size < 9:
                continue
            depth = np.nan_to_num(scar.depth_um)
            depth = depth - _ground(depth)
            figures = scar_figures(scar.x_um, scar.y_um, depth)
            shallow = DEPTH_ERROR_um / max(figures[SCAR_FIGURES.index("depth")], 1e-9)
            for place in np.flatnonzero((layout.kind == "skew") & (layout.level == 10.0 * side)):
                values[place] = scar_skew(scar.x_um, scar.y_um, depth)
                noise[place] = float(np.hypot(SKEW_ERROR, shallow * SHALLOW_SKEW))
            for place in np.flatnonzero(layout.kind == "scar"):
                code = int(layout.level[place])
                if code // 10 == side and figures[code % 10] > 0.0:
                    error = float(np.hypot(SCAR_ERROR, shallow))
                    values[place], noise[place] = np.log(figures[code % 10]), error


def _ground(depth_um: Array) -> float:
    """Mean reading where nothing is worn: clipped noise does not average to zero."""
    rim = np.concatenate([depth_um[0], depth_um[-1], depth_um[:, 0], depth_um[:, -1]])
    return float(np.median(rim))
