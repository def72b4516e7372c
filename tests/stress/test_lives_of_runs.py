"""Lives of runs: of a pulled flat, as a command and its page state it, and of a pulled line contact by closed forms."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, minimize

from geometry import Elastic
from geometry.arrays import Array
from tests.browser import page_faults
from tests.commands import wirewear
from tests.stress.fatigue_data import DUCTILITY, OWN, STRENGTH, B, C
from tests.studies import TABLES, line_study
from wirewear import lives, reference
from wirewear.results import RunResult
from wirewear.simulation import simulate
from wirewear.test.life import CRITERIA
from wirewear.views.life_page import NOT_AVERAGED

PULLED = """
format = 1
name = "pulled flat"
kind = "cylinder-on-flat"

[pad]
radius_mm = 6.0
material = "steel"

[specimen]
material = "steel"
bulk.axial_stress_MPa = 400.0
bulk.axial_stress_amplitude_MPa = 300.0

[conditions]
normal_load_N_per_mm = 30.0
displacement_amplitude_um = 1.5
cycles = 2000

[contact]
friction = 0.6

[wear]
specimen_energy_mm3_per_J = 2e-5

[log]
loop_cycles = [1, 2000]

[mesh]
contact_mesh_um = 16.0
jump_tolerance = 0.3

[life]
averaging_length_um = 20.0
tensile_strength_MPa = 800.0
"""


@pytest.mark.slow
def test_the_page_of_a_run_says_where_a_pulled_flat_cracks_and_which_lives_count_as_endless(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "pulled.toml").write_text(PULLED)
    assert "specimen: " in wirewear("life", "pulled.toml", "--body", "specimen", "--output", "out").output
    found = json.loads((tmp_path / "out" / "life.json").read_text(encoding="utf-8"))["lives"][0]
    # Pulled most when it is at its end at +x, the flat cracks behind the edge that trails then.
    assert 30.0 < found["x_um"] < 150.0
    assert 45.0 < found["plane_angle_deg"] <= 90.0
    assert found["cycles_low"] < found["cycles_to_initiation"] < found["cycles_high"]
    assert found["averaged"]
    page = (tmp_path / "out" / "life.html").read_text(encoding="utf-8")
    assert page_faults(tmp_path / "out" / "life.html") == []
    assert "Data of steel: estimates from the tensile strength: " in page
    assert NOT_AVERAGED not in page
    again = ["life", "runs/pulled", "--body", "specimen", "--wear-states", "1", "--json", "--output", "again"]
    stronger = wirewear(*again, "--set", "tensile_strength_MPa=1200")
    assert json.loads(stronger.stdout)["lives"][0]["cycles_to_initiation"] > 5.0 * found["cycles_to_initiation"]
    assert found["data"]["endurance_cycles"] == 1e12
    assert "<td>endurance_cycles</td>" in page
    (endless,) = json.loads(wirewear(*again, "--set", "endurance_cycles=9").stdout)["lives"]
    assert endless["cycles_to_initiation"] is None
    assert "no crack begins, for no stress of it would make one within 9 cycles" in endless["sentence"]
    for mistake, message in (
        (["--set", "strength=3"], "unknown key 'strength'"),
        (["--set", "averaging"], "KEY=VALUE"),
        (["--material", "brass"], "in no table of materials"),
    ):
        refused = wirewear(*again, *mistake, code=2)
        assert message in refused.output
        assert "Traceback" not in refused.output


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


def centres_mm(run: RunResult) -> Array:
    """Centre (s,) of the load on the specimen at the positions of the cycle."""
    forces = run.forces(1, "specimen")
    load, along_mm = forces.force_N[..., 2], 1e-3 * run.scar(1, "specimen").axial_um[forces.nodes]
    return np.asarray(load @ along_mm / load.sum(axis=1))


def history(run: RunResult, x: Array, z: Array) -> Array:
    """Stresses (s, n, 6) at the positions of the cycle and at their forces, by Masing's rule; x against the motion.

    The contact rolls to and fro by what moves the load's centre, 0.2 % of a: a point at its edge at one end lies under
    pressure at the other, which takes a sixth of its life.
    """
    forces = run.forces(1, "specimen")
    force = forces.tangential_force_N * np.sign(forces.tangential_force_N[forces.drive_um.argmax()])
    largest, found = np.abs(force).max(), []
    for q, phase, centre in zip(force, forces.phase, centres_mm(run), strict=True):
        bulk, sign = BULK_MPa * np.cos(2.0 * np.pi * phase), 1.0 if phase <= 0.5 else -1.0
        since = 0.5 * max(largest - sign * q, 0.0), 0.5 * (BULK_MPa - sign * bulk)
        at = x + centre
        shear = sign * (friction_stress(at, z, largest, BULK_MPa) - 2.0 * friction_stress(at, z, *since))
        of_bar = (BULK_MPa + bulk) * np.array([1.0, NU, 0.0, 0.0, 0.0, 0.0])
        found.append(reference.line_stress(at, z, **HERTZ) + shear + of_bar)
    return np.array(found)


def averaged(run: RunResult) -> Array:
    """Over what of discs about points of the surface near the trailing edge lies in the body."""
    steps = 0.5 * LENGTH_mm * (np.arange(-20, 20) + 0.5) / 20.0
    x, z = (each.ravel() for each in np.meshgrid(steps, steps[20:]))
    inside = np.hypot(x, z) <= 0.5 * LENGTH_mm
    middles = -a_mm * np.linspace(0.85, 1.2, 36)
    return np.stack([history(run, at + x[inside], z[inside]).mean(axis=1) for at in middles], axis=1)


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
    assert found.cycles == pytest.approx(shortest(criterion, averaged(run)), rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("criterion", CRITERIA)
def test_a_life_at_the_surface_itself_is_that_of_the_closed_forms(run: RunResult, criterion: str) -> None:
    found = lives(run, ["specimen"], values={"criterion": criterion})[0]
    edges = -a_mm - centres_mm(run)
    exact = shortest(criterion, history(run, edges, np.zeros(len(edges))))
    assert found.cycles == pytest.approx(exact, rel=0.1)
    assert abs(found.place_um[0]) == pytest.approx(1e3 * a_mm, rel=0.02)
