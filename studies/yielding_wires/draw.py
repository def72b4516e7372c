"""First loops, largest pressures, prints, scars, worn depths and damage of wires that yield, beside elastic ones.

Usage: python -m studies.yielding_wires.draw RUNS --output FOLDER
"""

import csv
from pathlib import Path

import click
import matplotlib.pyplot as plt
import numpy as np

from wirewear.results import RunResult, read_result


def results_in(runs: Path) -> list[RunResult]:
    """Results of all variants of a folder, the elastic one first, then by yield stress."""
    results = (read_result(path) for path in runs.glob("*/result.h5"))
    return sorted(results, key=lambda run: (run.variant != "elastic", run.variant))


def damage_of(run: RunResult) -> tuple[list[float], list[float]]:
    """(cycles, largest damage sum of the moving wire) that `wirewear life` has written beside a run; empty without."""
    if run.path is None or not (path := run.path.parent / "life" / "life.csv").is_file():
        return [], []
    with path.open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["body"] == "moving" and float(row["cycle"]) > 0.0]
    return [float(row["cycle"]) for row in rows], [float(row["largest_sum"]) for row in rows]


@click.command()
@click.argument("runs", type=click.Path(path_type=Path))
@click.option("--output", type=click.Path(path_type=Path), required=True, help="Folder of the picture.")
def draw(runs: Path, output: Path) -> None:
    """Draw yielding_wires.png, and print its numbers."""
    figure, axes = plt.subplots(2, 3, figsize=(14.0, 7.0), layout="constrained")
    loops, pressures, depths, prints, scars, sums = axes.flat
    elastic = results_in(runs)[0].evolution
    for run in results_in(runs):
        first, evolution = run.loops[0], run.evolution
        loops.plot(first.displacement_um, first.tangential_force_N, label=run.variant)
        pressures.semilogx(evolution["cycle"], 1e-3 * evolution["max_pressure_MPa"])
        fresh, worn = (next(one for one in run.scars if (one.cycle, one.body) == (n, "fixed")) for n in (1, 100_000))
        middle = fresh.transverse_um.size // 2
        left = np.zeros_like(fresh.depth_um) if fresh.print_um is None else fresh.print_um
        prints.plot(fresh.axial_um, -left[:, middle])
        scars.plot(worn.axial_um, -worn.measured_depth_um[:, worn.transverse_um.size // 2])
        cycle, depth = evolution["cycle"], evolution["max_depth_fixed_um"]
        same = np.interp(np.log(cycle), np.log(elastic["cycle"]), np.log(elastic["max_depth_fixed_um"]))
        depths.semilogx(cycle, depth / np.exp(same))
        sums.loglog(*damage_of(run))
        energy = evolution["dissipated_energy_mJ"]
        click.echo(
            f"{run.variant}: {evolution['max_pressure_MPa'][0]:.0f} MPa, first loop {energy[0]:.4f} mJ, first cycle "
            f"{1e3 * depth[0]:.1f} nm deep, print {left.max():.3f} um, rim {-left.min():.3f} um, last loop "
            f"{energy[-1]:.4f} mJ, {depth[-1]:.2f} um deep"
        )
    loops.set(title="first loop", xlabel="displacement [µm]", ylabel="tangential force [N]")
    pressures.set(title="largest pressure at a node", xlabel="cycle", ylabel="pressure [GPa]")
    depths.set(title="worn depth of the fixed wire", xlabel="cycle", ylabel="over that of elastic wires")
    prints.set(title="print of the fixed wire after a cycle", xlabel="along its axis [µm]", ylabel="µm", xlim=(-60, 60))
    scars.set(title="its scar after 100 000 cycles, as measured", xlabel="along its axis [µm]", ylabel="µm")
    sums.set(title="largest damage sum of the moving wire", xlabel="cycle", ylabel="1: a crack begins")
    loops.legend()
    output.mkdir(parents=True, exist_ok=True)
    figure.savefig(output / "yielding_wires.png", dpi=110)


if __name__ == "__main__":
    draw()
