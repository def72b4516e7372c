"""`wirewear new`: a commented study, or a mapping guessed from a logger's own files; and what import makes of it."""

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from tests.logger_files import height_points, write_english, write_german
from wirewear.faces import cli
from wirewear.kinds import KINDS, load_any_study
from wirewear.records import ExperimentRecord, read_record
from wirewear.records.importing.mapping import Source
from wirewear.records.importing.sources import files_of
from wirewear.study import load_study
from wirewear.study.keys import Table, table_of

EXAMPLE = Path("studies/steel_wires/example_records/rigid_stated_compliant_rig")


def wirewear(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def example() -> ExperimentRecord:
    return read_record(EXAMPLE)


def test_a_new_study_can_be_run_and_tells_what_each_key_means(tmp_path: Path) -> None:
    path = tmp_path / "soft_rig.toml"
    result = wirewear("new", tmp_path / "soft_rig")
    assert result.exit_code == 0, result.output
    study = load_study(path)
    assert study.name == "soft_rig"
    assert study.variant_names == ()
    lines = [line for line in path.read_text(encoding="utf-8").splitlines() if " = " in line][3:]
    assert all("#" in line for line in lines)
    again = wirewear("new", tmp_path / "soft_rig")
    assert again.exit_code == 2
    assert "is not overwritten" in again.stderr


def test_a_study_from_a_record_takes_over_its_test_and_its_cycles(tmp_path: Path, example: ExperimentRecord) -> None:
    result = wirewear("new", "mine", "--from", EXAMPLE, "--output", tmp_path / "mine.toml")
    assert result.exit_code == 0, result.output
    study = load_study(tmp_path / "mine.toml")
    assert study.tables.log.loop_cycles == example.cycles
    assert study.conditions.normal_load_N == example.tables.conditions.normal_load_N
    assert study.contact.friction == example.tables.stated.friction
    assert study.wear is not None
    assert study.wear.energy_wear_coefficient_mm3_per_J == 3e-5


def imported(folder: Path, files: list[Path]) -> ExperimentRecord:
    result = wirewear("new", "--mapping", *files, "--diameter", "0.45")
    assert result.exit_code == 0, result.output
    result = wirewear("import", folder / "mapping.toml", "--output", folder / "record")
    assert result.exit_code == 0, result.output
    return read_record(folder / "record")


@pytest.mark.parametrize("logger", ["German", "English"])
def test_a_guessed_mapping_gives_the_record_that_the_files_were_made_of(
    tmp_path: Path, example: ExperimentRecord, logger: str
) -> None:
    write = write_german if logger == "German" else write_english
    record = imported(tmp_path, write(example, tmp_path))
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


def test_a_file_that_is_named_twice_is_one_test(tmp_path: Path, example: ExperimentRecord) -> None:
    files = write_english(example, tmp_path)
    result = wirewear("new", "--mapping", *files, *files[:1], files[-1], "--diameter", "0.45")
    assert result.exit_code == 0, result.output
    text = (tmp_path / "mapping.toml").read_text(encoding="utf-8")
    assert [text.count(f'"{path.name}"') for path in files] == [1] * len(files)
    source = Source(files=("scar_fixed_*.xyz", "scar_fixed_1.xyz"))
    assert [path.name for path in files_of(source, tmp_path)] == [f"scar_fixed_{n}.xyz" for n in (1, 2, 3)]


def test_points_off_a_grid_give_the_same_scar(tmp_path: Path, example: ExperimentRecord) -> None:
    scar = example.scars_of("moving")[0]
    x, y, height = height_points(scar, 0.45)
    # A stage that comes to rest a little off its grid.
    random = np.random.default_rng(3)
    order = random.permutation(x.size)
    text = "\n".join(f"{a:.7f} {b:.7f} {c:.4f}" for a, b, c in np.stack([x, y, height], axis=1)[order])
    (tmp_path / "scar_moving.xyz").write_text("X[mm] Y[mm] Z[um]\n" + text, encoding="utf-8")
    moved = np.stack([x + 1e-6 * random.standard_normal(x.size), y, height], axis=1)[order]
    text = "\n".join(f"{a:.9f} {b:.9f} {c:.4f}" for a, b, c in moved)
    (tmp_path / "scar_fixed.xyz").write_text("X[mm] Y[mm] Z[um]\n" + text, encoding="utf-8")
    few = ExperimentRecord(example.tables, example.loops[:1])
    files = [*write_english(few, tmp_path), tmp_path / "scar_moving.xyz", tmp_path / "scar_fixed.xyz"]
    record = imported(tmp_path, files)
    gridded, scattered = record.scars_of("moving")[0], record.scars_of("fixed")[0]
    assert scattered.volume_mm3 == pytest.approx(gridded.volume_mm3, rel=0.05)


@pytest.mark.parametrize("um", [1.0, 1000.0], ids=["mm", "um"])
def test_points_without_names_are_a_scar(tmp_path: Path, example: ExperimentRecord, um: float) -> None:
    x, y, height = height_points(example.scars_of("fixed")[0], 0.45)
    rows = [f"{um * a:.7f} {um * b:.7f} {1e-3 * um * c:.7f}" for a, b, c in np.stack([x, y, height], axis=1)]
    (tmp_path / "scar_fixed.xyz").write_text("\n".join(rows) + "\n", encoding="utf-8")
    few = ExperimentRecord(example.tables, example.loops[:1])
    record = imported(tmp_path, [*write_english(few, tmp_path), tmp_path / "scar_fixed.xyz"])
    unit = "mm" if um == 1.0 else "µm"
    told = f"scar_fixed.xyz names no columns: they are taken for x, y and height in {unit}, {unit}, {unit}."
    assert told in (tmp_path / "mapping.toml").read_text(encoding="utf-8")
    assert record.scars_of("fixed")[0].volume_mm3 == pytest.approx(example.scars_of("fixed")[0].volume_mm3, rel=0.05)


def test_a_mapping_asks_for_what_no_file_tells(tmp_path: Path, example: ExperimentRecord) -> None:
    files = write_english(ExperimentRecord(example.tables, example.loops[:1]), tmp_path)
    asked = wirewear("new", "--mapping", *files)
    assert re.search(r'fill in what stands as "\?" in line \d+ \(diameter_mm\), then: wirewear import', asked.stdout)
    refused = wirewear("import", tmp_path / "mapping.toml", "--output", tmp_path / "record")
    assert refused.exit_code == 2
    assert re.search(r'not filled in: put what is right in place of "\?" in line \d+ \(diameter_mm\)\.', refused.stderr)
    (tmp_path / "mapping.toml").unlink()
    path = tmp_path / "other.csv"
    path.write_text("time_s,pressure_bar\n0,1\n1,2\n2,3\n", encoding="utf-8")
    assert "no file holds loops" in wirewear("new", "--mapping", path, "--diameter", "0.45").stderr


def test_a_folder_that_holds_a_mapping_already_is_guessed_anew_only_elsewhere(
    tmp_path: Path, example: ExperimentRecord
) -> None:
    mapping = mapping_of(tmp_path, write_english(ExperimentRecord(example.tables, example.loops[:2]), tmp_path))
    first, everything = mapping.read_text(encoding="utf-8"), sorted(tmp_path.iterdir())
    again = wirewear("new", "--mapping", *everything, "--diameter", "0.45")
    assert again.exit_code == 2
    assert "is not overwritten" in again.stderr
    other = tmp_path / "other.toml"
    result = wirewear("new", "--mapping", *everything, "--diameter", "0.45", "--output", other)
    assert result.exit_code == 0, result.output
    assert other.read_text(encoding="utf-8") == first


def test_a_wrong_material_is_told_with_what_is_like_it(tmp_path: Path, example: ExperimentRecord) -> None:
    files = write_english(ExperimentRecord(example.tables, example.loops[:1]), tmp_path)
    result = wirewear("new", "--mapping", *files, "--diameter", "0.45", "--material", "Inconel 69O")
    assert result.exit_code == 2
    assert "--material is 'Inconel 69O', which is in no table" in result.stderr


def mapping_of(folder: Path, files: list[Path]) -> Path:
    result = wirewear("new", "--mapping", *files, "--diameter", "0.45")
    assert result.exit_code == 0, result.output
    return folder / "mapping.toml"


def few_files(folder: Path, example: ExperimentRecord) -> list[Path]:
    scars = tuple(scar for scar in example.scars if scar.repeat == 1)
    return write_german(ExperimentRecord(example.tables, example.loops[:2], scars=scars), folder)


def test_a_dry_run_draws_loop_and_fitted_scars_and_refuses_a_wrong_unit(
    tmp_path: Path, example: ExperimentRecord
) -> None:
    mapping = mapping_of(tmp_path, few_files(tmp_path, example))
    sound = wirewear("import", mapping, "--output", tmp_path / "dry", "--dry-run")
    assert sound.exit_code == 0, sound.output
    pictures = ["dry_first_loop.png", "dry_scar_moving.png", "dry_scar_fixed.png"]
    assert all((tmp_path / name).read_bytes().startswith(b"\x89PNG") for name in pictures)
    assert not (tmp_path / "dry").exists()
    text = mapping.read_text(encoding="utf-8")
    mapping.write_text(text.replace('"Weg", unit = "mm"', '"Weg", unit = "µm"'), encoding="utf-8")
    wrong = wirewear("import", mapping, "--output", tmp_path / "dry", "--dry-run")
    assert wrong.exit_code == 1
    assert "it looks like millimetres" in wrong.stderr


def test_a_force_that_drives_the_motion_is_turned_in_the_record_and_told(
    tmp_path: Path, example: ExperimentRecord
) -> None:
    mapping = mapping_of(tmp_path, few_files(tmp_path, example))
    text = mapping.read_text(encoding="utf-8")
    mapping.write_text(text.replace(", factor = -1.0", ""), encoding="utf-8")
    result = wirewear("import", mapping, "--output", tmp_path / "record")
    assert "the record has it with the other sign" in result.stdout
    loop = read_record(tmp_path / "record").loops[0]
    np.testing.assert_allclose(loop.tangential_force_N, example.loops[0].complete.tangential_force_N, atol=1e-5)


def test_a_misspelt_column_is_answered_with_the_one_like_it(tmp_path: Path, example: ExperimentRecord) -> None:
    mapping = mapping_of(tmp_path, few_files(tmp_path, example))
    text = mapping.read_text(encoding="utf-8")
    mapping.write_text(text.replace('"semicolon"', '";"').replace('"Weg"', '"weg"'), encoding="utf-8")
    result = wirewear("import", mapping, "--output", tmp_path / "record")
    assert result.exit_code == 2
    assert "did you mean 'Weg'?" in result.stderr


def test_metadata_come_along_and_are_shown(tmp_path: Path, example: ExperimentRecord) -> None:
    mapping = mapping_of(tmp_path, few_files(tmp_path, example))
    more = '\n[metadata]\nlaboratory = "Prüfstand 7"\ndate = 2026-11-22\ntemperature_C = 23.5\nlubricant = "none"\n'
    mapping.write_text(mapping.read_text(encoding="utf-8") + more, encoding="utf-8")
    assert wirewear("import", mapping, "--output", tmp_path / "record").exit_code == 0
    metadata = read_record(tmp_path / "record").tables.metadata
    assert (metadata.date, metadata.temperature_C) == ("2026-11-22", 23.5)
    assert "laboratory: Prüfstand 7" in wirewear("check", tmp_path / "record").stdout
    mapping.write_text(mapping.read_text(encoding="utf-8").replace("2026-11-22", '"yesterday"'), encoding="utf-8")
    assert "must be a date" in wirewear("import", mapping, "--output", tmp_path / "record").stderr


def test_check_says_where_to_get_what_is_missing(tmp_path: Path, example: ExperimentRecord) -> None:
    mapping = mapping_of(tmp_path, few_files(tmp_path, example))
    wirewear("import", mapping, "--output", tmp_path / "record")
    told = " ".join(wirewear("check", tmp_path / "record").stdout.split())
    assert "`wirewear fit RECORD` finds friction and rig stiffness" in told
    assert "Repeat the test with fresh specimens" in told


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
    result = wirewear("import", tmp_path / "tdms.toml", "--output", tmp_path / "record")
    assert result.exit_code == 0, result.output
    (read,) = read_record(tmp_path / "record").loops
    np.testing.assert_allclose(read.displacement_um, loop.displacement_um, rtol=1e-12)
    (tmp_path / "tdms.toml").write_text(head + source.replace("Loops/Weg", "Loops/Wag"), encoding="utf-8")
    refused = wirewear("import", tmp_path / "tdms.toml", "--output", tmp_path / "record")
    assert "did you mean 'Loops/Weg'?" in refused.stderr
    (tmp_path / "cycle_100.tdms").write_bytes(b"no measurement")
    refused = wirewear("import", tmp_path / "tdms.toml", "--output", tmp_path / "record")
    assert refused.exit_code == 2
    assert "cannot be read as a TDMS file" in refused.stderr


@pytest.mark.parametrize("kind", ["line-contact"])
def test_studies_of_the_other_kinds_begin_with_every_key_and_its_meaning(tmp_path: Path, kind: str) -> None:
    result = wirewear("new", tmp_path / "mine", "--kind", kind)
    assert result.exit_code == 0, result.output
    study = load_any_study(tmp_path / "mine.toml")
    assert (study.name, study.kind) == ("mine", kind)
    lines = [line for line in (tmp_path / "mine.toml").read_text(encoding="utf-8").splitlines() if " = " in line][3:]
    assert all("#" in line for line in lines)
    # Keys that are commented out stand there to be used: each is one that the study takes.
    known = {key for name in KINDS[kind].template.shown for key in _keys_of(KINDS[kind].template.tables, name)}
    assert {line.removeprefix("# ").split(" = ")[0] for line in lines} <= known
    refused = wirewear("new", tmp_path / "other", "--kind", kind, "--from", EXAMPLE)
    assert refused.exit_code == 2
    assert f"gives no study of --kind {kind}" in refused.stderr


def _keys_of(tables: type[Table], name: str) -> list[str]:
    inner = table_of(tables.model_fields[name])
    assert inner is not None
    return list(inner.model_fields)


@pytest.mark.slow
def test_a_study_that_was_begun_runs_as_it_is(tmp_path: Path) -> None:
    wirewear("new", tmp_path / "mine", "--kind", "line-contact")
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    text = text.replace("cycles = 10000", "cycles = 2")
    (tmp_path / "mine.toml").write_text(f"{text}\n[mesh]\ncontact_mesh_um = 80\nincrements_per_cycle = 32\n")
    result = wirewear("run", tmp_path / "mine.toml", "--fidelity", "quick", "--output", tmp_path / "run")
    assert result.exit_code == 0, result.output
    assert (tmp_path / "run" / "loops.png").is_file()
