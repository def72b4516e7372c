"""A run beside a record, by the kind of contact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import RenderableType

from wirewear.records.line_comparing import compare_line, line_differences_table, write_line_comparison
from wirewear.views.comparison import compare
from wirewear.views.comparison_writing import differences_table, write_comparison

COMPARISONS: dict[str, Callable[[Any, Any], Any]] = {"crossed-wires": compare, "line-contact": compare_line}


@dataclass(frozen=True, eq=False)
class Compared:
    """A run beside a record: `unlike` says where they are of different tests, `shown` is for a terminal."""

    unlike: str | None
    shown: Sequence[RenderableType]
    write: Callable[[Path], list[Path]]


def compared(result: Any, record: Any) -> Compared:
    """A run beside a record."""
    comparison = COMPARISONS[record.contact_kind](result, record)
    if not hasattr(comparison, "left_um"):
        table = differences_table(comparison)
        return Compared(comparison.unlike, [table], lambda folder: write_comparison(comparison, folder))
    moved = [
        f"{left:.3g} µm rms are left between the profiles of the {body}, moved by {comparison.aside_um[body]:+.0f} µm"
        for body, left in comparison.left_um.items()
    ]
    shown: list[RenderableType] = [line_differences_table(comparison), *moved]
    return Compared(comparison.unlike, shown, lambda folder: write_line_comparison(comparison, folder))
