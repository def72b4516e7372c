"""Commands on stresses inside the bodies of a run: stress fields, yield and fatigue."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from wirewear.app.cli.group import STRENGTH, Finite, OutputFolder, beside, cli, paper, recorded_cycles
from wirewear.base.errors import ResultError
from wirewear.base.words import counted
from wirewear.base.writing import usable_folder
from wirewear.results import POSITIONS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from wirewear.results import ContactForces, RunResult
    from wirewear.stress.strength import Strength, StrengthAsked


T = TypeVar("T")

#: Which body is asked for; of the older name, all were wires.
BODY = click.option(
    "--body", "--wire", "body", default="both", show_default=True,
    help="One of the bodies by its name, as fixed, ball or specimen, or lower or upper.",
)  # fmt: skip


@cli.command()
@click.argument("result_path", metavar="RESULT", type=click.Path(path_type=Path))
@click.option("--cycle", type=Finite(0.0), required=True, help="The recorded cycle nearest to this one is taken.")
@click.option(
    "--at",
    metavar="POSITION",
    multiple=True,
    help=f"{', '.join(POSITIONS)}, a number, or all; may be repeated.  [default: mid-forward]",
)
@BODY
@click.option("--fresh-nodes", is_flag=True, help="Leave the nodes where they were when fresh.")
@click.option("--integration-points", is_flag=True, help="Write the stresses at the integration points, too.")
@click.option("--no-pictures", is_flag=True, help="Write files for ParaView only.")
@click.option("--animate", is_flag=True, help="Draw the positions as an animation (give --at all).")
@click.option("--output", metavar="DIR", type=OutputFolder(), help="[default: fields/ beside the result]")
@paper
def fields(
    result_path: Path,
    cycle: float,
    at: tuple[str, ...],
    body: str,
    fresh_nodes: bool,
    integration_points: bool,
    no_pictures: bool,
    animate: bool,
    output: Path | None,
) -> None:
    """Write displacements and stresses inside the bodies of a run for ParaView, and draw them."""
    from wirewear.app.api.run import one_run
    from wirewear.app.cli.consoles import progress_bar
    from wirewear.kinds import contacts_of

    folder = output or beside(result_path) / "fields"
    chosen = None if "all" in at else at or ("mid-forward",)
    if animate and chosen is not None and len(set(chosen)) < 2:
        raise ResultError("an animation needs several positions: give --at all.")
    with progress_bar() as bar:

        def tracked(each: Sequence[T], doing: str, /) -> Iterable[T]:
            return bar.track(each, description=doing)

        result = one_run(result_path)
        contacts = contacts_of(result)
        given = {"--integration-points": integration_points, "--no-pictures": no_pictures, "--animate": animate}
        for option in (one for one, is_given in given.items() if is_given and one not in contacts.inside_options):
            name = result.contact_kind.replace("-", " ")
            raise ResultError(f"{option} does not apply to {result_path}, which is a {name}.")
        bodies = asked_bodies(body, result.label, result.bodies)
        report_taken(cycle, result, bodies)
        usable_folder(folder)
        shown: dict[str, Any] = {
            "bodies": bodies,
            "integration_points": integration_points,
            "pictures": not no_pictures and "all" not in at,
            "animation": animate,
        }
        written = contacts.write_fields(
            result, folder, **shown, cycle=cycle, at=chosen, worn=not fresh_nodes, tracked=tracked
        )
    for path in written:
        click.echo(path)
    if not no_pictures and not any(path.suffix in (".png", ".gif") for path in written):
        click.echo("wirewear: the bodies are apart there, of which no picture is drawn.", err=True)


def asked_bodies(body: str, where: str, bodies: tuple[str, ...]) -> tuple[str, ...]:
    """Names of both bodies for "both", else of the one named `body`, in a tuple; bodies: the known names. where: names
    the run in messages. Raises ResultError if there is no such body.
    """
    from wirewear.results.scar import body_named

    return bodies if body == "both" else (body_named(body, where, bodies),)


@cli.command()
@click.argument("result_path", metavar="RESULT", type=click.Path(path_type=Path))
@recorded_cycles
@BODY
@click.option("--yield-strength", metavar="MPa", type=STRENGTH, help="Of the bodies' material.  [default: as stated]")
@click.option(
    "--crossland-slope",
    type=Finite(0.0),
    default=0.3,
    show_default=True,
    help="Weight of the hydrostatic stress beside the amplitude of the root of J2.",
)
@click.option(
    "--averaging-length",
    metavar="UM",
    type=Finite(0.0),
    default=0.0,
    show_default=True,
    help="Stresses are averaged over balls of this diameter.",
)
@click.option("--output", metavar="DIR", type=OutputFolder(), help="[default: strength/ beside the result]")
@paper
def strength(
    result_path: Path,
    cycles: tuple[float, ...],
    body: str,
    yield_strength: float | None,
    crossland_slope: float,
    averaging_length: float,
    output: Path | None,
) -> None:
    """Say where and until when the bodies of a run yield, and where cracks begin first.

    Both bodies at every recorded cycle, unless --cycle and --body ask for less. Pictures are drawn of each --cycle;
    without it of each body's first, last and largest von Mises stress. Files for ParaView hold all cycles.
    """
    from wirewear.app.cli.consoles import progress_bar, wide_console
    from wirewear.stress.strength import StrengthAsked, yield_sentence
    from wirewear.stress.writing import save_strength, strength_table, write_strength, write_strength_table

    asked = StrengthAsked(yield_strength, crossland_slope, averaging_length)
    chosen, strength_at = _assessing(result_path, body, cycles, asked)
    folder = usable_folder(output or beside(result_path) / "strength")
    courses: dict[str, list[Strength]] = {one: [] for one in chosen}
    written: list[Path] = []
    with progress_bar() as bar:
        task = bar.add_task("", total=sum(map(len, chosen.values())))
        for one, its_cycles in chosen.items():
            worst: Strength | None = None
            for cycle in its_cycles:
                doing = f"{one}, cycle {counted(cycle)}"
                bar.update(task, description=doing)
                if bar.disable:
                    click.echo(f"wirewear: {doing}", err=True)
                found = strength_at(one, cycle)
                written.append(write_strength(found, folder))
                if cycles or cycle in (its_cycles[0], its_cycles[-1]):
                    written.append(save_strength(found, folder))
                elif worst is None or found.von_mises.value_MPa > worst.von_mises.value_MPa:
                    worst = found
                # What is written need not be held.
                courses[one].append(replace(found, grid=type(found.grid)()))
                bar.advance(task)
            if worst and worst.von_mises.value_MPa >= max(each.von_mises.value_MPa for each in courses[one]):
                written.append(save_strength(worst, folder))
    every = [one for course in courses.values() for one in course]
    wide_console(110).print(strength_table(every))
    for course in courses.values():
        if course[0].asked.yield_strength_MPa is not None:
            click.echo(yield_sentence(course))
    written.append(write_strength_table(every, folder))
    click.echo(f"{len(written)} files are in {folder}")


def _assessing(
    path: Path, body: str, cycles: Sequence[float], asked: StrengthAsked
) -> tuple[dict[str, list[int]], Callable[[str, int], Strength]]:
    """Recorded cycles to assess for each body, and a function that gives the strength of a body at a cycle.

    Raises before anything is computed if a request is refused.
    """
    from wirewear.app.api.run import one_run
    from wirewear.kinds import contacts_of
    from wirewear.stress.strength import assessable, strength_of
    from wirewear.test import study_from_tables

    result = one_run(path)
    contacts = contacts_of(result)
    inside = contacts.inside
    every = cycles or recorded(result.contact_forces)
    bodies = asked_bodies(body, result.label, result.bodies)
    for cycle in cycles:
        report_taken(cycle, result, bodies)
    chosen = {one: [*dict.fromkeys(assessable(result, one, cycle, asked, inside) for cycle in every)] for one in bodies}
    stated = study_from_tables(result.study, result.label).tables.yields if asked.yield_strength_MPa is None else {}
    limits = {one: replace(asked, yield_strength_MPa=own[0]) for one, own in stated.items() if own is not None}
    return chosen, lambda one, cycle: strength_of(result, one, cycle, limits.get(one, asked), inside)


def report_taken(cycle: float, result: RunResult, bodies: Iterable[str]) -> None:
    """State on standard error which recorded cycle is taken where forces on the bodies are not recorded at `cycle`.
    Raises ResultError if there are none near it.
    """
    taken = {result.forces(cycle, one).cycle for one in bodies} - {cycle}
    if taken:
        others = ", ".join(map(counted, recorded(result.contact_forces)))
        click.echo(
            f"wirewear: cycle {cycle:g} is not recorded, {counted(taken.pop())} is taken; recorded are {others}.",
            err=True,
        )


def recorded(forces: Iterable[ContactForces]) -> list[int]:
    """Cycles with recorded contact forces; [1] if there are none."""
    return sorted({one.cycle for one in forces}) or [1]
