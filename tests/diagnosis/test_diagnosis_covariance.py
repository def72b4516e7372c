"""What differs between tests and between solvers without any gap, as the diagnosis expects it, whatever its sizes."""

from collections.abc import Callable
from dataclasses import replace
from random import Random
from unittest.mock import Mock

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from geometry.arrays import Array
from tests.diagnosis.diagnosis_cases import autoregressive, nominal, record, states
from tests.diagnosis.layouts import SITES, at_sites, layout
from wirewear.diagnosis.infer.covariance import (
    EXPECTED_NUMBERS,
    Covariance,
    estimate,
    noise_factors,
    remainder,
    solver_covariance,
    tolerated,
)
from wirewear.diagnosis.infer.inference import Problem, fit, problem_around
from wirewear.diagnosis.observe import Site, channels
from wirewear.diagnosis.observe.along_branches import BEYOND, PEAK, PlateauForce, Stick, peak_N
from wirewear.diagnosis.observe.measured_loops import _force_noise, _usual, reduced_loop
from wirewear.diagnosis.observe.reduction import Layout, Observations, all_observables, reduce
from wirewear.diagnosis.surrogate.candidates import Candidate
from wirewear.effects import all_effects
from wirewear.effects.holder import Plasticity
from wirewear.loops.noise import (
    correlated_noise,
    correlation_of,
    correlation_of_neighbours,
    noise_factor,
    noise_of_neighbours,
    sample_noise,
    stretch_of,
)
from wirewear.records import MeasuredLoop
from wirewear.records.tables import Noise, Tolerance


def covariance_of(observed: Observations) -> Covariance:
    return estimate(states(), nominal("sensor"), observed)


@pytest.mark.seconds
@pytest.mark.parametrize("cycles", [1.0, 1e3, 1e5])
def test_every_number_has_an_error_of_the_solvers_and_the_covariance_is_definite(cycles: float) -> None:
    whole = layout()
    setup = replace(nominal(), cycles=cycles)
    within = tolerated(states(), setup, whole, Tolerance().model_dump())
    covariance = solver_covariance(states(), setup, whole) + within
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-12)
    assert np.diag(covariance).min() > 0.0
    sizes = np.sqrt(np.diag(covariance))
    assert np.linalg.eigvalsh(covariance / np.outer(sizes, sizes)).min() > 1e-9


def test_the_mean_of_one_repeat_is_that_repeat_however_much_its_numbers_share_of_their_noise() -> None:
    observed = reduce(record(repeats=1))
    noise = observed.noise * np.geomspace(1e-5, 1.0, len(observed.layout))
    shared = replace(observed, noise=noise, alike=np.ones((1, noise.size, noise.size)))
    assert covariance_of(shared).mean == pytest.approx(observed.values[0], rel=1e-12)


@pytest.mark.slow
def test_forces_under_a_stated_yield_stress_are_known_no_better_than_half_of_what_it_changes_them() -> None:
    observed, wires = reduce(record(repeats=1)), replace(states(), stroke_um=60.0)
    stated = replace(nominal("sensor"), print_um=1.0)
    plateau = observed.layout.of_kind(PlateauForce)
    before, after = observed.layout.computed(wires, stated, stated.with_effect(Plasticity(yield_stress_MPa=1e5)))
    expected = estimate(wires, stated, observed).numerical
    more = np.diag(problem_around(wires, stated, stated, observed)[1].numerical - expected)
    assert np.sqrt(more[plateau].min()) > 0.5 * np.abs(after - before)[plateau].max() > 1e-3
    elastic = nominal("sensor")
    assert np.all(
        problem_around(wires, elastic, elastic, observed)[1].total == estimate(wires, elastic, observed).total
    )


@pytest.mark.seconds
@settings(max_examples=4, deadline=None)
@given(st.randoms(use_true_random=False))
def test_the_order_in_which_numbers_are_listed_changes_nothing(random: Random) -> None:
    parts = [(one, [*SITES[type(one)]]) for one in all_observables()]
    random.shuffle(parts)
    for _, sites in parts:
        random.shuffle(sites)
    shuffled = at_sites(*parts)
    whole = layout()

    def names(one: Layout) -> list[tuple[str, Site]]:
        return [(part.observable.name, site) for part in one for site in part.sites]

    place = [names(shuffled).index(name) for name in names(whole)]
    for compute in (remainder, solver_covariance):
        expected, found = (compute(states(), nominal(), one) for one in (whole, shuffled))
        np.testing.assert_allclose(found[np.ix_(place, place)], expected, rtol=1e-9, atol=1e-14)


@pytest.mark.seconds
def test_a_stroke_that_wanders_alike_in_every_test_is_no_gap() -> None:
    """Repeats agree on what their drive does: they show nothing of it."""
    observed = reduce(record(repeats=3))
    strokes = observed.layout.of_kind(channels.Amplitude)
    total = covariance_of(observed).total[np.ix_(strokes, strokes)]
    wander = 0.002 * nominal("sensor").amplitude_um * np.linspace(-1.0, 1.0, int(strokes.sum()))
    assert wander @ np.linalg.solve(total, wander) < 4.0


@pytest.mark.seconds
def test_whitened_gap_free_residuals_are_standard_deviates_at_most() -> None:
    """Records of the model itself differ by noise and scatter alone, so less than solvers are allowed to."""
    observed = reduce(record(repeats=3))
    covariance = covariance_of(observed)
    problem = Problem.of(states(), nominal("sensor"), observed.layout, covariance)
    whitened = problem.whitened(problem.setup)
    assert np.mean(whitened**2) < 1.0
    assert np.abs(whitened).max() < 4.0


SMOOTH = np.polynomial.chebyshev.chebvander(np.linspace(-1.0, 1.0, 90), 11).astype(np.float64)


def autoregression(count: int, correlation: float, seed: int) -> Array:
    white = np.random.default_rng(seed).standard_normal(count)
    return np.asarray(lfilter([np.sqrt(1.0 - correlation**2)], [1.0, -correlation], white))[1000:]


@pytest.mark.parametrize("correlation", [0.0, 0.4, 0.8])
@pytest.mark.parametrize("count", [1, 4, 9])
def test_means_of_few_samples_scatter_as_drawn_noise_does(correlation: float, count: int) -> None:
    noise = autoregression(401_000, correlation, seed=2)
    means = noise[: noise.size // count * count].reshape(-1, count).mean(axis=1)
    factor = noise_factor(np.full(count, 1.0 / count), np.arange(count), correlation)
    assert factor == pytest.approx(means.std(), rel=0.03)


@pytest.mark.parametrize("correlation", [0.0, 0.5, 0.8])
def test_a_noise_estimated_by_cubics_through_neighbours_is_that_of_a_sample(correlation: float) -> None:
    noise = autoregression(41_000, correlation, seed=5)
    time = np.arange(noise.size, dtype=float)
    estimated = sample_noise(noise + np.sin(1e-3 * time), time)
    assert estimated * noise_of_neighbours(correlation) == pytest.approx(1.0, rel=0.04)


@pytest.mark.parametrize("correlation", [0.3, 0.6, 0.8])
def test_neighbours_nearer_than_a_samples_noise_show_how_they_correlate(correlation: float) -> None:
    noise = autoregression(41_000, correlation, seed=6)
    estimated = sample_noise(noise, np.arange(noise.size, dtype=float))
    assert correlation_of_neighbours(1.0 / estimated, most=0.95) == pytest.approx(correlation, abs=0.04)
    assert correlation_of(stretch_of(correlation)) == pytest.approx(correlation)


def cosine(time: Array) -> Array:
    return np.asarray(np.cos(2.0 * np.pi * time))


def noisy_loop(
    cycle: int,
    correlation: float,
    random: np.random.Generator,
    count: int = 400,
    drive: Callable[[Array], Array] = cosine,
) -> MeasuredLoop:
    """A loop of a spring and a slider, each channel with noise of that correlation."""
    time = np.arange(count) / count
    displacement = 60.0 * drive(time)
    force = 1.24 - np.minimum(0.3 * (60.0 - displacement), 2.48)
    force[count // 2 :] = -force[: count // 2]
    x, q, p = (autoregressive(count, correlation, random) for _ in range(3))
    return MeasuredLoop(1, cycle, time, displacement + 0.15 * x, force + 0.008 * q, 2.0 + 0.008 * p)


@pytest.mark.parametrize("correlation", [0.0, 0.3, 0.6, 0.75])
def test_noise_and_its_correlation_are_found_under_a_curve_that_takes_its_slow_part(correlation: float) -> None:
    random, found = np.random.default_rng(7), []
    for _ in range(25):
        noise = (autoregressive(len(SMOOTH), correlation, random) for _ in range(2))
        branches = [(SMOOTH, np.asarray(SMOOTH[:, 3] + 0.01 * one)) for one in noise]
        deviation, stretch = correlated_noise(branches, None)
        found.append(deviation * stretch)
    assert np.median(found) == pytest.approx(0.01 * np.sqrt((1.0 + correlation) / (1.0 - correlation)), rel=0.15)


def test_noise_is_separated_from_a_hooked_branch_and_a_spread_by_medians_is_a_standard_deviation() -> None:
    random = np.random.default_rng(8)
    x = np.linspace(-55.0, 60.0, 190)
    hooked = [(x, 1.24 + 0.6 * (x / 60.0) ** 21 + 0.01 * random.standard_normal(x.size)) for _ in range(2)]
    noise = _force_noise(hooked, Noise(), 0.0)
    assert noise is not None
    assert noise[0] == pytest.approx(0.01, rel=0.1)
    assert _usual(random.standard_normal(10_001)) == pytest.approx((0.0, 1.0), abs=0.03)


@pytest.mark.parametrize(("near", "peak"), [(1, np.nan), (2, 0.2)])
def test_a_peak_is_what_its_window_has_beyond_the_plateau_if_it_holds_two_samples(near: int, peak: float) -> None:
    past = np.concatenate([np.linspace(*PEAK, 2)[:near], np.linspace(*BEYOND, 3)])
    force = np.where(np.arange(past.size) < near, 1.2, 1.0)
    assert peak_N(60.0 * past, force, 60.0)[0] == pytest.approx(peak, nan_ok=True)


def test_errors_of_readings_grow_with_the_correlation_of_the_noise() -> None:
    random = np.random.default_rng(11)
    errors = {}
    for correlation in (0.0, 0.7):
        loops = [reduced_loop(noisy_loop(cycle, correlation, random), Noise(), 2.0) for cycle in range(1, 9)]
        errors[correlation] = [
            float(np.median([getattr(loop, name) for loop in loops]))
            for name in ("sample_noise_N", "force_noise_N", "normal_error_N")
        ]
    # One sample's noise is the same; that of means grows by √(1.7/0.3) = 2.4.
    assert np.divide(errors[0.7], errors[0.0]) == pytest.approx([1.0, 2.4, 2.4], rel=0.25)


@pytest.mark.parametrize("steps", [0.01, 1.7])
def test_normal_forces_along_the_stroke_scatter_as_their_errors_say_whatever_the_converters_steps(steps: float) -> None:
    random, deviations, step = np.random.default_rng(12), [], 0.008 * steps
    for cycle in range(1, 61):
        loop = noisy_loop(cycle, 0.0, random, count=160)
        assert loop.normal_force_N is not None
        loop = replace(loop, normal_force_N=step * np.round((loop.normal_force_N + random.uniform(0.0, step)) / step))
        read = reduced_loop(loop, Noise(), 2.0)
        along = [one.read(read, Site(cycle)) for one in (channels.NormalForceAtEnds(), channels.NormalForceBySides())]
        deviations += [value / error for value, error in along]
    assert np.std(deviations) == pytest.approx(0.8, abs=0.25)


@pytest.mark.seconds
def test_places_where_a_force_is_reached_do_not_move_with_the_converters_steps() -> None:
    random, found = np.random.default_rng(4), {0.172: list[float](), 0.0: list[float]()}
    for cycle in range(1, 7):
        loop = noisy_loop(cycle, 0.0, random, count=500)
        force = loop.tangential_force_N + 0.06 * random.standard_normal(500)
        for step, values in found.items():
            written = step * np.round(force / step) if step else force
            read = reduced_loop(replace(loop, tangential_force_N=written), Noise(), 2.0)
            lines = [Stick().line(read, Site(cycle, 1, level)) for level in (-0.3, 0.3)]
            values.append(sum(line.value * sign for line, sign in zip(lines, (-1.0, 1.0), strict=True) if line))
    assert np.mean(found[0.172]) == pytest.approx(np.mean(found[0.0]), abs=0.12)


def test_what_bodies_give_by_the_way_they_are_held_is_in_doubt() -> None:
    observed = reduce(record(repeats=2, evolution=False))
    free, held = (
        estimate(replace(states(), held_um_per_N=size), nominal("sensor"), observed).total for size in (0.0, 0.5)
    )
    (part,) = (part for part in observed.layout if part.observable.name == "stick")
    # From the reversal on, where the force is the plateau's of the other branch.
    passed_N = part.sites.level + 1.24
    grown_um = np.sqrt(np.diag(held - free))[part.rows]
    assert np.median(grown_um / passed_N) == pytest.approx(0.5, rel=0.15)


COUNT = 400


def observations(true_factor: float, repeats: int = 3, scatter: float = 0.0, seed: int = 1) -> Observations:
    """Repeats of plateaus whose noise has so many times the variance that is expected of it; stick branches as is."""
    sites = [Site(cycle, 1, 0.0) for cycle in range(1, COUNT + 1)]
    layout = at_sites((PlateauForce(), sites), (Stick(), sites))
    random = np.random.default_rng(seed)
    noise = np.full((repeats, 2 * COUNT), 0.01)
    true = noise * np.repeat([true_factor**0.5, 1.0], COUNT)
    values = true * random.standard_normal(true.shape) + scatter * random.standard_normal((repeats, 1))
    return Observations(layout, tuple(range(1, repeats + 1)), values, noise, np.zeros((2 * COUNT, 0)), (), ())


def scattered(size: float) -> Array:
    return np.full((2 * COUNT, 2 * COUNT), size**2)


@pytest.mark.parametrize("true_factor", [0.4, 1.0, 3.0])
@pytest.mark.parametrize("scatter", [0.0, 0.05])
def test_the_factor_on_the_noise_is_found_whatever_the_specimens_scatter(true_factor: float, scatter: float) -> None:
    factors = noise_factors(observations(true_factor, scatter=scatter), scattered(scatter))
    numbers = 2 * COUNT
    expected = (EXPECTED_NUMBERS + numbers * true_factor) / (EXPECTED_NUMBERS + numbers)
    # Squares beyond three deviations count as that, so that large factors are found too small.
    assert factors[0] == pytest.approx(expected, rel=0.15 if true_factor < 2.0 else 0.3)
    assert factors[-1] == pytest.approx(1.0, rel=0.12)


@pytest.mark.seconds
def test_a_record_whose_repeats_agree_worse_than_they_are_read_is_known_less_well() -> None:
    observed = reduce(record())
    shaken = observed.values.copy()
    plateaus = observed.layout.of_kind(PlateauForce)
    random = np.random.default_rng(3)
    shaken[:, plateaus] += 3.0 * observed.noise[:, plateaus] * random.standard_normal(shaken[:, plateaus].shape)
    # Of one number, given all others: scatter, which moves all plateaus alike, counts for nothing there.
    assumed, doubted = (
        1.0 / np.diag(np.linalg.inv(estimate(states(), nominal("sensor"), one).total))[plateaus]
        for one in (observed, replace(observed, values=shaken))
    )
    assert np.median(doubted / assumed) > 1.5


def test_a_number_is_known_no_better_than_the_change_that_its_effect_makes() -> None:
    changes = Mock(free={}, setup=nominal(), whitening=1e4 * np.eye(3), mean=np.ones(3))
    changes.states.model_error = lambda _: 0.1
    changes.predictions = lambda setups: np.array(
        [3 * [sum(own.factor - 1.0 for own in one.effects)] for one in setups]
    )
    found = fit(changes, [Candidate.of(all_effects()["wear_rate_offset"], {})])
    ((candidate, (place,), (deviation,)),) = found.parts()
    ends = [candidate.values(np.array([place + side * deviation]))["factor"] for side in (-0.5, 0.5)]
    assert ends[1] - ends[0] == pytest.approx(0.1, rel=0.01)
