"""Fatigue indicators of plain histories, whose values are known, and of a wire."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

from geometry import Elastic
from tests.interior_runs import CYCLE, run_with_forces
from wirewear.faces import cli
from wirewear.interior.fatigue import averaging, crossland, smith_watson_topper
from wirewear.interior.strength import strength_of, yield_sentence
from wirewear.results import write_result

Array = NDArray[np.float64]

STEEL = Elastic(200_000.0, 0.3)
PHASE = np.linspace(0.0, 2.0 * np.pi, 25)


def history(tensor: Array, course: Array) -> Array:
    """A tensor (3, 3) times a course (s,), as six components of one point."""
    six = np.array([tensor[0, 0], tensor[1, 1], tensor[2, 2], tensor[0, 1], tensor[1, 2], tensor[0, 2]])
    return np.asarray((course[:, None] * six)[:, None, :])


def rotation(seed: int) -> Array:
    return np.asarray(np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_in_reversed_tension_the_critical_plane_lies_across_it_whatever_its_direction(seed: int) -> None:
    turn = rotation(seed)
    pull = turn @ np.diag([300.0, 0.0, 0.0]) @ turn.T
    found = smith_watson_topper(history(pull, np.cos(PHASE)), STEEL)
    assert found.parameter_MPa[0] == pytest.approx(300.0**2 / 200_000.0, rel=1e-4)
    assert abs(found.normal[0] @ turn[:, 0]) == pytest.approx(1.0, abs=1e-4)


def test_pulsating_tension_keeps_the_largest_stress_and_halves_the_strain_amplitude() -> None:
    pull = np.diag([300.0, 0.0, 0.0])
    found = smith_watson_topper(history(pull, 0.5 * (1.0 + np.cos(PHASE))), STEEL)
    assert found.parameter_MPa[0] == pytest.approx(300.0 * 150.0 / 200_000.0, rel=1e-4)


def test_crossland_of_reversed_shear_and_of_tension() -> None:
    shear = np.zeros((3, 3))
    shear[0, 1] = shear[1, 0] = 100.0
    turn = rotation(4)
    found = crossland(history(turn @ shear @ turn.T, np.cos(PHASE)))
    assert found.amplitude_MPa[0] == pytest.approx(100.0, rel=1e-3)
    assert found.hydrostatic_MPa[0] == pytest.approx(0.0, abs=1e-9)
    pulled = crossland(history(np.diag([300.0, 0.0, 0.0]), np.cos(PHASE)))
    assert pulled.amplitude_MPa[0] == pytest.approx(300.0 / np.sqrt(3.0), rel=1e-3)
    assert pulled.equivalent_MPa(0.3)[0] == pytest.approx(300.0 / np.sqrt(3.0) + 30.0, rel=1e-3)


def test_the_amplitude_of_a_circular_path_is_its_radius_and_a_constant_stress_has_none() -> None:
    """Out-of-phase tension and shear of equal deviatoric size: the path is a circle, every diameter as long."""
    path = np.zeros((25, 1, 6))
    path[:, 0, 0] = np.sqrt(3.0) * 100.0 * np.cos(PHASE)
    path[:, 0, 3] = 100.0 * np.sin(PHASE)
    path[:, 0, 4] = 500.0
    assert crossland(path).amplitude_MPa[0] == pytest.approx(100.0, rel=0.02)
    assert crossland(path[:1].repeat(5, axis=0)).amplitude_MPa[0] == pytest.approx(0.0, abs=1e-9)


def test_averages_keep_linear_fields_in_the_middle_and_a_length_of_zero_leaves_all_as_it_is() -> None:
    lines = np.linspace(-1.0, 1.0, 21)
    points = np.stack(np.meshgrid(lines, lines, lines, indexing="ij"), axis=-1).reshape(-1, 3)
    volumes = np.ones(len(points))
    middle = np.array([len(points) // 2])
    field = points @ [1.0, -2.0, 0.5] + 3.0
    assert (averaging(points, volumes, middle, 0.65) @ field)[0] == pytest.approx(3.0)
    bump = (points**2).sum(axis=1)
    # Over a ball of radius a the mean of r² is 3 a² / 5.
    assert (averaging(points, volumes, middle, 1.6) @ bump)[0] == pytest.approx(0.6 * 0.8**2, rel=0.03)
    assert (averaging(points, volumes, middle, 0.0) @ bump)[0] == bump[middle[0]]


@pytest.mark.seconds
def test_averaging_lowers_the_peaks_of_a_wire_and_yield_follows_the_stated_strength() -> None:
    run = run_with_forces()
    sharp = strength_of(run, "fixed", CYCLE, yield_strength_MPa=100.0)
    smooth = strength_of(run, "fixed", CYCLE, yield_strength_MPa=1e5, averaging_length_um=60.0)
    for name in ("von_mises", "critical_plane", "crossland"):
        assert getattr(smooth, name).value_MPa < getattr(sharp, name).value_MPa, name
    assert (sharp.yields, smooth.yields) == (True, False)
    assert "yields at 100 MPa from cycle 100" in yield_sentence([sharp])
    assert "to cycle 100, the last one looked at. Stresses beyond yield are" in yield_sentence([sharp])
    relieved = replace(smooth, cycle=200, asked=sharp.asked, von_mises=replace(smooth.von_mises, value_MPa=50.0))
    assert "to cycle 100; the next one looked at, 200, does not. Stresses" in yield_sentence([sharp, relieved])
    assert "nothing yields" in yield_sentence([smooth])
    assert sharp.grid.point_data["smith_watson_topper_MPa"].max() == sharp.critical_plane.value_MPa
    # The shear is reversed in the same place: cracks begin at the surface, at both edges alike.
    assert sharp.critical_plane.depth_um < 1.0
    assert abs(sharp.critical_plane.x_um) > 10.0


@pytest.mark.slow
def test_the_command_writes_table_fields_and_maps(tmp_path: Path) -> None:
    write_result(tmp_path / "result.h5", run_with_forces())
    asked = ["strength", str(tmp_path), "--wire", "fixed", "--yield-strength", "500", "--averaging-length", "20"]
    outcome = CliRunner().invoke(cli, asked, catch_exceptions=False)
    assert outcome.exit_code == 0, outcome.output
    assert "yields at 500 MPa" in outcome.output
    assert "wirewear: fixed, cycle 100\n" in outcome.stderr
    names = {path.name for path in (tmp_path / "strength").iterdir()}
    assert names == {"strength.csv", "strength_fixed_0000100.vtu", "strength_fixed_0000100.png"}
