"""The force just past the knee: adhesion at reversals shows there and nowhere else."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import Array
from tests.diagnosis.diagnosis_cases import autoregressive, nominal, record, states, tables, with_effect
from wirewear.diagnosis.infer.search import search
from wirewear.diagnosis.observe.along_branches import PlateauForce, ShelfTravel, Stick, travel_between
from wirewear.diagnosis.observe.local_lines import LocalLine, ObservedBranch, force_at
from wirewear.diagnosis.observe.observable import Site, Sites
from wirewear.diagnosis.observe.observed_record import corners_of, read, read_at_corners
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.records import ExperimentRecord, MeasuredLoop

WINDOW_um = 4.2
FEW = 60  #: Samples of a loop with which its stick branches have few.


def plateau(samples: int, force: Array | float = 1.2) -> ObservedBranch:
    """A branch of an eccentric's stroke whose plateau has no slope, from which noise is to be read."""
    at = -60.0 * np.cos(np.pi * np.linspace(0.0, 1.0, samples))
    return ObservedBranch(1, at, force + np.zeros(samples), 3)


def line(branch: ObservedBranch, at_um: float) -> LocalLine:
    found = force_at(branch, at_um, WINDOW_um)
    assert found is not None
    return found


@pytest.mark.parametrize("samples", [40, 48, 200])
def test_a_plateau_ends_where_the_force_has_fallen(samples: int) -> None:
    """A reading that leans against the force runs on past the drive's turn: its last samples stick again."""
    whole = plateau(samples)
    fallen = whole.force_N.copy()
    fallen[-1] = 0.0
    read = line(ObservedBranch(1, whole.displacement_um, fallen, 3), 58.0)
    assert read.value == pytest.approx(1.2, abs=1e-12)


def test_a_wall_between_few_samples_is_read_along_its_curve() -> None:
    flat = plateau(20)
    wall = replace(flat, force_N=1.2 + 0.4 * np.maximum(flat.displacement_um / 60.0, 0.0) ** 4)
    assert [line(wall, at).value for at in (36.0, 45.0)] == pytest.approx([1.2518, 1.3266], abs=0.003)


@pytest.mark.parametrize("samples", [48, 200])
def test_errors_of_neighbouring_places_hang_together_as_many_noisy_branches_say(samples: int) -> None:
    random = np.random.default_rng(4)
    places = (-9.0, 0.0, 6.0)
    noisy = [plateau(samples, 1.2 + random.normal(0.0, 0.01, samples)) for _ in range(1500)]
    read_off = np.array([[line(branch, at).value for at in places] for branch in noisy])
    seen = np.corrcoef(read_off.T)
    lines = [line(plateau(samples), at) for at in places]
    for i, one in enumerate(lines):
        for j, other in enumerate(lines):
            # Lines that reach far have an error of their own beside that of the samples.
            predicted = one.correlation(other, 0.0) / (one.sampled * other.sampled)
            assert seen[i, j] == pytest.approx(predicted, abs=0.08)


@settings(max_examples=20, deadline=None)
@given(samples=st.integers(20, 300), correlation=st.floats(0.0, 0.9))
def test_errors_that_hang_together_are_a_covariance(samples: int, correlation: float) -> None:
    lines = [force_at(plateau(samples), at, WINDOW_um) for at in np.linspace(-40.0, 54.0, 12)]
    found = [one for one in lines if one is not None]
    matrix = np.array(
        [[1.0 if one is other else one.correlation(other, correlation) for other in found] for one in found]
    )
    assert np.linalg.eigvalsh(matrix).min() > 0.0


@pytest.mark.parametrize("kind", [PlateauForce, Stick])
def test_numbers_of_different_loops_share_no_sample(kind: type[PlateauForce] | type[Stick]) -> None:
    one = record(repeats=1)
    reading = read(replace(one, loops=one.loops[:2]))
    observable = kind()
    sites = Sites.of(observable.sites(reading))
    alike = observable.alike(reading, 1, sites)
    apart = (sites.cycle[:, None] != sites.cycle) | (sites.branch[:, None] != sites.branch)
    assert not alike[apart].any()
    assert np.array_equal(alike, alike.T)
    assert np.array_equal(np.diag(alike), np.ones(len(sites)))


def branch(shelf_um: float, phase: float, step_um: float) -> ObservedBranch:
    """A branch that rises to 1 N by 2 N/µm, floats over the shelf at zero, rises to 1 N and slides."""
    x = np.arange(phase * step_um, 60.0, step_um)
    force = np.clip(2.0 * x, 0.0, 1.0) - 1.0 + np.clip(2.0 * (x - 0.5 - shelf_um), 0.0, 1.0)
    return ObservedBranch(1, x, force, int(np.argmax(force > 1.0 - 1e-9)))


def shelves(observed: Observations) -> Array:
    values: Array = observed.values[0, observed.layout.of_kind(ShelfTravel)]
    return values


def test_noisy_samples_of_a_shelf_do_not_pull_what_is_read_beside_it() -> None:
    """Beside a shelf of 8 µm, between elastic parts that rise by 1 N over 6 µm each."""
    random, noise_N = np.random.default_rng(3), 0.02
    x = np.arange(0.0, 60.0, 0.35)
    force = np.clip(x / 6.0, 0.0, 1.0) - 1.0 + np.clip((x - 14.0) / 6.0, 0.0, 1.0)
    whole = ObservedBranch(1, x, force, int(np.argmax(force > 1.0 - 1e-9)))
    loop = replace(
        read(record(repeats=1)).loops[0], mid_force_N=1.0, sample_noise_N=noise_N, force_noise_N=noise_N,
        displacement_noise_um=1e-3,
    )  # fmt: skip
    sites = Sites.of([Site(1, 1, -0.12), Site(1, 1, 0.12)])
    found = []
    for _ in range(200):
        noisy = replace(whole, force_N=whole.force_N + random.normal(0.0, noise_N, whole.force_N.size))
        found.append([Stick().read(replace(loop, branches=(noisy, noisy)), site)[0] for site in sites])
    assert np.mean(found, axis=0) == pytest.approx([6.0 - 0.72, 14.0 + 0.72], abs=0.04)


@given(shelf_um=st.floats(0.0, 8.0), phase=st.floats(0.0, 1.0), step_um=st.floats(0.05, 3.0))
def test_the_true_travel_lies_within_what_samples_allow(shelf_um: float, phase: float, step_um: float) -> None:
    travel, unsure = travel_between(branch(shelf_um, phase, step_um), 0.1)
    if np.isfinite(travel):
        # Between ±0.1 N the elastic parts take 0.05 µm each. Between one sample and the next lies any length.
        assert abs(travel - shelf_um - 0.1) <= np.sqrt(12.0) * unsure + 1e-9
        assert unsure <= 2.0 * step_um / np.sqrt(12.0) + 1e-9


def test_a_play_lengthens_the_computed_travel_by_its_gap() -> None:
    layout = reduce(record(repeats=1, samples=FEW)).layout
    rows = layout.of_kind(ShelfTravel)
    plain, loose = (
        layout.observed(simulate(states(), setup, layout.cycles))[rows]
        for setup in (nominal("sensor"), with_effect(nominal("sensor"), "free_play", {"gap_um": 3.0}))
    )
    np.testing.assert_allclose(loose - plain, 3.0, atol=0.1)


@pytest.mark.slow
def test_a_play_of_few_samples_is_measured_within_what_they_allow_and_named() -> None:
    one = reduce(record({"free_play": {"gap_um": 3.0}}, repeats=1, samples=FEW))
    plain = reduce(record(repeats=1, samples=FEW))
    assert np.median(shelves(one)) - np.median(shelves(plain)) == pytest.approx(3.0, abs=1.0)
    assert search(states(), nominal("sensor"), one).best.names == ("free_play",)
    unseen = search(states(), nominal("sensor"), plain)
    assert unseen.best.log_evidence - unseen.none.log_evidence < 2.0


AMPLITUDE_um, PLATEAU_N, STICK_um, FREQUENCY_Hz = 60.0, 1.2, 8.0, 3.0
Drive = Callable[[Array], Array]


def sine(phase: Array) -> Array:
    """A drive with the harmonics of a worn eccentric."""
    return np.asarray(np.sin(phase) + 0.01 * np.sin(2.0 * phase) + 0.008 * np.sin(3.0 * phase))


def triangle(phase: Array) -> Array:
    """A drive of constant speed."""
    return np.asarray(2.0 / np.pi * np.arcsin(np.sin(phase)))


@cache
def true_loop(points: int, drive: Drive = sine) -> tuple[Array, Array]:
    """Displacement [µm] and force [N] of Coulomb friction behind a spring at even times (points,)."""
    place = AMPLITUDE_um * drive(2.0 * np.pi * np.arange(points) / points)
    force, at = np.zeros(points), 0.0
    for _ in range(2):
        for step, now in enumerate(place):
            at += now - place[step - 1]
            limit = STICK_um * (1.0 + 0.3 * (now / AMPLITUDE_um) ** 2)
            at = float(np.clip(at, -limit, limit))
            force[step] = PLATEAU_N * at / STICK_um
    return place, force


def logged(
    points: int | None,
    samples: int,
    *,
    loops: int = 8,
    correlation: float = 0.0,
    size: float = 1.0,
    coupling: float = 0.0,
    drive: Drive = sine,
) -> list[MeasuredLoop]:
    """Loops at so many samples, straight between points (None: as good as curves), with a laboratory's noise."""
    random = np.random.default_rng(5)
    place, force = true_loop(points or 8192, drive)
    place = place + coupling * force
    time = np.arange(samples) / samples
    known = np.arange(place.size) / place.size
    x, q = (np.interp(time, known, channel, period=1.0) for channel in (place, force))
    return [
        MeasuredLoop(
            1,
            cycle,
            time / FREQUENCY_Hz,
            x + size * 0.15 * autoregressive(samples, correlation, random),
            q + size * 0.008 * autoregressive(samples, correlation, random),
            None,
        )
        for cycle in range(1, loops + 1)
    ]


@pytest.mark.parametrize("points", [30, 40, 48])
@pytest.mark.parametrize("samples", [128, 256, 400])
def test_lines_between_few_points_are_seen_under_noise(points: int, samples: int) -> None:
    assert corners_of(logged(points, samples), FREQUENCY_Hz) == points


@pytest.mark.first_case
@pytest.mark.parametrize("size", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("correlation", [0.0, 0.8])
@pytest.mark.parametrize("coupling", [0.0, 2.0])
@pytest.mark.parametrize("drive", [sine, triangle])
def test_curves_are_no_lines(size: float, correlation: float, coupling: float, drive: Drive) -> None:
    for samples in (96, 256):
        loops = logged(None, samples, size=size, correlation=correlation, coupling=coupling, drive=drive)
        assert corners_of(loops, FREQUENCY_Hz) is None


def test_lines_of_one_channel_alone_are_no_lines() -> None:
    curves = [one.tangential_force_N for one in logged(None, 256)]
    loops = [replace(one, tangential_force_N=force) for one, force in zip(logged(30, 256), curves, strict=True)]
    assert corners_of(loops, FREQUENCY_Hz) is None


def test_a_record_is_read_at_its_corners_whatever_outliers_it_has() -> None:
    loops = logged(40, 256)
    spoiled = loops[3].displacement_um.copy()
    spoiled[[20, 90]] += 25.0
    loops[3] = replace(loops[3], displacement_um=spoiled)
    read, note = read_at_corners(ExperimentRecord(tables(), tuple(loops), (), ()))
    assert note is not None
    assert "40 points a cycle" in note
    place, force = true_loop(40)
    for loop in read.loops:
        assert loop.time_s == pytest.approx(np.arange(40) / 40 / FREQUENCY_Hz)
        # Six samples a line leave less noise than one has.
        assert np.std(loop.displacement_um - place) < 0.12
        assert np.abs(loop.displacement_um - place).max() < 0.5
        assert np.std(loop.tangential_force_N - force) < 0.0065
