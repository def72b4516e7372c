"""Tests of maps as a table, as JSON and as rows of a CSV file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

from wirewear.base.frame import figure
from wirewear.base.quantity import counted
from wirewear.faces.maps_values import REGIMES, MappedTest, lines_of
from wirewear.views.regression import RegressionLine

#: Rows of the table and of the CSV file of crossed wires: its heading there, here, and its digits here.
COLUMNS = (
    ("normal_load_N", "P [N]", 3),
    ("displacement_amplitude_um", "δa [µm]", 3),
    ("slip_amplitude_um", "δ0 [µm]", 3),
    ("energy_ratio", "A", 2),
    ("system_free_ratio", "B", 2),
    ("friction", "µ", 3),
    ("regime", "regime", 0),
    ("energy_J", "ΣE_d [J]", 3),
    ("volume_mm3", "V [mm³]", 3),
    ("wear_coefficient_mm3_per_J", "V/ΣE_d [mm³/J]", 3),
    ("repeats", "tests", 0),
    ("cracks", "cracks", 0),
)


#: What is given per millimetre of line contacts: its heading there, and here.
PER_MM = {
    "normal_load_N": ("normal_load_N_per_mm", "P [N/mm]"),
    "energy_J": ("energy_J_per_mm", "ΣE_d [J/mm]"),
    "volume_mm3": ("volume_mm3_per_mm", "V [mm³/mm]"),
}


def columns_of(tests: Sequence[MappedTest]) -> tuple[tuple[str, str, int], ...]:
    """Rows of the table of tests that are all of one kind of contact."""
    if not tests[0].per_mm:
        return COLUMNS
    return tuple((*PER_MM.get(name, (name, heading)), digits) for name, heading, digits in COLUMNS)


def row_of(test: MappedTest) -> dict[str, Any]:
    """One test by the names of its columns; slip and criteria are those of the last cycle, None where not known."""
    last = test.sliding[-1]
    row = {
        "test": test.name,
        "source": test.source,
        "normal_load_N": test.normal_load_N,
        "displacement_amplitude_um": test.displacement_amplitude_um,
        "slip_amplitude_um": test.slip_amplitude_um[-1],
        "energy_ratio": last.energy_ratio,
        "system_free_ratio": last.system_free_ratio,
        "friction": test.friction,
        "regime": test.regime,
        "energy_J": test.energy_J,
        "volume_mm3": test.volume_mm3,
        "wear_coefficient_mm3_per_J": test.volume_mm3 / test.energy_J if test.energy_J > 0.0 else float("nan"),
        "repeats": test.repeats,
        "cracks": test.cracks,
    }
    if test.per_mm:
        row = {PER_MM[key][0] if key in PER_MM else key: value for key, value in row.items()}
    # NaN alone differs from itself.
    return {key: None if value != value else value for key, value in row.items()}  # noqa: PLR0124


def tests_table(tests: Sequence[MappedTest]) -> Table:
    """All tests, numbered as on the page, to be printed with rich."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("", "test", "source"):
        table.add_column(heading, overflow="fold")
    columns = columns_of(tests)
    for _, heading, digits in columns:
        table.add_column(heading, justify="right" if digits else "left")
    for number, test in enumerate(tests, 1):
        row = row_of(test)
        shown = (_shown(row[name], digits) for name, _, digits in columns)
        table.add_row(str(number), Text(test.name), test.source, *shown)
    return table


def _shown(value: Any, digits: int) -> str:
    return figure(value, digits) if digits else str("–" if value is None else value)


def sentences(tests: Sequence[MappedTest]) -> list[str]:
    """What the tests come to, for a reader in a hurry."""
    counts = {regime: sum(test.regime == regime for test in tests) for regime in REGIMES}
    named = [
        f"{count} in {regime}" if regime != "mixed" else f"{count} mixed" for regime, count in counts.items() if count
    ]
    said = [f"{counted(len(tests))} test{'' if len(tests) == 1 else 's'}: {', '.join(named)}."]
    through, threshold = lines_of(tests)
    if through is not None:
        said.append(f"Wear: V = {_interval(through)} · ΣE_d over {counted(through.tests)} worn specimen pairs.")
    if threshold is not None:
        low, high = threshold.threshold_interval95
        told = "no threshold can be told from zero" if low <= 0.0 <= high else "a threshold is told from zero"
        unit = "J/mm" if tests[0].per_mm else "J"
        energy = f"E_th {figure(threshold.threshold_J)} {unit} ({figure(low)} to {figure(high)})"
        said.append(f"With a threshold, V = {_interval(threshold)} · (ΣE_d − E_th), {energy}: {told}.")
    return said


def _interval(line: RegressionLine) -> str:
    low, high = line.slope_interval95
    within = f" ({figure(low)} to {figure(high)})" if line.tests > 1 else ""
    return f"{figure(line.slope_mm3_per_J)}{within} mm³/J"


def maps_json(tests: Sequence[MappedTest]) -> dict[str, Any]:
    """``{"tests": [row_of(test), ...], "through_origin": {...}, "with_threshold": {...}}``; lines may be null."""
    through, threshold = lines_of(tests)
    return {
        "tests": [row_of(test) for test in tests],
        "through_origin": _line_json(through),
        "with_threshold": _line_json(threshold),
    }


def _line_json(line: RegressionLine | None) -> dict[str, Any] | None:
    if line is None:
        return None
    known = line.tests > 1
    return {
        "slope_mm3_per_J": line.slope_mm3_per_J,
        "slope_interval95": list(line.slope_interval95) if known else None,
        "threshold_J": line.threshold_J,
        "threshold_interval95": list(line.threshold_interval95),
        "explained": None if line.explained != line.explained else line.explained,
        "tests": line.tests,
    }
