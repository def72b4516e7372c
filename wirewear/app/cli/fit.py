"""The command that fits parameters to a record."""

from pathlib import Path
from typing import Any

import click

from wirewear.app.cli.group import Finite, Given, OutputFolder, cli, most_memory, of_block, stage
from wirewear.base.errors import RecordError
from wirewear.base.files import TABLE_FILE_NAME
from wirewear.base.writing import json_text, usable_file
from wirewear.kinds import contacts_of
from wirewear.test import FIDELITIES


@cli.command()
@click.argument("record_path", metavar="RECORD", type=Given())
@click.option("--output", metavar="DIR", required=True, type=OutputFolder(), help="Study, table, run.")
@click.option("--check", "fidelity", type=click.Choice(("none", *FIDELITIES)), default="quick", show_default=True,
              help="Check the fit by a run.")  # fmt: skip
@click.option("--wear-coefficient", metavar="mm3/J", type=Finite(0.0, 1.0, min_open=True),
              help="Of both bodies together, where no scars were measured.")  # fmt: skip
@click.option("--worn-volume", metavar="mm3", type=Finite(0.0, 1e3, min_open=True),
              help="Of both bodies at the end of a test, where no scars were measured.")  # fmt: skip
@of_block
@click.option("--into-record", is_flag=True, help="Write the fitted values into the record's [stated], too.")
@click.option("--json", "as_json", is_flag=True, help="Print the fit as JSON.")
@most_memory
def fit(
    record_path: Path,
    output: Path,
    fidelity: str,
    wear_coefficient: float | None,
    worn_volume: float | None,
    block: int | None,
    into_record: bool,
    as_json: bool,
) -> None:
    """Fit friction, rig stiffness, play and wear coefficients to a record, each with its interval.

    Loops determine friction, rig and play. The wear coefficient takes a scar's volume, measured or given, as well.
    """
    from wirewear.app.cli.consoles import wide_console
    from wirewear.base.locks import occupied
    from wirewear.diagnosis.fit import GivenWear, check_by_run, fit_record
    from wirewear.records import read_record
    from wirewear.simulation import ProgressBar
    from wirewear.test.kinds import kind_of
    from wirewear.views.fit_report import (
        check_table,
        fit_json,
        fit_table,
        require_no_other_study,
        write_fit,
        write_stated,
    )
    from wirewear.views.run_page import write_page

    if wear_coefficient is not None and worn_volume is not None:
        raise RecordError("give either --wear-coefficient or --worn-volume: each follows from the other.")
    require_no_other_study(output)
    given = GivenWear(wear_coefficient, worn_volume)
    if into_record:
        usable_file(record_path / TABLE_FILE_NAME)
    with stage("reading the record"):
        record = read_record(record_path).of_block(block)
    with occupied(output, f"fit {record_path}"):
        fitted = fit_record(
            record,
            given=None if given == GivenWear() else given,
            observer_of=lambda name: ProgressBar(f"{name}, first estimate"),
            stage=stage,
        )
        written = write_fit(fitted, output)
    checked = None
    if fidelity != "none" and kind_of(record).simulated:
        checked = check_by_run(fitted, output / "run", fidelity, lambda name: ProgressBar(f"{name}, fitted"))
        runs: Any = [checked.result]  # of either kind
        contacts_of(record).write_beside(runs, output / "run")
        written.append(write_page(runs, output / "run"))
    if into_record:
        written.append(write_stated(fitted))
    if as_json:
        click.echo(json_text(fit_json(fitted, checked)))
        return
    console = wide_console(100)
    console.print(fit_table(fitted))
    if checked is not None:
        console.print(check_table(checked))
    for note in fitted.notes:
        click.echo(f"– {note}")
    for path in written:
        click.echo(path)
