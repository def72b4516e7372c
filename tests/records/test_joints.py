"""Joints: loops of a friction contact without bodies are checked, imported, fitted and written like others."""

from pathlib import Path

import numpy as np
import pytest

from tests.commands import wirewear
from wirewear import RecordError, StudyError, read_record, write_record
from wirewear.diagnosis.fit import fit_record
from wirewear.kinds import load_any_study
from wirewear.records import check_record
from wirewear.simulation import simulate

FORCE_N, RIG_N_per_mm, OWN_N_per_mm, AMPLITUDE_um = 39.0, 900.0, 4500.0, 500.0

TABLES = """
format = 1
name = "friction damper"
[contact]
kind = "joint"
contact_stiffness_N_per_mm = {own}
[conditions]
{load}displacement_amplitude_um = 500.0
frequency_Hz = 0.25
cycles = 30
[stated]
{friction}
tangential_stiffness_N_per_mm = 900.0
[files]
loops = "loops.csv"
"""


def joint(folder: Path, load: str = "", friction: str = "friction_force_N = 39.0", own: object = OWN_N_per_mm) -> Path:
    """A record of a slider behind two springs in series, of two repeats and cycles."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "experiment.toml").write_text(TABLES.format(load=load, friction=friction, own=own), encoding="utf-8")
    random, count = np.random.default_rng(1), 400
    stroke = AMPLITUDE_um * np.sin(2.0 * np.pi * np.arange(2 * count) / count)
    stiffness = 1e-3 / (1.0 / RIG_N_per_mm + 1.0 / OWN_N_per_mm)
    force = np.zeros(stroke.size)
    for i in range(1, stroke.size):
        force[i] = np.clip(force[i - 1] + stiffness * (stroke[i] - stroke[i - 1]), -FORCE_N, FORCE_N)
    lines = ["repeat,cycle,sample,time_s,displacement_um,tangential_force_N"]
    for repeat in (1, 2):
        for cycle in (1, 30):
            noise = 0.1 * random.standard_normal(count)
            rows = enumerate(zip(stroke[count:], force[count:] + noise, strict=True))
            lines += [f"{repeat},{cycle},{i},{4.0 * i / count},{x},{q}" for i, (x, q) in rows]
    (folder / "loops.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


def test_a_friction_force_stands_for_load_and_friction_of_a_joint(tmp_path: Path) -> None:
    alone = read_record(joint(tmp_path / "a")).tables
    assert (alone.contact_kind, alone.conditions.normal_load_N, alone.stated.friction) == ("joint", FORCE_N, 1.0)
    pressed = read_record(joint(tmp_path / "b", "normal_load_N = 130.0\n")).tables
    assert (pressed.conditions.normal_load_N, pressed.stated.friction) == (130.0, pytest.approx(0.3))
    with pytest.raises(RecordError, match="both friction and friction_force_N"):
        read_record(joint(tmp_path / "c", friction="friction = 0.3\nfriction_force_N = 39.0"))
    with pytest.raises(RecordError, match="normal_load_N"):
        read_record(joint(tmp_path / "d", friction="friction = 0.3"))


def test_a_joint_is_checked_and_written_without_a_word_on_bodies(tmp_path: Path) -> None:
    record = read_record(joint(tmp_path / "a"))
    report = check_record(record)
    assert not report.problems
    said = " ".join((*report.supports, *report.cannot))
    assert "scar" not in said
    assert "A prediction of its loops" in said
    again = read_record(write_record(tmp_path / "b", record))
    assert again.tables == record.tables.model_copy(update={"files": again.tables.files})


@pytest.mark.parametrize("own", [OWN_N_per_mm, '"rigid"'])
def test_a_joints_loops_give_its_friction_force_and_rig(tmp_path: Path, own: object) -> None:
    fitted = fit_record(read_record(joint(tmp_path / "a", own=own)))
    rig = RIG_N_per_mm if own == OWN_N_per_mm else 1.0 / (1.0 / RIG_N_per_mm + 1.0 / OWN_N_per_mm)
    for name, true in (("friction", 1.0), ("tangential_stiffness_N_per_mm", rig)):
        low, high = fitted.parameters[name].interval95
        assert low < true < high
        assert fitted.parameters[name].value == pytest.approx(true, rel=0.03)
    assert fitted.study.kind == "joint"
    assert not any("wear" in note for note in fitted.notes)


def test_commands_take_a_joint_and_say_that_it_is_not_simulated(tmp_path: Path) -> None:
    record = joint(tmp_path / "a")
    wirewear("check", record)
    wirewear("loops", record)
    wirewear("fit", record, "--output", tmp_path / "fit", "--into-record")
    assert read_record(record).tables.conditions.normal_load_N == pytest.approx(FORCE_N, rel=0.02)
    study = load_any_study(tmp_path / "fit" / "study.toml")
    assert study.contact.contact_stiffness_N_per_mm == OWN_N_per_mm
    with pytest.raises(StudyError, match="no bodies"):
        simulate(study)
    for command in ("run", "mesh"):
        refused = wirewear(command, tmp_path / "fit" / "study.toml", "--output", tmp_path / "run", code=2)
        assert "no bodies" in refused.stderr
    wirewear("new", tmp_path / "mine", "--kind", "joint")
    assert load_any_study(tmp_path / "mine.toml").kind == "joint"
    wirewear("new", "--from", record, tmp_path / "taken")
    assert load_any_study(tmp_path / "taken.toml").kind == "joint"
