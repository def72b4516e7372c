"""The command on the contacts inside a strand or rope."""

from __future__ import annotations

from pathlib import Path

import click

from wirewear.app.cli import group
from wirewear.base.writing import usable_folder
from wirewear.test import FIDELITIES


@group.cli.command()
@click.argument("rope_path", metavar="ROPE.toml", type=group.Given())
@click.option("--output", metavar="DIR", type=group.OutputFolder(), help="Result folder.  [default: runs/<rope>]")
@click.option("--run", "with_runs", is_flag=True, help="Also simulate the study of each contact.")
@click.option("--worst", type=click.IntRange(1), metavar="N", help="With --run, of the N worst contacts only.")
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="quick", show_default=True, help="Of the runs.")
@click.option("--jobs", type=click.IntRange(1), help="Runs side by side.  [default: one a core]")
@group.scheduler_option
@click.option("--json", "as_json", is_flag=True, help="Print the table as JSON.")
@group.most_memory
@group.paper
def strand(
    rope_path: Path,
    output: Path | None,
    with_runs: bool,
    worst: int | None,
    fidelity: str,
    jobs: int | None,
    scheduler: str | None,
    as_json: bool,
) -> None:
    """Find the contacts inside a bent strand or rope: loads, slips, stresses, wear and life, and a study of each.

    Leaves contacts.csv, section.png, studies/ and the page strand.html.
    """
    from wirewear.app.cli.consoles import wide_console
    from wirewear.strand import strand_contacts
    from wirewear.strand.studies import write_studies
    from wirewear.views.strand_page import sentence, strand_json, strand_tables, write_strand

    found = strand_contacts(rope_path)
    folder = usable_folder(output or group.default_output(rope_path))
    studies = write_studies(found.contacts, found.tables, folder / "studies")
    rows = found.rows
    if with_runs:
        from wirewear.app.cli.sweeps import observer_of
        from wirewear.base.engine import engine_of
        from wirewear.strand.runs import run_contacts, with_figures_of_runs

        with observer_of(min(worst or len(studies), len(studies))) as observer:
            runs = run_contacts(
                found.name, found.studies(), fidelity, folder, engine_of(jobs, scheduler), observer, worst=worst
            )
        rows = with_figures_of_runs(rows, runs)
    written = write_strand(found, rows, folder)
    if as_json:
        click.echo(strand_json(found, rows))
    else:
        wide_console(170).print(*strand_tables(found, rows))
        click.echo("\n".join([sentence(found), *found.notes]))
        if studies:
            click.echo(f"studies are in {folder / 'studies'}, of the worst contact {next(iter(studies.values())).name}")
    click.echo(f"the page is {written[-1]}", err=as_json)
