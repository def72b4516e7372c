"""Layers between the surfaces: roughness that stiffens with pressure, and debris that carries the load."""

from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from solvers.adaptive_loop import closed_adaptive_cycle
from solvers.contact import ContactProblem, press, unloaded_state
from solvers.contact_state import ContactState, Holder, WearState
from solvers.drive import Drive
from solvers.fretting import first_quarter
from solvers.layers import RoughLayer, ThirdBody, layers_at_nodes
from solvers.wear import WearRates
from tests.bodies import LOAD_N, AMPLITUDE_mm, RIG_N_per_mm, crossed_wires, driven, pressed
from wirewear.loops.sensor import enclosed_area

pytestmark = pytest.mark.seconds
COARSE_mm = 0.010
STEPS = AMPLITUDE_mm * np.sin(0.5 * np.pi * np.arange(1, 6) / 5)
ROUGH = RoughLayer(2e-4, 100.0)


@pytest.fixture(scope="module")
def smooth() -> ContactProblem:
    return crossed_wires(COARSE_mm, long_patch=True, rig_N_per_mm=RIG_N_per_mm)


def worn_by(problem: ContactProblem, depth_mm: float) -> WearState:
    """Both wires worn by the same depth everywhere."""
    fresh = unloaded_state(problem).wear
    return replace(
        fresh,
        primary_depth=np.full(problem.primary.patch.shape, depth_mm),
        secondary_depth=np.full(problem.secondary.patch.shape, depth_mm),
    )


def test_the_rough_layer_closes_by_its_law_and_stiffens_with_the_pressure() -> None:
    pressure = np.array([0.0, 100.0, 300.0, 700.0])
    closure, slope = ROUGH.closure(pressure, np.zeros(4))
    assert closure == pytest.approx(2e-4 * np.log([1.0, 2.0, 4.0, 8.0]), abs=1e-15)
    assert 1.0 / slope == pytest.approx((pressure + 100.0) / 2e-4)
    step = 1e-3
    shear, change = ROUGH.shear_compliance(pressure + step, np.zeros(4))
    assert shear[1:] * pressure[1:] == pytest.approx(1.21 * closure[1:], rel=1e-4)
    assert (shear - ROUGH.shear_compliance(pressure - step, np.zeros(4))[0])[1:] / (2.0 * step) == pytest.approx(
        change[1:], rel=1e-3
    )


def test_a_layer_softens_contact_by_its_closure_without_penetration_or_lost_load(smooth: ContactProblem) -> None:
    bare, _ = pressed(smooth)
    rough, report = pressed(replace(smooth, layers=(ROUGH,)))
    closure, _ = ROUGH.closure(rough.traction[:, 2], np.zeros(len(rough.traction)))
    loaded = rough.traction[:, 2] > 0.0
    assert report.normal_force == pytest.approx(LOAD_N, rel=1e-9)
    assert report.penetration < 1e-4
    assert report.complementarity < 1e-4
    # The approach grows by about the layer's closure where the load is, less what the lower pressure saves.
    extra = bare.holder_z - rough.holder_z
    mean = float(closure[loaded] @ rough.traction[loaded, 2] / rough.traction[loaded, 2].sum())
    assert 0.6 * mean < extra < 1.05 * mean


def lightly_pressed(problem: ContactProblem, load_N: float, wear: WearState | None = None) -> tuple[float, float]:
    """Approach and highest pressure under a load at which the wires themselves hardly give way."""
    light = replace(problem, holder=Holder(load_N))
    start = unloaded_state(light)
    with threadpool_limits(limits=1, user_api="blas"):
        state, report = press(light, start if wear is None else replace(start, wear=wear))
    return -state.holder_z, report.max_pressure


def test_a_soft_bed_of_debris_is_pressed_as_a_winkler_foundation(smooth: ContactProblem) -> None:
    load, modulus, depth, radius = 0.002, 10.0, 1e-3, 0.225
    found, pressure = lightly_pressed(replace(smooth, layers=(ThirdBody(0.5, modulus),)), load, worn_by(smooth, depth))
    # p = (M / h) (delta - r^2 / 2 R) gives P = pi M R delta^2 / h; the unfilled half of both depths comes on top.
    delta = (load * depth / (np.pi * modulus * radius)) ** 0.5
    assert found - depth == pytest.approx(delta, rel=0.03)
    assert pressure == pytest.approx(modulus * delta / depth, rel=0.03)


def test_a_soft_rough_layer_carries_the_load_of_its_exponential_law(smooth: ContactProblem) -> None:
    layer, radius = RoughLayer(1.5e-3, 0.2), 0.225
    delta = 1.7 * layer.decay_mm
    # P = 2 pi R int_0^delta p_c (exp(w / s) - 1) dw.
    load = 2.0 * np.pi * radius * 0.2 * (layer.decay_mm * np.expm1(delta / layer.decay_mm) - delta)
    found, pressure = lightly_pressed(replace(smooth, layers=(layer,)), load)
    assert found == pytest.approx(delta, rel=0.03)
    assert pressure == pytest.approx(0.2 * np.expm1(delta / layer.decay_mm), rel=0.03)


def stick_stiffness(problem: ContactProblem, state: ContactState | None = None) -> float:
    """Tangential stiffness of holder and contact for a motion that is small against slip, N/mm."""
    start = pressed(problem)[0] if state is None else state
    step = 2e-5
    _, reports = driven(problem, start, np.array([step]))
    return reports[-1][-1].tangential_force / step


def test_shear_of_a_bed_of_debris_is_in_series_with_the_contact(smooth: ContactProblem) -> None:
    # Worn alike everywhere, so that the bed has the same thickness at all nodes.
    depth, debris = 1e-3, ThirdBody(0.5, 1e4)
    rigid = replace(smooth, holder=Holder(LOAD_N), layers=(debris,))
    worn = replace(pressed(smooth)[0], wear=worn_by(smooth, depth))
    settled = driven(replace(rigid, friction=0.0), worn, np.zeros(1))[0][0]
    area = float(smooth.surface.areas[(settled.traction[:, 2] > 0.0)].sum())
    bed = area / float(debris.shear_compliance(np.ones(1), np.array([2.0 * depth]))[0][0])
    bare = stick_stiffness(replace(rigid, layers=()))
    assert 0.2 < bed / bare < 2.0
    assert 1.0 / stick_stiffness(rigid, settled) == pytest.approx(1.0 / bare + 1.0 / bed, rel=0.1)


def test_roughness_makes_the_stick_branch_soft_and_stiffens_with_the_load(smooth: ContactProblem) -> None:
    rigid = replace(smooth, holder=replace(smooth.holder, tangential_compliance_mm_per_N=0.0))
    rough = replace(rigid, layers=(ROUGH,))
    heavy = replace(rough, holder=replace(rough.holder, normal_load_N=2.0 * LOAD_N))
    light_stiffness, heavy_stiffness = stick_stiffness(rough), stick_stiffness(heavy)
    assert light_stiffness < 0.9 * stick_stiffness(rigid)
    assert heavy_stiffness > 1.3 * light_stiffness
    worn_in = replace(rigid, layers=(replace(ROUGH, decay_mm=ROUGH.decay_mm * np.exp(-20.0)),))
    assert stick_stiffness(worn_in) == pytest.approx(stick_stiffness(rigid), rel=1e-4)


def test_a_loop_through_a_thick_rough_layer_encloses_its_friction_work(smooth: ContactProblem) -> None:
    problem = replace(smooth, layers=(RoughLayer(4e-4, 100.0),))
    with threadpool_limits(1, user_api="blas"):
        start = first_quarter(problem, pressed(problem)[0], Drive(0.004), 16)
        _, loop = closed_adaptive_cycle(problem, start, Drive(0.004), 32)
    assert abs(enclosed_area(loop.drive, loop.tangential_force)) == pytest.approx(loop.friction_work, rel=1e-2)


def test_retained_debris_fills_the_scar_and_keeps_volume_equal_to_energy(smooth: ContactProblem) -> None:
    worn = {}
    for fraction in (0.0, 0.6):
        problem = replace(smooth, wear=WearRates(1e-8, 1e-8), layers=(ThirdBody(fraction),) if fraction else ())
        states, _ = driven(problem, pressed(problem)[0], STEPS, cycles=400.0)
        wear = worn[fraction] = states[-1].wear
        volume = float(wear.primary_depth.ravel() @ problem.surface.areas)
        assert volume == pytest.approx(1e-8 * wear.energy_mJ, rel=1e-9)
    # The gap opens less, so the contact spreads less and the same work digs deeper.
    assert worn[0.6].energy_mJ == pytest.approx(worn[0.0].energy_mJ, rel=0.02)
    assert worn[0.6].primary_depth.max() > 1.1 * worn[0.0].primary_depth.max()


def test_layers_add_up_in_series() -> None:
    worn, pressure = np.array([1e-3]), np.array([[0.0, 0.0, 200.0]])
    both = layers_at_nodes((ROUGH, ThirdBody(0.5, 1000.0)), worn, pressure, np.array([[0.0, 0.0, 1.0]]))
    assert both.closure(np.array([200.0]))[0][0] == pytest.approx(2e-4 * np.log(3.0) + 0.5e-3 * 0.2)
