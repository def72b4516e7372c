"""The library of effects: names and parameters, what a study may say, what is refused."""

import json
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from solvers import Holder, WearRates
from tests.studies import COARSE, coarse
from wirewear import StudyError, effects, parse_study
from wirewear.effects.holder import RotationalCompliance
from wirewear.effects.registry import effect_text
from wirewear.loops.sensor import Sensor
from wirewear.test.study import study_from_tables

#: Names and parameters that other programs and files rely on.
FIXED = {
    "tangential_compliance": ["stiffness_N_per_mm"], "rotational_compliance": ["stiffness_N_mm_per_rad", "arm_mm"],
    "free_play": ["gap_um"],
    "debris_balance": ["retained_fraction", "modulus_MPa", "leaving_share", "protecting_um"],
    "holder_inertia": ["mass_kg"], "friction_offset": ["friction"],
    "friction_evolution": ["initial", "final", "cycles"],
    "roughness_compliance": ["layer_um", "cycles"], "third_body": ["retained_fraction", "modulus_MPa"],
    "plasticity": ["yield_stress_MPa", "flattening_um"],
    "crossing_angle_error": ["angle_deg"], "misalignment": ["angle_deg"],
    "normal_load_drift": ["fraction_per_100k_cycles"], "wear_rate_offset": ["factor"],
    "wear_rate_evolution": ["initial_factor", "final_factor", "cycles"],
    "contact_oxygenation": ["supply_W", "starved_factor"],
    "friction_heat": [
        "conductivity_W_per_m_K", "heat_capacity_J_per_cm3_K", "held_over_driven", "resistance_K_per_W",
        "line_length_mm", "wear_kJ_per_mol", "oxidation_kJ_per_mol", "friction_per_K",
    ],
    "displacement_gain": ["gain"],
    "displacement_load_coupling": ["linear_um_per_N", "quadratic_um_per_N2"], "force_crosstalk": ["coefficient"],
    "sensor_lag": ["time_s"], "held_displacement": ["displacement_amplitude_um"],
}  # fmt: skip
everyone = pytest.mark.parametrize("kind", effects.all_effects().values(), ids=list(effects.all_effects()))


def with_tables(text: str) -> str:
    return COARSE + text


def test_the_effects_bear_their_fixed_names_and_parameters() -> None:
    assert {name: list(kind.parameters()) for name, kind in effects.all_effects().items()} == FIXED


DESCRIPTIONS: dict[effects.Seam, Any] = {
    effects.Seam.HOLDER: Holder(2.0, tangential_compliance_mm_per_N=1.0 / 167.0),
    effects.Seam.CONTACT: effects.ContactLaw(0.62), effects.Seam.WEAR: WearRates(1.5e-8, 1.5e-8),
    effects.Seam.SPECIMENS: effects.Specimens(90.0), effects.Seam.DRIVE: effects.Control(20.0),
    effects.Seam.LOADING: effects.Loading(2.0), effects.Seam.SENSOR: Sensor(),
}  # fmt: skip


@pytest.mark.seconds
@everyone
@given(cycles=st.floats(0.0, 1e6), energy=st.floats(0.0, 100.0))
def test_an_effect_of_neutral_values_is_none(kind: type[effects.Effect[Any]], cycles: float, energy: float) -> None:
    described = DESCRIPTIONS[kind.seam]
    assert kind.neutral(coarse().stated).changed(described, effects.Age(cycles, energy)) == described


@everyone
def test_an_effect_changes_its_own_seam_and_no_other(kind: type[effects.Effect[Any]]) -> None:
    effect, late = kind.sized("easy", coarse().stated), effects.Age(1e4, 1.0)
    for seam, described in DESCRIPTIONS.items():
        assert (effects.applied([effect], seam, described, late) != described) == (seam is kind.seam)


@everyone
def test_a_study_with_an_effect_is_written_and_read_again(kind: type[effects.Effect[Any]]) -> None:
    for effect in (kind.sized("easy", coarse().stated), kind.neutral(coarse().stated)):
        again = study_from_tables(json.loads(json.dumps(coarse().with_effects(effect).resolved())), "resolved")
        assert again.effects == (effect,)


def test_two_pivots_move_and_tilt_the_wire_as_both_would() -> None:
    first = Holder(2.0, rotational_compliance_rad_per_N_mm=1e-5, pivot_height_mm=10.0)
    both = RotationalCompliance(stiffness_N_mm_per_rad=5e4, arm_mm=30.0).changed(first, effects.Age.new())
    assert both.compliance_at_contact_mm_per_N == pytest.approx(1e-5 * 10.0**2 + 2e-5 * 30.0**2)
    tilt = both.rotational_compliance_rad_per_N_mm * both.pivot_height_mm
    assert tilt == pytest.approx(1e-5 * 10.0 + 2e-5 * 30.0)


def test_a_variant_has_effects_of_its_own_in_place_of_the_studys() -> None:
    study = coarse(
        with_tables(
            '[[effects]]\nname = "friction_offset"\nfriction = 0.5\n'
            '[[variants.drift.effects]]\nname = "normal_load_drift"\nfraction_per_100k_cycles = 0.1\n'
            "[variants.plain]\neffects = []\n[variants.same.holder]\n"
        )
    )
    names = {name: [effect.name for effect in study.variant(name).effects] for name in study.variant_names}
    assert names == {"drift": ["normal_load_drift"], "plain": [], "same": ["friction_offset"]}
    assert study_from_tables(study.resolved(), "resolved") == study


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ("effects = 3\n", "is 3, but must be tables such as"),
        ("effects = [3]\n", "3 is no table"),
        ("[[effects]]\nfriction = 0.5\n", "an effect has no name"),
        ('[[effects]]\nname = "friction_ofset"\n', "did you mean 'friction_offset'?"),
        ('[[effects]]\nname = "gremlins"\n', "the effects are tangential_compliance, "),
        ('[[effects]]\nname = "friction_offset"\n', "friction_offset needs friction, the true coefficient"),
        ('[[effects]]\nname = "friction_offset"\nfrictoin = 1\n', "no parameter 'frictoin': did you mean 'friction'?"),
        (
            '[[effects]]\nname = "friction_offset"\nfriction = -1\n',
            "friction of friction_offset is -1, but must lie between 0 and 2",
        ),
        (
            '[[effects]]\nname = "tangential_compliance"\nstiffness_N_per_mm = "soft"\n',
            "is the text 'soft', but must be a number between 1 and 1000000000 newtons per millimetre, or \"rigid\"",
        ),
        (2 * '[[effects]]\nname = "wear_rate_offset"\nfactor = 2\n', "wear_rate_offset is given 2 times"),
        ('[[effects]]\nname = "wear_rate_offset"\nfactor = nan\n', "must be a finite number"),
    ],
)
def test_a_senseless_effect_is_refused_with_one_sentence(tables: str, message: str) -> None:
    top, tables = (tables, "") if tables.startswith("effects") else ("", tables)
    with pytest.raises(StudyError) as refused:
        parse_study(top + with_tables(tables), "coarse.toml")
    assert message in str(refused.value)
    assert str(refused.value).startswith("effects in coarse.toml ")
    assert str(refused.value).count(". ") == 0
    assert str(refused.value).endswith(".") != message.endswith("?")


@everyone
def test_an_effect_is_described_in_full(kind: type[effects.Effect[Any]]) -> None:
    text = effect_text(kind)
    assert all(f"\n{name}: " in f"\n{text}" for name in kind.parameters())
    assert f"Signature: {kind.signature}." in text
    assert "Distinguished by: " in text
