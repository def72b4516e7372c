"""Fingerprints of effects in real runs: parity of what they do to plateaus, course of what they do in stick, energy.

Residuals of a loop against the nominal one are split as in the separation of causes by symmetry: on the plateaus by
direction of motion b and position x, in stick, at equal force, into parts that go with Q, Q², the sign of Q and b.
"""

from dataclasses import dataclass

import numpy as np
import pytest

from geometry.arrays import Array
from tests.studies import COARSE, result_with
from wirewear import Loop
from wirewear.effects import all_effects, effect_named
from wirewear.results import read_loops

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
    # Loops of so few cycles do not show where the scar wears.
    assert set(SIZES) == set(all_effects()) - {"contact_oxygenation"}
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
