"""First loops, largest pressures, scars and prints of wires that yield, beside those of elastic ones.

Usage: python -m studies.yielding_wires.draw RUNS --output FOLDER
"""

from pathlib import Path

import click
import matplotlib.pyplot as plt
import numpy as np

from wirewear.results import RunResult, read_result


def results_in(runs: Path) -> list[RunResult]:
    """Results of all variants of a folder, the elastic one first."""
    return sorted((read_result(path) for path in runs.glob("*/result.h5")), key=lambda run: run.variant != "elastic")


@click.command()
@click.argument("runs", type=click.Path(path_type=Path))
@click.option("--output", type=click.Path(path_type=Path), required=True, help="Folder of the picture.")
def draw(runs: Path, output: Path) -> None:
    """Draw yielding_wires.png, and print its numbers."""
    figure, ((loops, pressures), (prints, scars)) = plt.subplots(2, 2, figsize=(10.0, 7.0), layout="constrained")
    for run in results_in(runs):
        first, evolution = run.loops[0], run.evolution
        loops.plot(first.displacement_um, first.tangential_force_N, label=run.variant)
        pressures.semilogx(evolution["cycle"], 1e-3 * evolution["max_pressure_MPa"])
        fresh, worn = (next(one for one in run.scars if (one.cycle, one.body) == (n, "fixed")) for n in (1, 100_000))
        middle = fresh.transverse_um.size // 2
        left = np.zeros_like(fresh.depth_um) if fresh.print_um is None else fresh.print_um
        prints.plot(fresh.axial_um, -left[:, middle])
        scars.plot(worn.axial_um, -worn.measured_depth_um[:, worn.transverse_um.size // 2])
        energy, depth = evolution["dissipated_energy_mJ"], evolution["max_depth_fixed_um"]
        click.echo(
            f"{run.variant}: {evolution['max_pressure_MPa'][0]:.0f} MPa, first loop {energy[0]:.4f} mJ, print "
            f"{left.max():.3f} um, last loop {energy[-1]:.4f} mJ, {depth[-1]:.2f} um deep"
        )
    loops.set(title="first loop", xlabel="displacement [µm]", ylabel="tangential force [N]")
    pressures.set(title="largest pressure at a node", xlabel="cycle", ylabel="pressure [GPa]")
    prints.set(
        title="print of the fixed wire after one cycle", xlabel="along its axis [µm]", ylabel="µm", xlim=(-30, 30)
    )
    scars.set(title="its scar after 100 000 cycles, as measured", xlabel="along its axis [µm]", ylabel="µm")
    loops.legend()
    output.mkdir(parents=True, exist_ok=True)
    figure.savefig(output / "yielding_wires.png", dpi=110)


if __name__ == "__main__":
    draw()
