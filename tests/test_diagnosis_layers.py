"""Rough layers that spread the contact: closed forms of fresh wires, what scars remember, and what loops show."""

from dataclasses import replace

import numpy as np
import pytest

from tests.diagnosis_cases import diagnosed, nominal, record, states, with_effect
from wirewear.diagnosis.model.forward import LoopCourse, simulate
from wirewear.diagnosis.model.layered_wires import LayeredWires
from wirewear.diagnosis.model.setup import Array, Setup

CYCLES = np.array([1.0, 100.0, 1000.0, 3000.0, 10_000.0, 30_000.0, 100_000.0])
FIVE = {"layer_um": 5.0, "cycles": 10_000.0}


def wires() -> LayeredWires:
    return replace(states(), stroke_um=60.0).layered()


def course(setup: Setup | None = None, **changed: float) -> LoopCourse:
    rough = with_effect(setup or nominal(), "roughness_compliance", {**FIVE, **changed})
    return simulate(replace(states(), stroke_um=60.0), rough, CYCLES)


@pytest.mark.seconds
def test_a_layer_without_height_changes_no_slope_and_no_contact() -> None:
    found = wires().at(np.zeros(3), np.zeros(3), np.array([0.0, 0.3, 20.0]))
    assert np.all(found[:, :-1] == 0.0)
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


@pytest.mark.slow
def test_a_layer_that_spreads_is_told_with_its_height() -> None:
    one = diagnosed(record({"roughness_compliance": FIVE}))
    probabilities = one.weighed.probabilities
    assert max(probabilities, key=lambda names: probabilities[names]) == ("roughness_compliance",)
