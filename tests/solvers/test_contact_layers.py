"""Layers between the surfaces and on them: rough ones, debris, films; how long one lasts, how it rubs, what is said."""

from dataclasses import replace
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import solvers
from solvers.adaptive_loop import closed_adaptive_cycle
from solvers.contact import ContactProblem, press, unloaded_state
from solvers.contact_state import ContactState, Holder, WearState
from solvers.drive import Drive
from solvers.fretting import first_quarter
from solvers.laws.layers import RoughLayer, ThirdBody, layers_at_nodes, receded
from solvers.wear import WearRates
from tests.bodies import FRICTION, LOAD_N, AMPLITUDE_mm, RIG_N_per_mm, crossed_wires, driven, pressed
from tests.simulation.coarse_runs import coarse
from tests.solvers.wear_jumps import LINE_LOAD_N_per_mm, line_contact
from tests.studies import line_study
from wirewear import run_study
from wirewear.base.errors import StudyError
from wirewear.loops.sensor import enclosed_area
from wirewear.pictures.scar_maps import scars_from_above
from wirewear.simulation import simulate
from wirewear.views.run_words import sentence

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


def test_layers_wear_one_after_another_as_their_differential_equation_says() -> None:
    layers = (solvers.SurfaceLayer(2e-3, 0.25), solvers.SurfaceLayer(1e-3, 4.0))
    depth, bare, steps = np.array([0.0, 1e-3, 2.9e-3, 5e-3]), 1e-2, 20_000
    worn = depth.copy()
    for _ in range(steps):
        worn += bare / steps * np.select([worn < 2e-3, worn < 3e-3], [0.25, 4.0], 1.0)
    assert depth + receded(layers, depth, np.full(4, bare)) == pytest.approx(worn, abs=5e-6)
    halfway = depth + receded(layers, depth, np.full(4, 0.5 * bare))
    assert halfway + receded(layers, halfway, np.full(4, 0.5 * bare)) == pytest.approx(worn, abs=5e-6)


@pytest.mark.slow
def test_a_coat_in_gross_slip_lasts_as_long_as_the_segment_of_the_cylinder_that_it_loses() -> None:
    """A cylinder that wears on a flat that does not becomes flat: A = 4/3 t √(2Rt) when it is worn by t."""
    radius_mm, thickness_mm, share = 6.0, 0.009, 0.5
    energy_mm3_per_J, friction, load, ends = 8e-4, 0.6, 30.0, [1, 1000, 10_000, 20_000]
    coat = {"thickness_um": 1e3 * thickness_mm, "wear_factor": share}
    wear = {"pad_energy_mm3_per_J": energy_mm3_per_J, "specimen_energy_mm3_per_J": 0.0}
    result = simulate(line_study(pad={"layers": [coat]}, wear=wear, log={"loop_cycles": ends}), fidelity="quick")
    area_mm2 = 4.0 / 3.0 * thickness_mm * sqrt(2.0 * radius_mm * thickness_mm)
    slip_mm = 1e-3 * float(result.evolution["slip_amplitude_um"][-2])
    per_cycle = 1e-3 * share * energy_mm3_per_J * 4.0 * friction * load * slip_mm
    (found,) = result.worn_through("pad")
    assert found == pytest.approx(area_mm2 / per_cycle, rel=0.02)
    assert result.worn_through("specimen") == ()
    # Wear goes on in the cylinder itself, twice as fast.
    volume, energy_J = result.evolution["worn_volume_pad_mm3"], result.evolution["accumulated_energy_J"]
    assert volume[2] / energy_J[2] == pytest.approx(share * energy_mm3_per_J, rel=1e-6)
    assert volume[-1] / energy_J[-1] > 1.05 * share * energy_mm3_per_J


def pulled(problem: solvers.ContactProblem, worn_mm: tuple[float, float] = (0.0, 0.0)) -> float:
    """Friction of a cylinder on a flat that slide, worn evenly by so much, over load and the coefficient."""
    fresh = solvers.unloaded_state(problem)
    depths = [depth + more for depth, more in zip(fresh.wear.depths, worn_mm, strict=True)]
    start = replace(fresh, wear=replace(fresh.wear, primary_depth=depths[0], secondary_depth=depths[1]))
    last = driven(problem, solvers.press(problem, start)[0], np.array([0.005, 0.01]))[1][-1][-1]
    assert last.sticking == 0
    return last.tangential_force / LINE_LOAD_N_per_mm / FRICTION


def test_a_layer_rubs_by_its_own_friction_until_it_is_worn_through() -> None:
    coat, skin = solvers.SurfaceLayer(3e-3, 1.0, 0.5), solvers.SurfaceLayer(5e-3, 1.0, 0.8)
    coated = line_contact(wear=solvers.WearRates(1e-9, 1e-9, upper_layers=(coat,)))
    assert pulled(coated) == pytest.approx(0.5, rel=5e-3)
    assert pulled(coated, (3e-3, 0.0)) == pytest.approx(1.0, rel=5e-3)
    assert pulled(coated, (2.85e-3, 0.0)) == pytest.approx(0.75, rel=5e-3)
    both = line_contact(wear=solvers.WearRates(1e-9, 1e-9, upper_layers=(coat,), lower_layers=(skin,)))
    assert pulled(both) == pytest.approx(0.65, rel=5e-3)
    assert pulled(both, (4e-3, 0.0)) == pytest.approx(0.8, rel=5e-3)


def test_a_run_of_wires_states_when_a_layer_was_worn_through_and_shows_where(tmp_path: Path) -> None:
    bare = coarse().with_values({"fidelity.quick.contact_mesh_um": 12.0, "conditions.cycles": 100})
    deepest = run_study(bare, fidelity="quick", output=tmp_path / "bare")[0].evolution["max_depth_fixed_um"]
    layers = [{"thickness_um": 0.5 * float(deepest[-1]), "wear_factor": 0.9, "friction": 0.5}]
    coated = bare.with_values({"wires.fixed.layers": layers})
    rates = coated.tables.wear_rates
    assert rates.lower_layers == ()
    assert rates.upper_layers[0].friction_factor == pytest.approx(0.5 / bare.contact.friction)
    result = run_study(coated, fidelity="quick", output=tmp_path / "coated")[0]
    (through,) = result.worn_through("fixed")
    assert through is not None
    cycles, depth = result.evolution["cycle"], result.evolution["max_depth_fixed_um"]
    assert depth[cycles < through].max() < layers[0]["thickness_um"] < depth[-1]
    assert f"layers, from the outermost, are worn through at cycle {round(through)}." in sentence(result)
    maps = scars_from_above([result]).axes[:2]
    assert [any("Contour" in type(one).__name__ for one in axes.collections) for axes in maps] == [False, True]


def test_a_layers_friction_needs_friction_in_the_contact() -> None:
    layers = {"layers": [{"thickness_um": 2.0, "friction": 0.2}]}
    with pytest.raises(StudyError, match=r"layers in study.toml give a friction of their own, which goes with"):
        line_study(pad=layers, contact={"friction": 0.0})
    with pytest.raises(StudyError, match=r"give a friction of their own, which goes with a friction above 0"):
        coarse().with_values({"contact.friction": 0.0, "wires.fixed.layers": layers["layers"]})
    with pytest.raises(StudyError, match="thickness_um"):
        line_study(pad={"layers": [{"thickness_um": -2.0}]})
