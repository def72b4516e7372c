"""What a convergence study found, as a table for the terminal and as a CSV file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich import box
from rich.markup import escape
from rich.table import Table

from wirewear.base.errors import ResultError
from wirewear.base.writing import write_csv, writing
from wirewear.simulation.convergence import Converged

CSV_FILE_NAME = "convergence.csv"


def convergence_table(rows: Sequence[Converged]) -> Table:
    """Each figure with its change by every refinement, and the limit with its error."""
    shown = Table(box=box.SIMPLE, pad_edge=False, title="The last cycle's figures and where they tend to")
    shown.add_column("figure")
    shown.add_column("value", justify="right", no_wrap=True)
    for run in rows[0].refined:
        name, factor = run.rsplit("-", 1)
        shown.add_column(f"{name}\n× {factor}", justify="right", no_wrap=True)
    for heading in ("limit", "error of\nlimit", "value off\nlimit by"):
        shown.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        changes = (_percent(value - row.value, row.value) for value in row.refined.values())
        shown.add_row(
            escape(f"{row.figure.name} [{row.figure.unit}]"),
            f"{row.value:.5g}",
            *changes,
            f"{row.limit:.5g}",
            _percent(row.error, row.limit, sign=""),
            _percent(row.value - row.limit, row.limit),
        )
    return shown


def _percent(part: float, whole: float, sign: str = "+") -> str:
    return f"{100.0 * part / whole:{sign}.2f} %" if whole else "–"


def write_convergence(folder: Path, rows: Sequence[Converged]) -> Path:
    """Write convergence.csv: values of all runs, the limit, order and error of each resolution and of all together.

    Raises:
        ResultError: the file cannot be written.
    """
    path = folder / CSV_FILE_NAME
    with writing(ResultError, f"cannot write {path}"):
        return write_csv(path, [_cells(row) for row in rows])


def _cells(row: Converged) -> dict[str, Any]:
    limits: dict[str, float | None] = {}
    for name, limit in row.limits.items():
        limits |= {f"limit_{name}": limit.value, f"error_{name}": limit.error, f"order_{name}": limit.order}
    first = {"figure": row.figure.name, "unit": row.figure.unit, "base": row.value}
    return {**first, **row.refined, **limits, "limit": row.limit, "error": row.error}
