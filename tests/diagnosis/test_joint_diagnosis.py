"""Diagnosis of joints: a slider behind springs, by loops alone."""

from pathlib import Path

import pytest

from studies.real_rigs.diagnose import record_of as real_record
from tests.commands import wirewear
from tests.records.joint_records import FORCE_N, OWN_N_per_mm, Rig, joint
from wirewear import read_record
from wirewear.diagnosis import diagnose

#: What is not as stated; the effect that says so, its parameter and value.
FAULTS = (
    (Rig(friction=0.85), "friction_offset", "friction", 0.85),
    (Rig(spring_N_per_mm=2000.0), "tangential_compliance", "stiffness_N_per_mm", 2000.0),
    (Rig(play_um=25.0), "free_play", "gap_um", 25.0),
    (Rig(force_lag_s=0.08), "sensor_lag", "time_s", 0.08),
    (Rig(gain=1.15), "displacement_gain", "gain", 1.15),
    (Rig(mass_kg=0.5, frequency_Hz=30.0), "holder_inertia", "mass_kg", 0.5),
    (Rig(friction=0.8, last_friction=1.1), "friction_evolution", "final", 1.1),
)


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("own", [OWN_N_per_mm, '"rigid"'])
def test_a_joint_as_stated_has_no_gap_and_nothing_is_said_of_bodies(tmp_path: Path, own: object) -> None:
    rig = Rig() if own == OWN_N_per_mm else Rig(spring_N_per_mm=-OWN_N_per_mm)
    found = diagnose(read_record(joint(tmp_path, own=own, rig=rig))).diagnosis
    assert found.verdict == "no_gap"
    considered = {cause.effect for cause in found.causes} | set(found.undetectable)
    assert considered.isdisjoint({"wear_rate_offset", "third_body", "roughness_compliance", "plasticity"})
    assert not any("wear" in note or "scar" in note for note in found.notes)


@pytest.mark.seconds
@pytest.mark.first_case
@pytest.mark.parametrize(("rig", "effect", "parameter", "true"), FAULTS, ids=[one[1] for one in FAULTS])
def test_a_joint_that_is_not_as_stated_is_explained_by_its_fault(
    tmp_path: Path, rig: Rig, effect: str, parameter: str, true: float
) -> None:
    found = diagnose(read_record(joint(tmp_path, rig=rig))).diagnosis
    assert found.verdict == "explained"
    cause = next(one for one in found.causes if one.effect == effect)
    low, high = cause.parameters[parameter].interval95
    assert low < true < high
    if effect != "friction_evolution":  # whose course beyond the fitted cycles is not known
        assert found.shrink.shrink == pytest.approx(1.0, abs=0.05)


@pytest.mark.seconds
def test_the_command_takes_a_joint_and_its_fitted_study(tmp_path: Path) -> None:
    record = joint(tmp_path / "a", rig=Rig(friction=0.85))
    wirewear("fit", record, "--output", tmp_path / "fit")
    answer = wirewear(
        "diagnose", record, "--output", tmp_path / "out", "--model", tmp_path / "fit" / "study.toml", "--confirm"
    )
    assert "agree" in answer.stdout
    assert f"{FORCE_N:g}" not in answer.stderr
    wirewear("diagnose", record, "--output", tmp_path / "stated", "--confirm")
    assert "states no bodies" in (tmp_path / "stated" / "diagnosis.json").read_text()


@pytest.mark.seconds
def test_a_dampers_play_of_millimetres_is_fitted_under_kilonewtons(tmp_path: Path) -> None:
    """A banded damper with backlash, whose band is at 80 lb; half the distance of its plateaus is 12.6 kN."""
    fitted = real_record("2022_80lb_0.5Hz", tmp_path, 12600.0, 3400.0).fit(progress=False)
    assert fitted.parameters["friction"].value == pytest.approx(1.0, abs=0.05)
    (play,) = (one.values["gap_um"] for one in fitted.study.effects if one.name == "free_play")
    assert 1000.0 < play < 4000.0
