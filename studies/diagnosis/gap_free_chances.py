"""Are gap-free records as likely as the diagnosis believes? Chi square per number, and whether p-values are uniform.

    python -m studies.diagnosis.gap_free RECORDS --tests 10 --rigs 10 --reference T2:iwan
    python -m studies.diagnosis.gap_free_chances RECORDS
    python -m studies.diagnosis.gap_free_chances BATCH/records --scored DIAGNOSES/score.json

Every record of RECORDS is gap-free, or is said to be by the score of its batch. Its residuals against the nominal
model, whitened by the covariance that a diagnosis of it takes, have a chi square; a covariance that is right makes that
of the size of their number. Two chances of a larger one are tested for being uniform (Kolmogorov and Smirnov): that of
a variance known within a factor (`SCALE`), as a diagnosis takes it, and that of a variance that is known.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from rich import box
from rich.table import Table
from scipy.stats import chi2, kstest

from studies.json_files import read_json
from studies.study_script import StudyScript
from wirewear import RecordError, ResultError, WirewearError, read_record
from wirewear.app.cli.consoles import wide_console
from wirewear.diagnosis import prepared
from wirewear.diagnosis.infer.covariance import estimate
from wirewear.diagnosis.infer.inference import Problem, fit
from wirewear.diagnosis.infer.weighing import chance

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
    def left(self) -> float:
        """Chi square per number."""
        return self.squares / self.numbers

    @property
    def p_value(self) -> float:
        """Of a larger chi square by chance, as the diagnosis takes it: the variance is known within a factor only."""
        return chance(self.squares, self.numbers, SCALE)

    @property
    def plain_p_value(self) -> float:
        """p-value if the variance were known, by the chi-squared distribution."""
        return float(chi2.sf(self.squares, self.numbers))


def chances(folder: Path, score: Path | None = None) -> Iterator[Chance]:
    """Of all records in a folder; of those without a gap, where the score of their batch says which."""
    kept = None if score is None else gap_free_cases(score)
    for path in sorted(path.parent for path in folder.glob("*/experiment.toml")):
        if kept is not None and path.name not in kept:
            continue
        try:
            yield _chance(path)
        except WirewearError as problem:
            click.echo(f"{path.name}: {problem}")


def gap_free_cases(score: Path) -> set[str]:
    """Names of a scored batch's records that have no gap."""
    lines = read_json(score, ResultError, "score of a batch")["lines"]
    return {line["case"] for line in lines if line["kind"] == "none"}


def _chance(path: Path) -> Chance:
    read = prepared(read_record(path))[0].reduced()
    covariance = estimate(read.states, read.setup, read.observed)
    problem = Problem.of(read.states, read.setup, read.observed.layout, covariance)
    setup = fit(problem, ()).setup
    whitened, residual = problem.whitened(setup), problem.mean - problem.predicted(setup)
    by_observable = {}
    for part in problem.layout:
        block = covariance.total[part.rows, part.rows]
        rest = residual[part.rows]
        by_observable[part.observable.name] = float(rest @ np.linalg.solve(block, rest)) / rest.size
    return Chance(path.name, whitened.size, float(whitened @ whitened), by_observable)


@click.command(cls=StudyScript)
@click.argument("folders", nargs=-1, required=True, type=click.Path(exists=True, path_type=Path))
@click.option("--scored", type=click.Path(exists=True, path_type=Path), help="Score of the one batch in FOLDERS.")
def main(folders: tuple[Path, ...], scored: Path | None) -> None:
    """Chi squares and p-values of the gap-free records in FOLDERS."""
    console = wide_console(130)
    found = [one for folder in folders for one in chances(folder, scored)]
    if not found:
        raise RecordError("these folders hold no folder with a record that can be read.")
    table = Table("record", "numbers", "χ²/n", "p", "observables beyond 1.5", box=box.SIMPLE_HEAD)
    for one in found:
        beyond = ", ".join(f"{name} {size:.1f}" for name, size in one.by_observable.items() if size > 1.5)
        table.add_row(one.name, str(one.numbers), f"{one.left:.2f}", f"{one.p_value:.3f}", beyond)
    console.print(table)
    sizes = [one.left for one in found]
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
