"""The force just past the knee: adhesion at reversals shows there and nowhere else."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.diagnosis_cases import NOISE_N, nominal, record, states, with_effect
from wirewear.diagnosis.infer.search import search
from wirewear.diagnosis.infer.solver_differences import remainder
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.evolution import SlipAmplitude
from wirewear.diagnosis.observe.knee import computed_peaks_N, knee_index, peak_N
from wirewear.diagnosis.observe.knee_peak import KneePeak
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.local_lines import LocalLine, ObservedBranch, force_at
from wirewear.diagnosis.observe.plateau import PlateauForce
from wirewear.diagnosis.observe.reading import read
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.diagnosis.observe.shelf import ShelfTravel, travel_between
from wirewear.diagnosis.observe.sites import Site, Sites
from wirewear.diagnosis.observe.spikes import without_spikes
from wirewear.diagnosis.observe.stick import Stick
from wirewear.loops.noise import spikes
from wirewear.records import ExperimentRecord, MeasuredLoop
from wirewear.records.loop_statistics import of_equal_times

WINDOW_um = 4.2

#: Samples of a loop with which its stick branches have few.
FEW = 60


def spoiled(made: ExperimentRecord, place: int, sample: int, **shift: float) -> ExperimentRecord:
    """The record with one sample of one loop off."""
    loops = list(made.loops)
    for name, off in shift.items():
        values = getattr(loops[place], name).copy()
        values[sample] += off
        loops[place] = replace(loops[place], **{name: values})
    return replace(made, loops=tuple(loops))


def left_out(made: ExperimentRecord) -> dict[int, list[int]]:
    """Samples left out of each loop."""
    found = {place: np.flatnonzero(np.isnan(loop.displacement_um)) for place, loop in enumerate(made.loops)}
    return {place: bad.tolist() for place, bad in found.items() if bad.size}


def alike(samples: int) -> ExperimentRecord:
    """Twelve loops of one recorder that starts all of them at the same place of the stroke."""
    made = record(samples=4096, repeats=3)
    loops = []
    for loop in made.loops:
        rising = np.roll(loop.displacement_um, -256) > 0.0
        start = int(np.argmin(np.abs(loop.displacement_um) + np.where(rising, 0.0, 1e3)))
        at = (start + np.arange(samples) * 4096 // samples) % 4096
        loops.append(
            replace(
                loop,
                time_s=np.arange(samples) / (3.0 * samples),
                displacement_um=loop.displacement_um[at],
                tangential_force_N=loop.tangential_force_N[at],
                normal_force_N=None if loop.normal_force_N is None else loop.normal_force_N[at],
            )
        )
    return replace(made, loops=tuple(loops))


@pytest.mark.parametrize("samples", [40, 96])
def test_a_spike_is_left_out_wherever_it_lies_and_nothing_else(samples: int) -> None:
    made = alike(samples)
    assert left_out(without_spikes(made)) == {}
    for sample in range(0, samples, 5):
        assert left_out(without_spikes(spoiled(made, 4, sample, displacement_um=9.0))) == {4: [sample]}
        assert left_out(without_spikes(spoiled(made, 4, sample, normal_force_N=-0.2))) == {4: [sample]}
    flat = samples // 8
    assert left_out(without_spikes(spoiled(made, 4, flat, tangential_force_N=-0.2))) == {4: [flat]}


def test_what_all_loops_show_is_no_spike() -> None:
    made = alike(40)
    shown = made
    for place in range(len(made.loops)):
        shown = spoiled(shown, place, 7, tangential_force_N=0.3)
    assert left_out(without_spikes(shown)) == {}


def test_dense_loops_few_loops_and_loops_of_unlike_times_are_left_alone() -> None:
    dense = spoiled(alike(200), 4, 50, displacement_um=9.0)
    assert without_spikes(dense) is dense
    few = spoiled(alike(40), 1, 7, displacement_um=9.0)
    few = replace(few, loops=few.loops[:3])
    assert without_spikes(few) is few
    unlike = spoiled(alike(40), 4, 7, displacement_um=9.0)
    loops = [replace(loop, time_s=loop.time_s * (1.0 + 0.01 * place)) for place, loop in enumerate(unlike.loops)]
    assert left_out(without_spikes(replace(unlike, loops=tuple(loops)))) == {}


def test_several_spikes_of_a_loop_are_found_one_by_one() -> None:
    random = np.random.default_rng(2)
    loops = np.sin(2.0 * np.pi * np.arange(64) / 64) + 0.003 * random.standard_normal((9, 64))
    loops[3, [10, 12, 40]] += (0.3, -0.2, 0.1)
    assert np.argwhere(spikes(loops)).tolist() == [[3, 10], [3, 12], [3, 40]]


def test_loops_are_grouped_by_their_times() -> None:
    def loop(count: int, missing: bool = False) -> MeasuredLoop:
        values = np.arange(count, dtype=float)
        force = np.where(values == 3.0, np.nan, values) if missing else values
        return MeasuredLoop(1, 1, values, values, force, None)

    groups = of_equal_times([loop(20), loop(30), loop(30), loop(30, missing=True), loop(20), loop(30)])
    assert [[one.time_s.size for one in group] for group in groups] == [[30, 30, 30], [20, 20]]
    assert of_equal_times([]) == []


def test_a_channel_that_never_changes_but_for_round_off_has_no_spikes() -> None:
    random = np.random.default_rng(4)
    still = np.full((6, 40), 2.0)
    assert not spikes(still).any()
    assert not spikes(still + 4e-16 * random.integers(0, 2, still.shape)).any()
    assert not spikes(np.zeros((6, 40))).any()


def plateau(samples: int, force: Array | float = 1.2) -> ObservedBranch:
    """A branch of an eccentric's stroke whose plateau has no slope, from which noise is to be read."""
    at = -60.0 * np.cos(np.pi * np.linspace(0.0, 1.0, samples))
    return ObservedBranch(1, at, force + np.zeros(samples), 3)


def line(branch: ObservedBranch, at_um: float) -> LocalLine:
    found = force_at(branch, at_um, WINDOW_um)
    assert found is not None
    return found


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
            foreseen = one.correlation(other, 0.0) / (one.sampled * other.sampled)
            assert seen[i, j] == pytest.approx(foreseen, abs=0.08)


def test_lines_without_a_common_sample_share_errors_of_correlated_noise_only() -> None:
    left, right = (line(plateau(400), at) for at in (-20.0, 20.0))
    assert left.correlation(right, 0.0) == 0.0
    near = line(plateau(400), -11.0)
    assert 0.0 < left.correlation(near, 0.8) < 0.5


def test_a_line_that_must_reach_far_has_most_of_its_error_to_itself_where_plateaus_bend() -> None:
    fine, coarse = line(plateau(400), 36.0), line(plateau(16), 36.0)
    assert fine.sampled > 0.95
    assert coarse.sampled < 0.6
    assert line(plateau(16), 0.0).sampled == 1.0


def test_lines_are_believed_to_miss_most_where_they_miss_most_of_a_wall() -> None:
    """Of a wall in the fourth power of the place: at mid-stroke nothing, further out the more the fewer samples."""
    missed, own = {}, {}
    for samples in (16, 24, 40, 96):
        wall = 0.2 * np.cos(np.pi * np.linspace(0.0, 1.0, samples)) ** 4
        for at in (0.0, 36.0):
            found = line(plateau(samples, wall), at)
            missed[at, samples] = abs(found.value - 0.2 * (at / 60.0) ** 4)
            own[at, samples] = np.sqrt(1.0 - found.sampled**2)
    assert missed[0.0, 16] < 0.1 * missed[36.0, 16]
    assert own[0.0, 16] == 0.0
    further = [(missed[36.0, samples], own[36.0, samples]) for samples in (96, 40, 24, 16)]
    assert all(a[0] < b[0] and a[1] < b[1] for a, b in pairwise(further))


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
    rows = observed.layout.of_kind(ShelfTravel)
    values: Array = observed.values[0, rows]
    return values


@given(shelf_um=st.floats(0.0, 8.0), phase=st.floats(0.0, 1.0), step_um=st.floats(0.05, 3.0))
def test_the_true_travel_lies_within_what_samples_allow_wherever_they_fall(
    shelf_um: float, phase: float, step_um: float
) -> None:
    travel, unsure = travel_between(branch(shelf_um, phase, step_um), 0.1)
    if np.isfinite(travel):
        # Between ±0.1 N the elastic parts take 0.05 µm each. Between one sample and the next lies any length.
        assert abs(travel - shelf_um - 0.1) <= np.sqrt(12.0) * unsure + 1e-9
        assert unsure <= 2.0 * step_um / np.sqrt(12.0) + 1e-9


@given(phase=st.floats(0.0, 1.0), step_um=st.floats(0.05, 0.4))
def test_an_even_flank_has_its_own_travel_without_bias(phase: float, step_um: float) -> None:
    travel, _ = travel_between(branch(0.0, phase, step_um), 0.04)
    assert np.isnan(travel) or travel == pytest.approx(0.04, abs=1e-6) or step_um < 0.04 + 1e-9


def test_a_reading_that_runs_back_has_a_negative_travel() -> None:
    forth = branch(0.0, 0.5, 0.2)
    back = ObservedBranch(1, -forth.displacement_um, forth.force_N, forth.knee)
    travel, unsure = travel_between(forth, 0.1)
    assert travel_between(back, 0.1) == (-travel, unsure)


def test_a_branch_that_begins_without_force_tells_nothing() -> None:
    force = np.linspace(-0.05, 1.0, 30)
    assert np.isnan(travel_between(ObservedBranch(1, np.linspace(0.0, 60.0, 30), force, 20), 0.1)).all()


def test_shelves_are_read_where_samples_are_few_and_only_there() -> None:
    few, many = (reduce(record(repeats=1, samples=count)) for count in (FEW, 400))
    assert few.layout.of_kind(ShelfTravel).any()
    assert not many.layout.of_kind(ShelfTravel).any()


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
    found = search(states(), nominal("sensor"), one)
    assert found.best.names == ("free_play",)
    unseen = search(states(), nominal("sensor"), plain)
    assert unseen.best.log_evidence - unseen.none.log_evidence < 2.0


def test_slip_amplitudes_read_on_a_shelf_are_unsure_together() -> None:
    layout = Layout.of_sites((SlipAmplitude(), [Site(cycle) for cycle in (100, 100_000)]))
    plain = nominal("sensor")
    firm, loose = (
        remainder(states(), setup, layout) for setup in (plain, with_effect(plain, "free_play", {"gap_um": 3.0}))
    )
    # Anywhere on most of a shelf of 3 µm: up to 3/√12 for what all readings share.
    assert 0.5 < (loose[0, 1] - firm[0, 1]) / (3.0**2 / 12.0) <= 1.0
    assert firm[0, 1] < 0.1 * loose[0, 1]


def _branch(peak_N: float = 0.0, samples: int = 400) -> tuple[np.ndarray, np.ndarray, float]:
    """Displacement and force of a branch that sticks up to 1 N over 10 of 120 µm; a peak decays over 4 µm past it."""
    x = np.linspace(-60.0, 60.0, samples)
    force = np.minimum(-1.0 + 2.0 * (x + 60.0) / 10.0, 1.0)
    past = np.maximum(x + 50.0, 0.0)
    return x, force + np.where(x > -50.0, peak_N * np.exp(-past / 4.0), 0.0), 60.0


def test_the_knee_is_where_sliding_begins() -> None:
    x, force, amplitude = _branch()
    assert x[knee_index(x + 60.0, force, 1.0, amplitude)] == pytest.approx(-50.0, abs=0.5)


def test_a_flat_plateau_has_no_peak_and_adhesion_has_one() -> None:
    for size in (0.0, 0.3):
        x, force, amplitude = _branch(size)
        peak, factor = peak_N(x + 50.0, force, amplitude)
        # Mean of exp(−s/4) over 0.9 to 7.2 µm.
        expected = size * 4.0 * (np.exp(-0.9 / 4.0) - np.exp(-7.2 / 4.0)) / 6.3
        assert peak == pytest.approx(expected, abs=0.012)
        assert factor == pytest.approx(np.sqrt(1.0 / 21.0 + 1.0 / 40.0), rel=0.05)


def test_windows_with_too_few_samples_tell_nothing() -> None:
    x, force, amplitude = _branch(0.3, samples=20)
    assert np.isnan(peak_N(x + 50.0, force, amplitude)[0])


def test_measured_and_computed_peaks_of_one_model_agree() -> None:
    observed = reduce(record(repeats=1, scatter=0.0, samples=400))
    knee = observed.layout.of_kind(KneePeak)
    computed = observed.layout.observed(simulate(states(), nominal("sensor"), observed.layout.cycles))
    assert knee.sum() == 8
    assert np.abs(observed.values[0, knee] - computed[knee]).max() < 5.0 * observed.noise[0, knee].max()


def test_both_branches_of_a_computed_loop_have_the_same_peak() -> None:
    x, force, _ = _branch(0.3)
    peaks = computed_peaks_N(np.stack([x, -x])[None], np.stack([force, -force])[None])
    assert peaks[0, 0] == pytest.approx(peaks[0, 1])
    assert peaks[0, 0] > 0.1


def test_adhesion_is_seen_in_a_record() -> None:
    one = record(repeats=1, samples=400)

    def sticky(loop: MeasuredLoop) -> MeasuredLoop:
        x, force = loop.displacement_um, loop.tangential_force_N
        forward = np.gradient(x) > 0.0
        knee = {True: -48.0, False: 48.0}
        past = np.where(forward, x - knee[True], knee[False] - x)
        lift = np.where(past > 0.0, 0.3 * np.exp(-np.maximum(past, 0.0) / 4.0), 0.0)
        return replace(loop, tangential_force_N=force + np.where(forward, lift, -lift))

    plain, adhesive = (reduce(replace(one, loops=loops)) for loops in (one.loops, tuple(map(sticky, one.loops))))
    peaks = []
    for own in (plain, adhesive):
        knee = own.layout.of_kind(KneePeak)
        peaks.append(own.layout.branch[knee] * own.values[0, knee])
    # Means over so many samples leave 0.27 of their noise.
    assert (peaks[1] - peaks[0]).min() > 5.0 * NOISE_N * 0.27


def test_the_knee_stays_where_a_drive_turns_between_two_samples() -> None:
    """The first sample has most of the rise behind it, which the other branch's end knows; walls pass for the rest."""
    x = np.arange(-59.4, 60.0, 0.6)
    force = np.minimum(-2.2 + 4.33 * (x + 60.0), 1.1 + 0.5 * (1.0 - np.exp(-(x + 59.0) / 20.0)))
    unknown, known = (x[knee_index(x + 60.0, force, 1.6, 60.0, reversal)] for reversal in (np.inf, -2.2))
    assert known == pytest.approx(-59.0, abs=0.6)
    assert unknown > -50.0
