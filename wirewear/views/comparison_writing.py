"""The files that a comparison leaves: a page, its pictures, and the table as CSV and JSON."""

from collections.abc import Callable, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from rich import box
from rich.table import Table
from rich.text import Text

from wirewear.base.errors import RecordError
from wirewear.base.quantity import counted
from wirewear.base.writing import json_text, write_csv, write_text, writing
from wirewear.pictures.colours import DEPTH_COLOURS
from wirewear.pictures.style import WIDTH_in, cycle_name, new_figure, panel_letters, round_below, save, scale_bar, svg
from wirewear.records.values import Array
from wirewear.views.comparison import RecordComparison
from wirewear.views.comparison_page import page, worst_differences
from wirewear.views.comparison_pictures import BAND, MEASURED, SIMULATED, evolution_picture, loops_picture
from wirewear.views.differences import REPEATS
from wirewear.views.registration import ScarPair

#: Blue where the simulation wears too little, red where it wears too much.
DIFFERENCE_COLOURS = "RdBu_r"

TABLE_NAME, PAGE_NAME = "differences", "comparison.html"


def differences_table(comparison: RecordComparison) -> Table:
    """The largest difference of each quantity over its cycles, to be printed with rich."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title="Largest differences", title_justify="left")
    table.add_column("from")
    table.add_column("quantity")
    for heading in ("cycle", "difference", "in scatters"):
        table.add_column(heading, justify="right", no_wrap=True)
    worst = worst_differences(comparison.differences)
    for row in worst:
        ratio = "–" if row.in_scatter is None else f"{row.in_scatter:+.2g}"
        difference = f"{row.difference:+.3g} {row.unit}".strip()
        cycle = "" if row.cycle is None else counted(row.cycle)
        table.add_row(row.source, Text(row.quantity), cycle, difference, ratio)
    if any(row.in_scatter is None and row.basis != REPEATS for row in worst):
        table.caption = "– one repeat tells no scatter: differences of quantities with a dash cannot be judged"
    return table


def maps_picture(pairs: Sequence[ScarPair]) -> Figure:
    """One row for each wire: measured mean, simulated, and simulated minus measured; one scale for each kind."""
    deepest = max(float(np.nanmax([pair.mean, pair.simulated])) for pair in pairs) or 1.0
    worst = max(float(np.nanmax(np.abs(pair.simulated - pair.mean))) for pair in pairs) or 1e-3
    half_x, half_y = (max(float(np.abs(getattr(pair, n)).max()) for pair in pairs) for n in ("x_um", "y_um"))
    panel_in = 0.80 * WIDTH_in / 3
    figure = new_figure(len(pairs) * (panel_in * half_y / half_x + 0.30) + 1.3)
    grid = figure.subplots(len(pairs), 3, sharex=True, sharey=True, squeeze=False)
    depth_norm, difference_norm = Normalize(0.0, deepest), Normalize(-worst, worst)
    for row, pair in zip(grid, pairs, strict=True):
        for axes, values, title in zip(
            row, (pair.mean, pair.simulated, pair.simulated - pair.mean), ("measured", "simulated", "difference"),
            strict=True,
        ):  # fmt: skip
            difference = title == "difference"
            colours, norm = (DIFFERENCE_COLOURS, difference_norm) if difference else (DEPTH_COLOURS, depth_norm)
            axes.pcolormesh(pair.x_um, pair.y_um, values.T, cmap=colours, norm=norm, shading="gouraud", rasterized=True)
            axes.set_title(f"{pair.wire} wire, {title}")
            axes.set_aspect("equal")
            axes.grid(visible=False)
            axes.spines[:].set_visible(True)
            axes.set_xlim(-half_x, half_x)
            axes.set_ylim(-half_y, half_y)
        row[0].set_ylabel("y [µm]")
        scale_bar(row[0], round_below(0.4 * half_x))
    for axes in grid[-1]:
        axes.set_xlabel("x, sliding [µm]")
    for columns, colours, norm, label in (
        (grid[:, :2], DEPTH_COLOURS, depth_norm, "worn depth [µm]"),
        (grid[:, 2:], DIFFERENCE_COLOURS, difference_norm, "simulated − measured [µm]"),
    ):
        bar = ScalarMappable(norm, colours)
        figure.colorbar(bar, ax=columns, label=label, location="bottom", aspect=40 if columns.shape[1] > 1 else 20)
    panel_letters(list(grid.flat))
    return figure


def sections_picture(pairs: Sequence[ScarPair]) -> Figure:
    """Depth along the motion and across it, through the origin; one row for each wire, all on one scale."""
    figure = new_figure(2.1 * len(pairs) + 0.7)
    grid = figure.subplots(len(pairs), 2, sharex=True, sharey=True, squeeze=False)
    for row, pair in zip(grid, pairs, strict=True):
        along = [pair.section_along(depth) for depth in pair.measured]
        across = [pair.section_across(depth) for depth in pair.measured]
        _draw_section(row[0], pair.x_um, np.stack(along), pair.section_along(pair.simulated))
        _draw_section(row[1], pair.y_um, np.stack(across), pair.section_across(pair.simulated))
        row[0].set_title(f"{pair.wire} wire along the motion, {cycle_name(pair.simulated_cycle)} cycles")
        row[1].set_title(f"{pair.wire} wire across it")
        row[0].set_ylabel("worn depth [µm]")
    grid[0, 0].invert_yaxis()
    grid[-1, 0].set_xlabel("x at y = 0 [µm]")
    grid[-1, 1].set_xlabel("y at x = 0 [µm]")
    panel_letters(list(grid.flat))
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure


def _draw_section(axes: Axes, at: Array, tests: Array, simulated: Array) -> None:
    known = np.isfinite(tests).all(axis=0)
    many = len(tests) > 1
    if many:
        low, high = tests[:, known].min(axis=0), tests[:, known].max(axis=0)
        axes.fill_between(at[known], low, high, color=BAND, linewidth=0, label=f"range of {len(tests)} repeats")
    label = "measured, mean" if many else "measured"
    axes.plot(at[known], tests[:, known].mean(axis=0), color=MEASURED, linewidth=0.8, label=label)
    axes.plot(at, simulated, color=SIMULATED, linewidth=1.4, label="simulated")


def write_comparison(comparison: RecordComparison, folder: Path) -> list[Path]:
    """Write one self-contained HTML page, its pictures, and the table as CSV and JSON; return their paths.

    Raises:
        RecordError: the folder cannot be written.
    """
    drawings: dict[str, Callable[[], Figure]] = {
        "loops": partial(loops_picture, comparison.loops),
        "evolution": partial(evolution_picture, comparison.result, comparison.record, comparison.loops),
    }
    if comparison.scars:
        drawings["scar_maps"] = partial(maps_picture, comparison.scars)
        drawings["scar_sections"] = partial(sections_picture, comparison.scars)
    with writing(RecordError, f"cannot write the comparison to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        pictures = {name: save(draw, folder / f"{name}.png") for name, draw in drawings.items()}
        texts = {
            f"{TABLE_NAME}.json": json_text(comparison.to_json()),
            PAGE_NAME: page(comparison, svg(drawings["scar_maps"]) if comparison.scars else None),
        }
        for name, text in texts.items():
            write_text(folder / name, text)
        table = write_csv(folder / f"{TABLE_NAME}.csv", [asdict(row) for row in comparison.differences])
    return [folder / PAGE_NAME, table, folder / f"{TABLE_NAME}.json", *pictures.values()]
