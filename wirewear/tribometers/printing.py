"""Judged tribometers as a table and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

from wirewear.tribometers.report import Tribometer

_COLUMNS = (
    ("P [N]", "normal_load_N", "g"),
    ("µ_max", "friction_max", "g"),
    ("K_t,c [N/µm]", "contact_stiffness_N_per_um", ".4g"),
    ("stated", "stated_contact_stiffness_N_per_um", ".4g"),
    ("K_t,m", "measured_stiffness_N_per_um", ".4g"),
    ("rig", "rig_stiffness_N_per_um", ".4g"),
    ("δ0 [µm]", "slip_amplitude_um", ".4g"),
    ("predicted", "predicted_slip_amplitude_um", ".4g"),
    ("lost", "lost_um", ".3g"),
    ("in contact", "lost_in_contact_um", ".3g"),
    ("in rig", "lost_in_rig_um", ".3g"),
    ("unexplained", "unexplained_um", ".2g"),
)


def tribometers_table(rows: Sequence[Tribometer]) -> Table:
    """The figures of each row, to be printed with rich; `verdicts_table` says what they mean."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("source")
    for heading, _, _ in _COLUMNS:
        table.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        values = ((getattr(row, name), digits) for _, name, digits in _COLUMNS)
        numbers = ("–" if value is None else f"{value:{digits}}" for value, digits in values)
        table.add_row(Text(row.source), *numbers)
    return table


def verdicts_table(rows: Sequence[Tribometer]) -> Table:
    """The verdict on each row, to be printed with rich."""
    table = Table("source", "P [N]", "µ_max", "verdict", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for row in rows:
        table.add_row(Text(row.source), f"{row.normal_load_N:g}", f"{row.friction_max:g}", row.verdict)
    return table


def tribometers_json(rows: Sequence[Tribometer]) -> list[dict[str, Any]]:
    """Rows as JSON."""
    return [asdict(row) for row in rows]
