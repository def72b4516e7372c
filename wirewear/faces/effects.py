"""Commands that list effects and materials, and draw what an effect does to a test."""

from pathlib import Path

import click

from wirewear.base.errors import StudyError
from wirewear.base.writing import json_text
from wirewear.faces.group import cli, given
from wirewear.study import FIDELITIES

#: Options that say what is plotted, how and where, and their parameters.
_OF_A_PLOT = {"--size": "size", "--study": "study_path", "--fidelity": "fidelity", "--output": "output"}


@cli.command(name="materials")
def materials_command() -> None:
    """List the materials that a study may name, with their elastic constants' sources, and whether these were read."""
    from rich import box
    from rich.table import Table

    from wirewear.faces.study_script import wide_console
    from wirewear.study.materials import materials

    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("material", no_wrap=True)
    table.add_column("also", no_wrap=True)
    for heading in ("E [GPa]", "ν"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("source", overflow="fold")
    for item in materials():
        modulus, ratio = item.elastic.youngs_modulus_MPa, item.elastic.poissons_ratio
        source = item.source if item.verified else f"unverified: {item.source}"
        table.add_row(item.name, ", ".join(item.also), f"{1e-3 * modulus:.4g}", f"{ratio:g}", source)
    wide_console(130).print(table)


@cli.command(name="effects")
@click.argument("name", required=False)
@click.option("--json", "as_json", is_flag=True, help="Print all effects, or NAME alone, as JSON.")
@click.option("--plot", is_flag=True, help="Run the steel-wire test without and with NAME, and draw what differs.")
@click.option("--study", "study_path", metavar="STUDY.toml", type=click.Path(path_type=Path), help="Plot this one.")
@click.option("--size", type=click.Choice(["easy", "hard"]), default="easy", show_default=True, help="Size to plot.")
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="quick", show_default=True)
@click.option(
    "--output",
    metavar="DIR",
    type=click.Path(path_type=Path),
    default=Path("runs/effects"),
    show_default=True,
    help="Of runs and pictures; finished runs there are used again.",
)
def effects_command(
    name: str | None, as_json: bool, plot: bool, study_path: Path | None, size: str, fidelity: str, output: Path
) -> None:
    """List the effects that a study can have beyond the nominal model, or describe or draw the one called NAME."""
    from wirewear.effects import effect_named
    from wirewear.effects.listing import effect_text, effects_json, effects_table
    from wirewear.faces.study_script import wide_console

    for option, parameter in _OF_A_PLOT.items():
        if not plot and given(parameter):
            raise StudyError(f"{option} belongs to --plot: give both, or neither.")
    if plot:
        if as_json:
            raise StudyError("--json does not go with --plot, which draws.")
        if name is None:
            raise StudyError("--plot needs the name of an effect: `wirewear effects` lists them.")
        _plot_effect(name, study_path, size, fidelity, output)
    elif as_json:
        own = None if name is None else effect_named(name).name
        chosen = [effect for effect in effects_json() if own in (None, effect["name"])]
        click.echo(json_text(chosen))
    elif name is not None:
        click.echo(effect_text(effect_named(name)))
    else:
        console = wide_console(130)
        console.print(effects_table())


def _plot_effect(name: str, study_path: Path | None, size: str, fidelity: str, output: Path) -> None:
    """Run a study without and with an effect, and draw its signature."""
    from wirewear.effects import effect_named
    from wirewear.simulation import ProgressBar
    from wirewear.study import load_study
    from wirewear.sweeps.signature import draw_signature, signature_of, signature_study

    study = signature_study() if study_path is None else load_study(study_path)
    if study.variants:
        raise StudyError(f"{study_path} has variants, but a signature needs a study without.")
    effect = effect_named(name).sized("hard" if size == "hard" else "easy", study.stated)
    signature = signature_of(effect, output, study=study, fidelity=fidelity, observer_of=ProgressBar)
    click.echo(draw_signature(signature, output / f"{name}.png"))
