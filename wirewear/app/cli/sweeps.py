"""Commands of many runs: sweeps, maps, convergence of a study, verification of the program."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from math import inf
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

import click

from wirewear.app.cli import group
from wirewear.base.words import counted
from wirewear.base.writing import json_text
from wirewear.test import FIDELITIES

if TYPE_CHECKING:
    from wirewear.sweeps.forecast import Forecast
    from wirewear.sweeps.running import SweepObserver
    from wirewear.sweeps.sweep import SweepRow
    from wirewear.test import Study


@group.cli.command()
@click.argument("paths", metavar="RECORD_OR_RESULT...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", type=group.OutputFolder(), default=Path("runs/maps"), show_default=True)
@click.option(
    "--fatigue-limit", "limit", metavar="MPa", type=group.STRENGTH,
    help="Draw the line of this tension only.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print tests and lines as JSON.")
def maps(paths: tuple[Path, ...], output: Path, limit: float | None, as_json: bool) -> None:
    """Set tests side by side: running conditions, material response, sliding criteria, wear against friction energy."""
    from wirewear.app.cli.consoles import wide_console
    from wirewear.comparison.mapped_tests import fretting_tests
    from wirewear.views.maps_page import maps_json, sentences, tests_table, write_maps

    with group.busy("reading the tests"):
        tests = [test for path in paths for test in fretting_tests(path)]
    with group.busy("drawing the maps"):
        written = write_maps(tests, output, limit)
    if as_json:
        click.echo(json_text(maps_json(tests)))
        return
    wide_console(150).print(tests_table(tests))
    for sentence in sentences(tests):
        click.echo(sentence)
    for path in written:
        click.echo(path)


@group.cli.command()
@click.argument("sweep_path", metavar="SWEEP.toml", type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", type=group.OutputFolder(), help="Result folder.  [default: runs/<sweep>]")
@click.option("--jobs", type=click.IntRange(1), help="Runs side by side.  [default: one a core]")
@group.scheduler_option
@click.option("--estimate", is_flag=True, help="Make one run only, and say what all of them will take.")
@click.option("--test", "test_paths", metavar="RECORD", multiple=True, type=click.Path(path_type=Path),
              help="A measured test on the fretting map; may be repeated.")  # fmt: skip
@group.most_memory
def sweep(sweep_path: Path, output: Path | None, jobs: int | None, scheduler: str | None, estimate: bool,
          test_paths: tuple[Path, ...]) -> None:  # fmt: skip
    """Run a study with keys or effects varied; the same command goes on with a sweep that was interrupted.

    Leaves table.parquet, table.csv, failures.csv and the page sweep.html.
    """
    from wirewear.base.engine import engine_of
    from wirewear.comparison.mapped_tests import fretting_tests
    from wirewear.sweeps import load_sweep, run_sweep
    from wirewear.views.sweep_page import require_no_others_tables, write_sweep

    asked = load_sweep(sweep_path)
    tests = [test for path in test_paths for test in fretting_tests(path)]
    folder = output or Path("runs") / sweep_path.resolve().stem
    require_no_others_tables(folder)
    with observer_of(len(asked)) as observer:
        result = run_sweep(asked, folder, engine_of(jobs, scheduler), observer, only_pilots=estimate)
    if estimate and not result.whole:
        if result.failures:
            count, first = len(result.failures), result.failures[0]
            click.echo(
                f"{count} of the {len(result.rows)} runs made failed; run {first.number}: {first.failure}", err=True
            )
        return
    for path in write_sweep(folder, result, tests):
        click.echo(path)
    if result.failures:
        click.echo(f"{len(result.failures)} of {len(asked)} runs failed; failures.csv says why.", err=True)


def run_scattered(study: Study, variant: str | None, folder: Path, jobs: int | None) -> None:
    """Run a study whose inputs scatter, print the intervals of its results and write them to `folder`. variant: name of
    the study's variant; None if it has none. jobs: runs side by side; None for one a core.
    """
    from wirewear.app.cli.consoles import wide_console
    from wirewear.base.engine import engine_of
    from wirewear.sweeps.uncertainty import RUNS, run_uncertain
    from wirewear.test.any_study import alone
    from wirewear.views.uncertainty_page import sentence, table, write_uncertainty

    study = alone(study) if variant is None else study.variant(variant)
    with observer_of(RUNS + 1) as observer:
        found = run_uncertain(study, folder, engine_of(jobs), observer=observer)
    wide_console(110).print(table(found))
    click.echo(sentence(found))
    for path in write_uncertainty(folder, found):
        click.echo(path)


@contextmanager
def observer_of(runs: int) -> Iterator[SweepObserver]:
    """Context that yields the observer of a sweep: it moves a progress bar over `runs` runs, and prints notes to
    standard error.
    """
    from rich.progress import MofNCompleteColumn, Progress, TimeRemainingColumn

    from wirewear.app.cli.consoles import progress_bar
    from wirewear.sweeps.running import SweepObserver

    columns = (*Progress.get_default_columns()[:3], TimeRemainingColumn(), MofNCompleteColumn())
    with progress_bar(*columns) as bar:
        task = bar.add_task("runs", total=runs)

        class Shown(SweepObserver):
            said_s = -inf

            def note(self, sentence: str) -> None:
                click.echo(f"wirewear: {sentence}", err=True)

            def expected(self, forecast: Forecast) -> None:
                click.echo(forecast.sentence, err=True)

            def done(self, _row: SweepRow, rows: int, of: int) -> None:
                bar.update(task, completed=rows)
                # Off a terminal, lines on the progress of many runs are no closer.
                if bar.disable and monotonic() - self.said_s > 2.0:
                    self.said_s = monotonic()
                    self.note(f"run {counted(rows)} of {counted(of)} is done")

        yield Shown()


@group.cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=group.Given())
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option("--variant", metavar="NAME", help="The variant of the study to refine, if it has variants.")
@click.option(
    "--output", metavar="DIR", type=group.OutputFolder(), help="Result folder.  [default: runs/<study>/converge]"
)
@click.option("--jobs", type=click.IntRange(1), help="Runs side by side.  [default: one a core]")
@group.scheduler_option
@group.most_memory
def converge(
    study_path: Path, fidelity: str, variant: str | None, output: Path | None, jobs: int | None, scheduler: str | None
) -> None:
    """Run a study again with mesh, positions in a cycle and cycle jumps refined, each alone and by two factors.

    Prints a table of the results, as wear volume, with the value that each tends to under refinement, and writes it to
    convergence.csv. Runs that are complete are not repeated.
    """
    from wirewear.app.cli.consoles import wide_console
    from wirewear.base.engine import engine_of
    from wirewear.kinds import contacts_of, load_any_study
    from wirewear.simulation import ProgressBar, convergence_table, write_convergence
    from wirewear.simulation import converge as refine

    study = load_any_study(study_path)
    if variant is not None:
        study = study.variant(variant)
    folder = output or group.default_output(study_path) / "converge"
    engine = None if scheduler is None else engine_of(scheduler=scheduler)
    asked: dict[str, Any] = {
        "fidelity": fidelity,
        "output": folder if scheduler is None else folder.resolve(),
        "observer_of": ProgressBar,
        "jobs": jobs or os.cpu_count() or 1,
        "engine": engine,
    }
    # A scheduler that does not answer is to be reported before bodies are condensed.
    with nullcontext() if engine is None else engine.held():
        rows = refine(study, contacts_of(study).refined, **asked)
    written = write_convergence(folder, rows)
    wide_console(150).print(convergence_table(rows))
    click.echo(f"the table is in {written}")


@group.cli.command()
@click.option("--quick", is_flag=True, help="Coarse meshes and wider tolerances.")
@click.option("--json", "json_path", metavar="FILE", type=group.OutputFile(), help="Write the table there too.")
@click.pass_context
def verify(context: click.Context, quick: bool, json_path: Path | None) -> None:
    """Solve the reference problems and compare with closed forms; exit code 1 if any check fails."""
    from wirewear.app.cli.consoles import progress_bar, wide_console
    from wirewear.verification import FULL, QUICK, table, write_json
    from wirewear.verification import verify as solve

    level = QUICK if quick else FULL
    with progress_bar() as progress:
        task = progress.add_task("", total=1.0)

        def show_stage(title: str, done: int, of: int) -> None:
            progress.update(task, description=title, completed=done / of)

        rows = solve(level, show_stage)
    wide_console(132).print(table(rows))
    if json_path is not None:
        write_json(json_path, level.name, rows)
    if not all(row.passed for row in rows):
        context.exit(1)
