"""Wires flattened before any wear: closed forms of the flats, what is remembered of them, and another model's hooks."""

from dataclasses import replace

import numpy as np
import pytest

from tests.diagnosis_cases import diagnosed, nominal, record, states, with_effect
from wirewear.diagnosis.model.flattened_wires import FlattenedWires
from wirewear.diagnosis.model.forward import LoopCourse, simulate

CYCLES = np.array([1.0, 100.0, 1000.0, 3000.0, 10_000.0, 100_000.0])


def wires() -> FlattenedWires:
    return replace(states(), stroke_um=60.0).flattened()


def course(flattening_um: float) -> LoopCourse:
    flat = with_effect(nominal(), "plasticity", {"flattening_um": flattening_um})
    return simulate(replace(states(), stroke_um=60.0), flat, CYCLES)


def test_the_flats_have_the_volumes_of_their_closed_forms() -> None:
    deepest, stroke = wires().flattenings[-1], 60.0 / 52.0
    cap, groove = 0.5 * np.pi * deepest**2, 4.0 / 3.0 * stroke * deepest * np.sqrt(2.0 * deepest)
    assert wires().table.volume[-1] == pytest.approx([groove + cap, cap], rel=0.03)


def test_flattened_wires_have_no_hooks_at_first_steep_ends_later_and_none_in_mid_stroke() -> None:
    volumes = np.array([0.0, 0.3, 20.0])
    slope = wires().at(np.full(3, 0.17), volumes).slope
    inner = wires().positions < 0.6
    assert np.all(np.abs(slope[0]) < 0.02)
    assert slope[1, -1] > 0.05
    assert slope[1, -1] > 5.0 * np.abs(slope[1, inner]).max()
    assert 0.0 < slope[2, -1] < 0.2 * slope[1, -1]


def test_the_moving_scar_is_deeper_the_fixed_one_shallower_and_the_flats_count_in_both() -> None:
    flat, sharp = course(2.0), course(0.0)
    assert flat.scars[0, 1] > sharp.scars[0, 1] + 0.2
    assert flat.scars[1, 1] < sharp.scars[1, 1] - 0.1
    # πR h²/2 of the cap alone, and the groove of 4/3 · 2 · 60 µm · h sqrt(2 R h)/2 beside it.
    gained = flat.scars[:, 0].sum() - sharp.scars[:, 0].sum() - (flat.volume_um3[-1] - sharp.volume_um3[-1])
    assert gained == pytest.approx(np.pi * 225.0 * 4.0 + 80.0 * 2.0 * 30.0, rel=0.1)


@pytest.mark.slow
def test_a_flattening_is_told_from_wear_that_changes() -> None:
    one = diagnosed(record({"plasticity": {"flattening_um": 2.0}}))
    probabilities = one.weighed.probabilities
    assert max(probabilities, key=lambda names: probabilities[names]) == ("plasticity",)
    (cause,) = (cause for cause in one.diagnosis.causes if cause.effect == "plasticity")
    low, high = cause.parameters["flattening_um"].interval95
    assert low < 2.0 < high
