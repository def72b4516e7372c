"""What effects make of a test as fast models take it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solvers import RoughLayer, ThirdBody
from tests.studies import coarse
from wirewear.base.course import Course
from wirewear.effects import Ageing, Chain, Effect, all_effects, effect_named

CYCLES = np.array([1.0, 100.0, 3000.0, 1e5])

everyone = pytest.mark.parametrize("kind", all_effects().values(), ids=list(all_effects()))


def chain() -> Chain:
    """Four moments of a test in which nothing but wear changes."""
    nothing = np.zeros(4)
    return Chain(
        radius_um=225.0,
        fresh_area_um2=640.0,
        cycles=CYCLES,
        energy_J=2.5e-4 * CYCLES,
        worn_um3=7.5 * CYCLES,
        load_N=nothing + 2.0,
        misalignment_rad=nothing,
        friction=nothing + 0.62,
        wear_um3_per_mJ=nothing + 30.0,
        retained_fraction=nothing,
        bed_MPa=nothing,
        oxygen_W=nothing,
        starved_factor=nothing + 1.0,
        compliance_um_per_N=nothing + 6.0,
        free_play_um=nothing,
        flattening_um=nothing,
        rough_um=nothing,
        bed_um=nothing,
        crossing_error_rad=nothing,
        gain=nothing + 1.0,
        linear_um_per_N=nothing,
        quadratic_um_per_N2=nothing,
        crosstalk=nothing,
        force_zero_N=nothing,
        lag_s=nothing,
        force_lag_s=nothing,
    )


def effect(name: str, **values: float) -> Effect[Any]:
    return effect_named(name)(**values)


def changes(one: Effect[Any]) -> dict[str, Any]:
    """What is another one in the chain with the effect, by name."""
    before, after = vars(chain()), vars(one.foreseen(chain()))
    same = {name for name, value in after.items() if np.allclose(value, before[name], rtol=1e-12, atol=1e-15)}
    return {name: value for name, value in after.items() if name not in same}


@everyone
def test_an_effect_at_its_neutral_values_leaves_the_chain_as_it_is(kind: type[Effect[Any]]) -> None:
    assert changes(kind.neutral(coarse().stated)) == {}


@everyone
def test_an_effect_follows_over_a_test_what_it_says_it_does(kind: type[Effect[Any]]) -> None:
    one = kind.sized("easy", coarse().stated)
    worn = replace(chain(), energy_J=chain().energy_J[::-1], worn_um3=chain().worn_um3[::-1])
    early, late = vars(one.foreseen(chain())), vars(one.foreseen(worn))
    columns = changes(one)
    assert all(np.ptp(early[name]) == 0.0 for name in columns) is (kind.ages is Ageing.NEVER)
    assert all(np.array_equal(early[name], late[name]) for name in columns) is (kind.ages is not Ageing.BY_WEAR)


@pytest.mark.parametrize(
    ("name", "values", "column", "expected"),
    [
        ("tangential_compliance", {"stiffness_N_per_mm": 250.0}, "compliance_um_per_N", 6.0 + 1e3 / 250.0),
        (
            "rotational_compliance",
            {"stiffness_N_mm_per_rad": 9e4, "arm_mm": 30.0},
            "compliance_um_per_N",
            6.0 + 1e3 * 30.0**2 / 9e4,
        ),
        ("free_play", {"gap_um": 3.0}, "free_play_um", 3.0),
        ("friction_offset", {"friction": 0.5}, "friction", 0.5),
        (
            "friction_evolution",
            {"initial": 0.4, "final": 0.7, "cycles": 3000.0},
            "friction",
            Course(0.4, 0.7, 3000.0).at(CYCLES),
        ),
        ("plasticity", {"flattening_um": 1.5}, "flattening_um", 1.5),
        ("crossing_angle_error", {"angle_deg": 4.0}, "crossing_error_rad", np.radians(4.0)),
        ("misalignment", {"angle_deg": -2.0}, "misalignment_rad", -np.radians(2.0)),
        ("normal_load_drift", {"fraction_per_100k_cycles": 0.3}, "load_N", 2.0 * (1.0 + 3e-6 * CYCLES)),
        ("wear_rate_offset", {"factor": 1.4}, "wear_um3_per_mJ", 42.0),
        (
            "wear_rate_evolution",
            {"initial_factor": 3.0, "final_factor": 0.5, "cycles": 1e4},
            "wear_um3_per_mJ",
            30.0 * Course(3.0, 0.5, 1e4).at(CYCLES),
        ),
        ("displacement_gain", {"gain": 1.05}, "gain", 1.05),
        ("force_crosstalk", {"coefficient": 0.03}, "crosstalk", 0.03),
        ("sensor_lag", {"time_s": 0.003}, "lag_s", 0.003),
    ],
)
def test_an_effect_changes_one_column_as_its_closed_form_says(
    name: str, values: dict[str, float], column: str, expected: float | np.ndarray
) -> None:
    (found,) = changes(effect(name, **values)).items()
    assert found[0] == column
    assert found[1] == pytest.approx(np.broadcast_to(expected, 4), rel=1e-12)


def test_a_rough_layer_is_a_spring_and_spreads_the_pressure_by_its_height() -> None:
    found = changes(effect("roughness_compliance", layer_um=1.0, cycles=3000.0))
    height = np.exp(-CYCLES / 3000.0)
    assert set(found) == {"compliance_um_per_N", "rough_um"}
    # 1.21 s/P.
    assert found["compliance_um_per_N"] == pytest.approx(6.0 + 0.605 * height)
    assert found["rough_um"] == pytest.approx(height)


def test_debris_softens_the_contact_the_more_the_larger_the_scar_up_to_a_limit() -> None:
    found = changes(effect("third_body", retained_fraction=0.4, modulus_MPa=500.0))
    added = found["compliance_um_per_N"] - 6.0
    assert np.all(np.diff(added) > 0.0)
    assert added[-1] == pytest.approx(0.5 * 0.4 / (np.pi * 225.0 * 0.286e-6 * 500.0), rel=1e-3)
    assert found["retained_fraction"] == pytest.approx(np.full(4, 0.4))


def test_debris_spreads_the_pressure_as_a_rough_layer_does_that_closes_as_much_under_the_mean_pressure() -> None:
    found = changes(effect("third_body", retained_fraction=0.4, modulus_MPa=500.0))
    own = chain()
    area_um2 = np.sqrt(own.worn_area2_um4)
    pressure_MPa = 1e6 * own.load_N / (area_um2 + own.fresh_area_um2)
    for worn_um, pressure, height_um in zip(own.worn_um3 / area_um2, pressure_MPa, found["bed_um"], strict=True):
        bed, _ = ThirdBody(0.4, 500.0).closure(np.array([pressure]), np.array([1e-3 * worn_um]))
        layer, _ = RoughLayer(1e-3 * height_um).closure(np.array([pressure]), np.zeros(1))
        assert layer == pytest.approx(bed)
    assert set(changes(effect("third_body", retained_fraction=0.4, modulus_MPa=500.0, spreading=0.0))) == {
        "retained_fraction",
        "bed_MPa",
        "compliance_um_per_N",
    }


def test_effects_on_one_seam_act_one_after_the_other() -> None:
    slower = effect("friction_evolution", initial=0.4, final=0.7, cycles=3000.0).foreseen(chain())
    play = effect("free_play", gap_um=2.0)
    assert play.foreseen(play.foreseen(slower)).free_play_um == pytest.approx(np.full(4, 4.0))
    drifting = effect("normal_load_drift", fraction_per_100k_cycles=0.3).foreseen(chain())
    leaning = effect("misalignment", angle_deg=2.0).foreseen(drifting)
    assert leaning.load_N == pytest.approx(drifting.load_N)
