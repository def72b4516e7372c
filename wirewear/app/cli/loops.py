"""Commands on measured loops: analyse them, calibrate the sensors that read them."""

import codecs
from pathlib import Path
from typing import Any

import click

from wirewear.app.cli.group import (
    Finite,
    Given,
    OutputFile,
    OutputFolder,
    a_list,
    busy,
    cli,
    default_output,
    most_memory,
    overwrite_record,
    paper,
)
from wirewear.base import kinds
from wirewear.base.errors import RecordError
from wirewear.base.files import DELIMITERS, is_encoding_of_text
from wirewear.base.writing import json_text, usable_file
from wirewear.test import FIDELITIES


def _known_encoding(_context: click.Context, _parameter: click.Parameter, name: str | None) -> str | None:
    if name is not None and not is_encoding_of_text(name):
        raise click.BadParameter(f"{name!r} is no encoding such as utf-8 or latin-1.")
    return name if name is None else codecs.lookup(name).name


@cli.command(name="loops")
@click.argument("path", metavar="FILE_OR_RECORD", type=Given())
@click.option("--cycle", type=click.IntRange(0), help="This cycle only.  [default: all]")
@click.option("--variant", metavar="NAME", help="Which run, where a result holds several.")
@click.option("--displacement", metavar="COLUMN[:UNIT]", help="Column by name or number.  [default: by its name]")
@click.option("--force", metavar="COLUMN[:UNIT]", help="Column by name or number.  [default: by its name]")
@click.option("--normal-load", metavar="COLUMN[:UNIT]|N", help="Column with its unit, or one number in newtons.")
@click.option("--encoding", metavar="NAME", callback=_known_encoding, help="Of a CSV file.  [default: guessed]")
@click.option("--delimiter", type=click.Choice(tuple(DELIMITERS)), help="Of a CSV file.  [default: guessed]")
@click.option("--decimal", type=click.Choice([".", ","]), help="Decimal sign of a CSV file.  [default: guessed]")
@click.option("--header-lines", type=click.IntRange(0, 100_000), help="Before the line of names.  [default: guessed]")
@click.option("--lines-after-names", type=click.IntRange(0, 100), help="Such as one of units.  [default: guessed]")
@click.option("--json", "as_json", is_flag=True, help="Print the figures as JSON; a picture only with --output.")
@click.option("--output", metavar="PNG", type=OutputFile(), help="Picture.")
@click.option("--corrected", metavar="DIR", type=OutputFolder(),
              help="Write the loops without drift, lag, play and compliance, too.")  # fmt: skip
@paper
def loops_command(
    path: Path,
    cycle: int | None,
    as_json: bool,
    output: Path | None,
    corrected: Path | None,
    encoding: str | None,
    delimiter: str | None,
    decimal: str | None,
    header_lines: int | None,
    lines_after_names: int | None,
    **chosen: str | None,
) -> None:
    """Analyse the loops of a CSV file, a record or a result: amplitudes, stiffness, friction, energy, regime."""
    from wirewear.app.cli.consoles import wide_console
    from wirewear.pictures import require_picture_name
    from wirewear.records.importing.loop_sources import Spelling, read_loops
    from wirewear.views.corrected_loops import write_corrected
    from wirewear.views.loops_picture import draw_loops
    from wirewear.views.loops_report import (
        analyse_loops,
        loops_json,
        loops_table,
        partial_slip_table,
        real_loops_table,
        remarks,
    )

    spelling = Spelling(encoding, delimiter, decimal, header_lines, lines_after_names)
    if output is None and not as_json:
        output = usable_file(default_output(path) / "loops.png")
    if output is not None:
        require_picture_name(output)
    with busy("analysing the loops"):
        analysed = analyse_loops(read_loops(path, cycle=cycle, spelling=spelling, **chosen))
        picture = None if output is None else draw_loops(analysed, output)
        written = [] if corrected is None else write_corrected(analysed, corrected)
    if as_json:
        click.echo(json_text(loops_json(str(path), analysed)))
        return
    console = wide_console(170)
    console.print(loops_table(analysed))
    for table in (partial_slip_table(analysed), real_loops_table(analysed)):
        if table is not None:
            console.print(table)
    for remark in remarks(analysed):
        click.echo(remark)
    for file in (picture, *written):
        click.echo(file)


@cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=Given())
@a_list("--loads", form="normal loads in newtons.  [default: 0.5, 1, 1.5 × the study's]")
@click.option(
    "--near", metavar="POINT", default="moving-wire", show_default=True, help="Or between-wires, between-holders."
)
@click.option("--remote-compliance", metavar="UM_PER_N", type=Finite(0.0), default=0.0, show_default=True,
              help="From the sensor's point to the moving wire's holder.")  # fmt: skip
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option("--variant", metavar="NAME", help="Which variant of the study.")
@click.option("--record", "record_path", metavar="RECORD", type=Given(), help="To be corrected.")
@click.option("--output", metavar="DIR", type=OutputFolder(of_record=True), help="Where the corrected record goes.")
@overwrite_record
@click.option("--json", "as_json", is_flag=True, help="Print the calibration as JSON.")
@most_memory
def calibrate(study_path: Path, loads: str, near: str, remote_compliance: float, fidelity: str, variant: str | None,
              record_path: Path | None, output: Path | None, overwrite: bool, as_json: bool) -> None:  # fmt: skip
    """Calibrate a remote displacement sensor by simulation under a range of loads, and correct a record with it."""
    from rich.console import Console
    from rich.markup import escape

    from wirewear.app.cli.consoles import progress_bar
    from wirewear.diagnosis.fit.sensor_calibration import calibrate as solve
    from wirewear.diagnosis.fit.sensor_calibration import corrected_record, parse_loads, parse_near
    from wirewear.records import read_record, require_place, write_record
    from wirewear.test import load_study
    from wirewear.views.calibration_report import calibration_json, calibration_text

    if (record_path is None) != (output is None):
        raise RecordError("--record and --output belong together: which record, and where it goes when corrected.")
    study = load_study(study_path)
    study = study if variant is None else study.variant(variant)
    record = None if record_path is None else read_record(record_path, kinds.CROSSED_WIRES)
    place: dict[str, Any] = {"made_of": [record_path], "overwrite": overwrite}
    if output is not None:
        require_place(output, **place)
    with progress_bar() as bar:
        task = bar.add_task(escape(study.name), total=1.0)
        calibration = solve(
            study,
            normal_loads_N=parse_loads(loads),
            near=parse_near(near),
            remote_compliance_um_per_N=remote_compliance,
            fidelity=fidelity,
            progress=lambda share, text: bar.update(task, completed=share, description=escape(text)),
        )
    correction = None if record is None else corrected_record(record, calibration.polynomial)
    if correction is not None and output is not None:
        write_record(output, correction.record, **place)
    if as_json:
        click.echo(json_text(calibration_json(study.name, calibration, correction)))
        return
    Console().print(calibration_text(calibration, correction))
    if output is not None:
        click.echo(output)
