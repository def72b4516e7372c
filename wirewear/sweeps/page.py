"""The page of a sweep, and the files beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.arrays import Array
from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.quantity import counted, words_of
from wirewear.base.writing import in_one_step, write_csv, write_text, writing
from wirewear.pictures.style import svg
from wirewear.sweeps import pictures
from wirewear.sweeps.running import SweepResult
from wirewear.sweeps.sensitivity import Index, indices
from wirewear.sweeps.sweep import Sweep, SweepRow, figures_named

if TYPE_CHECKING:
    import polars as pl

TABLE, FAILURES = "table", "failures.csv"

COMPLETE, FAILED = "complete", "failed"

PAGE = "sweep.html"

#: A figure that varies by less than this share over all runs is not drawn.
VARIES = 1e-6

#: Failures that the page names; the others stand in failures.csv.
MOST_NAMED = 12


def table_of(sweep: Sweep, rows: Mapping[int, SweepRow]) -> pl.DataFrame:
    """Number, varied keys, how it ended, figures; in the order of the numbers, the same however the runs were made."""
    import polars as pl

    numbers = sorted(rows)
    keys = {
        key: [float(sweep.design.points[number - 1, place]) for number in numbers]
        for place, key in enumerate(sweep.design.keys)
    }
    ended = [FAILED if rows[number].failed else COMPLETE for number in numbers]
    names = figures_named([body.name for body in sweep.study.bodies])
    figures = {name: [(rows[number].figures or {}).get(name) for number in numbers] for name in names}
    columns = {
        "run": pl.Series(numbers, dtype=pl.Int64),
        **{key: pl.Series(values, dtype=pl.Float64) for key, values in keys.items()},
        "ended": pl.Series(ended, dtype=pl.String),
        **{name: pl.Series(values, dtype=pl.Float64) for name, values in figures.items()},
    }
    return pl.DataFrame(columns)


def write_table(folder: Path, sweep: Sweep, rows: Mapping[int, SweepRow]) -> list[Path]:
    """Write table.parquet, table.csv and, if there are any, failures.csv; returns the paths.

    Raises:
        ResultError: a file cannot be written.
    """
    table = table_of(sweep, rows)
    parquet, text = folder / f"{TABLE}.parquet", folder / f"{TABLE}.csv"
    with writing(ResultError, f"cannot write the table to {folder}"):
        with in_one_step(parquet) as partial:
            table.write_parquet(partial)
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


HERE = Path(__file__).parent


def write_sweep(folder: Path, result: SweepResult) -> list[Path]:
    """Write the table and, where any run is complete, the page; returns the paths.

    Raises:
        ResultError: a file cannot be written.
    """
    written = write_table(folder, result.sweep, result.rows)
    with writing(ResultError, f"cannot write {folder / PAGE}"):
        return [*written, write_text(folder / PAGE, page(result))]


def page(result: SweepResult) -> str:
    """The page, which needs no other file."""
    figures = varying_figures(result)
    found = [i for name in pictures.drawn_among(figures) for i in indices(result.sweep.design, result.rows, name)]
    return frame.rendered(
        HERE / "page.html",
        {
            "sweep": result.sweep,
            "count": len(result.rows),
            "failures": result.failures[:MOST_NAMED],
            "failed": len(result.failures),
            "sentences": sentences(result, found),
            "pictures": _pictures(result, figures, found),
            "ranges": [_range(name, values) for name, values in figures.items()],
            "indices": found,
            "cpu_s": sum(row.cpu_s for row in result.rows.values()),
        },
        {"words": words_of, "label": pictures.label_of},
    )


def varying_figures(result: SweepResult) -> dict[str, Array]:
    """Figures of all runs (n,) that are not the same in all of them; NaN where a run failed."""
    rows = [result.rows.get(number) for number in range(1, len(result.sweep) + 1)]
    found = {}
    names = figures_named([body.name for body in result.sweep.study.bodies])
    for name in (*pictures.drawn_among(names), "worn_volume_mm3", "max_mean_pressure_MPa"):
        numbers = [None if row is None or row.figures is None else row.figures.get(name) for row in rows]
        values = np.array([np.nan if number is None else number for number in numbers], dtype=float)
        known = values[np.isfinite(values)]
        if known.size > 1 and np.ptp(known) > VARIES * np.abs(known).max():
            found[name] = values
    return found


def sentences(result: SweepResult, found: list[Index]) -> list[str]:
    """What a reader in a hurry needs to know."""
    done, failed = len(result.rows), len(result.failures)
    said = [f"{counted(done)} of {counted(len(result.sweep))} runs are done, {counted(failed)} of them failed."]
    for name in dict.fromkeys(index.figure for index in found):
        own = [index for index in found if index.figure == name]
        most = max(own, key=lambda index: index.first)
        share = f"{100.0 * most.first:.0f} ± {100.0 * most.first_error:.0f} %"
        said.append(f"{most.key} alone makes {share} of the variance of the {words_of(name)}.")
    return said


def _pictures(result: SweepResult, figures: dict[str, Array], found: list[Index]) -> list[tuple[str, str, str]]:
    """Heading, caption and SVG of each."""
    design = result.sweep.design
    drawn = {name: figures[name] for name in pictures.drawn_among(figures)}
    made: list[tuple[str, str, bytes]] = []
    if drawn:
        image = svg(lambda: pictures.draw_responses(design.factors, design.points, drawn))
        words = (
            "Each dot is a run. Lines join runs that differ in that key alone, or else medians of neighbouring runs."
        )
        made.append(("Responses", words, image))
    if found:
        words = "Shares of the variance that each key makes, with 95 % intervals."
        made.append(("Sensitivities", words, svg(lambda: pictures.draw_indices(found))))
    if {pictures.SLIP, depths := pictures.depth_among(drawn)} <= drawn.keys():
        known = np.isfinite(drawn[pictures.SLIP])
        slip, depth = drawn[pictures.SLIP][known], drawn[depths][known]
        words = "Slip amplitude and depth of the held body at the last cycle."
        made.append(("Slip against depth", words, svg(lambda: pictures.draw_front(slip, depth, depths))))
    return [(head, words, frame.inline_svg(image, f"p{n}")) for n, (head, words, image) in enumerate(made)]


def _range(name: str, values: Array) -> dict[str, Any]:
    low, middle, high = np.nanpercentile(values, [2.5, 50.0, 97.5]).tolist()
    return {"name": name, "low": low, "middle": middle, "high": high}
