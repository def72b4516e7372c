"""Where the sets of plausible classes end: conformal quantiles by verdict, from development records.

    python -m studies.blind.ablations ANSWERS BATCH...
    python -m studies.blind.conformal ANSWERS BATCH... [--frozen T2] [--write COMMIT]

The answers are those that ablations.py kept. For each verdict the table says before how much probability the true class
stood in nine of ten records, how large sets are that go so far, and how often sets hold whose reach the other records
set. `--write` puts the reaches into calibration.toml, first in that commit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np
from rich import box
from rich.table import Table

from studies.blind import TIERS, Truth
from studies.blind.scoring.answers import answer_of
from studies.blind.scoring.judging import judged
from wirewear.diagnosis.calibration import FILE, Constant, with_entry
from wirewear.diagnosis.infer.sets import LEVEL, REACH, before_truth, in_order, masses, reach_of
from wirewear.faces.study_script import StudyScript, wide_console

from .ablations import PARTS, all_answers


@dataclass(frozen=True)
class Placed:
    """A record: its verdict, the probability before its true class, and those before each class of the answer."""

    verdict: str
    before: float
    others: tuple[float, ...]

    def size(self, reach: float) -> int:
        """Classes in a set of that reach."""
        return max(sum(before <= reach for before in self.others), 1)


def placed(truth: Truth, said: Mapping[str, Any]) -> Placed:
    """One record by its truth and its answer."""
    verdict = said["verdict"]
    causes = ((cause["effect"], cause["probability"]) for cause in said["causes"])
    known = masses(causes, said["equivalent"])
    befores, before = [], 0.0
    for members in in_order(verdict, known):
        befores.append(before)
        before += known[members]
    aims = judged(truth, answer_of(said)).aims
    return Placed(verdict, before_truth(verdict, known, aims, said.get("undetectable", ())), tuple(befores))


def held_by_others(own: Sequence[Placed]) -> float:
    """Share of records whose truth lies in the set that the others' quantile makes."""
    befores = [one.before for one in own]
    held = [one <= reach_of(befores[:i] + befores[i + 1 :], LEVEL) for i, one in enumerate(befores)]
    return float(np.mean(held))


@click.command(cls=StudyScript)
@click.argument("answers", type=click.Path(exists=True, path_type=Path))
@click.argument("batches", nargs=-1, type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--frozen", "tiers", type=click.Choice(TIERS), multiple=True, help="Frozen records of this tier, too.")
@click.option("--article", is_flag=True, help="Of the frozen ones only those of the article's test.")
@click.option("--write", metavar="COMMIT", help="Put the reaches into calibration.toml, first in this commit.")
def main(answers: Path, batches: tuple[Path, ...], tiers: tuple[str, ...], article: bool, write: str | None) -> None:
    """Print the reach of each verdict's sets."""
    found = all_answers(answers, batches, tiers, article)
    records = [placed(truth, own[PARTS[0].words]) for truth, own in found]
    table = Table(
        "verdict", "records", "truth is first", "reach", "classes, mean", "held, left out", box=box.SIMPLE_HEAD
    )
    reaches = {}
    for verdict in REACH:
        own = [one for one in records if one.verdict == verdict]
        if not own:
            continue
        reach = reaches[verdict] = min(reach_of([one.before for one in own], LEVEL), 1.0)
        size = np.mean([one.size(reach) for one in own])
        first = sum(one.before == 0.0 for one in own)
        table.add_row(verdict, str(len(own)), str(first), f"{reach:.3f}", f"{size:.1f}", f"{held_by_others(own):.2f}")
    wide_console(110).print(table)
    if write:
        FILE.write_text(written(FILE.read_text(encoding="utf-8"), reaches, write), encoding="utf-8")


def written(text: str, reaches: dict[str, float], commit: str) -> str:
    """calibration.toml with these reaches."""
    for verdict, reach in reaches.items():
        name, value = f"infer.sets.{verdict}", float(f"{reach:.3g}")
        text = with_entry(text, Constant(name, value, "probability", "conformal", commit))
    return text


if __name__ == "__main__":
    main()
