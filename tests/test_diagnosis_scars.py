"""What scars tell a diagnosis: their skew, and through it the crossing angle."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.diagnosis_cases import CYCLES, NOISE_N, diagnosed, nominal, record, states, tables
from tests.synthetic_results import result
from wirewear.base.errors import RecordError
from wirewear.diagnosis.diagnose import concluded
from wirewear.diagnosis.infer.inference import Problem
from wirewear.diagnosis.infer.physical import physical_gap
from wirewear.diagnosis.infer.sets import next_measurement
from wirewear.diagnosis.infer.shrink import Shrink, held_out_cycles, splits
from wirewear.diagnosis.infer.solver_differences import derivatives
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.loop_states import WIRES, scar_skew
from wirewear.diagnosis.model.nominal import nominal_study
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.amplitude import Amplitude
from wirewear.diagnosis.observe.evolution import LargestForce, SlipAmplitude, half_width, loop_area
from wirewear.diagnosis.observe.layout import Features, Layout
from wirewear.diagnosis.observe.local_lines import ObservedBranch, displacement_at
from wirewear.diagnosis.observe.normal_along import NormalForce
from wirewear.diagnosis.observe.plateau import PlateauForce
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.observe.scars import ScarFigures, ScarSkew
from wirewear.diagnosis.observe.sites import Site
from wirewear.diagnosis.observe.stick import Stick
from wirewear.records import ExperimentRecord, MeasuredScar

RADIUS_um, DEPTH_um = 225.0, 10.0
LINE_um = np.linspace(-160.0, 160.0, 161)


def test_reduced_loops_agree_with_the_model_that_made_them() -> None:
    one = record(repeats=1, scatter=0.0, samples=400)
    observed = reduce(one)
    setup = nominal("sensor")
    residual = observed.values[0] - observed.layout.observed(simulate(states(), setup, observed.layout.cycles))
    scaled = residual / observed.noise[0]
    plateau, stick = (scaled[observed.layout.of_kind(kind)] for kind in (PlateauForce, Stick))
    assert np.sqrt(np.nanmean(plateau**2)) < 2.0
    assert np.sqrt(np.nanmean(stick**2)) < 3.0


def test_coarse_loops_are_read_at_their_samples() -> None:
    layout = reduce(record(repeats=1, samples=36)).layout
    (sites,) = (part.sites for part in layout if isinstance(part.observable, Stick))
    assert len({round(float(level), 6) for level in sites.level}) > 12


def test_noise_that_neighbours_share_counts_for_more() -> None:
    one = record(repeats=1, samples=400)
    random = np.random.default_rng(5)

    def coloured(size: int) -> Array:
        noise = np.zeros(size)
        for i, kick in enumerate(random.standard_normal(size)):
            noise[i] = 0.8 * noise[i - 1] + 0.6 * kick
        return noise

    loops = tuple(
        replace(loop, tangential_force_N=loop.tangential_force_N + 2.0 * NOISE_N * coloured(loop.time_s.size))
        for loop in one.loops
    )
    white, red = (reduce(replace(one, loops=own)) for own in (one.loops, loops))
    plain, shared = (float(np.nanmedian(own.noise[0, own.layout.of_kind(PlateauForce)])) for own in (white, red))
    # Independent noise of that size would raise the error by √5 = 2.24.
    assert shared > 2.5 * plain


def test_one_outlier_on_a_stick_branch_hardly_moves_its_reading() -> None:
    one = next(iter(reduce(record(repeats=1)).loops))
    x = np.concatenate([np.linspace(-60.0, -48.0, 13), np.linspace(-47.0, 60.0, 40)])
    force = np.minimum((x + 54.0) / 6.0, 1.0)
    readings = []
    for outlier in (0.0, 1.2):
        spoilt = force.copy()
        spoilt[2] += outlier
        branch = ObservedBranch(1, x, spoilt, 12)
        line = displacement_at(branch, 0.2, 0.1, replace(one, branches=(branch, branch)))
        assert line is not None
        readings.append(line.value)
    assert readings[0] == pytest.approx(-52.8, abs=0.05)
    # It counts as one sample of 1 µm.
    assert readings[1] == pytest.approx(readings[0], abs=1.0)


def test_a_gap_of_scars_alone_is_scored_on_the_fixed_wires() -> None:
    scars = [Site(1000, wire=wire, figure=figure) for wire in WIRES for figure in ("volume", "depth")]
    layout = Layout.of_sites(
        (PlateauForce(), [Site(cycle, 1) for cycle in (10, 100, 1000)]),
        (Stick(), [Site(cycle, 1, 0.1) for cycle in (10, 100, 1000)]),
        (ScarFigures(), scars),
    )
    late, second, scar = splits(layout)
    assert (late.held_out, second.held_out, scar.held_out) == ((1000,), (10, 1000), (1000,))
    assert [split.scar for split in (late, second, scar)] == ["", "", "fixed"]
    assert [(part.observable.name, *part.sites) for part in layout.taken(scar.test)] == [("scar", *scars[2:])]
    assert scar.train.sum() == len(layout) - 2
    assert not any(layout.of_kind(ScarFigures)[split.test].any() for split in (late, second))
    assert layout.of_kind(ScarFigures)[second.train].sum() == 4


def test_a_scar_held_out_at_a_cycle_without_a_loop_leaves_the_distances_of_all_loops() -> None:
    observed, setup = reduce(record(repeats=1)), nominal("sensor")
    stiff = replace(setup, compliance_um_per_N=0.0)
    at_the_scar, at_all = (physical_gap(states(), observed, stiff, setup, cycles) for cycles in ((777,), ()))
    assert at_the_scar == at_all
    before, after = at_all["slip_amplitude_um"]
    assert before > 5.0
    assert after < 1.0


def test_a_figure_of_the_evolution_that_jumps_is_left_out() -> None:
    one = record(repeats=1)
    columns = dict(one.evolution[0].columns)
    spoilt = columns["slip_amplitude_um"].copy()
    spoilt[3] *= 0.5
    cycle = int(columns["cycle"][3])
    bad = replace(one.evolution[0], columns={**columns, "slip_amplitude_um": spoilt})
    layout = reduce(replace(one, evolution=(bad,))).layout
    assert cycle not in layout.cycle[layout.of_kind(SlipAmplitude)]
    assert cycle in reduce(one).layout.cycle[reduce(one).layout.of_kind(SlipAmplitude)]


@pytest.mark.parametrize("coefficient", [0.04, -0.04])
def test_half_the_range_of_the_force_is_read_as_the_largest_force_it_belongs_to(coefficient: float) -> None:
    one = record({"force_crosstalk": {"coefficient": coefficient}}, repeats=1)
    columns = dict(one.evolution[0].columns)
    columns["max_tangential_force_N"] = columns["max_tangential_force_N"] - 0.04 * 2.0
    other = replace(one, evolution=(replace(one.evolution[0], columns=columns),))
    known, found = reduce(one), reduce(other)
    rows = known.layout.of_kind(LargestForce)
    assert rows.sum() > 3
    assert found.values[0, rows] == pytest.approx(known.values[0, rows], abs=0.01)


def test_a_record_that_never_slides_is_refused_in_a_sentence() -> None:
    one = record(repeats=1, cycles=(100,))
    x = one.loops[0].displacement_um
    stuck = replace(one.loops[0], tangential_force_N=0.002 * x)
    with pytest.raises(RecordError, match="no loop of the record"):
        reduce(replace(one, loops=(stuck,)))


def test_a_record_without_friction_says_what_to_add() -> None:
    stated = tables().model_copy(update={"stated": tables().stated.model_copy(update={"friction": None})})
    with pytest.raises(RecordError, match="does not give friction"):
        nominal_study(ExperimentRecord(stated, ()))


def test_height_and_slope_of_a_branch_are_features() -> None:
    layout = Layout.of_sites(
        (PlateauForce(), [Site(100, 1, x) for x in (-30.0, 0.0, 30.0)]), (NormalForce(), [Site(100)])
    )
    features = Features.of(layout, np.ones(4, dtype=bool))
    values = np.array([1.0, 2.0, 3.0, 7.0])
    assert features.of_each(values, np.ones(4, dtype=bool)) == pytest.approx([2.0, 1.0 / 30.0, 7.0])
    variances = features.variances(np.eye(4), np.ones(4, dtype=bool))
    assert variances == pytest.approx([1.0 / 3.0, 1.0 / 1800.0, 1.0])


def test_features_of_what_was_not_measured_are_unknown() -> None:
    layout = Layout.of_sites((PlateauForce(), [Site(100, 1, x) for x in (-30.0, 30.0)]))
    features = Features.of(layout, np.ones(2, dtype=bool))
    height, slope = features.of_each(np.array([1.0, np.nan]), np.array([True, False]))
    assert height == 1.0
    assert np.isnan(slope)


def test_late_cycles_are_left_out_first_then_every_second_one() -> None:
    assert held_out_cycles(np.array([100, 1000, 10000])) == [(10000,), (100, 10000)]
    assert held_out_cycles(np.array([100, 1000])) == [(1000,)]
    assert held_out_cycles(np.array([100, 100])) == []


@pytest.mark.parametrize(("before", "share", "supported"), [(3.0, 0.9, True), (3.0, 0.1, False), (1.02, 0.0, True)])
def test_an_explanation_must_hold_on_cycles_that_were_left_out(before: float, share: float, *, supported: bool) -> None:
    shrink = Shrink(before, 1.0, 1.0, share, (0.0, 1.0), share, (100,), None, None)
    assert shrink.supports is supported


@pytest.mark.parametrize(("predicted", "reach", "supported"), [(0.7, 0.8, True), (0.7, 0.3, False), (0.3, 0.8, False)])
def test_an_early_fit_that_leaves_a_size_open_refutes_nothing(
    predicted: float, reach: float, *, supported: bool
) -> None:
    shrink = Shrink(3.0, 2.8, 1.0, 0.1, (0.0, 0.2), predicted, (100,), None, None, reach=reach)
    assert shrink.supports is supported


def test_derivatives_are_those_of_the_observables() -> None:
    layout = Layout.of_sites((Amplitude(), [Site(100)]), (NormalForce(), [Site(100)]))
    change = derivatives(states(), nominal(), layout, {"load": 0.01, "amplitude": 0.01})
    assert change[1, 0] == pytest.approx(0.02, rel=0.01)
    assert change[0, 1] == pytest.approx(0.6, rel=0.02)
    assert abs(change[1, 1]) < 1e-6


def test_whitened_residuals_have_unit_variance() -> None:
    layout = Layout.of_sites((Amplitude(), [Site(100), Site(1000)]))
    covariance = np.array([[0.04, 0.01], [0.01, 0.09]])
    factor = np.linalg.inv(np.linalg.cholesky(covariance))
    problem = Problem(states(), nominal(), layout, np.zeros(2), factor, 0.0)
    whitened = problem.whitening @ covariance @ problem.whitening.T
    assert whitened == pytest.approx(np.eye(2), abs=1e-9)


def test_half_widths_and_areas_of_a_rectangle() -> None:
    x = np.array([[[-50.0, -50.0, 50.0], [50.0, 50.0, -50.0]]])
    q = np.array([[[-1.0, 1.0, 1.0], [1.0, -1.0, -1.0]]])
    assert loop_area(x, q) == pytest.approx([0.2])
    assert half_width(x, q) == pytest.approx([50.0])


def test_the_next_measurement_is_one_that_is_not_there_yet() -> None:
    belief = {"misalignment": 0.5, "friction_offset": 0.5}
    chosen = next_measurement(belief, (), frozenset())
    assert chosen is not None
    following = next_measurement(belief, (), frozenset({chosen[0]}))
    assert following is not None
    assert following[0].what != chosen[0].what
    assert next_measurement({"none": 1.0}, (), frozenset()) is None


def swept_scar(error_rad: float, reach_um: float) -> Array:
    """Depth on a wire along x after strokes of ±reach by one whose axis is off the right angle by that error."""
    x, y = np.meshgrid(LINE_um, LINE_um, indexing="ij")
    across = x * np.cos(error_rad) + y * np.sin(error_rad)
    past = np.maximum(np.abs(across) - reach_um, 0.0)
    depth: Array = np.maximum(DEPTH_um - (y**2 + past**2) / (2.0 * RADIUS_um), 0.0)
    return depth


@given(st.floats(-8.0, 8.0), st.floats(0.0, 60.0))
def test_the_skew_of_a_swept_scar_is_the_tangent_of_the_angle(error_deg: float, reach_um: float) -> None:
    error = np.radians(error_deg)
    skew = scar_skew(LINE_um, LINE_um, swept_scar(error, reach_um))
    assert skew == pytest.approx(-np.tan(error), abs=2e-3 + 0.03 * abs(error))


def test_a_map_without_a_scar_has_no_skew() -> None:
    assert np.isnan(scar_skew(LINE_um, LINE_um, np.zeros((161, 161))))


def test_the_computed_skew_is_that_of_the_angle() -> None:
    turned = replace(nominal(), crossing_error_rad=0.05)
    assert simulate(states(), turned, np.array([CYCLES[-1]])).skew == pytest.approx(-np.tan(0.05))


@pytest.mark.parametrize("angle_deg", [60.0, 90.0, 125.0])
def test_wires_at_the_stated_angle_have_the_skew_of_their_run_and_at_another_angle_its_shear_more(
    angle_deg: float,
) -> None:
    run = result()
    wires = {"diameter_mm": 0.45, "youngs_modulus_MPa": 2.1e5, "poissons_ratio": 0.3, "crossing_angle_deg": angle_deg}
    study = {
        "wires": wires,
        "contact": {"friction": 0.62},
        "conditions": {"normal_load_N": 2.0, "displacement_amplitude_um": 60.0},
    }
    # Its scars are bowls along the motion, without any skew, as no rigid sweep at such an angle leaves them.
    own = WearStates.of_run(replace(run, study=study))
    stated = np.radians(angle_deg - 90.0)
    skews = [
        simulate(own, replace(nominal(), crossing_error_rad=stated + more), np.array([CYCLES[-1]])).skew
        for more in (0.0, 0.05)
    ]
    assert skews[0] == pytest.approx(np.zeros(2), abs=1e-3)
    assert skews[1] == pytest.approx(np.full(2, np.tan(stated) - np.tan(stated + 0.05)), abs=1e-3)


def with_scars(error_deg: float) -> ExperimentRecord:
    """A gap-free record with scars of three repeats that are skewed by an angle."""
    plain = record(repeats=3)
    course = simulate(states(), nominal("sensor"), np.array([float(CYCLES[-1])]))
    random = np.random.default_rng(4)
    scars = []
    for repeat in (1, 2, 3):
        for wire, reach, figures in (("moving", 48.0, course.scars[0]), ("fixed", 6.0, course.scars[1])):
            depth = swept_scar(np.radians(error_deg + 0.1 * random.standard_normal()), reach)
            # As voluminous as the model's, so that nothing but the skew differs much.
            step = LINE_um[1] - LINE_um[0]
            scaled = depth * figures[0] / (depth.sum() * step**2)
            scars.append(
                MeasuredScar(repeat, wire, LINE_um, LINE_um, scaled + 0.02 * random.standard_normal(depth.shape))
            )
    return ExperimentRecord(plain.tables, plain.loops, plain.evolution, tuple(scars))


def test_the_skew_of_both_scars_is_observed() -> None:
    observed = reduce(with_scars(3.0))
    skews = observed.values[:, observed.layout.of_kind(ScarSkew)]
    assert skews.shape == (3, 2)
    assert skews == pytest.approx(-np.tan(np.radians(3.0)), abs=0.008)


@pytest.mark.slow
def test_a_crossing_angle_is_named_from_its_skew_and_undetectable_without_scars() -> None:
    skewed = with_scars(4.0)
    observed = reduce(skewed)
    # The states' scars are no swept ones, so only the skew is compared.
    keep = ~observed.layout.of_kind(ScarFigures)
    only_skew = replace(
        observed,
        layout=observed.layout.taken(keep),
        values=observed.values[:, keep],
        noise=observed.noise[:, keep],
        common=observed.common[keep],
    )
    found = concluded(skewed, nominal_study(skewed), states(), only_skew).diagnosis
    assert found.verdict == "explained"
    (cause,) = (cause for cause in found.causes if cause.effect == "crossing_angle_error")
    low, high = cause.parameters["angle_deg"].interval95
    assert low < 4.0 < high
    assert "crossing_angle_error" not in found.undetectable
    assert "crossing_angle_error" in diagnosed(record()).diagnosis.undetectable
