"""The command on temperatures of rubbing surfaces."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from wirewear.app.cli.group import Finite, OutputFolder, beside, cli, paper, recorded_cycles
from wirewear.app.cli.stress import recorded, report_taken
from wirewear.base.writing import usable_folder


class OfBodies(Finite):
    """Type of an option: a positive number for both bodies, or one for the driven and one for the held body."""

    name = "number[,number]"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Both numbers. Raises click.BadParameter if there are more, or one is out of range."""
        if not isinstance(value, str):  # converted already
            return value
        parts = value.split(",")
        if len(parts) > 2:
            self.fail(f"{value} is more than one number for each of two bodies.", param, ctx)
        numbers = [super(OfBodies, self).convert(part, param, ctx) for part in parts]
        return numbers[0], numbers[-1]


@cli.command()
@click.argument("result_path", metavar="RESULT", type=click.Path(path_type=Path))
@click.option(
    "--conductivity",
    metavar="W/(m·K)",
    type=OfBodies(0.0, min_open=True),
    required=True,
    help="Of both bodies, or of the driven and the held one, as 46,6.7 for carbon steel on Ti-6Al-4V.",
)
@click.option(
    "--heat-capacity",
    metavar="J/(cm³·K)",
    type=OfBodies(0.0, min_open=True),
    required=True,
    help="Per volume: 3.6 for carbon steel, 2.4 for Ti-6Al-4V.",
)
@click.option(
    "--resistance",
    metavar="K/W",
    type=OfBodies(0.0),
    default=(0.0, 0.0),
    help="From each body, through its holder, to the surroundings.  [default: none]",
)
@recorded_cycles
@click.option("--output", metavar="DIR", type=OutputFolder(), help="[default: heat/ beside the result]")
@paper
def heat(
    result_path: Path,
    conductivity: tuple[float, float],
    heat_capacity: tuple[float, float],
    resistance: tuple[float, float],
    cycles: tuple[float, ...],
    output: Path | None,
) -> None:
    """Say how warm friction makes the surfaces of a run: mean and flash temperatures, and how both bodies share it."""
    from solvers import Conductor
    from wirewear.app.api.run import one_run
    from wirewear.app.cli.consoles import wide_console
    from wirewear.stress.heat import heat_table, surface_heat, write_heat

    result = one_run(result_path)
    for cycle in cycles:
        report_taken(cycle, result, result.bodies)
    asked = cycles or recorded(result.contact_forces)
    taken = dict.fromkeys(result.forces(cycle, result.bodies[0]).cycle for cycle in asked)
    stated = zip(conductivity, heat_capacity, resistance, strict=True)
    conductors = dict(zip(result.bodies, (Conductor(*each) for each in stated), strict=True))
    folder = usable_folder(output or beside(result_path) / "heat")
    found = [one for cycle in taken for one in surface_heat(result, cycle, conductors)]
    wide_console(110).print(heat_table(found, result.called))
    for path in write_heat(found, folder):
        click.echo(path)
