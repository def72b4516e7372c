"""A run at a glance: its loops, its course, and where it ended."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from wirewear.base.errors import ResultError
from wirewear.pictures.colours import GREY
from wirewear.pictures.evolution import draw_amplitudes, draw_depths
from wirewear.pictures.loops import draw_loops
from wirewear.pictures.sections import profile
from wirewear.pictures.smooth import smooth_scar
from wirewear.pictures.style import cycle_name, new_figure, panel_letters, variant_style
from wirewear.results import RunResult


def overview(results: Sequence[RunResult]) -> Figure:
    """Four panels: loops of the first run, amplitudes and depths of all over the cycles, sections of the fixed wires.

    Raises:
        ResultError: a run has no measured cycle yet.
    """
    if not all(result.evolution["cycle"].size for result in results):
        raise ResultError("nothing is measured yet, so there is nothing to draw")
    figure = new_figure(5.6)
    panels = list(figure.subplots(2, 2).flat)
    draw_loops(panels[0], results[0])
    panels[0].set_title(f"loops of {results[0].label}" if len(results) > 1 else "loops")
    draw_amplitudes(panels[1], results)
    draw_depths(panels[2], results)
    _draw_last_sections(panels[3], results)
    panel_letters(panels)
    handles, labels = panels[1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=min(len(labels), 4))
    return figure


def _draw_last_sections(axes: Axes, results: Sequence[RunResult]) -> None:
    with_scars = [(index, result) for index, result in enumerate(results) if result.scar_cycles()]
    for index, result in with_scars:
        scar = smooth_scar(result.scar(result.scar_cycles()[-1], "fixed"))
        reach, _ = scar.section_along_motion()
        x = np.linspace(reach[0], reach[-1], 401)
        unworn, worn = profile(scar, x)
        if index == with_scars[0][0]:
            axes.plot(x, unworn, color=GREY, linewidth=1.0, linestyle=(0, (3, 2)))
        axes.plot(x, worn, **variant_style(index))
        axes.set_title(f"fixed wire, {cycle_name(scar.cycle)} cycles")
    axes.set_xlabel("position along the motion x [µm]")
    axes.set_ylabel("height z [µm]")
