"""Loops without what rig and sensors do to them, against a slider whose drift, lag, play and spring are known."""

import csv
from pathlib import Path

import numpy as np
import pytest

from geometry.arrays import Array
from tests.commands import wirewear
from tests.records.joint_records import FORCE_N, AMPLITUDE_um, OWN_N_per_mm, Rig, RIG_N_per_mm
from wirewear.loops import analyse_loop
from wirewear.loops.corrected import corrected_loop
from wirewear.loops.sensor import enclosed_area

COUNT, PLAY_um = 400, 25.0
STIFFNESS = 1e-3 / (1.0 / RIG_N_per_mm + 1.0 / OWN_N_per_mm)
TIME = np.arange(COUNT) / COUNT


def measured(play_um: float = 0.0, noise_N: float = 0.05) -> tuple[Array, Array]:
    x, force = Rig(play_um=play_um).loop(30, COUNT)
    return x, force + noise_N * np.random.default_rng(5).standard_normal(COUNT)


def test_the_slip_of_a_slider_is_found_behind_spring_and_play() -> None:
    x, force = measured(PLAY_um)
    found = corrected_loop(x, force, FORCE_N, time_s=TIME)
    assert found.free_play_um == pytest.approx(PLAY_um, rel=0.03)
    assert found.compliance_um_per_N == pytest.approx(1.0 / STIFFNESS, rel=0.03)
    # By definition; on the shelf the play is passed.
    true = x - force / STIFFNESS - 0.5 * PLAY_um * np.sign(force)
    off = np.abs(force) > 1.0
    assert np.nanmax(np.abs(found.slip_um - true)[off]) < 0.02 * AMPLITUDE_um
    assert 0.5 * np.nanmax(np.ptp(found.slip_um)) == pytest.approx(
        AMPLITUDE_um - FORCE_N / STIFFNESS - 0.5 * PLAY_um, rel=0.01
    )


def test_play_and_compliance_leave_the_energy_as_it_is() -> None:
    x, force = measured(PLAY_um, noise_N=0.0)
    found = corrected_loop(x, force, FORCE_N, time_s=TIME)
    for corrected in (found.displacement_um, found.slip_um):
        assert enclosed_area(corrected, found.force_N) == pytest.approx(enclosed_area(x, force), rel=0.01)


def test_a_drift_and_a_lag_are_taken_out() -> None:
    x, force = measured()
    drift = 0.04 * AMPLITUDE_um
    found = corrected_loop(x + drift * TIME, np.roll(force, 4), FORCE_N, time_s=TIME)
    assert found.drift_um == pytest.approx(drift, rel=0.25)
    assert found.lag_samples == pytest.approx(4.0, abs=1.0)
    middle = np.abs(force) < 0.7 * FORCE_N
    assert np.nanmax(np.abs(found.force_N - force)[middle]) < 0.2 * FORCE_N


def test_a_loop_without_faults_is_corrected_for_its_compliance_alone() -> None:
    x, force = measured()
    found = corrected_loop(x, force, FORCE_N, time_s=TIME)
    assert (found.drift_um, found.lag_samples, found.free_play_um, found.lean_um_per_N) == (0.0, 0.0, 0.0, 0.0)
    kept = np.isfinite(found.displacement_um)
    np.testing.assert_allclose(found.displacement_um[kept], x[kept])


def test_the_samples_of_each_figure_lie_where_the_figure_is_read() -> None:
    x, force = measured()
    used = {name: [*own] for name, own in analyse_loop(x, force, FORCE_N, time_s=TIME).used.items()}
    assert len(used["energy"]) == COUNT
    slides = np.abs(force) > 0.98 * FORCE_N
    assert slides[used["friction"]].all()
    rising = np.sign(np.cos(2.0 * np.pi * TIME)) * force
    assert rising[used["stiffness"]].max() < 0.98 * FORCE_N
    assert np.abs(force[used["slip"]]).max() < 0.7 * FORCE_N
    # Without a load there is no friction to read.
    assert analyse_loop(x, force, time_s=TIME).used["friction"] == ()


def test_one_command_exports_corrected_loops_with_units_and_the_samples_used(tmp_path: Path) -> None:
    x, force = measured(PLAY_um)
    lines = [
        "time_s,displacement_um,tangential_force_N",
        *(f"{t},{a},{q}" for t, a, q in zip(TIME, x, force, strict=True)),
    ]
    (tmp_path / "loop.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    picture = tmp_path / "loop.png"
    wirewear("loops", tmp_path / "loop.csv", "--normal-load", FORCE_N, "--corrected", tmp_path / "out",
             "--output", picture)  # fmt: skip
    with (tmp_path / "out" / "corrected_loops.csv").open(encoding="utf-8") as file:
        rows = [*csv.DictReader(file)]
    with (tmp_path / "out" / "corrections.csv").open(encoding="utf-8") as file:
        (corrections,) = csv.DictReader(file)
    assert len(rows) == COUNT
    assert [float(row["displacement_um"]) for row in rows] == pytest.approx(x, abs=1e-9)
    assert float(corrections["free_play_um"]) == pytest.approx(PLAY_um, rel=0.03)
    assert {row["gave_stiffness"] for row in rows} == {"0", "1"}
    assert picture.exists()
