"""Published tribometers: how much of the applied displacement the contact's and the rig's compliance explain."""

import csv
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rich import box
from rich.table import Table

from wirewear.errors import RecordError
from wirewear.reference import (
    Elastic,
    contact_modulus,
    half_plane_line_stiffness,
    mindlin_stiffness,
    tangential_contact_modulus,
)

#: Elastic constants by the `materials` column; both bodies of a row are of one material.
MATERIALS = {"Ti-6Al-4V": Elastic(116_000.0, 0.3), "steel": Elastic(210_000.0, 0.3)}
CONTACTS = ("cylinder-on-flat", "crossed-cylinders")
NUMBERS = (
    "radius_mm",
    "normal_load_N",
    "contact_half_width_mm",
    "friction_max",
    "displacement_amplitude_um",
    "slip_amplitude_um",
    "measured_stiffness_N_per_um",
)

#: The loss counts as explained within this share of itself: what reading loops off published figures allows.
TOLERANCE = 0.10


@dataclass(frozen=True)
class Tribometer:
    """One row: its contact stiffness K_t,c, rig stiffness (None if the loop is stiffer than the contact) and losses."""

    source: str
    contact: str
    contact_stiffness_N_per_um: float
    stated_contact_stiffness_N_per_um: float | None
    measured_stiffness_N_per_um: float
    rig_stiffness_N_per_um: float | None
    slip_amplitude_um: float
    predicted_slip_amplitude_um: float
    lost_um: float
    unexplained_um: float
    verdict: str


def read_tribometers(path: Path) -> tuple[Tribometer, ...]:
    """Read and judge the rows of a CSV file.

    Raises:
        RecordError: the file cannot be read, or a value is missing or wrong; one sentence with line and column.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as problem:
        raise RecordError(f"{path} cannot be read ({problem}).") from None
    if not rows:
        raise RecordError(f"{path}, line 2: there are no rows below the column names.")
    return tuple(_judged(row, f"{path}, line {line}") for line, row in enumerate(rows, start=2))


def _judged(row: dict[str, Any], where: str) -> Tribometer:
    numbers = {name: _number(row, name, where) for name in NUMBERS}
    contact, material = row.get("contact"), row.get("materials")
    if contact not in CONTACTS:
        raise RecordError(f"{where}, column contact: {contact!r} is none of {', '.join(CONTACTS)}.")
    if material not in MATERIALS:
        raise RecordError(f"{where}, column materials: {material!r} is none of {', '.join(MATERIALS)}.")
    own = _contact_stiffness(contact, MATERIALS[material], numbers)
    measured, slip = numbers["measured_stiffness_N_per_um"], numbers["slip_amplitude_um"]
    stroke, force = numbers["displacement_amplitude_um"], numbers["friction_max"] * numbers["normal_load_N"]
    # K_t,m holds rig and contact; a round contact has crept 1.110 instead of 1 µP/K_t,c when the force passes zero.
    taken = force / measured + (0.110 * force / own if contact == "crossed-cylinders" else 0.0)
    lost = stroke - slip
    if lost < 0.0:
        raise RecordError(f"{where}, column slip_amplitude_um: the slip amplitude exceeds the displacement amplitude.")
    stated = row.get("theoretical_stiffness_N_per_um")
    return Tribometer(
        source=row.get("source") or where,
        contact=contact,
        contact_stiffness_N_per_um=own,
        stated_contact_stiffness_N_per_um=_number(row, "theoretical_stiffness_N_per_um", where) if stated else None,
        measured_stiffness_N_per_um=measured,
        rig_stiffness_N_per_um=1.0 / (1.0 / measured - 1.0 / own) if own > measured else None,
        slip_amplitude_um=slip,
        predicted_slip_amplitude_um=stroke - taken,
        lost_um=lost,
        unexplained_um=lost - taken,
        verdict=_verdict(lost, taken, stiffer=measured >= own),
    )


def _number(row: dict[str, Any], name: str, where: str) -> float:
    try:
        value = float(row.get(name) or "")
    except (TypeError, ValueError):
        value = math.nan
    if not 0.0 < value < math.inf:
        raise RecordError(f"{where}, column {name}: {row.get(name)!r} stands where a positive number should.")
    return value


def _contact_stiffness(contact: str, material: Elastic, numbers: dict[str, float]) -> float:
    """K_t,c in N/µm: Mindlin for crossed cylinders, half-planes with points 5 mm deep for a cylinder on a flat."""
    half_width = numbers["contact_half_width_mm"]
    if contact == "crossed-cylinders":
        return 1e-3 * mindlin_stiffness(tangential_contact_modulus(material, material), half_width)
    # Hertz, a² = 4(P/L)R/(πE*), solved for the length L.
    modulus = contact_modulus(material, material)
    length = 4.0 * numbers["normal_load_N"] * numbers["radius_mm"] / (math.pi * modulus * half_width**2)
    return 1e-3 * half_plane_line_stiffness(material, material, half_width, length)


def _verdict(lost: float, taken: float, *, stiffer: bool) -> str:
    if stiffer:
        return "the loop is stiffer than its contact: check the reading of displacement"
    if abs(lost - taken) <= TOLERANCE * lost:
        return "compliance explains it"
    if lost > taken:
        return f"{lost - taken:.3g} µm more are lost than compliance takes: free play or a lagging sensor"
    return f"less is lost than the peak force would take: peak friction above a plateau of {lost / taken:.0%} of it"


def tribometers_table(rows: tuple[Tribometer, ...]) -> Table:
    """One line for each row, to be printed with rich."""
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.add_column("source")
    for heading in ("K_t,c [N/µm]", "stated", "K_t,m", "rig", "δ0 [µm]", "predicted", "lost", "unexplained"):
        table.add_column(heading, justify="right")
    table.add_column("verdict")
    for row in rows:
        numbers = list(asdict(row).values())[2:-1]
        table.add_row(row.source, *("–" if value is None else f"{value:.4g}" for value in numbers), row.verdict)
    return table


def tribometers_json(rows: tuple[Tribometer, ...]) -> list[dict[str, Any]]:
    """Rows as JSON."""
    return [asdict(row) for row in rows]
