"""Commands of the blind check: make sealed records, score diagnoses of them."""

from pathlib import Path

import click

from wirewear.cli.blind_options import outside_option, stated_scatter_option
from wirewear.cli.group import OutputFile, OutputFolder, cli, scheduler_option


@cli.group()
def blind() -> None:
    """Records whose effect is withheld, and the scoring of diagnoses made of them."""


@blind.command(name="make")
@click.argument("output", metavar="OUT_DIR", type=OutputFolder())
@click.option("--cases", type=click.IntRange(1), required=True, help="Records to make.")
@click.option("--seed", type=click.IntRange(0), required=True, help="Seed of everything that is drawn; keep it secret.")
@click.option("--tier", type=click.Choice(("T0", "T1", "T2", "L1")), default="T2", show_default=True,
              help="L1: line contacts.")  # fmt: skip
@click.option("--law", help="Friction law of the tier T2: dahl, iwan, weakening or bouc.  [default: dahl]")
@outside_option
@click.option(
    "--tests", type=click.IntRange(1), default=10, show_default=True, help="Different nominal tests among them."
)
@click.option("--key", "key_path", metavar="FILE", type=OutputFile(), help="Key file.  [default: OUT_DIR.key]")
@stated_scatter_option
@click.option("--jobs", type=click.IntRange(1), help="Records to make side by side.  [default: one a core]")
@scheduler_option
def blind_make(
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

    from wirewear.blind import default_key_path, generator_of, make_batch
    from wirewear.engine import engine_of
    from wirewear.study_script import progress_bar

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


@blind.command(name="score")
@click.argument("batch", metavar="OUT_DIR", type=click.Path(path_type=Path))
@click.argument("diagnoses", metavar="DIAGNOSES_DIR", type=click.Path(path_type=Path))
@click.option("--key", "key_path", metavar="FILE", type=click.Path(path_type=Path), required=True, help="Key file.")
@click.option("--output", metavar="DIR", type=OutputFolder(), help="Of the report.  [default: DIAGNOSES_DIR]")
def blind_score(batch: Path, diagnoses: Path, key_path: Path, output: Path | None) -> None:
    """Verify a batch, score the diagnoses of its records (DIAGNOSES_DIR/<record>/diagnosis.json), and log the run."""
    from wirewear.blind import score_batch, score_table
    from wirewear.study_script import wide_console

    score = score_batch(batch, diagnoses, key_path=key_path, output=output)
    console = wide_console(120)
    console.print(score_table(score.report))
    click.echo(f"score.json and score.html are in {output or diagnoses}")
