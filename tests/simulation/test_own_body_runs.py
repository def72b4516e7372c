"""Runs of a ball from a file beside those of the program's own ball."""

from pathlib import Path

import pytest

from tests.bodies import ball_of_tetrahedra
from wirewear import lives
from wirewear.results import RunResult
from wirewear.simulation import simulate
from wirewear.stress.strength import StrengthAsked, strength_of
from wirewear.test.study import load_study

STUDY = """
format = 1
name = "ball"
kind = "point-contact"
[bodies.lower]
shape = "flat"
material = "steel"
[bodies.upper]
{ball}
material = "steel"
[contact]
friction = 0.6
[conditions]
normal_load_N = 100.0
displacement_amplitude_um = 20.0
frequency_Hz = 10.0
cycles = 100
[wear]
energy_wear_coefficient_mm3_per_J = 2.0e-4
moving_share = 0.5
[log]
loop_cycles = [1, 100]
[life]
averaging_length_um = 50.0
"""
OWN = 'shape = "mesh"\nfile = "ball.msh"\nunit = "m"\ncontact = "contact"\nheld = "grip"'
BUILT_IN = 'shape = "ball"\ndiameter_mm = 12.7'


def run(ball: str, folder: Path, fidelity: str, **changes: object) -> RunResult:
    (path := folder / "study.toml").write_text(STUDY.format(ball=ball), encoding="utf-8")
    return simulate(load_study(path).with_values(changes), fidelity=fidelity)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program's ball of 12.7 mm in tetrahedra, in metres."""
    found = tmp_path_factory.mktemp("ball")
    ball_of_tetrahedra(found / "ball.msh", 6.35e-3, 3.81e-3, 6.35e-3, 0.9e-3, 2)
    return found


@pytest.mark.slow
def test_a_ball_of_tetrahedra_runs_as_the_programs_own(folder: Path) -> None:
    """Loop, wear, and stresses within 1 %; damage, which goes with a high power of stress, within a tenth."""
    own, built = (run(ball, folder, "quick") for ball in (OWN, BUILT_IN))
    columns = ("slip_amplitude_um", "max_tangential_force_N", "dissipated_energy_mJ", "max_pressure_MPa")
    worn = ("worn_volume_upper_mm3", "worn_volume_lower_mm3", "max_depth_upper_um", "max_depth_lower_um")
    for column in (*columns, *worn):
        assert own.evolution[column] == pytest.approx(built.evolution[column], rel=0.01), column
    for body in ("lower", "upper"):
        ours, theirs = (strength_of(one, body, 1, StrengthAsked(800.0)) for one in (own, built))
        for name in ("von_mises", "critical_plane", "crossland"):
            assert getattr(ours, name).value_MPa == pytest.approx(getattr(theirs, name).value_MPa, rel=0.01), name
    for of_own, of_built in zip(lives(own), lives(built), strict=True):
        sums = [float(one.damage.at(100.0).damage.max()) for one in (of_own, of_built)]
        assert sums[0] == pytest.approx(sums[1], rel=0.1)


@pytest.mark.slow
def test_a_ball_of_tetrahedra_meets_hertz_at_standard(folder: Path) -> None:
    found = run(OWN, folder, "standard", **{"conditions.cycles": 1, "log.loop_cycles": [1]}).settings
    assert found["fresh_max_pressure_MPa"] == pytest.approx(found["hertz_pressure_MPa"], rel=0.015)
