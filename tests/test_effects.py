"""The library of effects: names and parameters, what a study may say, what is refused; their prints in real runs."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import Array
from solvers import Holder, WearRates
from tests.studies import COARSE, coarse, result_with
from wirewear import Loop, StudyError, effects, parse_study
from wirewear.effects import all_effects, effect_named
from wirewear.effects.holder import RotationalCompliance
from wirewear.loops.sensor import Sensor
from wirewear.results import read_loops
from wirewear.study.reading import study_from_tables

#: Names and parameters that other programs and files rely on.
FIXED = {
    "tangential_compliance": ["stiffness_N_per_mm"],
    "rotational_compliance": ["stiffness_N_mm_per_rad", "arm_mm"],
    "free_play": ["gap_um"],
    "friction_offset": ["friction"],
    "friction_evolution": ["initial", "final", "cycles"],
    "roughness_compliance": ["layer_um", "cycles"],
    "third_body": ["retained_fraction", "modulus_MPa"],
    "plasticity": ["flattening_um"],
    "crossing_angle_error": ["angle_deg"],
    "misalignment": ["angle_deg"],
    "normal_load_drift": ["fraction_per_100k_cycles"],
    "wear_rate_offset": ["factor"],
    "wear_rate_evolution": ["initial_factor", "final_factor", "cycles"],
    "contact_oxygenation": ["supply_W", "starved_factor"],
    "displacement_gain": ["gain"],
    "displacement_load_coupling": ["linear_um_per_N", "quadratic_um_per_N2"],
    "force_crosstalk": ["coefficient"],
    "sensor_lag": ["time_s"],
    "held_displacement": ["displacement_amplitude_um"],
}

everyone = pytest.mark.parametrize("kind", effects.all_effects().values(), ids=list(effects.all_effects()))


def with_tables(text: str) -> str:
    return COARSE + text


def test_the_effects_bear_their_fixed_names_and_parameters() -> None:
    assert {name: list(kind.parameters()) for name, kind in effects.all_effects().items()} == FIXED


DESCRIPTIONS: dict[effects.Seam, Any] = {
    effects.Seam.HOLDER: Holder(2.0, tangential_compliance_mm_per_N=1.0 / 167.0),
    effects.Seam.CONTACT: effects.ContactLaw(0.62),
    effects.Seam.WEAR: WearRates(1.5e-8, 1.5e-8),
    effects.Seam.SPECIMENS: effects.Specimens(90.0),
    effects.Seam.DRIVE: effects.Control(20.0),
    effects.Seam.LOADING: effects.Loading(2.0),
    effects.Seam.SENSOR: Sensor(),
}


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
        study = coarse().with_effects(effect)
        again = study_from_tables(json.loads(json.dumps(study.resolved())), "resolved")
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


LIMIT_N = 0.62 * 2.0
# Walls of a scar keep their parity over the position of slip, which on a rigid rig is that of the drive.
FRESH = COARSE + "[holder]\ntangential_stiffness_N_per_mm = 300.0\n"
WORN = (
    COARSE.replace("cycles = 1", "cycles = 8").replace("increments_per_cycle = 40", "increments_per_cycle = 24")
    + "[wear]\nenergy_wear_coefficient_mm3_per_J = 7.0e-4\n"
)
#: Sizes that fit a stroke of 40 um and eight cycles.
SIZES: dict[str, dict[str, float]] = {
    "tangential_compliance": {"stiffness_N_per_mm": 1000.0},
    "rotational_compliance": {"stiffness_N_mm_per_rad": 1000.0 * 30.0**2, "arm_mm": 30.0},
    "free_play": {"gap_um": 1.0},
    "friction_offset": {"friction": 0.589},
    "friction_evolution": {"initial": 0.589, "final": 0.62, "cycles": 1e5},
    "roughness_compliance": {"layer_um": 0.1, "cycles": 1e5},
    "third_body": {"retained_fraction": 0.6, "modulus_MPa": 500.0},
    "plasticity": {"flattening_um": 0.5},
    "crossing_angle_error": {"angle_deg": 4.0},
    "misalignment": {"angle_deg": 2.0},
    "normal_load_drift": {"fraction_per_100k_cycles": 5.0},
    "wear_rate_offset": {"factor": 1.2},
    "wear_rate_evolution": {"initial_factor": 1.4, "final_factor": 1.0, "cycles": 10.0},
    "displacement_gain": {"gain": 1.05},
    "displacement_load_coupling": {"linear_um_per_N": 0.5, "quadratic_um_per_N2": 0.25},
    "force_crosstalk": {"coefficient": 0.03},
    "sensor_lag": {"time_s": 0.003},
}
#: Effects that show only once the wires have worn or the load has drifted.
NEED_CYCLES = {"third_body", "normal_load_drift", "wear_rate_offset", "wear_rate_evolution"}


@dataclass(frozen=True)
class Fingerprint:
    """Plateau parts by parity (b, x), shares of µP; stick parts in µm, at Q = µP; energy over the nominal one."""

    plateau: dict[str, float]
    stick: dict[str, float]
    energy_ratio: float


def fingerprint(loop: Loop, nominal: Loop) -> Fingerprint:
    return Fingerprint(plateau_parts(loop, nominal), stick_parts(loop, nominal), area(loop) / area(nominal))


def area(loop: Loop) -> float:
    x, q = loop.displacement_um, loop.tangential_force_N
    return 0.5 * abs(float(np.sum(x * np.roll(q, -1) - np.roll(x, -1) * q)))


def branches(loop: Loop) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Displacement and force of the forward and of the backward branch, each from its reversal on."""
    first = int(np.argmin(loop.displacement_um))
    x, q = (np.roll(values, -first) for values in (loop.displacement_um, loop.tangential_force_N))
    top = int(np.argmax(x))
    return (x[: top + 1], q[: top + 1]), (np.append(x[top:], x[0]), np.append(q[top:], q[0]))


def plateau_parts(loop: Loop, nominal: Loop) -> dict[str, float]:
    """Signed root mean square of each parity of the force residual between the slip's middle and 60 % to its end."""
    x = np.linspace(-5.0, 5.0, 41)
    residual = []
    for (u, q), (u0, q0) in zip(branches(loop), branches(nominal), strict=True):
        order, order0 = np.argsort(u), np.argsort(u0)
        residual.append(np.interp(x, u[order], q[order]) - np.interp(x, u0[order0], q0[order0]))
    parts = {}
    for b, by_direction in (("even", residual[0] + residual[1]), ("odd", residual[0] - residual[1])):
        for parity, sign in (("even", 1.0), ("odd", -1.0)):
            part = 0.25 * (by_direction + sign * by_direction[::-1])
            parts[f"{b}, {parity}"] = float(np.sign(part[-1]) * np.sqrt(np.mean(part**2)) / LIMIT_N)
    return parts


def stick_parts(loop: Loop, nominal: Loop) -> dict[str, float]:
    """Parts of the displacement residual at equal force just after the reversals, by least squares."""
    level = np.linspace(-0.7, 0.7, 29)
    rows, residual = [], []
    for b, (u, q), (u0, q0) in zip((1.0, -1.0), branches(loop), branches(nominal), strict=True):
        end, end0 = int(np.argmax(b * q)), int(np.argmax(b * q0))
        at = b * level * LIMIT_N
        residual.append(
            np.interp(at * b, b * q[: end + 1], u[: end + 1]) - np.interp(at * b, b * q0[: end0 + 1], u0[: end0 + 1])
        )
        s = at / LIMIT_N
        rows.append(np.column_stack([np.ones_like(s), s, s**2, np.sign(s), np.full_like(s, b)]))
    found = np.linalg.lstsq(np.concatenate(rows), np.concatenate(residual), rcond=None)[0]
    return dict(zip(("constant", "linear", "quadratic", "step", "branch"), map(float, found), strict=True))


def fingerprint_of(name: str) -> Fingerprint:
    text = WORN if name in NEED_CYCLES else FRESH
    changed, nominal = (result_with(*effects, text=text) for effects in ((effect_named(name)(**SIZES[name]),), ()))
    return fingerprint(read_loops(changed)[-1], nominal.loops[-1])


def test_every_effect_has_a_fingerprint_below() -> None:
    # Loops of so few cycles do not show where the scar wears, and another stroke is no other loop.
    assert set(SIZES) == set(all_effects()) - {"contact_oxygenation", "held_displacement"}
    assert set(PLATEAU) | set(STICK) == set(SIZES)
    assert set(ENERGY) == set(SIZES)


#: Parity (b, x) of what an effect does to the plateaus, and its size in shares of the sliding force, or its sign only.
PLATEAU = {
    "friction_offset": ("odd, even", -0.05),
    "friction_evolution": ("odd, even", -0.05),
    "normal_load_drift": ("odd, even", 5.0 * 8e-5),
    "misalignment": ("even, even", np.tan(np.radians(2.0)) * (1.0 + 0.62**2) / 0.62),
    "force_crosstalk": ("even, even", 0.03 / 0.62),
    "wear_rate_offset": ("even, odd", +1),
    "wear_rate_evolution": ("even, odd", +1),
    "third_body": ("even, odd", -1),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", PLATEAU)
def test_what_an_effect_does_to_the_plateaus_has_its_parity(name: str) -> None:
    parity, size = PLATEAU[name]
    parts = fingerprint_of(name).plateau
    others = [abs(part) for other, part in parts.items() if other != parity]
    # On this coarse mesh a part of second order, 1e-4 of the friction, stands beside walls of 3e-4.
    assert abs(parts[parity]) > 3.0 * max(others)
    if isinstance(size, int):
        assert np.sign(parts[parity]) == size
    else:
        assert parts[parity] == pytest.approx(size, rel=0.03)


#: Parts of the residual in stick, um: value, or smallest size with its sign; those not named are no larger than 0.02.
STICK: dict[str, dict[str, float | str]] = {
    "tangential_compliance": {"linear": 1.24, "branch": 1.24},
    "rotational_compliance": {"linear": 1.24, "branch": 1.24},
    "free_play": {"step": "> 0.2", "linear": "> 0", "branch": "> 0"},
    "roughness_compliance": {"linear": "> 0.1", "branch": "> 0.1"},
    "plasticity": {"linear": "< -0.1", "branch": "< -0.1"},
    "crossing_angle_error": {},
    "displacement_gain": {"linear": "> 0.1", "branch": "< -0.5"},
    "displacement_load_coupling": {"linear": 0.5 * 1.24, "quadratic": 0.25 * 1.24**2},
    "sensor_lag": {"linear": "< -0.1", "branch": "< -0.3"},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", STICK)
def test_an_effect_of_stick_leaves_the_plateaus_and_bends_the_stick_branches_in_its_way(name: str) -> None:
    found = fingerprint_of(name)
    assert max(abs(part) for part in found.plateau.values()) < 2e-3
    for part, value in found.stick.items():
        match STICK[name].get(part, 0.0):
            case str(bound):
                size = float(bound[2:])
                assert value > size if bound[0] == ">" else value < size
            case expected:
                assert value == pytest.approx(expected, rel=0.02, abs=0.02)


#: Energy of the loop over the nominal one: least and largest.
ENERGY = {
    **dict.fromkeys(("tangential_compliance", "rotational_compliance", "free_play", "third_body"), (0.9, 0.98)),
    **dict.fromkeys(("friction_offset", "friction_evolution"), (0.95, 0.98)),
    "roughness_compliance": (0.98, 0.995),
    "plasticity": (1.005, 1.01),
    "crossing_angle_error": (0.9997, 1.0003),
    "misalignment": (1.0, 1.002),
    "normal_load_drift": (1.0003, 1.0005),
    **dict.fromkeys(("wear_rate_offset", "wear_rate_evolution"), (1.0, 1.002)),
    "displacement_gain": (1.05 - 1e-6, 1.05 + 1e-6),
    **dict.fromkeys(("displacement_load_coupling", "force_crosstalk"), (0.999, 1.001)),
    "sensor_lag": (1.01, 1.1),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", ENERGY)
def test_energy_tells_errors_of_the_sensor_from_changes_of_the_contact(name: str) -> None:
    least, largest = ENERGY[name]
    assert least < fingerprint_of(name).energy_ratio < largest
