"""`python -m studies.blind`: make sealed records, diagnose them, score the diagnoses."""

from math import inf
from pathlib import Path

import click

from studies.blind.generators.generator import LINE_TIERS, OTHERS, POINT_TIERS, TIERS
from studies.blind.options import outside_option, stated_scatter_option
from wirewear.app.cli import prepare_streams
from wirewear.app.cli.group import Commands, OutputFile, OutputFolder, scheduler_option


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
def exam() -> None:
    """Records whose effect is withheld, and the scoring of diagnoses made of them."""


exam.goes_on = dict.fromkeys(("make", "diagnose"), "the same command goes on with a batch")


@exam.command(name="make")
@click.argument("output", metavar="OUT_DIR", type=OutputFolder())
@click.option("--cases", type=click.IntRange(1), required=True, help="Records to make.")
@click.option("--seed", type=click.IntRange(0), required=True, help="Seed of everything that is drawn; keep it secret.")
@click.option(
    "--tier",
    type=click.Choice((*TIERS, OTHERS, *LINE_TIERS, *POINT_TIERS)),
    default="T2",
    show_default=True,
    help="T3: simulators by others; L1: line contacts; A1: wires at any angle; B1: balls on flats.",
)
@click.option(
    "--law",
    help="Friction law of the tier T2: dahl, iwan, weakening or bouc; simulators of T3: development, scoring, sticking "
    "(partial slip), joints, programmes, held (energies, forces) or swinging (loads).  [default: dahl, development]",
)
@outside_option
@click.option(
    "--tests", type=click.IntRange(1), default=10, show_default=True, help="Different nominal tests among them."
)
@click.option("--key", "key_path", metavar="FILE", type=OutputFile(), help="Key file.  [default: OUT_DIR.key]")
@stated_scatter_option
@click.option("--jobs", type=click.IntRange(1), help="Records to make side by side.  [default: one a core]")
@scheduler_option
def make(
    output: Path,
    cases: int,
    seed: int,
    tier: str,
    law: str | None,
    outside: str,
    tests: int,
    key_path: Path | None,
    stated_scatter: float,
    jobs: int | None,
    scheduler: str | None,
) -> None:
    """Make a batch of records, their key sealed; the same command continues one that was interrupted."""
    from rich.progress import MofNCompleteColumn, Progress

    from studies.blind import default_key_path, generator_of, make_batch
    from wirewear.app.cli.consoles import progress_bar
    from wirewear.base.engine import engine_of

    generator = generator_of(tier, law=law, outside=outside, stated_scatter=stated_scatter)
    with progress_bar(*Progress.get_default_columns(), MofNCompleteColumn()) as bar:
        task = bar.add_task("records", total=cases)
        manifest = make_batch(
            output,
            cases=cases,
            seed=seed,
            generator=generator,
            tests=tests,
            key_path=key_path,
            engine=engine_of(jobs, scheduler),
            progress=lambda done, _: bar.update(task, completed=done),
        )
    click.echo(f"{cases} records and {manifest}; keep {key_path or default_key_path(output)} apart from them.")


@exam.command()
@click.argument("batch", metavar="OUT_DIR", type=click.Path(path_type=Path))
@click.argument("diagnoses", metavar="DIAGNOSES_DIR", type=OutputFolder())
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Records side by side.")
@scheduler_option
def diagnose(batch: Path, diagnoses: Path, jobs: int, scheduler: str | None) -> None:
    """Diagnose the records of a batch that have no answer yet, each without the effects that it leaves out."""
    from studies.blind.batch import diagnosing_tasks, run_tasks
    from wirewear.base.engine import engine_of

    run_tasks(diagnosing_tasks(batch.resolve(), diagnoses.resolve()), engine_of(jobs, scheduler), "records", inf)
    click.echo(f"answers are in {diagnoses}")


@exam.command()
@click.argument("batch", metavar="OUT_DIR", type=click.Path(path_type=Path))
@click.argument("diagnoses", metavar="DIAGNOSES_DIR", type=click.Path(path_type=Path))
@click.option("--key", "key_path", metavar="FILE", type=click.Path(path_type=Path), required=True, help="Key file.")
@click.option("--output", metavar="DIR", type=OutputFolder(), help="Of the report.  [default: DIAGNOSES_DIR]")
def score(batch: Path, diagnoses: Path, key_path: Path, output: Path | None) -> None:
    """Verify a batch, score the diagnoses of its records (DIAGNOSES_DIR/<record>/diagnosis.json), and log the run."""
    from studies.blind import score_batch, score_table
    from wirewear.app.cli.consoles import wide_console

    scored = score_batch(batch, diagnoses, key_path=key_path, output=output)
    wide_console(120).print(score_table(scored.report))
    click.echo(f"score.json and score.html are in {output or diagnoses}")


def main() -> None:
    """Entry point of the module."""
    prepare_streams()
    exam(prog_name="python -m studies.blind")
