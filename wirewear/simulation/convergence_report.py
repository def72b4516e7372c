"""What a convergence study found, as a table for the terminal and as a CSV file."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from io import StringIO
from pathlib import Path

from rich import box
from rich.markup import escape
from rich.table import Table

from wirewear.errors import ResultError
from wirewear.files import write_text, writing
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
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    of_limits = [f"{what}_{name}" for name in rows[0].limits for what in ("limit", "error", "order")]
    writer.writerow(["figure", "unit", "base", *rows[0].refined, *of_limits, "limit", "error"])
    for row in rows:
        limits = [
            "" if part is None else part
            for limit in row.limits.values()
            for part in (limit.value, limit.error, limit.order)
        ]
        writer.writerow(
            [row.figure.name, row.figure.unit, row.value, *row.refined.values(), *limits, row.limit, row.error]
        )
    path = folder / CSV_FILE_NAME
    with writing(ResultError, f"cannot write {path}"):
        return write_text(path, text.getvalue())
