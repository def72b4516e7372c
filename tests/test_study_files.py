"""Files and values of any kind where a study is wanted: a study, or one sentence."""

from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from tests.studies import MINIMAL, minimal
from wirewear import StudyError
from wirewear.faces import cli
from wirewear.study import Study, load_study, parse_study, study_from_tables
from wirewear.study.tables import StudyTables


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "there is no study file"),
        (b"\xff\xfe\x00\x01", "line 1: this is not text in UTF-8"),
        (b"\x7fELF\x02", "is not valid TOML"),
        (b"", "missing key 'format'"),
    ],
)
def test_a_file_that_is_no_study_is_named(tmp_path: Path, content: bytes | None, message: str) -> None:
    path = tmp_path / "s.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(StudyError, match=message) as caught:
        load_study(path)
    assert str(path) in str(caught.value)


def test_a_folder_and_an_impossible_path_are_no_study(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="is a folder"):
        load_study(tmp_path)
    with pytest.raises(StudyError, match="cannot be read"):
        load_study("a\0b")


@pytest.mark.parametrize("command", [["run"], ["mesh"], ["converge"], ["sweep"], ["calibrate"]])
def test_a_study_called_without_its_ending_is_named(
    command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my_wires.toml").write_text(MINIMAL)
    missing = CliRunner().invoke(cli, [*command, "my_wires"])
    assert missing.exit_code == 2
    assert missing.stderr.endswith(" file my_wires, but my_wires.toml is there.\n")
    Path("my_wires").mkdir()
    folder = CliRunner().invoke(cli, [*command, "my_wires"])
    assert folder.stderr.endswith(" file is needed, but my_wires.toml is there.\n")
    assert "toml" not in CliRunner().invoke(cli, [*command, "others"]).stderr


def test_a_byte_order_mark_does_no_harm(tmp_path: Path) -> None:
    path = tmp_path / "s.toml"
    path.write_bytes(b"\xef\xbb\xbf" + MINIMAL.encode())
    assert load_study(path) == parse_study(MINIMAL, "s.toml")


scalars = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20) | st.dates()
junk = st.recursive(scalars, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3))
paths = st.sampled_from(
    [(table,) for table in [*StudyTables.model_fields, "variants"]]
    + [(table, key) for table, value in minimal().items() if isinstance(value, dict) for key in value]
    + [("log", "loop_cycles"), ("variants", "a"), ("variants", "a", "wires"), ("fidelity", "quick"), ("wires", "fixed")]
)


@given(st.text())
def test_any_text_is_a_study_or_a_study_error(text: str) -> None:
    with pytest.raises(StudyError):
        parse_study(text, "s.toml")


@given(paths, junk)
def test_any_value_in_any_place_is_accepted_or_told_in_one_sentence(keys: tuple[str, ...], value: object) -> None:
    data = minimal()
    here = data
    for key in keys[:-1]:
        here = here.setdefault(key, {})
    here[keys[-1]] = value
    try:
        study = study_from_tables(data, "s.toml")
    except StudyError as error:
        sentence = str(error)
        assert "s.toml" in sentence
        assert sentence[-1] in ".?"
        assert "\n" not in sentence
    else:
        assert isinstance(study, Study)
