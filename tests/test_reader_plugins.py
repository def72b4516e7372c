"""Readers of installed packages import files of their kind: the worked example of the docs."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.synthetic_loops import Recipe, SyntheticLoop
from tests.test_import import HEAD, SAMPLES, FREQUENCY_Hz
from tests.worked_examples import install_example
from wirewear.records.importing import import_record
from wirewear.records.importing.guessing import crossed_wires, guessed_mapping
from wirewear.records.importing.registry import readers


@pytest.fixture
def mapping(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A mapping that chooses the docs' reader, installed as they say."""
    (tmp_path / "plugin").mkdir()
    (loops,) = install_example("A logger's files", tmp_path / "plugin", monkeypatch).tables
    path = tmp_path / "mapping.toml"
    path.write_text(HEAD + loops, encoding="utf-8")
    readers.cache_clear()
    yield path
    monkeypatch.undo()
    readers.cache_clear()


def test_a_package_reads_another_loggers_files(mapping: Path) -> None:
    time, displacement, force = SyntheticLoop(Recipe()).sampled(SAMPLES)
    rows = zip(time / FREQUENCY_Hz, displacement, force, strict=True)
    text = "\n".join(json.dumps(dict(zip("txQ", row, strict=True))) for row in rows)
    for number in (1, 100):
        (mapping.parent / f"cycle_{number}.jsonl").write_text(text, encoding="utf-8")
    loops = import_record(mapping).loops
    assert [(loop.cycle, loop.time_s.size) for loop in loops] == [(1, SAMPLES), (100, SAMPLES)]
    assert loops[1].tangential_force_N.tolist() == pytest.approx(force.tolist())


def test_files_that_a_package_knows_are_guessed_without_being_told_their_kind(mapping: Path) -> None:
    time, displacement, force = SyntheticLoop(Recipe()).sampled(SAMPLES)
    rows = zip(time / FREQUENCY_Hz, displacement, force, strict=True)
    path = mapping.parent / "log.jsonl"
    path.write_text("\n".join(json.dumps(dict(zip("txQ", row, strict=True))) for row in rows), encoding="utf-8")
    known = {"normal_load_N": 2.0}
    source = guessed_mapping([path], known, crossed_wires(known, {})).tables["loops"]
    assert source["kind"] == "json-lines"
    assert {key: own["column"] for key, own in source["columns"].items()} == {
        "time_s": "t",
        "displacement_um": "x",
        "tangential_force_N": "Q",
    }
