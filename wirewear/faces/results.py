"""Commands on results: their pictures and their page."""

from pathlib import Path

import click

from wirewear.faces.group import OutputFolder, busy, cli


@cli.command()
@click.argument("result_path", metavar="RESULT", type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", type=OutputFolder(), help="Picture folder.  [default: beside it]")
@click.option("--format", "ending", type=click.Choice(["png", "svg", "pdf"]), default="png", show_default=True)
@click.option("--animation", is_flag=True, help="Draw loop and scar over the cycles as a GIF, too.")
def show(result_path: Path, output: Path | None, ending: str, animation: bool) -> None:
    """Draw the pictures of a result: a file, or the folder of a run."""
    from wirewear.pictures import show as draw

    for picture in draw(result_path, output, ending=ending, moving=animation):
        click.echo(picture)


@cli.command()
@click.argument("result_path", metavar="RESULT", type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", type=OutputFolder(), help="Page folder.  [default: beside it]")
def report(result_path: Path, output: Path | None) -> None:
    """Write the page of a result, or of a study's variants: one file for any browser, which needs no network."""
    from wirewear.base.folders import usable_folder
    from wirewear.results import read_results
    from wirewear.views.line_page import line_contacts_at
    from wirewear.views.run_page import write_page

    folder = output or (result_path if result_path.is_dir() else result_path.parent)
    with busy("writing the page"):
        results = line_contacts_at(result_path) or read_results(result_path)
        written = write_page(results, usable_folder(folder))
    click.echo(written)
