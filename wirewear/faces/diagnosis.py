"""The command that diagnoses a record."""

from __future__ import annotations

import os
from pathlib import Path

import click

from wirewear.faces.group import OutputFolder, busy, cli, most_memory, stage


@cli.command(name="diagnose")
@click.argument("record_path", metavar="RECORD", type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", required=True, type=OutputFolder())
@click.option(
    "--model", metavar="STUDY.toml", type=click.Path(path_type=Path), help="[default: what the record states]"
)
@click.option("--confirm", is_flag=True, help="Run the full simulation with the leading effects, too.")
@click.option("--without", metavar="EFFECT", multiple=True, help="An effect not to be considered; may be repeated.")
@click.option("--jobs", type=click.IntRange(1), help="Cores for linear algebra.  [default: all]")
@most_memory
def diagnose_command(
    record_path: Path, output: Path, model: Path | None, confirm: bool, without: tuple[str, ...], jobs: int | None
) -> None:
    """Say why a record and its model disagree: where, by which effect, and how far the gap shrinks with it."""
    from threadpoolctl import threadpool_limits

    from wirewear.base.locks import occupied
    from wirewear.diagnosis import confirmed, diagnose, ten_lines, write_diagnosis
    from wirewear.diagnosis.beginning import beginning_of
    from wirewear.kinds import load_any_study, read_any_record
    from wirewear.simulation import ProgressBar

    study = None if model is None else load_any_study(model)
    with busy("reading the record"):
        record = read_any_record(record_path)
        # Before a folder is made that nothing would come into.
        beginning_of(record, study)
    with occupied(output, f"diagnose {record_path}"):
        with threadpool_limits(limits=None if jobs is None else min(jobs, os.cpu_count() or 1), user_api="blas"):
            diagnosed = diagnose(record, model=study, observer_of=ProgressBar, left_out=without, stage=stage)
            if confirm:
                diagnosed = confirmed(diagnosed, observer_of=ProgressBar)
        with busy("writing the report"):
            written = write_diagnosis(diagnosed, output)
    click.echo(ten_lines(diagnosed.diagnosis))
    for path in written:
        click.echo(path)
