"""Checks of simulated figures against expected ones, and of statements against results, each with a verdict."""

from collections.abc import Sequence
from dataclasses import dataclass

from rich import box
from rich.table import Table
from rich.text import Text


@dataclass(frozen=True)
class Comparison:
    """Simulated and expected figure, relative tolerance (0.01: 1 %), and the source of the expected one in words."""

    name: str
    simulated: float
    expected: float
    tolerance: float
    source: str

    @property
    def deviation(self) -> float:
        """Simulated over expected figure, less 1; the expected figure must not be 0."""
        return self.simulated / self.expected - 1.0

    @property
    def holds(self) -> bool:
        """True if the deviation is within the tolerance; False for NaN."""
        return abs(self.deviation) <= self.tolerance


@dataclass(frozen=True)
class Finding:
    """A statement, the results that are its evidence, in words, and in `holds` True if they support it."""

    statement: str
    evidence: str
    holds: bool


def comparison_table(comparisons: Sequence[Comparison]) -> Table:
    """Table of simulated and expected figures with verdicts, to be printed with rich."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("figure", no_wrap=True)
    for heading in ("simulated", "expected", "difference"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("expected from", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    for item in comparisons:
        # Digits beyond the twelfth are round-off.
        deviation = round(100 * item.deviation, 10) + 0.0
        figures = f"{item.simulated:.5g}", f"{item.expected:.5g}", f"{deviation:+.2g} %"
        words = f"within {100 * item.tolerance:.2g} %", f"not within {100 * item.tolerance:.2g} %"
        table.add_row(Text(item.name), *figures, Text(item.source), _verdict(item.holds, *words))
    return table


def finding_table(findings: Sequence[Finding]) -> Table:
    """Table of statements, evidence and verdicts, to be printed with rich."""
    table = Table("finding", "computed", box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("verdict", no_wrap=True)
    for finding in findings:
        table.add_row(
            Text(finding.statement), Text(finding.evidence), _verdict(finding.holds, "holds", "does not hold")
        )
    return table


def _verdict(holds: bool, yes: str, no: str) -> Text:
    return Text(yes, "green") if holds else Text(no, "red")
