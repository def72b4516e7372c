"""`wirewear new`: a commented study, or a mapping guessed from a logger's own files; and what import makes of it."""

import dataclasses
import json
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests import synthetic_results
from tests.commands import wirewear
from tests.exam.frozen_states import frozen_states
from tests.records.logger_files import write_english, write_german
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.kinds import load_any_study
from wirewear.records import ExperimentRecord, read_record
from wirewear.results import RunResult, write_result
from wirewear.test import Study, load_study
from wirewear.test.keys import Table, table_of
from wirewear.test.kinds import KINDS
from wirewear.test.template import study_text

EXAMPLE = Path("studies/steel_wires/example_records/rigid_stated_compliant_rig").resolve()


@pytest.fixture(scope="module")
def example() -> ExperimentRecord:
    return read_record(EXAMPLE)


def test_a_new_study_can_be_run_and_explains_each_key(tmp_path: Path) -> None:
    path = tmp_path / "soft_rig.toml"
    wirewear("new", tmp_path / "soft_rig")
    study = load_study(path)
    assert study.name == "soft_rig"
    assert study.variant_names == ()
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if " = " in line][3:]
    assert all("#" in line for line in lines)
    assert "is not overwritten" in wirewear("new", tmp_path / "soft_rig", code=2).stderr


def imported(folder: Path, files: list[Path]) -> ExperimentRecord:
    wirewear("new", "--mapping", *files, "--diameter", "0.45")
    wirewear("import", folder / "mapping.toml", "--output", folder / "record")
    return read_record(folder / "record")


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("logger", ["German", "English"])
def test_a_guessed_mapping_gives_the_files_record(tmp_path: Path, example: ExperimentRecord, logger: str) -> None:
    record = imported(tmp_path, (write_german if logger == "German" else write_english)(example, tmp_path))
    assert record.repeats == example.repeats
    assert record.cycles == example.cycles
    assert record.tables.conditions.normal_load_N == pytest.approx(2.0, rel=0.01)
    assert record.tables.conditions.displacement_amplitude_um == pytest.approx(60.0, rel=0.005)
    assert record.tables.conditions.frequency_Hz == pytest.approx(3.0, rel=1e-3)
    for one, other in zip(record.loops, (loop.complete for loop in example.loops), strict=True):
        np.testing.assert_allclose(one.displacement_um, other.displacement_um, atol=1e-3)
        np.testing.assert_allclose(one.tangential_force_N, other.tangential_force_N, atol=1e-5)
    for wire in ("moving", "fixed"):
        volumes, truth = ([scar.volume_mm3 for scar in one.scars_of(wire)] for one in (record, example))
        np.testing.assert_allclose(volumes, truth, rtol=0.05)


def test_a_mapping_asks_for_what_no_file_states(tmp_path: Path, example: ExperimentRecord) -> None:
    files = write_english(ExperimentRecord(example.tables, example.loops[:1]), tmp_path)
    asked = wirewear("new", "--mapping", *files)
    assert re.search(r'fill in what stands as "\?" in line \d+ \(diameter_mm\), then: wirewear import', asked.stdout)
    refused = wirewear("import", tmp_path / "mapping.toml", "--output", tmp_path / "record", code=2)
    assert re.search(r'not filled in: put what is right in place of "\?" in line \d+ \(diameter_mm\)\.', refused.stderr)
    (tmp_path / "mapping.toml").unlink()
    path = tmp_path / "other.csv"
    path.write_text("time_s,pressure_bar\n0,1\n1,2\n2,3\n", encoding="utf-8")
    assert "no file holds loops" in wirewear("new", "--mapping", path, "--diameter", "0.45", code=2).stderr


@pytest.mark.parametrize(
    ("recorded", "phase"), [((1, 10, 100, 1000, 10_000), 0.0), ((1, 2, 3, 20, 21, 150), 0.7), ((1, 10_000), 0.0)]
)
def test_cycles_of_a_log_with_gaps_are_numbered_where_its_pieces_give_the_frequency(
    tmp_path: Path, recorded: tuple[int, ...], phase: float
) -> None:
    random, turn = np.random.default_rng(2), 2.0 * np.pi * np.arange(200) / 200
    lines = ["time [s];displacement [µm];tangential force [N]"]
    for cycle in recorded:
        x = 60.0 * np.sin(turn + phase) + 0.2 * random.standard_normal(turn.size)
        force = np.tanh(3.0 * np.cos(turn + phase)) + 0.01 * random.standard_normal(turn.size)
        time = ((cycle - 1) + turn / (2.0 * np.pi)) / 3.1
        lines += [f"{t:.5f};{a:.4f};{q:.4f}" for t, a, q in zip(time, x, force, strict=True)]
    (tmp_path / "log.csv").write_text("\n".join(lines), encoding="utf-8")
    made = wirewear("new", "--mapping", tmp_path / "log.csv", "--diameter", "0.45", "--normal-load", "2")
    guessed = tomllib.loads((tmp_path / "mapping.toml").read_text(encoding="utf-8"))["conditions"]
    if len(recorded) == 2:
        assert guessed["frequency_Hz"] == guessed["cycles"] == "?"
        assert "some 3.1 a second, do not show how many lie between them" in made.stdout
        return
    assert guessed["frequency_Hz"] == pytest.approx(3.1, rel=1e-5)
    assert guessed["cycles"] == recorded[-1]
    wirewear("import", tmp_path / "mapping.toml", "--output", tmp_path / "record")
    assert read_record(tmp_path / "record").cycles == recorded


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.03, 0.06])
def test_a_guessed_amplitude_is_not_that_of_the_outermost_noisy_readings(tmp_path: Path, noise: float) -> None:
    random = np.random.default_rng(1)
    time = np.arange(1600) / 800.0
    phase = 2.0 * np.pi * 5.0 * time
    x = 12.0 * (np.sin(phase) + noise * random.standard_normal(time.size))
    force = 0.6 * np.tanh(3.0 * np.cos(phase)) + 0.6 * np.clip(np.sin(phase), 0.0, 0.1)
    log = tmp_path / "log.csv"
    lines = [f"{t:.5f};{a:.4f};{q:.4f}" for t, a, q in zip(time, x, force, strict=True)]
    log.write_text("\n".join(["time [s];displacement [µm];tangential force [N]", *lines]), encoding="utf-8")
    wirewear("new", "--mapping", log, "--diameter", "0.45", "--normal-load", "2")
    guessed = tomllib.loads((tmp_path / "mapping.toml").read_text(encoding="utf-8"))["conditions"]
    assert guessed["displacement_amplitude_um"] == pytest.approx(12.0, rel=0.005 + 0.1 * noise)


def mapping_of(folder: Path, files: list[Path]) -> Path:
    wirewear("new", "--mapping", *files, "--diameter", "0.45")
    return folder / "mapping.toml"


def few_files(folder: Path, example: ExperimentRecord) -> list[Path]:
    scars = tuple(scar for scar in example.scars if scar.repeat == 1)
    return write_german(ExperimentRecord(example.tables, example.loops[:2], scars=scars), folder)


@pytest.mark.seconds
def test_a_dry_run_draws_loop_and_scars_and_refuses_a_wrong_unit(tmp_path: Path, example: ExperimentRecord) -> None:
    mapping = mapping_of(tmp_path, few_files(tmp_path, example))
    wirewear("import", mapping, "--output", tmp_path / "dry", "--dry-run")
    pictures = ["dry_first_loop.png", "dry_scar_moving.png", "dry_scar_fixed.png"]
    assert all((tmp_path / name).read_bytes().startswith(b"\x89PNG") for name in pictures)
    assert not (tmp_path / "dry").exists()
    text = mapping.read_text(encoding="utf-8")
    mapping.write_text(text.replace('"Weg", unit = "mm"', '"Weg", unit = "µm"'), encoding="utf-8")
    wrong = wirewear("import", mapping, "--output", tmp_path / "dry", "--dry-run", code=1)
    assert "it looks like millimetres" in wrong.stderr


@pytest.mark.seconds
def test_a_tdms_file_is_read_by_group_and_channel(tmp_path: Path, example: ExperimentRecord) -> None:
    nptdms = pytest.importorskip("nptdms")
    loop = example.loops[0].complete
    channels = {"Zeit": loop.time_s, "Weg": 1e-3 * loop.displacement_um, "Kraft": loop.tangential_force_N}
    with nptdms.TdmsWriter(tmp_path / "cycle_100.tdms") as writer:
        writer.write_segment([nptdms.ChannelObject("Loops", name, values) for name, values in channels.items()])
    mapping = mapping_of(tmp_path, few_files(tmp_path, example)).read_text(encoding="utf-8")
    head = mapping[: mapping.index("[loops]")].replace("[stated]", "[stated]\nfriction = 0.62\n#")
    source = (
        '[loops]\nfiles = "cycle_100.tdms"\nkind = "tdms"\nname_pattern = \'_(?P<cycle>\\d+)\'\n[loops.columns]\n'
        'displacement_um = { column = "Loops/Weg", unit = "mm" }\ntangential_force_N = "Kraft"\ntime_s = "Zeit"\n'
    )
    (tmp_path / "tdms.toml").write_text(head + source, encoding="utf-8")
    wirewear("import", tmp_path / "tdms.toml", "--output", tmp_path / "record")
    (read,) = read_record(tmp_path / "record").loops
    np.testing.assert_allclose(read.displacement_um, loop.displacement_um, rtol=1e-12)
    (tmp_path / "tdms.toml").write_text(head + source.replace("Loops/Weg", "Loops/Wag"), encoding="utf-8")
    refused = wirewear("import", tmp_path / "tdms.toml", "--output", tmp_path / "record", code=2)
    assert "did you mean 'Loops/Weg'?" in refused.stderr
    (tmp_path / "cycle_100.tdms").write_bytes(b"no measurement")
    refused = wirewear("import", tmp_path / "tdms.toml", "--output", tmp_path / "record", code=2)
    assert "cannot be read as a TDMS file" in refused.stderr


@pytest.mark.parametrize("kind", ["line-contact"])
def test_studies_of_the_other_kinds_begin_with_every_key_and_its_meaning(tmp_path: Path, kind: str) -> None:
    wirewear("new", tmp_path / "mine", "--kind", kind)
    study = load_any_study(tmp_path / "mine.toml")
    assert (study.name, study.kind) == ("mine", kind)
    lines = [line for line in (tmp_path / "mine.toml").read_text(encoding="utf-8").splitlines() if " = " in line][3:]
    assert all("#" in line for line in lines)
    # Keys that are commented out stand there to be used: each is one that the study takes.
    known = {key for name in KINDS[kind].template.shown for key in _keys_of(KINDS[kind].template.tables, name)}
    assert {line.removeprefix("# ").split(" = ")[0] for line in lines} <= known
    refused = wirewear("new", tmp_path / "other", "--kind", kind, "--from", EXAMPLE, code=2)
    assert f"gives no study of --kind {kind}" in refused.stderr


@pytest.mark.parametrize(("kind", "times"), [("ball-on-flat", 0), ("point-contact", 0), ("crossed-wires", 1)])
def test_the_motions_angle_to_a_wire_is_a_key_of_wires_alone(kind: str, times: int) -> None:
    assert study_text("mine", KINDS[kind].template).count("motion_angle_deg") == times


def _keys_of(tables: type[Table], name: str) -> list[str]:
    inner = table_of(tables.model_fields[name])
    assert inner is not None
    return list(inner.model_fields)


@pytest.fixture
def _no_elements(monkeypatch: pytest.MonkeyPatch) -> None:
    def run_study(study: Study, *, output: Path, **_options: Any) -> list[RunResult]:
        found = synthetic_results.result("", float(study.holder.tangential_stiffness_N_per_mm))
        found = dataclasses.replace(found, study=study.resolved())
        write_result(output / "result.h5", found)
        return [found]

    nominal = synthetic_results.result("", 167.0)
    monkeypatch.setattr("wirewear.diagnosis.surrogate.nominal.nominal_run", lambda *_: nominal)
    monkeypatch.setattr(WearStates, "of_run", classmethod(lambda *_: frozen_states()))
    monkeypatch.setattr("wirewear.simulation.run_study", run_study)


@pytest.mark.slow
@pytest.mark.usefixtures("_no_elements")
def test_five_commands_lead_from_own_files_to_an_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    imported(Path(), [path.relative_to(tmp_path) for path in write_german(read_record(EXAMPLE), tmp_path)])
    commands = (
        ["fit", "record", "--output", "fitted"],
        ["compare", "fitted/run", "record", "--output", "compared"],
        ["diagnose", "record", "--output", "diagnosed"],
        ["diagnose", "record", "--model", "fitted/study.toml", "--output", "diagnosis"],
    )
    for command in commands:
        result = wirewear(*command)
    # Off a terminal each stage of the diagnosis is a line.
    for stage in ("checking the record", "reducing the loops", "searching for causes"):
        assert f"wirewear: {stage}\n" in result.stderr
    fitted = (tmp_path / "fitted" / "study.toml").read_text(encoding="utf-8")
    assert "tangential_stiffness_N_per_mm = 1" in fitted
    assert "loop_cycles = [100, 1000, 10000, 100000]" in fitted
    assert (tmp_path / "compared" / "comparison.html").is_file()
    diagnosed = json.loads((tmp_path / "diagnosed" / "diagnosis.json").read_text(encoding="utf-8"))
    assert "tangential_compliance" in [cause["effect"] for cause in diagnosed["causes"]]
    diagnosis = json.loads((tmp_path / "diagnosis" / "diagnosis.json").read_text(encoding="utf-8"))
    # The owner's rig was rigid in mind only: with the fitted one, little is left to explain.
    assert diagnosis["verdict"] in ("no_gap", "explained", "ambiguous")
    assert all(
        cause["effect"] != "tangential_compliance" or cause["probability"] < 0.5 for cause in diagnosis["causes"]
    )
