"""Temperatures of rubbing surfaces over the cycles, and what they change of the wear.

Usage: python -m studies.heat.draw RUNS RUNS ... --output FOLDER
"""

from pathlib import Path

import click
import matplotlib.pyplot as plt

from studies.debris.draw import results_in


@click.command()
@click.argument("runs", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--output", type=click.Path(path_type=Path), required=True, help="Folder of the picture.")
def draw(runs: tuple[Path, ...], output: Path) -> None:
    """Draw heat_cycles.png, and print its numbers."""
    figure, (rise, wear) = plt.subplots(1, 2, figsize=(10.0, 3.8), layout="constrained")
    for run in [result for folder in runs for result in results_in(folder)]:
        evolution = run.evolution
        cycle, energy_J = evolution["cycle"], evolution["accumulated_energy_J"]
        one, other = (evolution[f"worn_volume_{body}_mm3"] for body in run.bodies)
        warm = "mean_rise_K" in evolution
        (line,) = wear.semilogx(cycle, 1e4 * (one + other) / energy_J, "-" if warm else ":", label=run.variant)
        words = f"{run.variant}: {(one[-1] + other[-1]) / energy_J[-1]:.4g} mm3/J"
        if warm:
            rise.loglog(cycle, evolution["mean_rise_K"], color=line.get_color(), label=run.variant)
            words += f", {evolution['mean_rise_K'][0]:.3g} to {evolution['mean_rise_K'][-1]:.3g} K"
        click.echo(words)
    rise.set(title="mean rise of the temperature", xlabel="cycle", ylabel="K")
    wear.set(title="worn volume over friction energy", xlabel="cycle", ylabel="10⁻⁴ mm³/J", ylim=(0.0, None))
    for axis in (rise, wear):
        axis.legend()
    output.mkdir(parents=True, exist_ok=True)
    figure.savefig(output / "heat_cycles.png", dpi=110)


if __name__ == "__main__":
    draw()
