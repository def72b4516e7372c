"""What other programs read: JSON without NaN and infinities, and text that a spreadsheet takes for text."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import isfinite
from typing import Any

#: Signs with which spreadsheets let a formula begin: OWASP, "CSV injection".
_BEGINS_FORMULA = ("=", "+", "-", "@", "\t", "\r")


def json_text(value: Any, indent: int | None = 2) -> str:
    """A value as JSON, which knows no number that is not finite: null stands for one."""
    return json.dumps(finite(value), indent=indent, ensure_ascii=False, allow_nan=False)


def cell(value: Any) -> Any:
    """A value for a cell of a CSV table; text that begins like a formula has an apostrophe before it."""
    return f"'{value}" if isinstance(value, str) and value.startswith(_BEGINS_FORMULA) else value


def finite(value: Any) -> Any:
    """A value of mappings, sequences and plain values with None in place of numbers that are not finite."""
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [finite(one) for one in value]
    return value
