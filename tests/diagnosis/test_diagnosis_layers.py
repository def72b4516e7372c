"""Rough layers that spread the contact: closed forms of fresh wires, what scars remember, and what loops show."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq

from geometry.arrays import Array
from tests.diagnosis.diagnosis_cases import diagnosed, nominal, record, states, with_effect
from tests.exam.independent_records import independent_record
from wirewear.diagnosis.surrogate.forward import PredictedLoops, simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.layered_wires import FlattenedWires, LayeredWires, flattened_wires
from wirewear.reference import kept_approach

CYCLES = np.array([1.0, 100.0, 1000.0, 3000.0, 10_000.0, 30_000.0, 100_000.0])
FIVE = {"layer_um": 5.0, "cycles": 10_000.0}


def wires() -> LayeredWires:
    return replace(states(), stroke_um=60.0).layered()


def course(setup: SurrogateInputs | None = None, **changed: float) -> PredictedLoops:
    rough = with_effect(setup or nominal(), "roughness_compliance", {**FIVE, **changed})
    return simulate(replace(states(), stroke_um=60.0), rough, CYCLES)


@pytest.mark.seconds
def test_a_layer_without_height_changes_no_slope_and_no_contact() -> None:
    assert np.all(wires().at(np.zeros(3), np.zeros(3), np.array([0.0, 0.3, 20.0]))[:, :-1] == 0.0)
    depth, extent = wires().scar(0.0, 3.0)
    assert np.all(depth == 0.0)
    assert np.all(extent == 0.0)


def test_a_groove_worn_under_a_layer_rises_earlier_and_ends_lower_than_one_worn_without() -> None:
    slope = wires().at(np.full(1, 0.3), np.full(1, 0.3), np.array([3.0]))[0, :-3]
    inside = slice(1, slope.size // 2 + 1)
    assert np.all(slope[inside] > 0.0)
    assert slope[-1] < -slope[inside].max()
    assert slope[0] == pytest.approx(0.0, abs=1e-12)


def test_debris_that_spreads_the_pressure_leaves_lower_hooks_than_debris_that_is_a_spring() -> None:
    def tips(spreading: float) -> Array:
        bed = {"retained_fraction": 0.3, "modulus_MPa": 900.0, "spreading": spreading}
        found = simulate(replace(states(), stroke_um=60.0), with_effect(nominal(), "third_body", bed), CYCLES)
        return np.asarray(found.tangential_force_N[:, 0].max(axis=1))

    less = tips(0.0) - tips(1.0)
    assert np.all(less[4:] > 0.01)
    assert abs(less[0]) < 0.1 * less.max()


def test_a_layer_unloaded_by_wear_lifts_the_wire_by_less_than_its_height() -> None:
    stiff, soft = (
        course(replace(nominal(), normal_spring_N_per_um=spring), cycles=1e9).normal_force_N[:, 0, 0]
        for spring in (0.01, 0.0)
    )
    lifted_um = (stiff - soft) / 0.01
    assert np.all(np.diff(lifted_um) > 0.1)
    assert lifted_um[-1] < FIVE["layer_um"]


def test_without_wear_a_layer_of_constant_height_lifts_no_wire_whatever_the_slip() -> None:
    own = replace(nominal(), normal_spring_N_per_um=0.01, wear_um3_per_mJ=0.0)
    soft = with_effect(own, "tangential_compliance", {"stiffness_N_per_mm": 100.0})
    found = course(
        with_effect(soft, "friction_evolution", {"initial": 0.3, "final": 0.9, "cycles": 1000.0}), cycles=1e9
    )
    assert np.ptp(found.slip_um) > 20.0
    assert found.normal_force_N == pytest.approx(own.load_N, abs=1e-6)


def test_layers_of_springs_and_of_asperities_give_way_alike_where_the_closure_is_the_height() -> None:
    """A spring of s/P is that of asperities with an exponential law: closures over heights are the ratio of both."""
    rigid = replace(nominal(), stick_factor=1e6)
    none, spring, spread = (
        course(rigid, cycles=1e9, layer_um=height, spreading=part)
        for height, part in ((0.0, 0.0), (5.0, 0.0), (5.0, 1.0))
    )
    unit = states().radius_um / spread.slip_um[0] ** 2
    closed = wires().at(np.array([5.0 * unit]), np.array([5.0 * unit]), np.zeros(1))[0, -1]
    lost = [one.slip_um[0] - none.slip_um[0] for one in (spring, spread)]
    assert lost[1] / lost[0] == pytest.approx(closed, rel=0.02)


CYCLES_OF_FLATTENING = np.array([1.0, 100.0, 1000.0, 3000.0, 10_000.0, 100_000.0])


def wires_of_flattening() -> FlattenedWires:
    return replace(states(), stroke_um=60.0).flattened()


def course_of_flattening(flattening_um: float) -> PredictedLoops:
    flat = with_effect(nominal(), "plasticity", {"flattening_um": flattening_um})
    return simulate(replace(states(), stroke_um=60.0), flat, CYCLES_OF_FLATTENING)


def test_flats_have_the_volumes_of_closed_forms_and_no_hooks_at_first_but_steep_ends_later() -> None:
    deepest, stroke = wires_of_flattening().flattenings[-1], 60.0 / 52.0
    cap, groove = 0.5 * np.pi * deepest**2, 4.0 / 3.0 * stroke * deepest * np.sqrt(2.0 * deepest)
    assert wires_of_flattening().table.volume[-1, 0] == pytest.approx([groove + cap, cap], rel=0.03)
    slope = wires_of_flattening().at(np.full(3, 0.17), similarity=np.array([0.0, 0.3, 20.0])).slope
    inner = wires_of_flattening().positions < 0.6
    assert np.all(np.abs(slope[0]) < 0.02)
    assert slope[1, -1] > 0.05
    assert slope[1, -1] > 5.0 * np.abs(slope[1, inner]).max()
    assert 0.0 < slope[2, -1] < 0.2 * slope[1, -1]


def test_the_moving_scar_is_deeper_the_fixed_one_shallower_and_the_flats_count_in_both() -> None:
    flat, sharp = course_of_flattening(2.0), course_of_flattening(0.0)
    assert flat.scars[0, 1] > sharp.scars[0, 1] + 0.2
    assert flat.scars[1, 1] < sharp.scars[1, 1] - 0.1
    # πR h²/2 of the cap alone, and the groove of 4/3 · 2 · 60 µm · h sqrt(2 R h)/2 beside it.
    gained = flat.scars[:, 0].sum() - sharp.scars[:, 0].sum() - (flat.volume_um3[-1] - sharp.volume_um3[-1])
    assert gained == pytest.approx(np.pi * 225.0 * 4.0 + 80.0 * 2.0 * 30.0, rel=0.1)


def test_bodies_that_yield_as_stated_have_no_effect_and_harder_ones_lack_the_print() -> None:
    at = np.array([100.0])
    stated = replace(nominal(), print_um=1.0)
    plain, elastic = (simulate(states(), setup, at).scars for setup in (stated, nominal()))
    softer, same, harder, soft = (
        simulate(states(), with_effect(setup, "plasticity", {"yield_stress_MPa": stress}), at).scars
        for setup, stress in ((stated, 200.0), (stated, yield_MPa(1.0)), (stated, 1e5), (nominal(), yield_MPa(1.0)))
    )
    assert same == pytest.approx(plain, rel=1e-9)
    assert np.all(softer[:, 0] > plain[:, 0])
    assert (plain - harder)[:, :2] == pytest.approx((soft - elastic)[:, :2], rel=0.02)


def test_sliding_prints_one_body_deeper_than_the_other_and_both_deeper_than_pressing() -> None:
    """Full runs of three cycles: wires of 450 MPa have prints of 0.60 and 1.38 µm and 4 360 µm³, 0.98 µm together if
    pressed; of 750 MPa 0.39 and 0.73 µm and 1 240 µm³, of 0.58 µm.
    """
    wires = replace(states(), slip_um=np.full(13, 52.07), stroke_um=60.0).flattened(slid=True)
    unit = 52.07**2 / 225.0
    printed = wires.at(np.array([0.98, 0.58]) / unit, similarity=np.zeros(2))
    assert unit * 52.07**2 * printed.volume.sum(axis=1) == pytest.approx([4360.0, 1240.0], rel=0.17)
    assert unit * printed.depth == pytest.approx(np.array([[0.60, 1.38], [0.39, 0.73]]), rel=0.26)


@pytest.mark.seconds
def test_prints_of_a_contact_that_is_small_against_its_stroke_grow_evenly_with_what_pressing_keeps() -> None:
    """All that touches comes to the limit there."""
    volumes = [float(flattened_wires(0.48, 1.15, own, along=0.75, slid=True).volumes[-1]) for own in (1.16, 1.29)]
    assert volumes[1] / volumes[0] == pytest.approx((1.29 / 1.16) ** 2, rel=0.1)


@pytest.mark.first_case
@pytest.mark.parametrize("slip_um", [52.0, 150.0])
def test_prints_are_followed_as_deep_as_the_softest_metal_keeps_them_and_no_deeper(slip_um: float) -> None:
    own = replace(states(), slip_um=np.full(13, slip_um), stroke_um=slip_um)
    radius_mm = 1e-3 * float(np.sqrt(own.fresh_area_um2 / np.pi))
    softest = 120.0 / 4650.0 * 1.5 * 2.0 / (np.pi * radius_mm**2)
    kept = 1e3 * kept_approach(2.0, radius_mm, 1e-3 * own.radius_um, softest)
    assert 0.9 < own.flattened(slid=True).flattenings[-1] * slip_um**2 / own.radius_um / kept < 1.5


def yield_MPa(flattening_um: float) -> float:
    """The yield stress of bodies that keep this approach."""
    mean_um, radius_mm = (states().fresh_area_um2 / np.pi) ** 0.5, 1e-3 * states().radius_um

    def missed(stress: float) -> float:
        return 1e3 * kept_approach(2.0, 1e-3 * mean_um, radius_mm, stress) - flattening_um

    return float(brentq(missed, 20.0, 2500.0, xtol=1e-10))


@pytest.mark.slow
def test_a_yield_stress_is_distinguished_from_wear_that_changes() -> None:
    soft = yield_MPa(2.0)
    one = diagnosed(record({"plasticity": {"yield_stress_MPa": soft}}))
    probabilities = one.weighed.probabilities
    assert max(probabilities, key=lambda names: probabilities[names]) == ("plasticity",)
    (cause,) = (cause for cause in one.diagnosis.causes if cause.effect == "plasticity")
    low, high = cause.parameters["yield_stress_MPa"].interval95
    assert low < soft < high


LEANING = {"angle_deg": 2.5}
Loop = tuple[Array, Array, Array]  #: Of the first loop: displacement, tangential and normal force.


@cache
def independent(*, leaning: bool) -> Loop:
    loop = independent_record({"misalignment": LEANING} if leaning else None, repeats=1, drive="stroke").loops[0]
    assert loop.normal_force_N is not None
    return loop.displacement_um, loop.tangential_force_N, loop.normal_force_N


@cache
def predicted(*, leaning: bool) -> Loop:
    setup = nominal("stroke")
    course = simulate(states(), with_effect(setup, "misalignment", LEANING) if leaning else setup, np.array([100.0]))
    channels = course.displacement_um, course.tangential_force_N, course.normal_force_N
    x, q, p = (channel[0].ravel() for channel in channels)
    return x, q, p


def ripple_N_per_um(plain: Loop, leaning: Loop) -> float:
    """By which the load rises along the motion; the noise of both records is the same."""
    return float(np.polyfit(leaning[0], leaning[2] - plain[2], 1)[0])


def bend_um(loop: Loop) -> float:
    """Displacement at ±1 N less twice that at none, mean over both branches while they stick."""
    x, q = np.roll(loop[0], -int(np.argmin(loop[0]))), np.roll(loop[1], -int(np.argmin(loop[0])))
    top, means = int(np.argmax(x)), np.zeros(3)
    for branch in (slice(0, top), slice(top, None)):
        near = np.abs(q[branch]) < 1.15
        order = np.argsort(q[branch][near])
        means += 0.5 * np.interp([-1.0, 0.0, 1.0], q[branch][near][order], x[branch][near][order])
    return float(means[0] + means[2] - 2.0 * means[1])


@pytest.mark.slow
def test_a_wire_that_climbs_presses_the_spring_and_the_holder_yields_to_force_along_the_motion() -> None:
    model, rig = (ripple_N_per_um(of(leaning=False), of(leaning=True)) for of in (predicted, independent))
    assert rig > 3e-5
    assert model == pytest.approx(rig, rel=0.1)
    # Without it, branches of a misaligned contact look as if the reading leant with the square of the force.
    model, rig = (bend_um(of(leaning=True)) - bend_um(of(leaning=False)) for of in (predicted, independent))
    assert model == pytest.approx(rig, abs=0.1)
