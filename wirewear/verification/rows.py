"""Rows and levels of the verification table, and measures of convergence."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields
from importlib.metadata import version
from itertools import pairwise
from math import isfinite, log
from pathlib import Path
from typing import TypeVar

from rich import box
from rich.markup import escape
from rich.table import Table

from wirewear.base.errors import ResultError
from wirewear.base.writing import json_text, prepared_folder, write_text, writing

Value = TypeVar("Value")


def _at(quick: Value, full: Value) -> Value:
    """A field with its values at both levels."""
    return field(default=quick, metadata={"full": full})


@dataclass(frozen=True)
class Level:
    """Meshes and relative tolerances of a level of verification, QUICK or FULL.

    A resolution is a number of elements per radius (or half-width) of the contact, in near_zone a number of grid
    points; hertz_resolutions are those of three meshes from coarse to fine, of which the last serves partial slip as
    well, under loads that enlarge the contact by `enlarged`.
    """

    name: str = _at("quick", "full")
    fidelity: str = _at("standard", "fine")  #: Level of fidelity of bodies that are meshed as in runs.
    hertz_resolutions: tuple[float, float, float] = _at((2.0, 3.0, 4.0), (2.0, 4.0, 8.0))
    enlarged: float = _at(1.6, 1.5)
    loop_resolution: float = _at(2.0, 3.0)
    line_resolution: float = _at(16.0, 32.0)
    slip_increments: int = _at(10, 16)  #: Increments of a loading branch in partial slip.
    partial_slip_wear_resolution: float = _at(4.0, 6.0)
    partial_slip_wear_tolerance: float = _at(0.5, 0.2)  #: Tolerance of the worn volume.
    partial_slip_run_resolution: float = _at(4.0, 8.0)
    partial_slip_run_tolerance: float = _at(0.3, 0.05)
    worn_line_cycles: int = _at(300, 5000)  #: Cycles of the worn line contact.
    hertz_tolerances: tuple[float, float, float] = _at((0.12, 0.03, 0.01), (0.12, 0.01, 0.01))
    ellipse_tolerance: float = _at(0.03, 0.02)
    slip_energy_tolerance: float = _at(0.15, 0.05)
    stress_tolerance: float = _at(0.02, 0.02)  #: Tolerance of the largest stress beneath a contact.
    surface_resolution: float = _at(3.5, 5.0)
    surface_tolerance: float = _at(0.05, 0.02)
    line_surface_resolution: float = _at(12.0, 18.0)
    line_surface_tolerance: float = _at(0.05, 0.03)
    yielding_fidelity: str = _at("quick", "standard")  #: Level of fidelity of bodies that yield.
    yielding_radius_tolerance: float = _at(0.1, 0.06)
    yielding_print_tolerance: float = _at(0.2, 0.2)
    near_zone_resolution: int = _at(6, 9)
    near_zone_tolerance: float = _at(0.05, 0.03)


QUICK, FULL = Level(), Level(**{one.name: one.metadata["full"] for one in fields(Level)})


def table(rows: "Sequence[Row]") -> Table:
    """A table for rich to print with one line for each row, and a caption on how many passed."""
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


def write_json(path: Path, level: str, rows: "Sequence[Row]") -> None:
    """Write version, level and all rows as JSON in one step; numbers that are not finite become null. The folder is
    created if missing. Raises ResultError if the file cannot be written, and RunError if the folder cannot be created.
    """
    document = {
        "wirewear": version("wirewear"),
        "level": level,
        "passed": all(row.passed for row in rows),
        "rows": [asdict(row) | {"passed": row.passed} for row in rows],
    }
    prepared_folder(path.parent)
    with writing(ResultError, f"cannot write the verification table to '{path}'"):
        write_text(path, json_text(document) + "\n")


@dataclass(frozen=True)
class Row:
    """A computed quantity and its closed form. error: (computed - exact) / scale, the scale being |exact| unless the
    problem names another; raw_error: without a correction for bulk compliance, None if nothing is corrected; tolerance:
    allowed |error|. order: observed order of convergence from the next coarser mesh, None without one.
    """

    problem: str
    quantity: str
    computed: float
    exact: float
    error: float
    tolerance: float
    raw_error: float | None = None
    order: float | None = None

    @property
    def passed(self) -> bool:
        return bool(isfinite(self.error) and abs(self.error) <= self.tolerance)


def compared(
    problem: str,
    quantity: str,
    computed: float,
    exact: float,
    tolerance: float,
    *,
    scale: float | None = None,
    raw: float | None = None,
    order: float | None = None,
) -> Row:
    """A row with errors relative to `scale` or, for None, to |exact|. raw: computed value without correction, None if
    there is none; order: observed order of convergence.
    """
    size = abs(exact) if scale is None else scale
    raw_error = None if raw is None else (raw - exact) / size
    return Row(problem, quantity, computed, exact, (computed - exact) / size, tolerance, raw_error, order)


def observed_order(coarse_error: float, fine_error: float, refinement: float) -> float:
    """Order q of errors ~ h^q on two meshes with the size ratio `refinement` > 1; NaN if an error is zero."""
    if coarse_error == 0.0 or fine_error == 0.0:
        return float("nan")
    return log(abs(coarse_error) / abs(fine_error)) / log(refinement)


def largest_growth(errors: Sequence[float], floor: float) -> float:
    """Largest ratio of an error to the one before it, from coarse to fine; errors below `floor` count as 0."""
    ratios = [0.0 if abs(fine) <= floor else abs(fine) / max(abs(coarse), floor) for coarse, fine in pairwise(errors)]
    return max(ratios, default=0.0)


def falling(problem: str, quantity: str, errors: Sequence[float], floor: float) -> Row:
    """A row that passes if no error, from coarse to fine, exceeds the one before; those below `floor` count as 0."""
    growth = largest_growth(errors, floor)
    return Row(problem, f"{quantity}: error over coarser mesh's, ≤ 1", growth, 1.0, max(growth - 1.0, 0.0), 0.0)
