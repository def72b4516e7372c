"""95 % intervals of a run's loops and figures from the scatter of its inputs, by some thirty quick runs and
polynomials.

The nominal run has all inputs at their mean; the others draw them from their scatter. Points are inputs in standard
deviations from their means.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement
from pathlib import Path

import numpy as np
from scipy.stats import norm, qmc

from geometry.arrays import Array, IntArray
from wirewear.base.engine import Engine
from wirewear.base.errors import StudyError
from wirewear.results import RESULT_FILE_NAME, read_result
from wirewear.sweeps.running import RESULTS, SweepObserver, run_sweep
from wirewear.sweeps.sweep import DIGITS, FIRST, TECHNICAL, Design, Sweep, SweepRow, VariedInput
from wirewear.sweeps.tables import LATIN_HYPERCUBE
from wirewear.test import Study

RUNS = 30  #: Runs beside the one in the middle; a second degree of five inputs has 21 terms.
FARTHEST = 3.0  #: Inputs farther than so many standard deviations from the middle are not drawn.
SEED = 1  #: Of all that is drawn.
PHASES = 240  #: Phases of the loop that intervals are given at.

PERCENTILES = (2.5, 50.0, 97.5)


@dataclass(frozen=True, eq=False)
class Surrogate:
    """Polynomial of first or second degree in d inputs with m terms: exponents (m, d) and coefficients (m,). error: its
    rms leave-one-out error, in its value's unit.
    """

    terms: IntArray
    coefficients: Array
    error: float

    def at(self, points: Array) -> Array:
        """Values (n,) of the polynomial at points (n, d)."""
        values: Array = _columns(points, self.terms) @ self.coefficients
        return values


def fitted(points: Array, values: Array) -> Surrogate:
    """Least-squares polynomial of first or second degree, whichever predicts left-out points better, for values (n,) at
    points (n, d). Leave-one-out residuals follow from the hat matrix (Allen's PRESS, Technometrics 16 (1974) 125).
    Raises ValueError if there are too few points for a first-degree polynomial.
    """
    count, factors = points.shape
    degrees = [degree for degree in (1, 2) if len(_terms(factors, degree)) < 0.8 * count]
    if not degrees:
        raise ValueError(f"{count} points are too few for {factors} factors")
    return min((_of_degree(points, values, degree) for degree in degrees), key=lambda one: one.error)


def _of_degree(points: Array, values: Array, degree: int) -> Surrogate:
    terms = _terms(points.shape[1], degree)
    columns = _columns(points, terms)
    q, r = np.linalg.qr(columns)
    coefficients = np.linalg.solve(r, q.T @ values)
    leverage = np.minimum((q**2).sum(axis=1), 1.0 - 1e-9)
    left_out = (values - columns @ coefficients) / (1.0 - leverage)
    return Surrogate(terms, coefficients, float(np.sqrt(np.mean(left_out**2))))


def _terms(factors: int, degree: int) -> IntArray:
    chosen = [pick for d in range(degree + 1) for pick in combinations_with_replacement(range(factors), d)]
    return np.array([[pick.count(factor) for factor in range(factors)] for pick in chosen], dtype=np.int64)


def _columns(points: Array, terms: IntArray) -> Array:
    columns: Array = np.prod(points[:, None, :] ** terms[None, :, :], axis=2)
    return columns


@dataclass(frozen=True)
class Input:
    """A key of the study that scatters: mean (`middle`) and standard deviation in the key's unit, and largest value."""

    key: str
    middle: float
    deviation: float
    most: float = float("inf")

    def at(self, deviations: float) -> float:
        """Value this many standard deviations from the mean; mirrored at `most` if it is beyond, as an angle at 90°."""
        value = self.middle + deviations * self.deviation
        if value > self.most:
            value = 2.0 * self.most - value
        return float(f"{value:.{DIGITS}g}")


@dataclass(frozen=True)
class Interval:
    """A figure's nominal value, median and 95 % interval (`low` to `high`), and rms error of its polynomial."""

    figure: str
    nominal: float
    low: float
    median: float
    high: float
    error: float


@dataclass(frozen=True, eq=False)
class LoopBand:
    """The nominal loop of a cycle and the band of 95 % of forces, at equally spaced phases (PHASES,) of it."""

    cycle: int
    displacement_um: Array
    nominal_N: Array
    low_N: Array
    high_N: Array


@dataclass(frozen=True, eq=False)
class Uncertainty:
    """Intervals and loop bands of a run whose inputs scatter, with the number of runs and of those that failed."""

    study: Study
    inputs: tuple[Input, ...]
    intervals: tuple[Interval, ...]
    loops: tuple[LoopBand, ...]
    runs: int
    failed: int


def inputs_of(study: Study) -> tuple[Input, ...]:
    """Inputs that scatter, from the study's table [scatter].

    Raises StudyError if nothing scatters, or a key scatters that has no value in the study.
    """
    stated = study.tables.scatter
    given = {} if stated is None else {name: value for name, value in stated if value}
    if not given:
        raise StudyError(
            f"the study {study.name!r} states no scatter: give standard deviations in [scatter], such as friction = "
            "0.05, normal_load = 0.02, wear = 0.2, tangential_stiffness = 0.05, crossing_angle_deg = 1.0."
        )
    return tuple(_input(study, name, size) for name, size in given.items())


def _input(study: Study, name: str, size: float) -> Input:
    if name == "crossing_angle_deg":
        return Input("wires.crossing_angle_deg", study.wires.crossing_angle_deg, size, most=90.0)
    wear = study.wear
    archard = wear is not None and wear.archard_wear_coefficient_mm3_per_N_m is not None
    law = "archard_wear_coefficient_mm3_per_N_m" if archard else "energy_wear_coefficient_mm3_per_J"
    key = {
        "friction": "contact.friction",
        "normal_load": "conditions.normal_load_N",
        "wear": f"wear.{law}",
        "tangential_stiffness": "holder.tangential_stiffness_N_per_mm",
    }[name]
    middle = study.stated.get(key)
    if middle is None:
        raise StudyError(f"{name} in [scatter] of the study {study.name!r} scatters {key}, which is no number there.")
    return Input(key, middle, size * middle)


def sweep_of(study: Study, fidelity: str, runs: int = RUNS) -> tuple[Sweep, Array]:
    """(sweep of the nominal run followed by `runs` others, their points (runs + 1, d))."""
    inputs = inputs_of(study)
    drawn = qmc.LatinHypercube(len(inputs), rng=np.random.default_rng(SEED)).random(runs)
    inside = norm.cdf(-FARTHEST) + drawn * (norm.cdf(FARTHEST) - norm.cdf(-FARTHEST))
    deviations = np.vstack([np.zeros(len(inputs)), norm.ppf(inside)])
    points = np.array([[one.at(z) for one, z in zip(inputs, row, strict=True)] for row in deviations.tolist()])
    shares = np.vstack([np.full(len(inputs), 0.5), drawn])
    factors = tuple(
        VariedInput(one.key, one.middle - FARTHEST * one.deviation, one.middle + FARTHEST * one.deviation, False)
        for one in inputs
    )
    name = f"{study.name}: scatter"
    return Sweep(name, study, Design(LATIN_HYPERCUBE, factors, shares, points), fidelity, True), deviations


def run_uncertain(study: Study, output: Path, engine: Engine, observer: SweepObserver | None = None) -> Uncertainty:
    """Compute the runs that OUTPUT does not hold yet, and the intervals in which 95 % of tests lie. Raises StudyError
    if the study states no scatter, the nominal run failed, or too few runs are complete, and what `run_sweep` raises.
    """
    sweep, deviations = sweep_of(study, "quick")
    rows = run_sweep(sweep, output, engine, observer).rows
    if rows[1].figures is None:
        raise StudyError(f"the run of the study {study.name!r} as it is failed: {rows[1].failure}.")
    complete = [number for number in sorted(rows) if not rows[number].failed]
    if len(complete) < 2 * (deviations.shape[1] + 1):
        raise StudyError(f"only {len(complete)} of {len(rows)} runs came to an end, which gives no interval.")
    at = deviations[[number - 1 for number in complete]]
    # Draws from the polynomials: intervals then scatter by some hundredths of their width.
    drawn = np.clip(np.random.default_rng(SEED).standard_normal((4000, at.shape[1])), -FARTHEST, FARTHEST)
    results = [output / RESULTS / f"{number:06d}" / RESULT_FILE_NAME for number in complete]
    return Uncertainty(
        study,
        inputs_of(study),
        tuple(_interval(name, at, [rows[n] for n in complete], drawn) for name in _varying(rows[1], complete, rows)),
        tuple(_bands(results, study.conditions.frequency_Hz, at, drawn)),
        len(rows),
        len(rows) - len(complete),
    )


def _varying(nominal: SweepRow, complete: Sequence[int], rows: Mapping[int, SweepRow]) -> list[str]:
    """Names of the figures that all complete runs have and that vary among them, those of the first cycle last."""
    found = []
    for name in nominal.figures or {}:
        if name in TECHNICAL or (nominal.figures or {}).get(name) is None:
            continue
        values = [(rows[n].figures or {}).get(name) for n in complete]
        if all(value is not None for value in values) and len(set(values)) > 1:
            found.append(name)
    last = {name for name in found if not name.startswith(FIRST)}
    return [name for name in found if name in last] + [name for name in found if name not in last]


def _interval(name: str, at: Array, rows: Sequence[SweepRow], drawn: Array) -> Interval:
    values = np.array([(row.figures or {})[name] for row in rows], dtype=float)
    model = fitted(at, values)
    low, median, high = np.percentile(_drawn(model, drawn), PERCENTILES).tolist()
    return Interval(name, float(values[0]), low, median, high, model.error)


def _drawn(model: Surrogate, drawn: Array, component: int = 0) -> Array:
    """Polynomial at the drawn inputs plus random error of its size, independent for each component of a loop."""
    missed = np.random.default_rng(SEED + 10 * component + 1).standard_normal(len(drawn))
    return model.at(drawn) + model.error * missed


def _bands(results: Sequence[Path], frequency_Hz: float, at: Array, drawn: Array) -> list[LoopBand]:
    loops = [{loop.cycle: loop for loop in read_result(path).loops} for path in results]
    common = sorted(set.intersection(*(set(one) for one in loops)))
    bands = []
    phase = np.arange(PHASES) / PHASES
    for cycle in dict.fromkeys((common[0], common[-1])) if common else ():
        displacement, force = [], []
        for one in loops:
            loop = one[cycle]
            own = loop.time_s * frequency_Hz
            displacement.append(np.interp(phase, own, loop.displacement_um, period=1.0))
            force.append(np.interp(phase, own, loop.tangential_force_N, period=1.0))
        bands.append(_band(cycle, displacement[0], np.array(force), at, drawn))
    return bands


def _band(cycle: int, displacement_um: Array, forces: Array, at: Array, drawn: Array) -> LoopBand:
    """Band of a loop, by principal components of the forces with one polynomial for each component."""
    mean = forces.mean(axis=0)
    left, size, shapes = np.linalg.svd(forces - mean, full_matrices=False)
    # Share of the loops' variance that principal components may leave out.
    kept = int(np.searchsorted(np.cumsum(size**2) / max(float(np.sum(size**2)), 1e-300), 1.0 - 1e-4)) + 1
    total = np.tile(mean, (len(drawn), 1))
    for place in range(min(kept, size.size)):
        model = fitted(at, left[:, place] * size[place])
        total += np.outer(_drawn(model, drawn, place + 1), shapes[place])
    low, high = np.percentile(total, (PERCENTILES[0], PERCENTILES[-1]), axis=0)
    return LoopBand(cycle, displacement_um, forces[0], low, high)
