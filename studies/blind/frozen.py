"""Sixty records of spent batches, frozen to guard the score: answers may change, the score must not fall.

    python -m studies.blind.frozen [OUTPUT] [--tier T1] [--article] [--jobs 2]

frozen_records/ holds them, twenty of each tier, and truths.json: what is true of each, and what the diagnosis said when
they were frozen. They were looked at before, so their figures say nothing of unseen records; falling ones say that a
change made the diagnosis worse. Exit code 1 if they fell.
"""

import json
import sys
import tarfile
from collections.abc import Iterable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click
from rich import box
from rich.table import Table

from studies.blind import TIERS, Judgement, Truth
from studies.blind.scoring.answers import NONE, read_answers
from studies.blind.scoring.score import judge_all
from studies.study_script import StudyScript
from wirewear.app.cli.consoles import wide_console
from wirewear.base.engine import LocalProcesses
from wirewear.base.writing import prepared_folder

from .answering import answer, answered
from .batch import run_tasks

FOLDER = Path(__file__).parent / "frozen_records"
TRUTHS = "truths.json"

#: Points that a tier may lose before it counts as worse: one record more or less is what a new mesh does.
ALLOWED = 1.0


@dataclass(frozen=True)
class FrozenRecord:
    """A record, its truth, and what was said of it when it was frozen.

    said: verdict and leading causes; points: see `points_of`; wrongly_named: an effect that is not its cause was named.
    """

    tier: str
    truth: Truth
    left_out: tuple[str, ...]
    is_articles_test: bool
    said: str
    points: float
    wrongly_named: bool

    @classmethod
    def of_json(cls, data: dict[str, Any]) -> "FrozenRecord":
        """The record that a line of truths.json describes."""
        frozen = data["frozen"]
        return cls(
            tier=data["tier"],
            truth=Truth.of_key(data),
            left_out=tuple(data["left_out"]),
            is_articles_test=data["is_articles_test"],
            said=frozen["said"],
            points=frozen["points"],
            wrongly_named=frozen["wrongly_named"],
        )

    @property
    def name(self) -> str:
        """Name of the record: its batch and case."""
        return self.truth.case


def frozen_records(tiers: Sequence[str] = TIERS, *, article_only: bool = False) -> tuple[FrozenRecord, ...]:
    """The frozen records of these tiers; `article_only` takes those of the article's nominal test."""
    lines = json.loads((FOLDER / TRUTHS).read_text(encoding="utf-8"))
    records = [FrozenRecord.of_json(line) for line in lines]
    return tuple(one for one in records if one.tier in tiers and (one.is_articles_test or not article_only))


def unpack(records: Iterable[FrozenRecord], folder: Path) -> None:
    """Write the folders of these records into `folder`."""
    wanted = {one.name for one in records}
    for tier in TIERS:
        with tarfile.open(FOLDER / f"{tier}.tar.xz") as archive:
            # Python 3.11.2 knows neither the filter nor the argument of that name.
            archive.extraction_filter = getattr(tarfile, "data_filter", None)
            archive.extractall(folder, [one for one in archive if one.name.split("/")[0] in wanted])


def diagnosed(records: Sequence[FrozenRecord], output: Path, jobs: int = 1) -> tuple[Judgement, ...]:
    """Diagnose the records that have no answer in `output` yet, and judge all answers."""
    unpack(records, output / "records")
    diagnoses = output / "diagnoses"
    tasks = [
        partial(answer, output / "records" / one.name, one.left_out, diagnoses)
        for one in records
        if not answered(diagnoses / one.name)
    ]
    if jobs == 1:
        for task in tasks:
            task()
    else:
        run_tasks(tasks, LocalProcesses(jobs), "records diagnosed", float("inf"))
    return judge_all([one.truth for one in records], read_answers(diagnoses, [one.name for one in records]))


def points_of(judgement: Judgement) -> float:
    """1 for a right answer, 0 for a wrong one; of a pair the share of its effects that were named."""
    return float(judgement.first_right) if judgement.pair_found is None else judgement.pair_found / 2


def is_wrongly_named(judgement: Judgement) -> bool:
    """Whether an effect was named that is not the cause, nor one of them."""
    return judgement.effect_named and points_of(judgement) == 0.0


def complaints(records: Sequence[FrozenRecord], judgements: Sequence[Judgement]) -> list[str]:
    """What became worse since the records were frozen, a sentence each: false alarms, points, wrong names."""
    found = []
    for one, now in zip(records, judgements, strict=True):
        if one.truth.hypotheses == (NONE,) and one.points == 1.0 and points_of(now) == 0.0:
            found.append(f"{one.name} has no gap, and now a false alarm: {now.said}.")
    for tier in TIERS:
        pairs = [(one, now) for one, now in zip(records, judgements, strict=True) if one.tier == tier]
        lost = [one.name for one, now in pairs if points_of(now) < one.points]
        before, after = sum(one.points for one, _ in pairs), sum(points_of(now) for _, now in pairs)
        if after < before - ALLOWED:
            found.append(f"{tier} scores {after:g} of {len(pairs)} instead of {before:g}; worse: {', '.join(lost)}.")
        wrong = [one.name for one, now in pairs if is_wrongly_named(now) and not one.wrongly_named]
        if sum(is_wrongly_named(now) for _, now in pairs) > sum(one.wrongly_named for one, _ in pairs) + ALLOWED:
            found.append(f"{tier} names more wrong causes than before, newly of {', '.join(wrong)}.")
    return found


def record_table(records: Sequence[FrozenRecord], judgements: Sequence[Judgement]) -> Table:
    """One line a record: its truth, what was said, what is said."""
    table = Table("record", "truth", "gap", "frozen", "now", "", box=box.SIMPLE_HEAD)
    for one, now in zip(records, judgements, strict=True):
        change = points_of(now) - one.points
        truth = " + ".join(one.truth.effects) or "no gap"
        kind = "" if one.truth.kind in ("none", "single", "pair") else f" ({one.truth.kind.replace('_', ' ')})"
        mark = "worse" if change < 0 else "better" if change > 0 else ""
        table.add_row(one.name, truth + kind, f"{one.truth.gap_in_scatter:.1f}", one.said, now.said, mark)
    return table


@click.command(cls=StudyScript)
@click.argument("output", required=False, type=click.Path(path_type=Path))
@click.option("--tier", "tiers", type=click.Choice(TIERS), multiple=True, help="May be repeated.  [default: all]")
@click.option("--article", is_flag=True, help="Only records of the article's nominal test, which share one run.")
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Records side by side.")
def main(output: Path | None, tiers: tuple[str, ...], article: bool, jobs: int) -> None:
    """Diagnose the frozen records, leave the answers in OUTPUT if given, and say what became worse."""
    records = frozen_records(tiers or TIERS, article_only=article)
    with TemporaryDirectory() if output is None else nullcontext(prepared_folder(output)) as folder:
        judgements = diagnosed(records, Path(folder), jobs)
    wide_console(150).print(record_table(records, judgements))
    for tier in tiers or TIERS:
        own = [(one, now) for one, now in zip(records, judgements, strict=True) if one.tier == tier]
        before, after = sum(one.points for one, _ in own), sum(points_of(now) for _, now in own)
        click.echo(f"{tier}: {after:g} of {len(own)} right, {before:g} when frozen.")
    worse = complaints(records, judgements)
    for sentence in worse:
        click.echo(sentence)
    sys.exit(int(bool(worse)))


if __name__ == "__main__":
    main()
