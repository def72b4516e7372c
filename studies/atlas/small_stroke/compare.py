"""Growth of scars that exceed the stroke: depth with the square root of the cycles, as the energy law asks for.

    python studies/small_stroke/compare.py RESULT_DIR [--output DIR]

RESULT_DIR is the folder that `wirewear run` left of study.toml. When the scar is much larger than the stroke both wires
wear into one another as if they did not move: the worn volume is that which the unworn wires share at an approach h,
V = pi R h² for equal wires at right angles, and as V grows with the energy, so does h with the root of the cycles.
"""

from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from wirewear import ResultError, RunResult, read_results
from wirewear.base.verdicts import Comparison, comparison_table
from wirewear.faces.study_script import comparison_command, wide_console
from wirewear.pictures import save
from wirewear.pictures.style import GREY, VARIANT_COLOURS, cycle_axis, new_figure

LARGE = 5.0  #: Half-width of the scar over the displacement amplitude from which on the law is looked for.

Array = NDArray[np.float64]


def depth_um(run: RunResult) -> Array:
    """Both wires' largest worn depths together, at each row of the evolution."""
    depth: Array = run.evolution["max_depth_moving_um"] + run.evolution["max_depth_fixed_um"]
    return depth


def overlap_um(run: RunResult) -> Array:
    """Depth of the volume that both unworn wires share, sqrt(V / pi R), for the worn volume at each row."""
    volume = run.evolution["worn_volume_moving_mm3"] + run.evolution["worn_volume_fixed_mm3"]
    radius = 0.5 * float(run.study["wires"]["diameter_mm"])
    depth: Array = 1e3 * np.sqrt(volume / (np.pi * radius))
    return depth


def large_scar(run: RunResult) -> NDArray[np.bool_]:
    """Rows at which the scar's half-width sqrt(2 R h) exceeds the amplitude by `LARGE`.
    Raises ResultError if there are fewer than three.
    """
    half_width_um = np.sqrt(1e3 * float(run.study["wires"]["diameter_mm"]) * overlap_um(run))
    large: NDArray[np.bool_] = half_width_um > LARGE * float(run.study["conditions"]["displacement_amplitude_um"])
    if large.sum() < 3:
        raise ResultError(f"the scars of {run.label} do not become {LARGE:g} times as wide as the stroke")
    return large


def exponent(run: RunResult) -> float:
    """Slope of log depth over log cycles while the scar is large."""
    large = large_scar(run)
    return float(np.polyfit(np.log(run.evolution["cycle"][large]), np.log(depth_um(run)[large]), 1)[0])


def picture(run: RunResult) -> Figure:
    """Depth against cycles beside that of the shared volume, with the part the exponent is fitted to."""
    figure = new_figure(3.2)
    axes = figure.subplots()
    cycle, depth = run.evolution["cycle"], depth_um(run)
    worn = depth > 0.0
    axes.plot(cycle[worn], depth[worn], color=VARIANT_COLOURS[0], label="both wires, simulated")
    axes.plot(cycle[worn], overlap_um(run)[worn], color=GREY, linestyle="--", label="√(V/πR) of the worn volume")
    large = large_scar(run)
    power = exponent(run)
    fitted = depth[large][-1] * (cycle[large] / cycle[large][-1]) ** power
    axes.plot(cycle[large], fitted, color=VARIANT_COLOURS[1], linewidth=4, alpha=0.4, label=f"∝ N^{power:.3f}")
    cycle_axis(axes)
    axes.set(yscale="log", ylabel="largest depth [µm]")
    axes.legend()
    return figure


@comparison_command
def main(result_dir: Path, folder: Path) -> None:
    """Compare the growth of the scars with the law of the square root."""
    run = read_results(result_dir)[0]
    comparisons = [
        Comparison("exponent of depth over cycles", exponent(run), 0.5, 0.1, "energy law"),
        Comparison("final depth [µm]", float(depth_um(run)[-1]), float(overlap_um(run)[-1]), 0.1, "√(V/πR)"),
    ]
    folder.mkdir(parents=True, exist_ok=True)
    drawn = save(partial(picture, run), folder / "growth.png")
    console = wide_console()
    console.print(comparison_table(comparisons))
    console.print(str(drawn), soft_wrap=True, highlight=False)


if __name__ == "__main__":
    main()
