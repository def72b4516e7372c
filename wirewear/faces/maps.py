"""The command that sets many tests side by side on maps."""

from pathlib import Path

import click

from wirewear.base.interchange import json_text
from wirewear.faces.group import STRENGTH, OutputFolder, busy, cli


@cli.command()
@click.argument("paths", metavar="RECORD_OR_RESULT...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", type=OutputFolder(), default=Path("runs/maps"), show_default=True)
@click.option(
    "--fatigue-limit", "limit", metavar="MPa", type=STRENGTH,
    help="Draw the line of this tension only.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print tests and lines as JSON.")
def maps(paths: tuple[Path, ...], output: Path, limit: float | None, as_json: bool) -> None:
    """Set tests side by side: running conditions, material response, sliding criteria, wear against friction energy."""
    from wirewear.faces.maps_page import write_maps
    from wirewear.faces.maps_reading import fretting_tests
    from wirewear.faces.maps_tables import maps_json, sentences, tests_table
    from wirewear.faces.study_script import wide_console

    with busy("reading the tests"):
        tests = [test for path in paths for test in fretting_tests(path)]
    with busy("drawing the maps"):
        written = write_maps(tests, output, limit)
    if as_json:
        click.echo(json_text(maps_json(tests)))
        return
    wide_console(150).print(tests_table(tests))
    for sentence in sentences(tests):
        click.echo(sentence)
    for path in written:
        click.echo(path)
