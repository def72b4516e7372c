"""Debris between the steel wires: its thickness over the cycles and along the motion, beside the worn depth.

Usage: python -m studies.debris.draw RUNS --output FOLDER
"""

from pathlib import Path

import click
import matplotlib.pyplot as plt

from wirewear.results import RunResult, read_result

SHOWN = (100, 1_000, 10_000, 100_000)  #: Cycles whose profiles are drawn.


def results_in(runs: Path) -> list[RunResult]:
    """Results of all variants of a folder."""
    return [read_result(path) for path in sorted(runs.glob("*/result.h5"))]


@click.command()
@click.argument("runs", type=click.Path(path_type=Path))
@click.option("--output", type=click.Path(path_type=Path), required=True, help="Folder of the picture.")
def draw(runs: Path, output: Path) -> None:
    """Draw debris.png, and print its numbers."""
    figure, (thickness, wear, along) = plt.subplots(1, 3, figsize=(14.0, 4.2), layout="constrained")
    for run in results_in(runs):
        evolution = run.evolution
        rate = (evolution["worn_volume_fixed_mm3"] + evolution["worn_volume_moving_mm3"]) / evolution[
            "accumulated_energy_J"
        ]
        wear.semilogx(evolution["cycle"], 1e5 * rate, label=run.variant)
        words = f"{run.variant}: {evolution['max_depth_fixed_um'][-1]:.2f} um deep, {rate[-1]:.3g} mm3/J"
        if "debris_thickness_um" in evolution:
            thickness.loglog(evolution["cycle"], evolution["debris_thickness_um"], label=run.variant)
            words += f", debris {evolution['debris_thickness_um'][-1]:.2f} um thick"
            words += f", {evolution['debris_left_mm3'][-1]:.3g} mm3 have left"
        click.echo(words)
    for scar in next(run for run in results_in(runs) if run.variant == "leaves").scars:
        if scar.body == "fixed" and scar.cycle in SHOWN and scar.debris_um is not None:
            middle = scar.transverse_um.size // 2
            along.plot(scar.axial_um, scar.debris_um[:, middle], label=f"cycle {scar.cycle}")
    thickness.set(title="largest thickness of debris", xlabel="cycle", ylabel="µm")
    wear.set(title="worn volume over friction energy", xlabel="cycle", ylabel="10⁻⁵ mm³/J", ylim=(0.0, None))
    along.set(
        title="debris of the fixed wire, where it leaves", xlabel="along its axis [µm]", ylabel="µm", xlim=(-250, 250)
    )
    for axis in (thickness, wear, along):
        axis.legend()
    output.mkdir(parents=True, exist_ok=True)
    figure.savefig(output / "debris.png", dpi=110)


if __name__ == "__main__":
    draw()
