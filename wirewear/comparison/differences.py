"""Differences of a simulation from a measurement, in physical units and in scatters of the repeated tests.

Loops are compared at equal phase of the drive. A scatter is the standard deviation of one test among its repeats. The
figures of a loop are the numbers that `analyse_loop` gives, such as its slip amplitude and dissipated energy.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from wirewear.comparison.registration import ScarPair
from wirewear.loops import LoopError, LoopFigures, Measured, analyse_loop
from wirewear.loops.drive import period_of
from wirewear.records import AnyRecord, MeasuredLoop
from wirewear.records.remarks import listed
from wirewear.results import Loop, RunResult, read_loops

NEAR = 1.1  #: A simulated cycle stands for a measured one if neither is more than this many times the other.
PHASES = 400  #: Points of a loop on one phase, from mid-stroke towards +x.

ROUND_OFF = 1e-9  #: Differences below this share of the value are round-off, whatever the scatter.
REPEATS = "repeats"  #: What a scatter between tests is taken from.

#: Quantity, unit, attribute of the figures, factor to the unit.
_FIGURES = (
    ("displacement amplitude δa", "µm", "displacement_amplitude_um", 1.0),
    ("slip amplitude δ0", "µm", "slip_amplitude_um", 1.0),
    ("dissipated energy", "mJ", "dissipated_energy_mJ", 1.0),
    ("measured stiffness", "N/mm", "measured_stiffness_N_per_um", 1e3),
    ("friction, largest Q/P", "", "friction_max", 1.0),
    ("friction, from energy", "", "friction_energy", 1.0),
    ("friction, geometry-independent", "", "friction_geometry_independent", 1.0),
)

#: Quantity, unit and column of the evolution.
EVOLUTION_FIGURES = (
    ("displacement amplitude δa", "µm", "displacement_amplitude_um"),
    ("slip amplitude δ0", "µm", "slip_amplitude_um"),
    ("largest tangential force", "N", "max_tangential_force_N"),
    ("dissipated energy", "mJ", "dissipated_energy_mJ"),
)


@dataclass(frozen=True, eq=False)
class LoopPair:
    """One measured cycle in all its repeats, and the simulated cycle compared with it.

    repeats: their numbers. simulated: (2, PHASES) displacement in µm and tangential force in N at even phases, from
    mid-stroke towards +x. measured: (repeats, 2, PHASES).
    """

    cycle: int
    simulated_cycle: int
    repeats: tuple[int, ...]
    simulated: Array
    measured: Array
    simulated_figures: LoopFigures
    measured_figures: tuple[LoopFigures, ...]


def loop_pairs(result: RunResult, record: AnyRecord) -> tuple[tuple[LoopPair, ...], tuple[str, ...]]:
    """Pairs of a measured and a simulated loop for all common cycles, and sentences on what was left out. Simulated
    loops are as the study's sensors read them; cycles are common if neither is more than NEAR times the other.
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
    """Displacement and force (2, PHASES) at even phases, from where the drive's first harmonic passes its middle
    upwards.
    """
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


@dataclass(frozen=True)
class Difference:
    """One row of the table of differences; None for a value that does not exist.

    source: "loops", "evolution" or a scar. quantity, unit: for readers. cycle: None for the whole test. measured: mean
    of the repeats. difference: simulated less measured, or a root mean square. scatter: standard deviation of one test,
    pooled over the cycles; for loops at least what noise alone gives. in_scatter: difference over scatter. basis:
    "repeats"; for a single repeat "one loop's uncertainty", and then in_scatter is None; or "none".
    """

    source: str
    quantity: str
    unit: str
    cycle: int | None
    simulated: float | None
    measured: float | None
    difference: float
    scatter: float | None
    in_scatter: float | None
    basis: str

    @property
    def percent(self) -> float | None:
        """Difference in per cent of the measured value; None if that is missing or 0."""
        return 100.0 * self.difference / abs(self.measured) if self.measured else None


def worst_differences(rows: Sequence[Difference]) -> list[Difference]:
    """The largest difference of each quantity over its cycles, sorted by size in scatters and then in per cent, largest
    first.
    """
    worst: dict[tuple[str, str], Difference] = {}
    for row in rows:
        key = row.source, row.quantity
        if key not in worst or abs(row.difference) > abs(worst[key].difference):
            worst[key] = row
    return sorted(worst.values(), key=lambda row: (-abs(row.in_scatter or 0.0), -abs(row.percent or 0.0)))


def loop_differences(pairs: Sequence[LoopPair]) -> list[Difference]:
    """Rows for the differences of each figure of each pair of loops, and for the root mean square of the difference in
    force at equal phase.
    """
    rows: list[Difference] = []
    for quantity, unit, attribute, factor in _FIGURES:
        lines: list[tuple[int, float, Array, Array]] = []
        variances: list[Array] = []
        for pair in pairs:
            simulated = _value(pair.simulated_figures, attribute)
            measured = [_value(figures, attribute) for figures in pair.measured_figures]
            values = [factor * item.value for item in measured if item is not None]
            if simulated is not None and values:
                deviations = [factor * item.deviation for item in measured if item is not None]
                lines.append((pair.cycle, factor * simulated.value, np.array(values), np.array(deviations)))
                # What definitions leave open, the analysis of the simulated loop has as well.
                variances.append(lines[-1][-1] ** 2 - (factor * simulated.deviation) ** 2)
        scatter, basis = _pooled([tests for _, _, tests, _ in lines], [deviations for *_, deviations in lines])
        known = [own for own in variances if np.isfinite(own).all()]
        if scatter is not None and basis == REPEATS and known:
            # Repeats may agree by chance.
            scatter = max(scatter, math.sqrt(max(float(np.median(np.concatenate(known))), 0.0)))
        for cycle, value, tests, _ in lines:
            rows.append(_row("loops", quantity, unit, cycle, value, float(tests.mean()), scatter, basis))
    return rows + _distances(pairs)


def _distances(pairs: Sequence[LoopPair]) -> list[Difference]:
    """Root mean square over a cycle of the difference in force at equal phase, for each matched loop."""
    spreads = [np.var(pair.measured[:, 1], axis=0, ddof=1) for pair in pairs if len(pair.repeats) > 1]
    scatter = float(np.sqrt(np.mean(spreads))) if spreads else None
    rows = []
    for pair in pairs:
        distance = _rms(pair.simulated[1] - pair.measured[:, 1].mean(axis=0))
        peak = float(np.abs(pair.simulated[1]).max())
        rows.append(
            Difference(
                "loops", "force at equal phase (rms)", "N", pair.cycle, None, None, distance, scatter,
                _ratio(distance, scatter, peak), "repeats" if scatter is not None else "none",
            )
        )  # fmt: skip
    return rows


def evolution_differences(result: RunResult, record: AnyRecord) -> list[Difference]:
    """Rows for the root mean square, over the cycles common to all repeats, of the difference in each column of the
    evolution.
    """
    rows = []
    for quantity, unit, name in EVOLUTION_FIGURES:
        cycles, tests = common_evolution(record, name)
        simulated = simulated_evolution(result, name, cycles)
        inside = np.isfinite(simulated)
        if not inside.any():
            continue
        tests, simulated = tests[:, inside], simulated[inside]
        difference = _rms(simulated - tests.mean(axis=0))
        scatter, basis = _pooled(list(tests.T), [])
        middle = float(np.mean(np.abs(simulated)))
        text = f"{quantity} (rms over {simulated.size} cycles)"
        ratio = _ratio(difference, scatter, middle)
        means = float(simulated.mean()), float(tests.mean())
        rows.append(Difference("evolution", text, unit, None, *means, difference, scatter, ratio, basis))
    return rows


def common_evolution(record: AnyRecord, name: str) -> tuple[Array, Array]:
    """Cycles (n,) at which all repeats have a value in the column `name`, and these values (repeats, n); empty if there
    are none.
    """
    series = []
    for part in record.evolution:
        known = np.isfinite(part.columns[name])
        series.append(dict(zip(part.columns["cycle"][known].tolist(), part.columns[name][known].tolist(), strict=True)))
    cycles = sorted(set.intersection(*(set(one) for one in series))) if series else []
    return np.array(cycles), np.array([[one[cycle] for cycle in cycles] for one in series])


def simulated_evolution(result: RunResult, name: str, cycles: Array) -> Array:
    """Column `name` of the simulation at cycles (n,), linear in log cycle; NaN beyond its first and last cycle."""
    known = np.round(result.evolution["cycle"])
    known, first = np.unique(known, return_index=True)
    if not known.size:
        return np.full(cycles.size, np.nan)
    at, values = (np.log(np.maximum(one, 0.5)) for one in (cycles, known))
    return np.interp(at, values, result.evolution[name][first], left=np.nan, right=np.nan)


def scar_differences(pairs: Iterable[ScarPair]) -> list[Difference]:
    """Rows for the differences in worn volume, depth and lengths of each body's scar, and for the root mean square of
    the difference in depth.
    """
    rows = []
    for pair in pairs:
        source, covered = f"scar, {pair.name}", np.isfinite(pair.measured).all(axis=0)
        if not covered.any():
            continue
        for quantity, unit, simulated, tests in (
            ("worn volume", "10⁻³ mm³", 1e3 * float(np.mean(pair.simulated_volumes_mm3)),
             1e3 * np.array(pair.measured_volumes_mm3)),
            *((name, "µm", float(own.mean()), tests) for name, (own, tests) in pair.spans_um.items()),
        ):  # fmt: skip
            scatter, basis = _pooled([tests], [])
            measured = float(tests.mean())
            rows.append(_row(source, quantity, unit, pair.simulated_cycle, simulated, measured, scatter, basis))
        maps = pair.measured[:, covered]
        distance = _rms(pair.simulated[covered] - maps.mean(axis=0))
        scatter = float(np.sqrt(np.mean(np.var(maps, axis=0, ddof=1)))) if len(maps) > 1 else None
        ratio = _ratio(distance, scatter, float(pair.simulated.max()))
        basis = "repeats" if scatter is not None else "none"
        text = "depth (rms over the map)"
        rows.append(Difference(source, text, "µm", pair.simulated_cycle, None, None, distance, scatter, ratio, basis))
    return rows


def _value(figures: LoopFigures, attribute: str) -> Measured | None:
    value: Measured | None = getattr(figures, attribute)
    return value


def _pooled(tests: Sequence[Array], deviations: Sequence[Array]) -> tuple[float | None, str]:
    """Standard deviation of one test, pooled over cycles as few repeats give it badly, and its basis (see
    `Difference`).
    """
    many = [values for values in tests if values.size > 1]
    if many:
        freedom = sum(values.size - 1 for values in many)
        return math.sqrt(sum(float(np.var(values) * values.size) for values in many) / freedom), REPEATS
    known = [values for values in deviations if np.isfinite(values).all() and values.size]
    if known:
        return float(np.sqrt(np.mean(np.concatenate(known) ** 2))), "one loop's uncertainty"
    return None, "none"


def _row(
    source: str,
    quantity: str,
    unit: str,
    cycle: int,
    simulated: float,
    measured: float,
    scatter: float | None,
    basis: str,
) -> Difference:
    difference = simulated - measured
    # How far one loop's analysis may be off says nothing about how tests differ.
    known = scatter if basis == REPEATS else None
    ratio = _ratio(difference, known, max(abs(simulated), abs(measured)))
    return Difference(source, quantity, unit, cycle, simulated, measured, difference, scatter, ratio, basis)


def _ratio(difference: float, scatter: float | None, size: float) -> float | None:
    if abs(difference) <= ROUND_OFF * size:
        return 0.0
    if scatter is None or scatter <= ROUND_OFF * size:
        return None
    return difference / scatter


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
