"""What a run must not lose or hide: complete results, values that no variant uses, the cycles of a record."""

from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from tests import synthetic_results
from tests.studies import MINIMAL
from wirewear.faces import cli
from wirewear.results import write_result

EXAMPLE = Path("studies/steel_wires/example_records/no_gap")
VARIANTS = '[variants.rigid.holder]\ntangential_stiffness_N_per_mm = "rigid"\n'
VARIANTS += "[variants.compliant.holder]\ntangential_stiffness_N_per_mm = 167.0\n"


def wirewear(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    asked: dict[str, Any] = {}

    def run_study(study: Any, **options: Any) -> list[Any]:
        asked.update(options, study=study)
        return [synthetic_results.result(variant="compliant", stiffness_N_per_mm=167.0)]

    monkeypatch.setattr("wirewear.simulation.run_study", run_study)
    return asked


@pytest.fixture
def study_file(tmp_path: Path) -> Path:
    path = tmp_path / "wires.toml"
    path.write_text(MINIMAL, encoding="utf-8")
    return path


@pytest.mark.parametrize("place", ["result.h5", "compliant/result.h5"])
def test_a_complete_result_is_overwritten_only_when_that_is_asked_for(
    study_file: Path, asked: dict[str, Any], place: str
) -> None:
    folder = study_file.with_name("out")
    write_result(folder / place, synthetic_results.result(variant="", stiffness_N_per_mm=167.0))
    refused = wirewear("run", study_file, "--output", folder)
    assert refused.exit_code == 2
    assert "is a complete result, and is not overwritten" in refused.stderr
    assert asked == {}
    for option in ("--overwrite", "--resume"):
        assert wirewear("run", study_file, "--output", folder, option).exit_code == 0


def test_a_run_can_log_the_cycles_of_the_record_that_it_will_be_compared_with(
    study_file: Path, asked: dict[str, Any]
) -> None:
    study_file.write_text(MINIMAL + VARIANTS, encoding="utf-8")
    result = wirewear("run", study_file, "--cycles-of", EXAMPLE)
    assert result.exit_code == 0, result.output
    last = asked["study"].conditions.cycles
    for study in (asked["study"], asked["study"].variant("rigid")):
        assert study.tables.log.loop_cycles == tuple(
            sorted({c for c in (100, 1000, 10000, 100000) if c <= last} | {last})
        )


def test_a_value_that_every_variant_replaces_is_told(study_file: Path, asked: dict[str, Any]) -> None:
    own = "[holder]\ntangential_stiffness_N_per_mm = 200.0\n"
    study_file.write_text(MINIMAL + own + VARIANTS, encoding="utf-8")
    result = wirewear("run", study_file)
    assert "[holder] tangential_stiffness_N_per_mm = 200.0 is used by no variant" in result.stderr
    study_file.write_text(MINIMAL + own.replace("200", "167") + VARIANTS, encoding="utf-8")
    assert wirewear("run", study_file).stderr == ""


def test_a_run_given_to_check_is_named_as_one(tmp_path: Path) -> None:
    write_result(tmp_path / "run" / "result.h5", synthetic_results.result(variant="", stiffness_N_per_mm=167.0))
    result = wirewear("check", tmp_path / "run")
    assert result.exit_code == 2
    assert "is a result of a run, and no record" in result.stderr


def test_a_kind_of_contact_that_is_yet_to_come_is_named_as_such(study_file: Path) -> None:
    study_file.write_text(MINIMAL.replace('"crossed-wires"', '"sphere-on-flat"'), encoding="utf-8")
    assert 'sphere-on-flat", which is not supported yet' in wirewear("run", study_file).stderr
