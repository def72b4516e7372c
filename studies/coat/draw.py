"""Pressure and depth of a ball on coated flats over the cycles, until the coats are worn through.

Usage: python -m studies.coat.draw RUNS --output FOLDER
"""

from pathlib import Path

import click
import matplotlib.pyplot as plt

from wirewear.results import read_result


@click.command()
@click.argument("runs", type=click.Path(path_type=Path))
@click.option("--output", type=click.Path(path_type=Path), required=True, help="Folder of the picture.")
def draw(runs: Path, output: Path) -> None:
    """Draw coats.png, and print its numbers."""
    figure, (pressure, depth) = plt.subplots(1, 2, figsize=(10.0, 4.2), layout="constrained")
    for path in sorted(runs.glob("*/result.h5")):
        run = read_result(path)
        cycle, mean = run.evolution["cycle"], run.evolution["max_mean_pressure_MPa"]
        pressure.semilogx(cycle, mean, label=run.variant)
        depth.loglog(cycle, run.evolution["max_depth_flat_um"], label=run.variant)
        for face in run.layer_faces_um("flat"):
            depth.axhline(face, color="gray", linestyle=":")
        words = f"{run.variant}: contact radius {run.settings['fresh_contact_radius_um']:.1f} um, {mean[0]:.0f} MPa at"
        click.echo(f"{words} first, {mean[-1]:.0f} at last; worn through at {run.worn_through('flat')}")
    pressure.set(title="largest mean pressure", xlabel="cycle", ylabel="MPa", ylim=(0.0, None))
    depth.set(title="depth of the flat, and of the coats (dotted)", xlabel="cycle", ylabel="µm")
    for axis in (pressure, depth):
        axis.legend()
    output.mkdir(parents=True, exist_ok=True)
    figure.savefig(output / "coats.png", dpi=110)


if __name__ == "__main__":
    draw()
