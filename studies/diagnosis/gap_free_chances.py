"""Are gap-free records as likely as the diagnosis believes? Chi square per number, and whether p-values are uniform.

    python -m studies.diagnosis.gap_free RECORDS --tests 10 --rigs 10 --reference T2:iwan
    python -m studies.diagnosis.gap_free_chances RECORDS

Every record of RECORDS is gap-free. Its residuals against the nominal model, whitened by the covariance that a
diagnosis of it takes, have a chi square; a covariance that is right makes that of the size of their number. Solvers
differ more on some tests than on others, so that p-values count their variance as known within a factor
(`SCALE`): those are uniform (Kolmogorov and Smirnov).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from rich import box
from rich.table import Table
from scipy.stats import chi2, kstest

from wirewear import RecordError, WirewearError
from wirewear.diagnosis.infer.covariance import estimate
from wirewear.diagnosis.infer.gate import chance
from wirewear.diagnosis.infer.inference import Problem
from wirewear.study_script import StudyScript, wide_console

from .reduced_record import reduced_record

#: Deviation of the logarithm of a whole record's variance: eighty gap-free records of nineteen tests have 0.18 of it.
SCALE = 0.2


@dataclass(frozen=True)
class Chance:
    """A gap-free record: chi square of so many numbers, and per number of each observable."""

    name: str
    numbers: int
    squares: float
    by_observable: dict[str, float]

    @property
    def p_value(self) -> float:
        """Of a larger chi square by chance, as the diagnosis takes it: the variance is known within a factor only."""
        return chance(self.squares, self.numbers, SCALE)

    @property
    def plain_p_value(self) -> float:
        """The same if the variance were known."""
        return float(chi2.sf(self.squares, self.numbers))


def chances(folder: Path) -> Iterator[Chance]:
    """Of all records in a folder."""
    for path in sorted(path.parent for path in folder.glob("*/experiment.toml")):
        try:
            yield _chance(path)
        except WirewearError as problem:
            click.echo(f"{path.name}: {problem}")


def _chance(path: Path) -> Chance:
    states, setup, observed = reduced_record(path)
    covariance = estimate(states, setup, observed)
    problem = Problem.of(states, setup, observed.layout, covariance)
    whitened = problem.whitened(setup)
    residual = problem.mean - problem.predicted(setup)
    by_observable = {}
    for part in problem.layout:
        block = covariance.total[part.rows, part.rows]
        rest = residual[part.rows]
        by_observable[part.observable.name] = float(rest @ np.linalg.solve(block, rest)) / rest.size
    return Chance(path.name, whitened.size, float(whitened @ whitened), by_observable)


@click.command(cls=StudyScript)
@click.argument("folders", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
def main(folders: tuple[Path, ...]) -> None:
    """Chi squares and p-values of the gap-free records in FOLDERS."""
    console = wide_console(130)
    found = [one for folder in folders for one in chances(folder)]
    if not found:
        raise RecordError("these folders hold no folder with a record that can be read.")
    table = Table("record", "numbers", "χ²/n", "p", "observables beyond 1.5", box=box.SIMPLE_HEAD)
    for one in found:
        beyond = ", ".join(f"{name} {size:.1f}" for name, size in one.by_observable.items() if size > 1.5)
        table.add_row(one.name, str(one.numbers), f"{one.squares / one.numbers:.2f}", f"{one.p_value:.3f}", beyond)
    console.print(table)
    sizes = [one.squares / one.numbers for one in found]
    console.print(f"{len(found)} records: χ²/n {np.mean(sizes):.3f} on average, median {np.median(sizes):.2f}")
    for words, values in (
        ("p-values, the variance being known within a factor", [one.p_value for one in found]),
        ("p-values, the variance being known", [one.plain_p_value for one in found]),
    ):
        test = kstest(values, "uniform")
        console.print(f"{words}: uniform with p = {test.pvalue:.2g} (Kolmogorov and Smirnov)", highlight=False)
    for name in dict.fromkeys(name for one in found for name in one.by_observable):
        own = [one.by_observable[name] for one in found if name in one.by_observable]
        console.print(f"{name}: χ²/n {np.mean(own):.2f}, median {np.median(own):.2f}", highlight=False)


if __name__ == "__main__":
    main()
