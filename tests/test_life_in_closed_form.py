"""Lives of a line contact in partial slip whose specimen is pulled, by closed forms of its stresses and of criteria.

Hertz, Cattaneo and Mindlin, and Nowell and Hills for the bulk stress: nothing here is by the code that computes lives.
"""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, minimize

from geometry import Elastic
from geometry.arrays import Array
from tests.studies import TABLES, line_study
from tests.test_life import DUCTILITY, OWN, STRENGTH, B, C
from wirewear import lives, reference
from wirewear.results import ContactForces, RunResult
from wirewear.simulation import simulate
from wirewear.study.life import CRITERIA

STEEL = Elastic(TABLES["pad"]["youngs_modulus_MPa"], TABLES["pad"]["poissons_ratio"])
E, NU, G = STEEL.youngs_modulus_MPa, STEEL.poissons_ratio, STEEL.shear_modulus_MPa
LOAD_N_per_mm, RADIUS_mm, FRICTION, LIMIT_N_per_mm = 200.0, 20.0, 0.6, 120.0
BULK_MPa = 200.0  #: Both mean and amplitude.
LENGTH_mm = 0.1
LINE = reference.hertz_line(LOAD_N_per_mm, RADIUS_mm, reference.contact_modulus(STEEL, STEEL))
a_mm = LINE.half_width_mm
HERTZ: dict[str, Any] = {
    "half_width_mm": a_mm, "peak_pressure_MPa": LINE.peak_pressure_MPa, "poissons_ratio": NU
}  # fmt: skip


@pytest.fixture(scope="module")
def run() -> RunResult:
    """At standard, without wear."""
    thick = {"height_mm": 30.0, "half_width_mm": 15.0}
    pulled = {"axial_stress_MPa": BULK_MPa, "axial_stress_amplitude_MPa": BULK_MPa}
    bodies: dict[str, Any] = {"pad": {"radius_mm": RADIUS_mm} | thick, "specimen": {"bulk": pulled} | thick}
    asked = {"normal_load_N_per_mm": LOAD_N_per_mm, "displacement_amplitude_um": 6.2, "cycles": 1}
    study = line_study(**bodies, conditions=asked, wear=None, mesh=None, life=OWN, log={"loop_cycles": [1]})
    return simulate(study, fidelity="standard")


def friction_stress(x: Array, z: Array, force_N_per_mm: float, bulk_MPa: float) -> Array:
    """By friction (n, 6) at first loading to a force, under a bulk stress in phase with it."""
    slip = reference.line_partial_slip_stress(
        x, z, stick_half_width_mm=max(a_mm * np.sqrt(1.0 - force_N_per_mm / LIMIT_N_per_mm), 1e-9),
        stick_centre_mm=reference.line_stick_shift(LINE, FRICTION, bulk_MPa), friction=FRICTION, **HERTZ,
    )  # fmt: skip
    return slip - reference.line_stress(x, z, **HERTZ)


def history(forces: ContactForces, x: Array, z: Array) -> Array:
    """Stresses (s, n, 6) at the positions of the cycle and at their forces, by Masing's rule; x against the motion."""
    force = forces.tangential_force_N * np.sign(forces.tangential_force_N[forces.drive_um.argmax()])
    largest, found = np.abs(force).max(), []
    for q, phase in zip(force, forces.phase, strict=True):
        bulk, sign = BULK_MPa * np.cos(2.0 * np.pi * phase), 1.0 if phase <= 0.5 else -1.0
        since = 0.5 * max(largest - sign * q, 0.0), 0.5 * (BULK_MPa - sign * bulk)
        shear = sign * (friction_stress(x, z, largest, BULK_MPa) - 2.0 * friction_stress(x, z, *since))
        of_bar = (BULK_MPa + bulk) * np.array([1.0, NU, 0.0, 0.0, 0.0, 0.0])
        found.append(reference.line_stress(x, z, **HERTZ) + shear + of_bar)
    return np.array(found)


def averaged(forces: ContactForces) -> Array:
    """Over what of discs about points of the surface near the trailing edge lies in the body."""
    steps = 0.5 * LENGTH_mm * (np.arange(-20, 20) + 0.5) / 20.0
    x, z = (each.ravel() for each in np.meshgrid(steps, steps[20:]))
    inside = np.hypot(x, z) <= 0.5 * LENGTH_mm
    middles = -a_mm * np.linspace(0.85, 1.2, 36)
    return np.stack([history(forces, at + x[inside], z[inside]).mean(axis=1) for at in middles], axis=1)


def shortest(criterion: str, stress: Array) -> float:
    """The shortest life of points by a cycle (s, n, 6), on planes across the plane of strain."""
    xx, yy, zz, _, _, xz = np.moveaxis(stress[:, :, None], -1, 0)
    angle = np.radians(np.arange(0.0, 180.0, 0.5))
    cos, sin = np.cos(angle), np.sin(angle)
    normal = xx * cos**2 + zz * sin**2 + 2.0 * xz * sin * cos
    shear = (zz - xx) * sin * cos + xz * (cos**2 - sin**2)
    strain = ((1.0 + NU) * normal - NU * (xx + yy + zz)) / E
    highest, amplitude = normal.max(axis=0), 0.5 * np.ptp(normal, axis=0)
    pulled = np.maximum(highest, 0.0)
    if criterion == "crossland":
        mean = stress[..., :3].mean(axis=-1)
        path = np.concatenate([stress[..., :3] - mean[..., None], 2.0**0.5 * stress[..., 3:]], axis=-1)
        extent = np.linalg.norm(np.ptp(path, axis=0), axis=-1)
        worst = (extent / 8.0**0.5 + 0.3 * mean.max(axis=0)).argmax()

        def radius(centre: Array) -> float:
            return float(np.linalg.norm(path[:, worst] - centre, axis=1).max())

        ball = minimize(radius, path[:, worst].mean(axis=0), method="Powell", options={"xtol": 1e-6, "ftol": 1e-9}).fun
        parameter = ball / 2.0**0.5 + 0.3 * mean[:, worst].max()
        terms = [(STRENGTH * (3.0**-0.5 + 0.1), B)]
    elif criterion == "stress-life":
        morrow = amplitude / (1.0 - (highest - amplitude) / STRENGTH)
        parameter, terms = np.where(highest > 0.0, morrow, 0.0).max(), [(STRENGTH, B)]
    elif criterion == "fatemi-socie":
        parameter = (0.5 * np.ptp(shear, axis=0) / G * (1.0 + pulled / STRENGTH)).max()
        terms = [(STRENGTH / 3.0**0.5 / G, B), (3.0**0.5 * DUCTILITY, C)]
    else:
        parameter = (0.5 * pulled * np.ptp(strain, axis=0)).max()
        terms = [(STRENGTH**2 / E, 2.0 * B), (STRENGTH * DUCTILITY, B + C)]
    decades = brentq(lambda n: sum(f * (2.0 * 10.0**n) ** p for f, p in terms) - parameter, -1.0, 40.0)
    return float(10.0**decades)


@pytest.mark.slow
@pytest.mark.parametrize("criterion", CRITERIA)
def test_a_life_without_wear_is_that_of_the_closed_forms_of_the_contact(run: RunResult, criterion: str) -> None:
    found = lives(run, ["specimen"], values={"criterion": criterion, "averaging_length_um": 1e3 * LENGTH_mm})[0]
    assert found.cycles == pytest.approx(shortest(criterion, averaged(run.forces(1, "specimen"))), rel=0.05)
