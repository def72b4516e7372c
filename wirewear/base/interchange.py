"""What other programs read: JSON without NaN and infinities, and text that a spreadsheet takes for text."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wirewear.base.writing import in_one_step

if TYPE_CHECKING:
    import polars as pl

#: Signs with which spreadsheets let a formula begin: OWASP, "CSV injection".
_BEGINS_FORMULA = r"^[=+\-@\t\r]"


def json_text(value: Any, indent: int | None = 2) -> str:
    """A value as JSON, which knows no number that is not finite: null stands for one."""
    return json.dumps(finite(value), indent=indent, ensure_ascii=False, allow_nan=False)


def write_csv(path: Path, table: pl.DataFrame | Sequence[Mapping[str, Any]]) -> Path:
    """Write a table, or its rows, in one step; text that begins like a formula has an apostrophe before it.

    Raises:
        OSError: the file cannot be written.
    """
    import polars as pl

    frame = table if isinstance(table, pl.DataFrame) else pl.DataFrame(table, infer_schema_length=None)
    with in_one_step(path) as partial:
        frame.with_columns(pl.col(pl.String).str.replace(_BEGINS_FORMULA, "'$0")).write_csv(partial)
    return path


def finite(value: Any) -> Any:
    """A value of mappings, sequences and plain values with None in place of numbers that are not finite."""
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [finite(one) for one in value]
    return value
