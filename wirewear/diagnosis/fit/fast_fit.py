"""Figures of a record's loops for each test and cycle, and friction and rig compliance fitted to them by the fast
model.

An axis called FITTED runs over the fitted figures, in the order of that table. A shelf is a stretch of a loop at zero
force, by free play.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from geometry.arrays import Array
from wirewear.base.course import Course
from wirewear.base.errors import RecordError
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.effects.contact import FrictionEvolution
from wirewear.loops import LoopError, LoopFigures, Measured, analyse_loop
from wirewear.records import AnyRecord

#: Figures that are fitted, and the relative deviation of the model that they are compared with.
FITTED = {
    "friction_geometry_independent": 0.01,
    "slip_amplitude_um": 0.005,
    "dissipated_energy_mJ": 0.01,
    "measured_stiffness_N_per_um": 0.03,
}

FRICTIONS = (1e-3, 2.0)  #: Friction that a fit looks for, up to the most that a study may state.
MOST_CYCLES = 8  #: Cycles that are fitted at most: loops change slowly.

#: Figures that a loop shows otherwise where its shelf is seen, and taken out of it.
_OF_SHELF = [list(FITTED).index(name) for name in ("slip_amplitude_um", "measured_stiffness_N_per_um")]


#: Running-in counts where it lowers Schwarz's criterion by so much, and changes friction by this share.
EVIDENCE, LEAST_CHANGE = 6.0, 0.03


@dataclass(frozen=True, eq=False)
class LoopsOfTests:
    """Figures of a record's loops.

    figures: (repeats, cycles, FITTED), NaN where missing. deviations: (cycles, FITTED) standard deviations of one test.
    plays: (repeats, cycles, 2) free plays in µm and their standard deviations, NaN where none was found. samples:
    median number in a loop. If most loops show free play, figures that it changes are taken from these loops only, and
    else from the others only.
    """

    repeats: tuple[int, ...]
    cycles: Array
    figures: Array
    deviations: Array
    plays: Array
    samples: int

    @property
    def has_play(self) -> bool:
        """True if at least half of the analysed loops show free play."""
        return _has_play(self.plays, self.figures)

    @property
    def friction(self) -> float:
        return float(np.nanmean(self.figures[:, :, 0]))

    @property
    def mean(self) -> Array:
        """Means over all repeats (cycles, FITTED); NaN where none has the figure."""
        known = np.isfinite(self.figures)
        total = np.where(known, self.figures, 0.0).sum(axis=0)
        return np.where(known.any(axis=0), total / np.maximum(known.sum(axis=0), 1), np.nan)


def loops_of_tests(record: AnyRecord, *, sliding: bool = True) -> LoopsOfTests:
    """Figures of the record's loops at up to MOST_CYCLES cycles, spread evenly over their logarithm.

    sliding: True to use only loops that slide as a whole, False for those in partial slip, too. Raises RecordError if
    it is True and no loop shows friction: none can be analysed, slides as a whole, or is sampled densely enough.
    """
    cycles = _chosen(record.cycles)
    repeats = tuple(sorted({loop.repeat for loop in record.loops}))
    figures = np.full((len(repeats), len(cycles), len(FITTED)), np.nan)
    deviations, plays = np.zeros_like(figures), np.full((*figures.shape[:2], 2), np.nan)
    slide = 0
    for i, repeat in enumerate(repeats):
        for j, cycle in enumerate(cycles):
            found = _figures(record, repeat, cycle)
            if found is None:
                continue
            slide += found.regime == "gross slip"
            if (play := found.free_play_um) is not None:
                plays[i, j] = play.value, play.deviation
            for k, measured in _usable(found, sliding=sliding).items():
                figures[i, j, k], deviations[i, j, k] = measured.value, measured.deviation
    if sliding:
        _require_friction(record, figures[:, :, 0], slide)
    other = np.isfinite(plays[:, :, 0]) != _has_play(plays, figures)
    for place in _OF_SHELF:
        figures[other, place] = np.nan
    samples = int(np.median([loop.time_s.size for loop in record.loops]))
    return LoopsOfTests(repeats, np.array(cycles, float), figures, _of_one_test(figures, deviations), plays, samples)


def _require_friction(record: AnyRecord, frictions: Array, slide: int) -> None:
    """Raise RecordError unless friction (repeats, cycles) can be fitted; `slide` is the number of loops in
    gross slip.
    """
    if not np.isfinite(frictions).any():
        raise RecordError(f"{_why_not(record, slide)}, so that neither friction nor wear can be fitted.")
    friction = float(np.nanmean(frictions))
    if not FRICTIONS[0] <= friction <= FRICTIONS[1]:
        raise RecordError(
            f"the loops of the record {record.name!r} give a coefficient of friction of {friction:.3g}, where one from "
            f"{FRICTIONS[0]:g} to {FRICTIONS[1]:g} can be fitted: check the units of tangential and normal force."
        )


def _has_play(plays: Array, figures: Array) -> bool:
    seen = int(np.isfinite(plays[:, :, 0]).sum())
    # A rig has free play where so large a share of its loops shows one.
    return seen > 0 and seen >= 0.5 * np.isfinite(figures[:, :, 0]).sum()


def _why_not(record: AnyRecord, sliding: int) -> str:
    """Reason why no loop of a record shows friction, as a sentence part; `sliding` is the number of loops in gross
    slip.
    """
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


def _usable(found: LoopFigures, *, sliding: bool) -> dict[int, Measured]:
    """Usable figures of a loop by their index in FITTED.

    Empty if the force does not resist the motion in both directions, or if `sliding` is True and the loop does not
    slide.
    """
    keeps_sign = found.asymmetry is not None and abs(found.asymmetry.value) >= 1.0
    if (sliding and found.regime != "gross slip") or keeps_sign:
        return {}
    known = ((k, getattr(found, name)) for k, name in enumerate(FITTED))
    return {k: one for k, one in known if one is not None and one.value > 0.0 and np.isfinite(one.deviation)}


def _of_one_test(figures: Array, deviations: Array) -> Array:
    """Standard deviations (cycles, FITTED) of one test: errors of analysis, scatter between tests and model, in
    squares.
    """
    known = np.isfinite(figures)
    count = known.sum(axis=0)
    mean = np.where(known, figures, 0.0).sum(axis=0) / np.maximum(count, 1)
    squares = np.where(known, (figures - mean) ** 2, 0.0).sum(axis=(0, 1))
    free = np.maximum(count - 1, 0).sum(axis=0)
    size = np.where(known, figures, 0.0).sum(axis=(0, 1)) / np.maximum(known.sum(axis=(0, 1)), 1)
    # Scatter between tests where one test alone is known.
    scatter = np.where(free > 0, np.sqrt(squares / np.maximum(free, 1)), 0.03 * size)
    analysed = np.where(known, deviations, 0.0).max(axis=0)
    model = np.array(list(FITTED.values())) * size
    return np.asarray(np.sqrt(scatter**2 + analysed**2 + model**2))


@dataclass(frozen=True, eq=False)
class FastFit:
    """Fitted friction and compliance of the holder.

    coordinates: (k,) ln µ and compliance in µm/N, or ln µ_initial, ln µ_final, ln n_c (cycles of running-in) and
    compliance if friction runs in; low, high: their bounds; covariance: (k, k). repeats: (n, k) coordinates of each
    test alone, by one Gauss–Newton step from the common ones. misfit: χ² of `points` numbers.
    """

    coordinates: Array
    low: Array
    high: Array
    covariance: Array
    repeats: Array
    misfit: float
    points: int

    @property
    def runs_in(self) -> bool:
        return self.coordinates.size > 2

    @property
    def friction(self) -> Course:
        return _friction(self.coordinates)

    @property
    def compliance_um_per_N(self) -> float:
        return float(self.coordinates[-1])


def _friction(coordinates: Array) -> Course:
    if coordinates.size == 2:
        return Course.constant(float(np.exp(coordinates[0])))
    initial, final, cycles = np.exp(coordinates[:3])
    return Course(float(initial), float(final), float(cycles))


def fast_fit(states: WearStates, setup: SurrogateInputs, tests: LoopsOfTests) -> FastFit:
    """Friction and rig compliance fitted to the loops of all cycles; friction runs in if that improves the fit
    enough.
    """
    start = np.array([np.log(setup.friction), setup.compliance_um_per_N])
    constant = _fitted(states, setup, tests, start)
    if tests.cycles.size < 4 or tests.cycles[-1] < 30.0 * tests.cycles[0]:
        return constant
    if constant.misfit < EVIDENCE + 2.0 * np.log(constant.points):
        return constant
    friction = tests.mean[:, 0]
    known = np.isfinite(friction)
    ends = np.log(friction[known][[0, -1]])
    middle = float(np.log(np.sqrt(tests.cycles[0] * tests.cycles[-1])))
    running = _fitted(states, setup, tests, np.array([*ends, middle, constant.compliance_um_per_N]))
    change = abs(running.friction.initial / running.friction.final - 1.0)
    gain = constant.misfit - running.misfit - 2.0 * np.log(constant.points)
    return running if gain > EVIDENCE and change > LEAST_CHANGE else constant


def _fitted(states: WearStates, setup: SurrogateInputs, tests: LoopsOfTests, start: Array) -> FastFit:
    low, high = (np.full(start.size, np.log(end)) for end in FRICTIONS)
    if start.size > 2:
        # Running-in takes at most so many times the test.
        low[2], high[2] = 0.0, np.log(10.0 * tests.cycles[-1])
    low[-1], high[-1] = 0.0, np.inf
    start = np.clip(start, low + 1e-9, high - 1e-9)

    def modelled(coordinates: Array) -> Array:
        return figures_of_model(states, setup, coordinates, tests.cycles, tests.samples)

    known = np.isfinite(tests.mean) & np.isfinite(modelled(start))
    weight = np.sqrt(np.isfinite(tests.figures).sum(axis=0)[known]) / tests.deviations[known]

    def residuals(coordinates: Array) -> Array:
        off: Array = np.nan_to_num((modelled(coordinates)[known] - tests.mean[known]) * weight, nan=10.0)
        return off

    scale = np.append(np.full(start.size - 1, 0.05), max(start[-1], 0.5))
    found = least_squares(residuals, start, bounds=(low, high), x_scale=scale, diff_step=2e-3, max_nfev=8)
    covariance = np.linalg.pinv(found.jac.T @ found.jac)
    expected = modelled(found.x)[known]
    own = []
    for figures in tests.figures:
        off = (figures[known] - expected) / tests.deviations[known]
        there = np.isfinite(off)
        jacobian = found.jac[there] / weight[there, None] / tests.deviations[known][there, None]
        own.append(np.clip(found.x + np.linalg.pinv(jacobian) @ off[there], low, high))
    return FastFit(found.x, low, high, covariance, np.array(own), 2.0 * float(found.cost), int(known.sum()))


def figures_of_model(
    states: WearStates, setup: SurrogateInputs, coordinates: Array, cycles: Array, samples: int = 128
) -> Array:
    """Figures (n, FITTED) of the fast model's loops at n cycles, analysed as measured loops are; NaN where a loop
    cannot be. coordinates: see `FastFit`. samples: in a loop.
    """
    course = _friction(coordinates)
    asked = replace(setup, friction=course.final, compliance_um_per_N=float(coordinates[-1]))
    if coordinates.size > 2:
        evolution = FrictionEvolution(initial=course.initial, final=course.final, cycles=course.cycles)
        asked = asked.with_effect(evolution)
    found = simulate(states, asked, cycles)
    loops = _sampled(found.displacement_um, found.tangential_force_N, samples)
    return np.array([_row(*loop, asked.load_N) for loop in loops])


def _sampled(displacement: Array, force: Array, samples: int) -> list[tuple[Array, Array]]:
    """Loops as (displacement, force) of `samples` samples under a sinusoidal drive, from branches (n, 2, m)."""
    phase = 2.0 * np.pi * np.arange(samples) / samples
    loops = []
    for (up_x, down_x), (up_q, down_q) in zip(displacement, force, strict=True):
        x = 0.5 * (up_x.max() + up_x.min()) + 0.5 * float(np.ptp(up_x)) * np.sin(phase)
        forward = np.interp(x, up_x, up_q)
        backward = np.interp(x, down_x[::-1], down_q[::-1])
        loops.append((x, np.where(np.cos(phase) >= 0.0, forward, backward)))
    return loops


def _row(displacement: Array, force: Array, load_N: float) -> list[float]:
    try:
        figures = analyse_loop(displacement, force, load_N)
    except LoopError:
        return [np.nan] * len(FITTED)
    return [np.nan if (found := getattr(figures, name)) is None else found.value for name in FITTED]
