"""A run as a moving picture: its loop and the fixed wire's scar, one frame for each recorded cycle."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from wirewear.errors import ResultError
from wirewear.files import write_bytes, writing
from wirewear.pictures.colours import DEPTH_COLOURS, GREY, VARIANT_COLOURS
from wirewear.pictures.scar_maps import draw_map
from wirewear.pictures.smooth import worn_half_extent
from wirewear.pictures.smooth_loops import smooth_loop
from wirewear.pictures.style import cycle_name, new_figure, round_below, scale_bar, sliding_arrow, styled
from wirewear.results import RunResult

#: Milliseconds of a frame and of the last one; dots per inch.
FRAME_ms, LAST_ms, DOTS_PER_INCH = 700, 2500, 100

HEIGHT_in = 3.2


def animation(result: RunResult, path: Path) -> Path:
    """Write the moving picture as GIF and return its path.

    Raises:
        ResultError: there is no cycle of which both a loop and scars are recorded, or the file cannot be written.
    """
    from PIL import Image

    cycles = sorted(set(result.scar_cycles()) & {loop.cycle for loop in result.loops})
    if not cycles:
        raise ResultError("no loop and scars of one cycle are recorded, so that nothing can be shown in motion")
    frames = []
    with styled():
        for cycle in cycles:
            image = BytesIO()
            _frame(result, cycle, cycles).savefig(image, format="png", dpi=DOTS_PER_INCH)
            frames.append(Image.open(image).convert("RGB"))
    # The last frame has every colour of the scale.
    palette = frames[-1].quantize(255)
    first, *others = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    durations = [FRAME_ms] * (len(frames) - 1) + [LAST_ms]
    moving = BytesIO()
    first.save(moving, format="GIF", save_all=True, append_images=others, duration=durations, loop=0)
    with writing(ResultError, f"cannot write the moving picture {path}"):
        path.parent.mkdir(parents=True, exist_ok=True)
        return write_bytes(path, moving.getvalue())


def _frame(result: RunResult, cycle: int, cycles: Sequence[int]) -> Figure:
    """Loop and scar of one cycle; axes and colours are those of all cycles."""
    scars = [result.scar(one, "fixed") for one in cycles]
    half_x, half_y = (1.25 * half for half in worn_half_extent(scars))
    norm = Normalize(0.0, max(scar.max_depth_um for scar in scars) or 1.0)
    figure = new_figure(HEIGHT_in)
    left, right = figure.subplots(1, 2)
    curves = {one: smooth_loop(result.loop(one)) for one in cycles}
    left.plot(*curves[cycles[0]], color=GREY, linewidth=0.9)
    left.plot(*curves[cycle], color=VARIANT_COLOURS[0])
    for axis, values in (("x", 0), ("y", 1)):
        reach = 1.06 * max(float(np.abs(curve[values]).max()) for curve in curves.values())
        getattr(left, f"set_{axis}lim")(-reach, reach)
    left.set_xlabel("displacement δ [µm]")
    left.set_ylabel("tangential force Q [N]")
    left.set_title(f"{result.label}: cycle {cycle_name(cycle)}")
    scar = result.scar(cycle, "fixed")
    draw_map(right, scar, half_x, half_y, norm)
    right.set_title(f"fixed wire, deepest {scar.max_depth_um:.3g} µm")
    right.set_xlabel("x [µm]")
    right.set_ylabel("y [µm]")
    sliding_arrow(right)
    scale_bar(right, round_below(0.4 * half_x))
    figure.colorbar(ScalarMappable(norm, DEPTH_COLOURS), ax=right, label="worn depth [µm]", shrink=0.8, pad=0.02)
    return figure
