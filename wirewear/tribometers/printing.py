"""Judged tribometers as a table and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

from wirewear.tribometers.report import Tribometer

_COLUMNS = {
    "K_t,c [N/µm]": "contact_stiffness_N_per_um",
    "stated": "stated_contact_stiffness_N_per_um",
    "K_t,m": "measured_stiffness_N_per_um",
    "rig": "rig_stiffness_N_per_um",
    "δ0 [µm]": "slip_amplitude_um",
    "predicted": "predicted_slip_amplitude_um",
    "lost": "lost_um",
    "in contact": "lost_in_contact_um",
    "in rig": "lost_in_rig_um",
    "unexplained": "unexplained_um",
}


def tribometers_table(rows: Sequence[Tribometer]) -> Table:
    """One line for each row, to be printed with rich."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("source")
    for heading in _COLUMNS:
        table.add_column(heading, justify="right")
    table.add_column("verdict")
    for row in rows:
        values = (getattr(row, name) for name in _COLUMNS.values())
        numbers = ("–" if value is None else f"{value:.4g}" for value in values)
        table.add_row(Text(row.source), *numbers, row.verdict)
    return table


def tribometers_json(rows: Sequence[Tribometer]) -> list[dict[str, Any]]:
    """Rows as JSON."""
    return [asdict(row) for row in rows]
