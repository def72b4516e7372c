"""Published tribometers: contact stiffness, rig stiffness, and what compliance leaves unexplained."""

from pathlib import Path

import pytest
from click.testing import CliRunner

from wirewear.cli import cli
from wirewear.errors import RecordError
from wirewear.tribometers import NUMBERS, read_tribometers

PUBLISHED = Path(__file__).resolve().parent.parent / "studies" / "tribometers" / "tribometers.csv"
HEAD = ",".join(("source", "contact", "materials", *NUMBERS))


def row(tmp_path: Path, contact: str, *numbers: float) -> Path:
    path = tmp_path / "rows.csv"
    path.write_text(f"{HEAD}\nmine,{contact},steel,{','.join(map(str, numbers))}\n", encoding="utf-8")
    return path


def test_large_cylinders_have_the_stated_stiffness_within_5_percent_and_small_ones_within_16() -> None:
    for found in read_tribometers(PUBLISHED):
        assert found.stated_contact_stiffness_N_per_um is not None
        within = 0.16 if found.source.startswith("Nottingham") else 0.05
        assert found.contact_stiffness_N_per_um == pytest.approx(found.stated_contact_stiffness_N_per_um, rel=within)


def test_crossed_wires_behind_the_rig_spring_are_explained(tmp_path: Path) -> None:
    measured = 1.0 / (1.0 / 0.167 + 1.0 / 2.709)
    path = row(tmp_path, "crossed-cylinders", 0.225, 2.0, 0.0143, 0.62, 60.0, 52.07, measured)
    (found,) = read_tribometers(path)
    assert found.contact_stiffness_N_per_um == pytest.approx(2.709, rel=0.01)
    assert found.rig_stiffness_N_per_um == pytest.approx(0.167, rel=0.001)
    assert found.predicted_slip_amplitude_um == pytest.approx(52.07, abs=0.02)
    assert found.verdict == "compliance explains it"


@pytest.mark.parametrize(("slip", "word"), [(48.0, "free play"), (55.0, "above a plateau")])
def test_more_or_less_loss_than_compliance_takes_is_named(tmp_path: Path, slip: float, word: str) -> None:
    (found,) = read_tribometers(row(tmp_path, "crossed-cylinders", 0.225, 2.0, 0.0143, 0.62, 60.0, slip, 0.157))
    assert word in found.verdict


def test_a_wrong_value_is_named_with_line_and_column(tmp_path: Path) -> None:
    path = row(tmp_path, "crossed-cylinders", 0.225, -2.0, 0.0143, 0.62, 60.0, 50.0, 0.157)
    with pytest.raises(RecordError, match="line 2, column normal_load_N"):
        read_tribometers(path)


def test_the_command_prints_json() -> None:
    result = CliRunner().invoke(cli, ["tribometers", str(PUBLISHED), "--json"])
    assert result.exit_code == 0
    assert result.stdout.count('"verdict"') == 11
