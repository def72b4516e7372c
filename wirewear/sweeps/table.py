"""The table of a sweep: what was varied and what came out, a row for each run, as Parquet and CSV."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from wirewear.errors import ResultError
from wirewear.files import in_one_step, writing
from wirewear.files.interchange import write_csv
from wirewear.sweeps.case import FIGURES, SweepRow
from wirewear.sweeps.sweep import Sweep

if TYPE_CHECKING:
    import polars as pl

TABLE, FAILURES = "table", "failures.csv"

COMPLETE, FAILED = "complete", "failed"


def table_of(sweep: Sweep, rows: Mapping[int, SweepRow]) -> pl.DataFrame:
    """Number, varied keys, how it ended, figures; in the order of the numbers, the same however the runs were made."""
    import polars as pl

    numbers = sorted(rows)
    keys = {
        key: [float(sweep.design.points[number - 1, place]) for number in numbers]
        for place, key in enumerate(sweep.design.keys)
    }
    ended = [FAILED if rows[number].failed else COMPLETE for number in numbers]
    figures = {name: [(rows[number].figures or {}).get(name) for number in numbers] for name in FIGURES}
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
