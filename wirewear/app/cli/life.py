"""Command `life`: fatigue lives of the bodies of a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wirewear.app.cli.group import Finite, Given, OutputFolder, beside, busy, cli, default_output, paper
from wirewear.app.cli.stress import BODY, asked_bodies
from wirewear.base.errors import ResultError, StudyError
from wirewear.base.words import counted
from wirewear.base.writing import usable_folder
from wirewear.test import FIDELITIES

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wirewear.results import RunResult


@cli.command()
@click.argument("path", metavar="STUDY|RESULT", type=Given())
@BODY
@click.option("--criterion", help="As criterion in [life].")
@click.option("--material", help="Material of the table whose data of fatigue are taken.")
@click.option("--averaging-length", metavar="UM", type=Finite(0.0, min_open=True), help="As averaging_length_um.")
@click.option("--set", "others", metavar="KEY=VALUE", multiple=True, help="Any key of [life]; may be repeated.")
@click.option("--wear-states", type=click.IntRange(1), help="Recorded cycles looked at, of each block.  [default: 6]")
@click.option("--cycle", type=Finite(0.0), help="Of the maps of damage.  [default: when the crack begins]")
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="quick", show_default=True, help="Of a study's run.")
@click.option("--variant", help="Of a study.")
@click.option("--json", "as_json", is_flag=True, help="Print the lives as JSON.")
@click.option("--output", metavar="DIR", type=OutputFolder(), help="[default: life/ beside the result]")
@paper
def life(
    path: Path,
    body: str,
    criterion: str | None,
    material: str | None,
    averaging_length: float | None,
    others: tuple[str, ...],
    wear_states: int | None,
    cycle: float | None,
    fidelity: str,
    variant: str | None,
    as_json: bool,
    output: Path | None,
) -> None:
    """Say after how many cycles a crack begins, where and on which plane, while wear takes damage away.

    A study is run first. Data of the material come from [life] of the study, or from the options.
    """
    from wirewear.app.api.run import lives, one_run
    from wirewear.app.cli.consoles import progress_bar
    from wirewear.views.life_page import life_json, notes, sentence, write_lives

    named = {"criterion": criterion, "material": material, "averaging_length_um": averaging_length}
    values = {key: value for key, value in named.items() if value is not None} | dict(map(_pair, others))
    if path.suffix == ".toml":
        result, home = _run_first(path, fidelity, variant, body, values)
    elif variant is None:
        result, home = one_run(path), beside(path)
    else:
        raise ResultError("--variant is of a study: name the folder of the variant's run instead.")
    with progress_bar() as bar:
        task = bar.add_task("", total=None)

        def report(name: str, at: int) -> None:
            bar.update(task, description=f"{name}, cycle {counted(at)}")
            if bar.disable:
                click.echo(f"wirewear: {name}, cycle {counted(at)}", err=True)

        found = lives(
            result, asked_bodies(body, result.label, result.bodies), values=values, wear_states=wear_states, tell=report
        )
    folder = usable_folder(output or home / "life")
    with busy("drawing the damage and writing the page"):
        written = write_lives(found, result.label, folder, cycle)
    if as_json:
        click.echo(life_json(found))
    else:
        for one in found:
            click.echo("\n".join([sentence(one), *(f"  {note}" for note in notes(one))]))
    click.echo(f"the page is {written[-1]}", err=as_json)


def _pair(text: str) -> tuple[str, Any]:
    key, equals, value = text.partition("=")
    if not equals:
        raise StudyError(f"--set takes KEY=VALUE, not {text!r}.")
    try:
        return key, float(value)
    except ValueError:
        return key, value


def _run_first(
    path: Path, fidelity: str, variant: str | None, body: str, values: Mapping[str, Any]
) -> tuple[RunResult, Path]:
    """Result of a study, which is run after its fatigue data are checked, and the folder beside which lives are
    written.
    """
    from wirewear.kinds import contacts_of, load_any_study
    from wirewear.simulation import ProgressBar, run_study
    from wirewear.stress.life import require_life
    from wirewear.test.any_study import alone

    study = load_any_study(path)
    study = alone(study) if variant is None else study.variant(variant)
    require_life(study, asked_bodies(body, study.name, study.body_names), values)
    folder, contacts = default_output(path), contacts_of(study)
    results = run_study(study, fidelity=fidelity, output=folder, resume=False, observer_of=ProgressBar, jobs=1)
    contacts.write_beside(results, folder)
    return results[0], folder
