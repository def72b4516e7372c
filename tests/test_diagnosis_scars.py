"""What scars tell a diagnosis: their skew, and through it the crossing angle."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import Array
from tests.diagnosis_cases import CYCLES, NOISE_N, diagnosed, nominal, record, states
from tests.synthetic_results import result
from wirewear.diagnosis.diagnose import concluded
from wirewear.diagnosis.infer.inference import Problem
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.loop_states import scar_skew
from wirewear.diagnosis.model.nominal import nominal_study
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.channels import Amplitude
from wirewear.diagnosis.observe.observable import Site
from wirewear.diagnosis.observe.plateau import PlateauForce
from wirewear.diagnosis.observe.reduction import Layout, reduce
from wirewear.diagnosis.observe.scars import ScarFigures
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


def test_whitened_residuals_have_unit_variance() -> None:
    layout = Layout.of_sites((Amplitude(), [Site(100), Site(1000)]))
    covariance = np.array([[0.04, 0.01], [0.01, 0.09]])
    factor = np.linalg.inv(np.linalg.cholesky(covariance))
    problem = Problem(states(), nominal(), layout, np.zeros(2), factor, 0.0)
    whitened = problem.whitening @ covariance @ problem.whitening.T
    assert whitened == pytest.approx(np.eye(2), abs=1e-9)


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


def test_the_computed_skew_is_that_of_the_angle() -> None:
    turned = replace(nominal(), crossing_error_rad=0.05)
    assert simulate(states(), turned, np.array([CYCLES[-1]])).skew == pytest.approx(-np.tan(0.05))


@pytest.mark.parametrize("angle_deg", [60.0, 75.0, 90.0])
def test_wires_at_the_stated_angle_have_the_skew_of_their_run_and_at_another_angle_its_shear_more(
    angle_deg: float,
) -> None:
    run = result()
    wires = {"diameter_mm": 0.45, "youngs_modulus_MPa": 2.1e5, "poissons_ratio": 0.3, "crossing_angle_deg": angle_deg}
    asked = {"normal_load_N": 2.0, "displacement_amplitude_um": 60.0, "frequency_Hz": 3.0, "cycles": 100_000}
    study = {"format": 1, "name": "wires", "kind": "crossed-wires", "wires": wires, "conditions": asked}
    study["contact"] = {"friction": 0.62}
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
