"""The verification table on a terminal and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from rich import box
from rich.markup import escape
from rich.table import Table

from wirewear.base.errors import ResultError
from wirewear.base.folders import prepared_folder
from wirewear.base.interchange import json_text
from wirewear.base.writing import write_text, writing
from wirewear.verification.rows import Row


def table(rows: Sequence[Row]) -> Table:
    """One line for each row; a caption says how many failed."""
    failed = sum(not row.passed for row in rows)
    caption = f"{len(rows) - failed} of {len(rows)} checks passed"
    result = Table(box=box.SIMPLE, pad_edge=False, caption=caption, caption_justify="left")
    result.add_column("problem")
    result.add_column("quantity")
    for heading in ("computed", "exact", "error", "uncorrected", "tolerance", "order"):
        result.add_column(heading, justify="right", no_wrap=True)
    result.add_column("")
    for row in rows:
        result.add_row(
            escape(row.problem),
            escape(row.quantity),
            f"{row.computed:.5g}",
            f"{row.exact:.5g}",
            _error(row.error),
            "" if row.raw_error is None else _error(row.raw_error),
            _error(row.tolerance),
            "" if row.order is None else f"{row.order:.1f}",
            "[green]pass[/]" if row.passed else "[red]FAIL[/]",
        )
    return result


def _error(value: float) -> str:
    return f"{100.0 * value:.2f} %" if value == 0.0 or abs(value) >= 5e-5 else f"{value:.1e}"


def write_json(path: Path, level: str, rows: Sequence[Row]) -> None:
    """Write version, level and all rows, replacing the file in one step; numbers that are not finite become null.

    The folder is made if need be.

    Raises:
        ResultError: the file cannot be written.
        RunError: the folder cannot be made.
    """
    document = {
        "wirewear": version("wirewear"),
        "level": level,
        "passed": all(row.passed for row in rows),
        "rows": [row.as_dict() for row in rows],
    }
    prepared_folder(path.parent)
    with writing(ResultError, f"cannot write the verification table to '{path}'"):
        write_text(path, json_text(document) + "\n")
