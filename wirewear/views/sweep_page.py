"""HTML page of a sweep, and its table.

A key is a varied value of the study; a figure is a result of a run, by its column name, such as "slip_amplitude_um".
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter
from numpy.typing import NDArray

from geometry.arrays import Array
from wirewear.base import frame
from wirewear.base.errors import ResultError, RunError
from wirewear.base.frame import figure as written
from wirewear.base.units import unit_of, words_of
from wirewear.base.words import counted
from wirewear.base.writing import in_one_step, require_absent, write_csv, write_text, writing
from wirewear.pictures.style import GREY, VARIANT_COLOURS, new_figure, svg
from wirewear.sweeps.indices import Index, indices
from wirewear.sweeps.running import JOURNAL, SweepResult
from wirewear.sweeps.sweep import DEPTH, Sweep, SweepRow, VariedInput
from wirewear.views.fretting_map import draw_fretting_map, is_map

if TYPE_CHECKING:
    import polars as pl

    from wirewear.comparison.mapped_tests import MappedTest


#: Figures that are drawn, where they vary, with a depth after the first three; units and words follow from names.
_DRAWN = ("max_tangential_force_N", "dissipated_energy_mJ", "slip_amplitude_um", "mid_stroke_mean_pressure_MPa")

#: The figure that should be large in the last picture; the depth of the held body should be small.
SLIP = "slip_amplitude_um"

FEWEST = 5  #: Runs of a group, at least; fewer show no trend.

TABLE, FAILURES = "table", "failures.csv"
COMPLETE, FAILED = "complete", "failed"
PAGE = "sweep.html"
HERE = Path(__file__).parent


def depth_among(names: Iterable[str]) -> str:
    """Name of the held body's depth, the last depth among the names; "" if there is none."""
    return next((name for name in reversed([*names]) if name.startswith(DEPTH)), "")


def drawn_among(names: Iterable[str]) -> list[str]:
    """Names out of `names` of the figures that are drawn, in their order on the page."""
    known = [*names]
    return [name for name in (*_DRAWN[:3], depth_among(known), *_DRAWN[3:]) if name in known]


def label_of(name: str) -> str:
    """Column name in words with its unit, such as "slip amplitude [µm]"."""
    unit = unit_of(name)
    words = words_of(name)
    return words if unit in ("", "1") else f"{words} [{unit}]"


def draw_responses(factors: Sequence[VariedInput], points: Array, figures: dict[str, Array]) -> Figure:
    """Figure with a panel for every result (rows) and varied key (columns); dots are runs, lines connect runs that
    differ in that key. points: (n, d) values of the d keys in n runs. figures: results (n,) by name, NaN where a run
    failed.
    """
    rows = drawn_among(figures)
    figure = new_figure(1.5 * len(rows) + 0.8)
    panels = figure.subplots(len(rows), len(factors), squeeze=False, sharex="col", sharey="row")
    for row, name in enumerate(rows):
        panels[row][0].set_ylabel(label_of(name), fontsize=7)
        for column, factor in enumerate(factors):
            _response(panels[row][column], factor, points, column, figures[name])
    for column, factor in enumerate(factors):
        panels[-1][column].set_xlabel("\n".join(wrap(label_of(factor.key.rpartition(".")[2]), 24)), fontsize=7)
    figure.align_ylabels()
    return figure


def _response(axes: Axes, factor: VariedInput, points: Array, column: int, y: Array) -> None:
    known = np.isfinite(y)
    x = points[:, column]
    axes.plot(x[known], y[known], "o", color=GREY, markersize=3.2, markeredgewidth=0.0)
    if factor.logarithmic:
        axes.set_xscale("log")
        axes.xaxis.set_minor_formatter(NullFormatter())
    else:
        axes.xaxis.set_major_locator(MaxNLocator(4))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: written(value)))
    for line in lines_through(points[known], column, y[known]):
        axes.plot(*line, color=VARIANT_COLOURS[0], linewidth=1.2)
    axes.tick_params(labelsize=6.5)


def lines_through(points: Array, column: int, y: Array) -> list[tuple[Array, Array]]:
    """Lines (x, y) through runs that differ in one key alone, as on a grid; else one line through medians of
    neighbours. points: (n, d) values of the keys. column: index of the key. y: (n,) results.
    """
    others = np.delete(points, column, axis=1)
    alike = [np.flatnonzero((others == one).all(axis=1)) for one in np.unique(others, axis=0)] if others.size else []
    joined = [runs[np.argsort(points[runs, column])] for runs in alike or [np.arange(len(points))] if runs.size > 1]
    x = points[:, column]
    return [(x[runs], y[runs]) for runs in joined] or [_medians(x, y)]


def _medians(x: Array, y: Array) -> tuple[Array, Array]:
    # Medians of so many groups of runs show the trend.
    groups = min(8, x.size // FEWEST)
    if groups < 2:
        return np.empty(0), np.empty(0)
    parts = np.array_split(np.argsort(x, kind="stable"), groups)
    return np.array([np.median(x[part]) for part in parts]), np.array([np.median(y[part]) for part in parts])


def draw_indices(found: Sequence[Index]) -> Figure:
    """Figure of bars: first-order sensitivity indices, and total ones where known, with 95 % intervals; needs at least
    one.
    """
    names, keys = list(dict.fromkeys(i.figure for i in found)), list(dict.fromkeys(i.key for i in found))
    of = {(index.figure, index.key): index for index in found}
    figure = new_figure(1.1 * len(names) + 0.9)
    panels = figure.subplots(len(names), 1, squeeze=False, sharex=True)[:, 0]
    place = np.arange(len(keys), dtype=np.float64)
    totals = found[0].total is not None
    for axes, name in zip(panels, names, strict=True):
        own = [of[name, key] for key in keys]
        shift = 0.2 if totals else 0.0
        _bars(axes, place + shift, [i.first for i in own], [i.first_error for i in own], 0, "alone")
        if totals:
            values, errors = [i.total or 0.0 for i in own], [i.total_error or 0.0 for i in own]
            _bars(axes, place - shift, values, errors, 1, "with all others")
        axes.set_yticks(place, keys, fontsize=7)
        axes.set_title(words_of(name), fontsize=8)
        axes.set_xlim(min(0.0, *(i.first - i.first_error for i in own)), 1.05)
    panels[-1].set_xlabel("share of the variance")
    if totals:
        panels[0].legend(loc="lower right", fontsize=7)
    return figure


def _bars(
    axes: Axes, at: NDArray[np.floating[Any]], values: Sequence[float], errors: Sequence[float], colour: int, label: str
) -> None:
    axes.barh(
        at,
        values,
        height=0.36,
        xerr=errors,
        color=VARIANT_COLOURS[colour],
        error_kw={"elinewidth": 0.9, "capsize": 2.0},
        label=label,
    )


def draw_front(slip: Array, depth: Array, name: str) -> Figure:
    """Figure of slip amplitude over depth of all runs, and those runs of which no other has both more slip and less
    depth. slip, depth: (n,) in µm. name: of the depth's column.
    """
    figure = new_figure(3.2)
    axes = figure.subplots()
    axes.plot(depth, slip, ".", color=GREY, markersize=6, label="runs")
    best = front(slip, depth)
    axes.plot(depth[best], slip[best], "o-", color=VARIANT_COLOURS[1], markersize=4, label="no run has both better")
    axes.set(xlabel=label_of(name), ylabel=label_of(SLIP))
    axes.legend()
    return figure


def front(more: Array, less: Array) -> NDArray[np.intp]:
    """Indices of runs on the Pareto front, sorted by `less`: no other run has both a larger `more` and a smaller
    `less`. more, less: (n,) results of all runs.
    """
    order = np.lexsort([-more, less])
    chosen, best = [], -np.inf
    for place in order:
        if more[place] > best:
            best = more[place]
            chosen.append(place)
    return np.array(chosen, dtype=np.intp)


def table_of(sweep: Sweep, rows: Mapping[int, SweepRow]) -> pl.DataFrame:
    """Table with a row for each run that is done, by number: varied keys, "complete" or "failed", figures."""
    import polars as pl

    numbers = sorted(rows)
    keys = {
        key: [float(sweep.design.points[number - 1, place]) for number in numbers]
        for place, key in enumerate(sweep.design.keys)
    }
    ended = [FAILED if rows[number].failed else COMPLETE for number in numbers]
    figures = {name: [(rows[number].figures or {}).get(name) for number in numbers] for name in sweep.figures}
    columns = {
        "run": pl.Series(numbers, dtype=pl.Int64),
        **{key: pl.Series(values, dtype=pl.Float64) for key, values in keys.items()},
        "ended": pl.Series(ended, dtype=pl.String),
        **{name: pl.Series(values, dtype=pl.Float64) for name, values in figures.items()},
    }
    return pl.DataFrame(columns)


def require_no_others_tables(folder: Path) -> None:
    """Raise RunError if the folder holds a file that a sweep would write or remove, but no sweep."""
    if not (folder / JOURNAL).exists():
        names = (f"{TABLE}.parquet", f"{TABLE}.csv", FAILURES, PAGE)
        require_absent([folder / name for name in names], RunError, "")


def write_table(folder: Path, sweep: Sweep, rows: Mapping[int, SweepRow]) -> list[Path]:
    """Write table.parquet, table.csv and, if runs failed, failures.csv; return their paths. rows: runs that are done,
    by number. Raises ResultError if a file cannot be written.
    """
    table = table_of(sweep, rows)
    parquet, text = folder / f"{TABLE}.parquet", folder / f"{TABLE}.csv"
    with writing(ResultError, f"cannot write the table to {folder}"):
        with in_one_step(parquet) as partial, partial.open("wb") as file:
            table.write_parquet(file)
        write_csv(text, table)
    failed = [row for _, row in sorted(rows.items()) if row.failed]
    if not failed:
        (folder / FAILURES).unlink(missing_ok=True)
        return [parquet, text]
    return [parquet, text, _write_failures(folder / FAILURES, sweep, failed)]


def _write_failures(path: Path, sweep: Sweep, failed: Sequence[SweepRow]) -> Path:
    values = [sweep.design.values(row.number - 1) for row in failed]
    rows = [{"run": row.number, **one, "why": row.failure} for row, one in zip(failed, values, strict=True)]
    with writing(ResultError, f"cannot write {path}"):
        return write_csv(path, rows)


def write_sweep(folder: Path, result: SweepResult, tests: Sequence[MappedTest] = ()) -> list[Path]:
    """Write the table and the page; return their paths. tests: measured tests for the fretting map. Raises ResultError
    if a file cannot be written.
    """
    written = write_table(folder, result.sweep, result.rows)
    with writing(ResultError, f"cannot write {folder / PAGE}"):
        return [*written, write_text(folder / PAGE, page(result, tests))]


def page(result: SweepResult, tests: Sequence[MappedTest] = ()) -> str:
    """Self-contained HTML page of a sweep; tests: measured tests for the fretting map."""
    figures = varying_figures(result)
    found = [i for name in drawn_among(figures) for i in indices(result.sweep.design, result.rows, name)]
    return frame.rendered(
        HERE / "sweep_page.html",
        {
            "sweep": result.sweep,
            "count": len(result.rows),
            "failures": result.failures[:12],  # the others stand in failures.csv
            "failed": len(result.failures),
            "sentences": sentences(result, found),
            "pictures": _pictures(result, figures, found, tests),
            "ranges": [_range(name, values) for name, values in figures.items()],
            "indices": found,
            "cpu_s": sum(row.cpu_s for row in result.rows.values()),
        },
        {"words": words_of, "label": label_of},
    )


def varying_figures(result: SweepResult) -> dict[str, Array]:
    """Results (n,) of all planned runs by name, of those that vary among them; NaN where a run failed or is not
    done.
    """
    rows = [result.rows.get(number) for number in range(1, len(result.sweep) + 1)]
    found = {}
    for name in (*drawn_among(result.sweep.figures), "worn_volume_mm3", "max_mean_pressure_MPa"):
        numbers = [None if row is None or row.figures is None else row.figures.get(name) for row in rows]
        values = np.array([np.nan if number is None else number for number in numbers], dtype=float)
        known = values[np.isfinite(values)]
        # A figure that varies by less than this share over all runs is not drawn.
        if known.size > 1 and np.ptp(known) > 1e-6 * np.abs(known).max():
            found[name] = values
    return found


def sentences(result: SweepResult, found: list[Index]) -> list[str]:
    """Summary: how many runs are done, and which key causes most of each result's variance. found: the sensitivity
    indices; empty if they are not known.
    """
    done, failed = len(result.rows), len(result.failures)
    said = [f"{counted(done)} of {counted(len(result.sweep))} runs are done, {counted(failed)} of them failed."]
    for name in dict.fromkeys(index.figure for index in found):
        own = [index for index in found if index.figure == name]
        most = max(own, key=lambda index: index.first)
        share = f"{100.0 * most.first:.0f} ± {100.0 * most.first_error:.0f} %"
        said.append(f"{most.key} alone makes {share} of the variance of the {words_of(name)}.")
    return said


def _pictures(
    result: SweepResult, figures: dict[str, Array], found: list[Index], tests: Sequence[MappedTest]
) -> list[tuple[str, str, str]]:
    design = result.sweep.design
    drawn = {name: figures[name] for name in drawn_among(figures)}
    made: list[tuple[str, str, bytes]] = []
    if is_map(result):
        words = (
            "Each mark is a run; mixed runs slide as a whole in the first or in the last cycle alone. Lines: where "
            "the unworn contact begins to slide as a whole, by Cattaneo and Mindlin."
        )
        made.append(("Fretting map", words, svg(lambda: draw_fretting_map(result, tests))))
    if drawn:
        image = svg(lambda: draw_responses(design.factors, design.points, drawn))
        words = (
            "Each dot is a run. Lines join runs that differ in that key alone, or else medians of neighbouring runs."
        )
        made.append(("Responses", words, image))
    if found:
        words = "Shares of the variance that each key makes, with 95 % intervals."
        made.append(("Sensitivities", words, svg(lambda: draw_indices(found))))
    if {SLIP, depths := depth_among(drawn)} <= drawn.keys():
        known = np.isfinite(drawn[SLIP])
        slip, depth = drawn[SLIP][known], drawn[depths][known]
        words = "Slip amplitude and depth of the held body at the last cycle."
        made.append(("Slip against depth", words, svg(lambda: draw_front(slip, depth, depths))))
    return [(head, words, frame.inline_svg(image, f"p{n}")) for n, (head, words, image) in enumerate(made)]


def _range(name: str, values: Array) -> dict[str, object]:
    low, middle, high = np.nanpercentile(values, [2.5, 50.0, 97.5]).tolist()
    return {"name": name, "low": low, "middle": middle, "high": high}
