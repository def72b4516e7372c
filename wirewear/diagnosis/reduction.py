"""From a record's samples to observables: local fits along both branches of every loop, evolution, scars."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from wirewear.diagnosis.knee import knee_index, peak_N
from wirewear.diagnosis.layout import Array, Layout
from wirewear.diagnosis.wear_states import SCAR_FIGURES, WIRES, scar_figures
from wirewear.errors import RecordError
from wirewear.loops import LoopError
from wirewear.loops.branches import Branch as LoopBranch
from wirewear.loops.branches import split_branches
from wirewear.loops.cleaning import CleanLoop, clean_loop
from wirewear.records import ExperimentRecord, MeasuredLoop
from wirewear.records.tables import Noise

#: Logged cycles that are used at most, and cycles of the evolution beside them.
MOST_CYCLES, MOST_EVOLUTION = 10, 8

#: Levels: positions as shares of the reading's amplitude, forces as shares of the force at mid-stroke.
POSITIONS = (-0.6, -0.45, -0.3, -0.15, 0.0, 0.15, 0.3, 0.45, 0.6, 0.75, 0.86, 0.94)
FORCES = (-0.85, -0.65, -0.45, -0.28, -0.12, 0.12, 0.28, 0.42, 0.58, 0.74)

#: Half-widths of the local fits' windows, as such shares.
POSITION_WINDOW, FORCE_WINDOW = 0.07, 0.09

#: A force level lies on the stick branch if it is below this share of the rise from reversal to knee.
STICK_SHARE = 0.86

#: Degree of the curve through a sliding branch about which its noise is taken, and samples for each: the walls of
#: a deep scar bend a branch sharply near its ends. And the most that samples correlate.
SMOOTH_DEGREE, SAMPLES_A_DEGREE, MOST_CORRELATION = 9, 5, 0.9

#: With at most this many samples on a stick branch, it is read at them: nothing is known between.
FEW_SAMPLES, SHELF_SHARE = 6, 0.05

#: A straight line between two samples may miss a curved stick branch by this share of their distance.
CHORD_ERROR = 0.12

#: Errors of figures that were read by another program, and of a profilometer's map, relative.
EVOLUTION_ERROR = {"energy": 0.004, "slip": 0.004, "force": 0.006}
SCAR_ERROR = 0.03

#: A map knows depths within this; figures of a scar that is hardly deeper mean little.
DEPTH_ERROR_um = 0.1

#: A figure is misread if it leaves the median of so many neighbours on either side by more than this share of it.
NEIGHBOURS, JUMP = 4, 0.03

_COLUMNS = {"energy": "dissipated_energy_mJ", "slip": "slip_amplitude_um", "force": "max_tangential_force_N"}


@dataclass(frozen=True, eq=False)
class Branch:
    """One branch of a measured loop in order of travel, both quantities times its direction: they rise. (m,) each."""

    sign: int
    displacement_um: Array
    force_N: Array
    knee: int

    @property
    def knee_um(self) -> float:
        """Displacement at which sliding begins, times the direction."""
        return float(self.displacement_um[self.knee])

    @property
    def stick_top_N(self) -> float:
        """Force up to which the branch sticks for certain."""
        low = float(self.force_N[: self.knee + 1].min())
        return low + STICK_SHARE * (float(self.force_N[self.knee]) - low)


@dataclass(frozen=True, eq=False)
class ReducedLoop:
    """A clean measured loop as two branches, with the noise of one sample, and what counts of it in means."""

    repeat: int
    cycle: int
    branches: tuple[Branch, Branch]
    amplitude_um: float
    amplitude_error_um: float
    mid_force_N: float
    displacement_noise_um: float
    force_noise_N: float
    sample_noise_N: float
    normal_N: tuple[float, float] | None
    normal_error_N: float

    @property
    def energy_mJ(self) -> float:
        """Area of the loop."""
        x = np.concatenate([branch.sign * branch.displacement_um for branch in self.branches])
        q = np.concatenate([branch.sign * branch.force_N for branch in self.branches])
        return 5e-4 * abs(float(x @ np.roll(q, -1) - np.roll(x, -1) @ q))

    @property
    def half_width_um(self) -> float:
        """Half of the loop's width where the force is zero."""
        crossings = [
            float(np.interp(0.0, np.maximum.accumulate(branch.force_N[: branch.knee + 1]),
                            branch.displacement_um[: branch.knee + 1]))
            for branch in self.branches
        ]  # fmt: skip
        return -0.5 * sum(crossings)


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
    loops = _of_one_recorder(loops)
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
                yield _reduced(loop, record.tables.noise)
            except (LoopError, ValueError, IndexError) as error:
                notes.append(f"the loop of {loop.name} was left out: {error}")


def _of_one_recorder(loops: list[ReducedLoop]) -> list[ReducedLoop]:
    """The loops with the median of their noise: one recorder took them all, whatever shape they have."""
    force, sample, displacement = (
        float(np.median([getattr(loop, name) for loop in loops]))
        for name in ("force_noise_N", "sample_noise_N", "displacement_noise_um")
    )
    return [
        replace(loop, force_noise_N=force, sample_noise_N=sample, displacement_noise_um=displacement) for loop in loops
    ]


def _reduced(measured: MeasuredLoop, stated: Noise) -> ReducedLoop:
    loop = measured.complete
    clean = clean_loop(loop.displacement_um, loop.tangential_force_N, None, time_s=loop.time_s)
    raw = clean.without_smooth_drive()
    middle = 0.5 * (clean.displacement_um.max() + clean.displacement_um.min())
    amplitude = 0.5 * float(np.ptp(clean.displacement_um))
    halves = split_branches(clean)
    branches = [_branch(raw, half, middle, amplitude) for half in halves]
    mid = float(np.mean([_force_at(branch, 0.0, POSITION_WINDOW * 2 * amplitude)[0] for branch in branches]))
    if not mid > 0.0 or any(branch.knee_um > 0.6 * amplitude for branch in branches):
        raise LoopError("it does not slide as a whole over most of the stroke, as a diagnosis needs.")
    noise, stretch = _force_noise(branches) or _stated_noise(stated, clean)
    noise_x = max(raw.raw_noise_um, 1e-4 * amplitude) * stretch
    noise_q = max(noise, 1e-4 * mid)
    error = clean.amplitude_noise_um if clean.smoothed else noise_x
    normal, normal_error = _normal(loop, halves)
    return ReducedLoop(
        loop.repeat, loop.cycle, (branches[0], branches[1]), amplitude, max(error, 5e-4 * amplitude), mid, noise_x,
        noise_q * stretch, noise_q, normal, normal_error,
    )  # fmt: skip


def _branch(raw: CleanLoop, branch: LoopBranch, middle: float, amplitude: float) -> Branch:
    sign = int(branch.direction)
    place = {int(index): at for at, index in enumerate(raw.index)}
    order = np.array([place[int(index)] for index in branch.samples])
    x, q = sign * (raw.raw_displacement_um[order] - middle), sign * raw.force_N[order]
    if order.size < 8:
        raise LoopError("one of its branches has fewer than eight samples.")
    knee = knee_index(branch.travel_um, q, float(np.median(q[np.abs(x) < 0.25 * amplitude])), amplitude)
    return Branch(sign, x, q, knee)


def _force_noise(branches: list[Branch]) -> tuple[float, float] | None:
    """Standard deviation of a sliding branch's force about a smooth curve, and what correlation makes of means.

    A mean of m samples whose neighbours correlate by ρ scatters as if there were m (1 − ρ)/(1 + ρ) of them.  None where
    there are too few samples to tell noise from shape.
    """
    products, squares, count = 0.0, 0.0, 0
    for branch in branches:
        x, q = branch.displacement_um[branch.knee :], branch.force_N[branch.knee :]
        if x.size < SAMPLES_A_DEGREE * SMOOTH_DEGREE:
            return None
        place = 2.0 * (x - x.min()) / max(float(np.ptp(x)), 1e-12) - 1.0
        design = np.polynomial.chebyshev.chebvander(place, SMOOTH_DEGREE)
        rest = q - design @ np.linalg.lstsq(design, q, rcond=None)[0]
        spread = 1.4826 * float(np.median(np.abs(rest)))
        rest = np.clip(rest, -3.0 * spread, 3.0 * spread)
        products += float(rest[1:] @ rest[:-1])
        squares += float(rest @ rest)
        count += rest.size - SMOOTH_DEGREE - 1
    correlation = float(np.clip(products / max(squares, 1e-300), 0.0, MOST_CORRELATION))
    return float(np.sqrt(squares / count)), float(np.sqrt((1.0 + correlation) / (1.0 - correlation)))


def _stated_noise(stated: Noise, clean: CleanLoop) -> tuple[float, float]:
    """What the record says of a sample's noise, or how far neighbours of few samples lie apart."""
    known = stated.tangential_force_N
    return (clean.force_noise_N if known is None else known), 1.0


def _normal(loop: MeasuredLoop, halves: tuple[LoopBranch, LoopBranch]) -> tuple[tuple[float, float] | None, float]:
    if loop.normal_force_N is None:
        return None, np.nan
    forward, backward = (half.samples for half in halves)
    means = []
    for samples in (forward, backward):
        values = loop.normal_force_N[samples]
        centre = np.median(values)
        spread = 1.4826 * np.median(np.abs(values - centre)) + 1e-12
        means.append(float(values[np.abs(values - centre) < 5.0 * spread].mean()))
    return (means[0], means[1]), float(spread / np.sqrt(0.5 * forward.size) + 1e-4 * abs(means[0]))


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
            force, weight = _force_at(branch, branch.sign * level, window)
            values[place], noise[place] = branch.sign * force, loop.force_noise_N * weight
        elif kind == "stick":
            at, error = _displacement_at(branch, level, FORCE_WINDOW * loop.mid_force_N, loop)
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


def _force_at(branch: Branch, at_um: float, window_um: float) -> tuple[float, float]:
    """Force on the sliding part at a position by a local line, and the factor from a sample's noise to its error."""
    x, q = branch.displacement_um[branch.knee :], branch.force_N[branch.knee :]
    near = np.abs(x - at_um) < window_um
    if np.count_nonzero(near) < 4:
        near = np.zeros(x.size, dtype=bool)
        near[np.argsort(np.abs(x - at_um))[:4]] = True
    away, force = x[near] - at_um, q[near]
    if away.size < 2 or np.ptp(away) < 1e-9 or away.min() > window_um or away.max() < -window_um:
        return np.nan, np.nan
    design = np.stack([np.ones_like(away), away], axis=1)
    for _ in range(2):
        inverse = np.linalg.pinv(design)
        rest = force - design @ (inverse @ force)
        spread = 1.4826 * float(np.median(np.abs(rest)))
        good = np.abs(rest) <= 4.0 * spread + 1e-12
        design, force = design[good], force[good]
    inverse = np.linalg.pinv(design)
    return float(inverse[0] @ force), float(np.linalg.norm(inverse[0]))


def _displacement_at(branch: Branch, level_N: float, window_N: float, loop: ReducedLoop) -> tuple[float, float]:
    """Displacement at which the stick branch reaches a force, and its error."""
    x, q = branch.displacement_um, branch.force_N
    end = min(branch.knee + 2, x.size - 1)
    above = np.flatnonzero(q[: end + 1] > level_N)
    if not above.size or above[0] == 0:
        return np.nan, np.nan
    right = int(above[0])
    left = right - 1
    local = np.arange(max(0, left - 12), min(end, right + 12) + 1)
    local = local[np.abs(q[local] - level_N) < window_N]
    if local.size >= 4 and np.ptp(q[local]) > 2.0 * loop.force_noise_N:
        away = q[local] - level_N
        slope, at = np.polyfit(away, x[local], 1)
        rest = x[local] - at - slope * away
        good = np.abs(rest) <= 4.0 * (1.4826 * np.median(np.abs(rest))) + 1e-12
        if np.count_nonzero(good) >= 3 and np.ptp(away[good]) > 0.0:
            slope, at = np.polyfit(away[good], x[local][good], 1)
        error = float(np.hypot(loop.displacement_noise_um, slope * loop.force_noise_N)) / np.sqrt(local.size - 1)
        return float(at), error
    share = (level_N - q[left]) / (q[right] - q[left])
    step = float(x[right] - x[left])
    slope = step / float(q[right] - q[left])
    error = float(np.hypot(loop.displacement_noise_um, slope * loop.force_noise_N))
    # A chord is right at its ends.
    return float(x[left] + share * step), float(np.hypot(error, 4.0 * share * (1.0 - share) * CHORD_ERROR * step))


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
            figures = scar_figures(scar.x_um, scar.y_um, depth - _ground(depth))
            for place in np.flatnonzero(layout.kind == "scar"):
                code = int(layout.level[place])
                if code // 10 == side and figures[code % 10] > 0.0:
                    error = float(np.hypot(SCAR_ERROR, DEPTH_ERROR_um / figures[SCAR_FIGURES.index("depth")]))
                    values[place], noise[place] = np.log(figures[code % 10]), error


def _ground(depth_um: Array) -> float:
    """Mean reading where nothing is worn: clipped noise does not average to zero."""
    rim = np.concatenate([depth_um[0], depth_um[-1], depth_um[:, 0], depth_um[:, -1]])
    return float(np.median(rim))
