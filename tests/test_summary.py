"""The one-screen summary of a run."""

import dataclasses
import io
import re
from pathlib import Path

import pytest
from rich.console import Console

from tests.synthetic_results import result
from wirewear.base.errors import ResultError
from wirewear.results import Evolution, RunResult
from wirewear.results.summary import summary


def printed(*results: RunResult, width: int = 110) -> list[str]:
    console = Console(width=width, record=True, file=io.StringIO())
    console.print(summary(results))
    return console.export_text().splitlines()


def row(lines: list[str], name: str) -> list[str]:
    line = next(line for line in lines if name in line)
    return re.split(r"\s{2,}", line.strip())[1:]


def test_each_variant_has_a_column_of_its_own_numbers() -> None:
    """Values are those of the evolution's ends, beside each other."""
    compliant, rigid = result("compliant", 167.0), result("rigid")
    lines = printed(compliant, rigid)
    for run, cell in zip((compliant, rigid), row(lines, "slip amplitude δ0"), strict=True):
        slip = run.evolution["slip_amplitude_um"]
        assert cell == f"{slip[0]:.4g} → {slip[-1]:.4g}"
    assert any("energy per cycle, first → last [mJ]" in line for line in lines)
    assert row(lines, "deepest wear, fixed") == ["20", "20"]
    assert row(lines, "wall time") == ["50.0 s", "50.0 s"]
    assert row(lines, "worst force balance relative") == ["1.0e-09", "1.0e-09"]


def test_pressures_are_told_as_means_over_a_length_and_at_nodes() -> None:
    run = result("compliant", 167.0)
    lines = printed(run)
    assert row(lines, "mean pressures are over [µm]") == ["28.6"]
    for name, column in (
        ("largest mean pressure, first → last [MPa]", "max_mean_pressure_MPa"),
        ("largest pressure at a node, first → last [MPa]", "max_pressure_MPa"),
    ):
        first, last = (f"{run.evolution[column][place]:.4g}" for place in (0, -1))
        assert row(lines, name) == [f"{first} → {last}"]
    columns = {name: values for name, values in run.evolution.items() if "mean_pressure" not in name}
    older = dataclasses.replace(run, settings={}, evolution=Evolution(columns))
    assert row(printed(older), "mean pressures are over [µm]") == ["–"]
    assert row(printed(older), "largest mean pressure") == ["– → –"]


def test_it_fits_on_one_screen() -> None:
    """Two variants take at most 40 lines of 100 characters."""
    lines = printed(result("compliant", 167.0), result("rigid"), width=100)
    assert len(lines) <= 40
    assert max(map(len, lines)) <= 100


def test_the_file_and_the_reason_of_a_failure_are_shown() -> None:
    """Square brackets in a message are text, not markup."""
    run = dataclasses.replace(result(status="failed"), message="no contact [see log]", path=Path("out/result.h5"))
    lines = printed(run)
    assert row(lines, "status") == ["failed"]
    assert row(lines, "message") == ["no contact [see log]"]
    assert "out/result.h5" in lines


def test_a_run_before_its_first_cycle_is_summed_up() -> None:
    """What does not exist yet is a dash."""
    run = dataclasses.replace(
        result(status="running"), evolution=Evolution.from_rows([]), quality={}, timings_s={}, message=""
    )
    lines = printed(run)
    for name in ("cycles", "largest tangential force", "wall time", "message"):
        assert row(lines, name) == ["–"]


def test_no_results_are_refused() -> None:
    """There is nothing to show."""
    with pytest.raises(ResultError, match="no results"):
        summary([])
