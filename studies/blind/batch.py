"""A blind batch from end to end, one record after the other: made, diagnosed, given to an oracle, scored.

    python -m studies.blind.batch OUTPUT --tier T2 --law dahl --cases 24 --seed 1001 [--jobs 2] [--most-hours 8]

Killed and started again with the same arguments, it goes on with the next record. Diagnoses stand in a folder named
after the state of the program that made them, so that no two states mix.
"""

import json
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress

from studies import blind
from studies.blind.options import outside_option, stated_scatter_option
from studies.study_script import StudyScript
from wirewear import RunError
from wirewear.app.cli.consoles import wide_console
from wirewear.base.cache import code_hash
from wirewear.base.engine import Engine, engine_of
from wirewear.base.writing import prepared_folder

from .answering import answer, answer_of_oracle, answered

Task = Callable[[], None]


def run_tasks(tasks: Sequence[Task], engine: Engine, what: str, until: float) -> bool:
    """Do tasks by an engine, starting none after `until`; returns whether all were done."""
    done = 0
    with Progress(
        *Progress.get_default_columns(), MofNCompleteColumn(), console=Console(stderr=True), transient=True
    ) as bar:
        shown = bar.add_task(what, total=len(tasks))
        for one in engine.done(tasks, until):
            one.value()
            done += 1
            bar.update(shown, completed=done)
    return done == len(tasks)


def diagnosing_tasks(batch: Path, diagnoses: Path) -> list[Task]:
    """Records that have no answer yet, in the manifest's order."""
    cases: dict[str, Any] = json.loads((batch / "manifest.json").read_text(encoding="utf-8"))["cases"]
    return [
        partial(answer, batch / name, tuple(case["left_out"]), diagnoses)
        for name, case in cases.items()
        if not answered(diagnoses / name)
    ]


def oracle_tasks(batch: Path, key: Path, diagnoses: Path) -> list[Task]:
    """Records of single effects and pairs that no oracle has seen yet; to be run when all diagnoses are made."""
    oracle = diagnoses / "oracle"
    return [
        partial(answer_of_oracle, batch / truth.case, truth.effects, blind.LIBRARY_EFFECTS, oracle)
        for truth in blind.verified(batch, key).truths
        if truth.kind in ("single", "pair") and not answered(oracle / truth.case)
    ]


@click.command(cls=StudyScript)
@click.argument("output", type=click.Path(path_type=Path))
@click.option("--cases", type=click.IntRange(1), required=True, help="Records.")
@click.option("--seed", type=click.IntRange(0), required=True, help="Seed; development and scoring use different ones.")
@click.option(
    "--tier", type=click.Choice((*blind.TIERS, *blind.LINE_TIERS, blind.OTHERS)), default="T2", show_default=True
)
@click.option("--law", help="Friction law of T2; scoring: those simulators of T3. Without it those for development.")
@outside_option
@click.option("--tests", type=click.IntRange(1), default=10, show_default=True, help="Different nominal tests.")
@stated_scatter_option
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Records side by side.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask cluster whose workers see OUTPUT, instead of --jobs.")
@click.option("--oracle/--no-oracle", default=True, show_default=True, help="Diagnose again, given the true effects.")
@click.option("--most-hours", type=click.FloatRange(min=0.0), default=24.0, show_default=True, help="Then stop.")
def main(
    output: Path,
    cases: int,
    seed: int,
    tier: str,
    law: str | None,
    outside: str,
    tests: int,
    stated_scatter: float,
    jobs: int,
    scheduler: str | None,
    oracle: bool,
    most_hours: float,
) -> None:
    """Make, diagnose and score a blind batch in OUTPUT; the same command continues one that was interrupted."""
    output, engine = prepared_folder(output.resolve()), engine_of(jobs, scheduler)
    until = time.monotonic() + 3600.0 * most_hours
    batch, key = output / "records", blind.default_key_path(output / "records")
    console = wide_console(120)
    with Progress(console=Console(stderr=True), transient=True) as bar:
        shown = bar.add_task("records made", total=cases)
        blind.make_batch(
            batch,
            cases=cases,
            seed=seed,
            generator=blind.generator_of(tier, law=law, outside=outside, stated_scatter=stated_scatter),
            tests=tests,
            engine=engine,
            progress=lambda done, _: bar.update(shown, completed=done),
        )
    diagnoses = output / f"diagnoses-{code_hash()[:12]}"
    whole = run_tasks(diagnosing_tasks(batch, diagnoses), engine, "records diagnosed", until)
    if whole and oracle:
        whole = run_tasks(oracle_tasks(batch, key, diagnoses), engine, "records given to the oracle", until)
    if not whole:
        raise RunError("the time is up; the same command continues where it stopped.")
    score = blind.score_batch(batch, diagnoses, key_path=key)
    console.print(blind.score_table(score.report))
    click.echo(f"{diagnoses / 'score.html'}")


if __name__ == "__main__":
    main()
