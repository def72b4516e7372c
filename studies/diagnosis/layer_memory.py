"""How well one height says what a scar remembers of a rough layer that wears in: against wires worn under the layer.

    python -m studies.diagnosis.layer_memory

The fast model takes the slopes of a scar from wires that were worn under layers that stay, at the mean of the heights
under which this one was worn, later wear weighing by a power of the volume. Here crossed wires wear on the same
foundation under layers that wear in. Printed is what is left of the change of their slopes, by power, for the steel
wires' test.
"""

from functools import partial

import click
import numpy as np
from numpy.typing import NDArray
from rich import box
from rich.table import Table

from studies.study_script import StudyScript
from wirewear.app.cli.consoles import wide_console
from wirewear.diagnosis.surrogate.layered_wires import LayeredCase, layered_wires, pressing_layers, remembered
from wirewear.diagnosis.surrogate.worn_wires import WornWires, slopes, wearing

Array = NDArray[np.float64]

#: The steel wires' test of 0.45 mm, 2 N and ±60 µm: by its end V R/δ⁴ is some 30, δ²/R is 10.2 µm.
CASE = LayeredCase(0.3, 1.25, 0.977, 0.115, 31.0, 0.5)
CYCLES, UNIT_um = 1e5, 10.24

#: Heights in µm and cycles over which they wear in.
LAYERS = ((5.1, 17_700.0), (2.9, 4100.0), (6.0, 1000.0), (4.0, 50_000.0), (1.5, 8000.0), (8.0, 30_000.0))

POWERS = (1.0, 1.5, 2.0, 2.5, 3.0)

STEPS, COMPARED = 400, 0.002  #: Steps of the volume, and the first that is compared, as a share of the whole.


def heights(volume: Array | float) -> Array:
    """Heights s R/δ² of the layers, the first of none, at V R/δ⁴, which grows evenly with the cycles."""
    cycles = np.asarray(volume) / CASE.most_worn * CYCLES
    return np.array([0.0 * cycles, *(height / UNIT_um * np.exp(-cycles / over) for height, over in LAYERS)])


def worn_under_layers(volumes: Array) -> Array:
    """Slopes (layers, volumes, positions) of wires that wear under the layers, less those of wires without."""
    now = heights(0.0)
    wires = WornWires.unworn(now.size, 1.08 * (4.0 * CASE.most_worn / np.pi) ** 0.25 + CASE.fresh_radius)
    guess = 0.1 * CASE.fresh_radius**2 + 2.0 * now[:, None] + np.zeros(wires.s.size)
    pressing = partial(pressing_layers, heights=now, engagement=CASE.engagement)
    found = []
    for volume, worn in zip(
        volumes.tolist(), wearing(wires, volumes, CASE.fresh_radius, guess, CASE.moving_share, pressing), strict=True
    ):
        now[...] = heights(volume)
        found.append(slopes(worn.part, worn.pressure))
    slope = np.stack(found, axis=1)
    return np.asarray(slope[1:] - slope[:1])


def errors(power: float, volumes: Array, direct: Array) -> list[float]:
    """What is left of each layer's change (root mean square), by the fast model with that power."""
    late, table = volumes > COMPARED * volumes[-1], layered_wires(CASE)
    left = []
    for height, change in zip(heights(volumes)[1:], direct, strict=True):
        found = table.at(remembered(height, volumes, power), height, volumes)[:, :-3]
        at, known = np.linspace(0.0, 1.0, change.shape[1]), np.linspace(0.0, 1.0, found.shape[1])
        own = np.stack([np.interp(at, known, row) for row in found])
        left.append(float(np.sqrt(((own - change)[late] ** 2).mean() / (change[late] ** 2).mean())))
    return left


@click.command(cls=StudyScript)
def main() -> None:
    """Print what is left of layers' changes, by the power of the volume."""
    volumes = np.concatenate([[0.0], np.geomspace(1e-4, 1.0, STEPS)]) * CASE.most_worn
    direct = worn_under_layers(volumes)
    table = Table("power", *(f"{height:g} µm, {over:g}" for height, over in LAYERS), "mean", box=box.SIMPLE_HEAD)
    for power in POWERS:
        left = errors(power, volumes, direct)
        table.add_row(f"{power:g}", *(f"{one:.2f}" for one in left), f"{np.mean(left):.2f}")
    wide_console(130).print(table)


if __name__ == "__main__":
    main()
