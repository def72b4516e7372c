"""Command that writes the page of a run, or the report of a test for print."""

from pathlib import Path

import click

from wirewear.app.cli.group import Finite, Given, OutputFolder, a_list, beside, busy, cli, most_memory, of_block
from wirewear.base.errors import RecordError
from wirewear.base.writing import usable_folder


@cli.command()
@click.argument("path", metavar="RECORD_OR_RESULT", type=Given())
@click.option("--output", metavar="DIR", type=OutputFolder(), help="Page folder.  [default: beside a result]")
@click.option("--print", "for_print", is_flag=True, help="Of a result, too, the report of its test for print.")
@click.option("--variant", metavar="NAME", help="To print: which run, where a result holds several.")
@click.option("--length", "length_mm", type=Finite(0.05, 500.0), help="To print: of a simulated line contact, mm.")
@of_block
@a_list("--calibration", form="to print: relative standard uncertainties of displacement=0.005, tangential_force, "
        "normal_force, depth, lateral")  # fmt: skip
@click.option("--rationale", default="", metavar="TEXT", help="To print: why the test deviates from ASTM G204.")
@click.option("--template", metavar="FILE", type=click.Path(path_type=Path),
              help="To print: a page of your own, with placeholders as ${figures}.")  # fmt: skip
@most_memory
def report(
    path: Path,
    output: Path | None,
    for_print: bool,
    variant: str | None,
    length_mm: float | None,
    block: int | None,
    calibration: str,
    rationale: str,
    template: Path | None,
) -> None:
    """Write the page of a result, or of a study's variants; of a record, the report of its test for print on A4.

    The report has volumes, regime, friction and energy with their uncertainty budgets, and deviations from ASTM G204.
    """
    from wirewear.base.files import TABLE_FILE_NAME
    from wirewear.results import read_results

    is_record = path.name == TABLE_FILE_NAME or (path / TABLE_FILE_NAME).is_file()
    if not is_record and not for_print:
        from wirewear.views.run_page import write_page

        with busy("writing the page"):
            click.echo(write_page(read_results(path), usable_folder(output or beside(path))))
        return
    from wirewear.comparison.laboratory_report import CHANNELS, laboratory_report
    from wirewear.records import read_record, record_of_result
    from wirewear.records.exporting import chosen_run, parse_channels
    from wirewear.views.report_page import write_report

    known = parse_channels(calibration, CHANNELS, "--calibration")
    if is_record and output is None:
        raise RecordError("say where the report goes: --output DIR, which is not the record's folder.")
    with busy("writing the report"):
        if is_record:
            record, home = read_record(path).of_block(block), path if path.is_dir() else path.parent
        else:
            result = chosen_run(read_results(path), variant, path)
            record, home = record_of_result(result, length_mm), result.path or path
        found = laboratory_report(record, home, known, rationale)
        for file in write_report(found, output or beside(path), template):
            click.echo(file)
