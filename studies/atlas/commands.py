"""`python -m studies.atlas`: run the atlas, write down predictions, begin an entry."""

import shutil
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

import click

from studies.atlas.entry import ALL, ENTRIES, PREDICTIONS, Entry, Row, read_entries
from wirewear import StudyError
from wirewear.app.cli.group import Commands, OutputFolder
from wirewear.base import kinds

fidelity_option = click.option(
    "--fidelity", type=click.Choice(("quick", "standard", "fine")), default="quick", show_default=True
)
output_option = click.option(
    "--output", type=OutputFolder(), default=Path("runs/atlas"), show_default=True, help="Folder of runs, page, table."
)


@click.group(cls=Commands, invoke_without_command=True, context_settings={"help_option_names": ["-h", "--help"]})
@fidelity_option
@output_option
@click.pass_context
def atlas(context: click.Context, fidelity: str, output: Path) -> None:
    """Published fretting experiments beside their simulations; without a command, all of them.

    The same command goes on with a run that was interrupted.
    """
    if context.invoked_subcommand is None:
        _run((), fidelity, output, freeze=False)


atlas.goes_on = dict.fromkeys(("run", "predict"), "the same command goes on where it stopped")


@atlas.command()
@click.argument("entries", nargs=-1)
@fidelity_option
@output_option
@click.option("--freeze", is_flag=True, help="Write what comes out as the frozen answer of these entries.")
def run(entries: tuple[str, ...], fidelity: str, output: Path, freeze: bool) -> None:
    """Run some entries, or all: a table, a page, and what has moved from the frozen answer (exit code 1)."""
    _run(entries, fidelity, output, freeze=freeze)


def _run(names: Sequence[str], fidelity: str, output: Path, *, freeze: bool) -> None:
    from rich.console import Console

    from studies.atlas.page import write_page
    from studies.atlas.table import FROZEN, compared, frozen, moved, rows_table, sentence, write_table
    from wirewear.app.cli.consoles import wide_console
    from wirewear.base.writing import prepared_folder

    entries = read_entries(names)
    rows = [row for entry in entries for row in _rows(entry, fidelity, output)]
    prepared_folder(output)
    page = write_page(entries, rows, fidelity, output / "atlas.html")
    table = write_table(rows, output / "atlas.csv")
    console: Console = wide_console(140)
    console.print(rows_table(compared(rows)))
    click.echo(f"{sentence(rows)}\nThe page is {page}, the table {table}.")
    before = frozen()
    if freeze:
        others = [row for row in before if row.entry not in {entry.name for entry in entries}]
        write_table(sorted([*others, *rows], key=lambda row: row.entry), FROZEN)
    elif fidelity == "quick" and (apart := moved(rows, before)):
        for row, old in apart:
            was = "none" if old.simulated is None else f"{old.simulated:.5g}"
            now = "none" if row.simulated is None else f"{row.simulated:.5g} {row.unit}"
            click.echo(f"{row.entry}, {row.test}: {row.figure} is {now}, was {was} in the frozen table.")
        raise SystemExit(1)


def _rows(entry: Entry, fidelity: str, output: Path, *, to_predict: bool = False) -> list[Row]:
    from studies.atlas.simulating import simulator

    return entry.rows(simulator(entry, fidelity, output), to_predict=to_predict)


@atlas.command()
@click.argument("entries", nargs=-1, required=True)
@fidelity_option
@output_option
def predict(entries: tuple[str, ...], fidelity: str, output: Path) -> None:
    """Write down what is predicted for tests that no constant was fitted on, without a look at what was measured.

    What is written is kept: commit the file, then `run` compares it.
    """
    from wirewear.base.writing import write_csv

    for entry in read_entries(entries):
        rows = _rows(entry, fidelity, output, to_predict=True)
        found = {(row.test, row.figure): row.simulated for row in rows if row.simulated and row.test != ALL}
        lines = [
            {"test": test, "figure": figure, "predicted": float(f"{value:.5g}")}
            for (test, figure), value in (found | entry.predictions).items()
        ]
        click.echo(f"{write_csv(entry.folder / PREDICTIONS, lines)} has {len(lines)} predictions: commit it, then run.")


@atlas.command()
@click.argument("doi")
@click.option("--name", required=True, help="Folder of the entry, as in author2011.")
@click.option("--kind", default="cylinder-on-flat", show_default=True, help="Kind of contact, as studies say it.")
@click.option("--table", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="CSV file, a test a row.")
@click.option("--into", type=OutputFolder(), default=ENTRIES, help="Folder of entries.  [default: the atlas's own]")
def new(doi: str, name: str, kind: str, table: Path | None, into: Path) -> None:
    """Begin an entry: entry.toml, tests.csv and study.toml, to be filled in."""
    from wirewear.base.writing import write_text
    from wirewear.test.kinds import KINDS
    from wirewear.test.template import study_text

    found = next((one for name, one in KINDS.items() if kind in kinds.NAMES[name]), None)
    if found is None:
        raise StudyError(f"there is no kind of contact {kind!r}: choose among {', '.join(KINDS)}.")
    folder = into / name
    if folder.exists():
        raise StudyError(f"{folder} is there already: choose another --name.")
    folder.mkdir(parents=True)
    template = files("studies.atlas").joinpath("template.toml").read_text(encoding="utf-8")
    write_text(folder / "entry.toml", template.replace("DOI", doi))
    write_text(folder / "study.toml", study_text(name, found.template))
    if table is None:
        write_text(folder / "tests.csv", "test,use,stroke_um,dissipated_energy_J\n1,fit,50,\n2,predict,60,\n")
    else:
        shutil.copyfile(table, folder / "tests.csv")
    click.echo(
        f"{folder} holds entry.toml, study.toml and tests.csv: fill them in (studies/atlas/README.md), "
        "then predict and run."
    )
