"""Temperatures of a run's surfaces: closed form of a slow disc, what both bodies share, the command."""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geometry.arrays import Array
from solvers import Conductor
from tests import synthetic_results
from tests.commands import wirewear
from wirewear.results import ContactForces, Loop, RunResult, Scar, write_result
from wirewear.stress.heat import SurfaceHeat, surface_heat

RADIUS_um, STROKE_um, COUNT, WORK_mJ, FREQUENCY_Hz = 30.0, 0.6, 48, 0.2, 3.0
STEEL, TITANIUM = Conductor(46.0, 3.6), Conductor(6.7, 2.4)
LINES = np.linspace(-40.0, 40.0, 41)


def rubbed(stuck_um: float = 0.0) -> RunResult:
    """Wires that rub on a disc under an even friction, beyond a radius, at an even speed, by a stroke that is short."""
    phase = (np.arange(COUNT) + 1.0) / COUNT
    drive = STROKE_um * (2.0 * np.abs(2.0 * phase - 1.0) - 1.0)
    radius = np.hypot(LINES[:, None], LINES[None, :])
    touched, unworn = radius < RADIUS_um, np.zeros_like(radius)
    slid = np.where(radius > stuck_um, touched, 0.0)
    nodes = np.flatnonzero(touched)
    force = np.zeros((COUNT, len(nodes), 3))
    force[:, :, 0] = np.sign(drive - np.roll(drive, 1))[:, None] * 1e-3
    column = np.zeros(COUNT)
    forces = [
        ContactForces(1, body, phase, drive, column, column, column, nodes, force) for body in ("moving", "fixed")
    ]
    scars = [
        Scar(1, body, 0.45, angle, LINES, LINES, unworn, unworn, unworn, slid)
        for body, angle in (("moving", 0.0), ("fixed", 90.0))
    ]
    time = np.arange(COUNT) / COUNT / FREQUENCY_Hz
    work = WORK_mJ * (np.arange(COUNT) + 1.0) / COUNT
    loop = Loop(1, time, np.roll(drive, 12), np.roll(drive, 12), column, column + 2.0, work)
    made_up = synthetic_results.result(milestones=(1,))
    conditions = {**made_up.study["conditions"], "frequency_Hz": FREQUENCY_Hz}
    study = {**made_up.study, "conditions": conditions}
    return replace(made_up, study=study, scars=tuple(scars), loops=(loop,), contact_forces=tuple(forces))


def test_under_slow_even_friction_a_disc_is_as_hot_as_the_closed_form() -> None:
    moving, fixed = surface_heat(rubbed(), 1.0, {"moving": STEEL, "fixed": STEEL})
    power = WORK_mJ * FREQUENCY_Hz
    assert moving.power_mW == pytest.approx(power, rel=1e-6)
    for one in (moving, fixed):
        assert one.share == pytest.approx(0.5, abs=0.01)
        # Carslaw & Jaeger § 10.5: P / (π a k) in the middle of a disc.
        assert one.largest_K == pytest.approx(0.5 * power / (np.pi * 1e-3 * RADIUS_um * 46.0), rel=0.05)


def test_still_bodies_share_the_heat_as_they_conduct_it_and_are_as_hot() -> None:
    titanium, steel = surface_heat(rubbed(), 1.0, {"moving": TITANIUM, "fixed": STEEL})
    assert steel.share == pytest.approx(46.0 / (46.0 + 6.7), abs=0.01)
    assert titanium.share + steel.share == pytest.approx(1.0, abs=1e-12)
    assert titanium.largest_K == pytest.approx(steel.largest_K, rel=1e-9)


def hottest_radius_um(one: SurfaceHeat) -> float:
    where: Array = one.rise_K.mean(axis=0)
    row, column = np.unravel_index(int(where.argmax()), where.shape)
    return float(np.hypot(one.axial_um[row], one.transverse_um[column]))


def test_where_the_middle_sticks_heat_enters_around_it() -> None:
    both = {"moving": STEEL, "fixed": STEEL}
    whole, ring = surface_heat(rubbed(), 1.0, both)[1], surface_heat(rubbed(20.0), 1.0, both)[1]
    assert hottest_radius_um(whole) < 5.0
    assert hottest_radius_um(ring) > 15.0
    assert not ring.touched[len(ring.axial_um) // 2, len(ring.transverse_um) // 2]


def test_the_command_writes_table_and_picture_and_refuses_what_is_no_conductivity(tmp_path: Path) -> None:
    path = tmp_path / "result.h5"
    write_result(path, rubbed())
    printed = wirewear("heat", path, "--conductivity", "46,6.7", "--heat-capacity", "3.6,2.4")
    assert "largest rise" in printed.output
    with (tmp_path / "heat" / "heat.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["body"] for row in rows] == ["moving", "fixed"]
    assert float(rows[0]["friction_power_mW"]) == pytest.approx(WORK_mJ * FREQUENCY_Hz)
    assert (tmp_path / "heat" / "heat.png").stat().st_size > 10_000
    refused = wirewear("heat", path, "--conductivity", "46,6.7,1", "--heat-capacity", "3.6", code=2)
    assert "one number for each of two bodies" in refused.output
