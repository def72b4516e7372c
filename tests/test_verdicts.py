"""Verdicts hold when figures agree, and fail when they do not."""

import io

import pytest
from rich.console import Console
from rich.table import Table

from wirewear.base.verdicts import Comparison, Finding, comparison_table, finding_table


def printed(table: Table) -> str:
    console = Console(width=120, file=io.StringIO(), record=True)
    console.print(table)
    return console.export_text()


@pytest.mark.parametrize(
    ("simulated", "holds"), [(99.1, True), (100.9, True), (98.9, False), (101.1, False), (float("nan"), False)]
)
def test_figures_agree_within_the_tolerance_only(simulated: float, holds: bool) -> None:
    assert Comparison("x", simulated, 100.0, 0.01, "by hand").holds is holds


def test_negative_expectations_have_a_deviation_too() -> None:
    assert Comparison("x", -1.1, -1.0, 0.2, "by hand").deviation == pytest.approx(0.1)


def test_the_table_of_figures_shows_units_difference_and_verdict() -> None:
    text = printed(comparison_table([Comparison("energy [mJ]", 0.25, 0.2, 0.01, "closed form")]))
    assert [word in text for word in ("energy [mJ]", "+25 %", "not within 1 %", "closed form")] == [True] * 4


def test_the_table_of_findings_shows_what_does_not_hold() -> None:
    text = printed(finding_table([Finding("slip falls", "50 → 51 [µm]", holds=False)]))
    assert "does not hold" in text
    assert "50 → 51 [µm]" in text
