"""Joints: loops of a friction contact without bodies are checked, imported, fitted and written like others."""

from pathlib import Path

import pytest

from tests.commands import wirewear
from tests.records.joint_records import FORCE_N, OWN_N_per_mm, RIG_N_per_mm, joint
from wirewear import RecordError, StudyError, read_record, write_record
from wirewear.diagnosis.fit import fit_record
from wirewear.kinds import load_any_study
from wirewear.records import check_record
from wirewear.simulation import simulate


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


def test_a_mapping_of_a_joints_files_asks_for_no_bodies_and_takes_its_friction_force_for_a_load(tmp_path: Path) -> None:
    loops, mapping = joint(tmp_path / "a") / "loops.csv", tmp_path / "a" / "mapping.toml"
    said = wirewear("new", "--mapping", "--kind", "joint", loops).stdout
    assert "steel" not in said
    assert "?" not in mapping.read_text(encoding="utf-8").partition("[stated]")[0]
    wirewear("import", mapping, "--output", tmp_path / "record")
    stated = read_record(tmp_path / "record").tables
    assert stated.conditions.normal_load_N == pytest.approx(FORCE_N, rel=0.02)
    assert stated.stated.friction == 1.0
    refused = wirewear("new", "--mapping", "--kind", "joint", loops, "--material", "steel", code=2)
    assert "--material does not go with the options of a joint" in refused.stderr
