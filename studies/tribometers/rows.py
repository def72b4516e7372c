"""Rows of a CSV file of tribometers, read and checked."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from wirewear.base.delimited import read_delimited
from wirewear.base.errors import RecordError
from wirewear.base.words import as_sentence, shown
from wirewear.reference import Elastic
from wirewear.test.materials import material_named

from .contact_stiffness import ASSUMED

#: Columns that give the elastic constants of materials that no table knows: of both bodies, and of the specimen where
#: it differs.
CONSTANTS = ("youngs_modulus_MPa", "poissons_ratio")
SPECIMEN_CONSTANTS = ("specimen_youngs_modulus_MPa", "specimen_poissons_ratio")

CONTACTS = ("cylinder-on-flat", "crossed-cylinders")
NUMBERS = (
    "radius_mm", "normal_load_N", "contact_half_width_mm", "friction_max", "displacement_amplitude_um",
    "slip_amplitude_um", "measured_stiffness_N_per_um",
)  # fmt: skip
OPTIONAL = ("cycles", "contact_length_mm", "theoretical_stiffness_N_per_um")
REQUIRED = ("contact", "materials", *NUMBERS)

_OTHER_SIGNS = {";": "semicolons", "\t": "tabs"}  #: What other programs than this one expect between fields.

#: Beyond these no test makes sense in the units of the columns, and arithmetic would end in infinities.
_LEAST, _MOST = 1e-9, 1e9


@dataclass(frozen=True)
class TribometerRow:
    """One reduced loop as published: fields as the columns of the file, None where an optional one is empty.

    pad: elastic constants of the cylinder, or of the first of two; specimen: of the flat, or of the second.
    """

    source: str
    contact: str
    pad: Elastic
    specimen: Elastic
    radius_mm: float
    normal_load_N: float
    contact_half_width_mm: float
    friction_max: float
    displacement_amplitude_um: float
    slip_amplitude_um: float
    measured_stiffness_N_per_um: float
    cycles: float | None
    contact_length_mm: float | None
    theoretical_stiffness_N_per_um: float | None

    @property
    def crossed(self) -> bool:
        """Whether the contact is a point contact of crossed cylinders, not a line contact on a flat."""
        return self.contact == "crossed-cylinders"


def read_rows(path: Path) -> tuple[TribometerRow, ...]:
    """Read the rows of a CSV file.
    Raises RecordError, in one sentence with line and column, if the file cannot be read, or a value is missing or
    wrong.
    """
    text = read_delimited(path)
    names, rows = text.names, [(line, cells) for line, cells in text.rows() if any(cells)]
    if not names:
        raise RecordError(f"{path} is empty; its first line should name the columns {', '.join(REQUIRED)}.")
    if missing := [name for name in REQUIRED if name not in names]:
        if sign := next((sign for sign in _OTHER_SIGNS if len(names) == 1 and sign in names[0]), None):
            raise RecordError(
                f"{path}, line 1: fields stand apart by {_OTHER_SIGNS[sign]}, where a table of tribometers has "
                "commas, and points in its numbers."
            )
        raise RecordError(f"{path}, line 1: these columns are missing: {', '.join(missing)}.")
    if twice := [name for name, count in Counter(names).items() if name and count > 1]:
        raise RecordError(f"{path}, line 1: the column {twice[0]} is named more than once.")
    if not rows:
        raise RecordError(f"{path}, line 1: there are no rows below the column names.")
    return tuple(_row(names, cells, path, line) for line, cells in rows)


def _row(names: Sequence[str], cells: list[str], path: Path, line: int) -> TribometerRow:
    where = f"{path}, line {line}"
    if len(cells) > len(names):
        raise RecordError(f"{where}: there are {len(cells)} values for {len(names)} columns.")
    return row_of(dict(zip(names, cells, strict=False)), where, f"line {line}")


def row_of(values: Mapping[str, str], where: str, source: str = "") -> TribometerRow:
    """A row of the table from its texts by column. where: names their origin in messages. source: for an empty column
    `source`. Raises RecordError, in one sentence, if a value is missing or wrong.
    """
    if values.get("contact") not in CONTACTS:
        raise RecordError(
            f"{where}, column contact: {shown(values.get('contact', ''))} is none of {', '.join(CONTACTS)}."
        )
    pad, specimen = _materials(values, where)
    numbers: dict[str, Any] = {name: _number(values, name, where) for name in NUMBERS}
    numbers |= {name: _number(values, name, where) if values.get(name) else None for name in OPTIONAL}
    row = TribometerRow(
        source=values.get("source") or source, contact=values["contact"], pad=pad, specimen=specimen, **numbers
    )
    _require_consistent(row, where)
    return row


def _materials(values: Mapping[str, str], where: str) -> tuple[Elastic, Elastic]:
    """Of both bodies: by their own constants where they are given, else by name."""
    own, specimens = (_constants(values, columns, where) for columns in (CONSTANTS, SPECIMEN_CONSTANTS))
    if own is not None:
        return own, specimens or own
    named = (values.get("materials") or "").split("/")
    if len(named) > 2:
        raise RecordError(f"{where}, column materials: {values['materials']!r} names more than two materials.")
    try:
        pad, specimen = (material_named(name).elastic for name in (named[0], named[-1]))
    except ValueError as problem:
        raise RecordError(
            as_sentence(f"{where}, column materials: {str(problem).removeprefix('is ')}")
            + f" Or give {' and '.join(CONSTANTS)} in columns of their own."
        ) from None
    return pad, specimens or specimen


def _constants(values: Mapping[str, str], columns: tuple[str, str], where: str) -> Elastic | None:
    """Of one body; None where none are given."""
    if not any(values.get(column) for column in columns):
        return None
    modulus, ratio = (_number(values, column, where) for column in columns)
    if ratio >= 0.5:
        raise RecordError(f"{where}, column {columns[1]}: {ratio:g} stands where a number below 0.5 should.")
    return Elastic(modulus, ratio)


def _number(values: Mapping[str, str], name: str, where: str) -> float:
    text = values.get(name, "")
    try:
        value = math.nan if "_" in text else float(text)
    except ValueError:
        value = math.nan
    if not _LEAST <= value <= _MOST:
        raise RecordError(
            f"{where}, column {name}: {text!r} stands where a positive number ({_LEAST:g} ... {_MOST:g}) should."
        )
    return value


def _require_consistent(row: TribometerRow, where: str) -> None:
    if row.slip_amplitude_um > row.displacement_amplitude_um:
        raise RecordError(f"{where}, column slip_amplitude_um: the slip amplitude exceeds the displacement amplitude.")
    if row.crossed and row.contact_length_mm is not None:
        raise RecordError(f"{where}, column contact_length_mm: crossed cylinders touch in a point; leave it empty.")
    widest = row.radius_mm if row.crossed else ASSUMED.widest_contact(row.radius_mm)
    if row.contact_half_width_mm > widest:
        raise RecordError(
            f"{where}, column contact_half_width_mm: {row.contact_half_width_mm:g} mm is not small against the "
            f"bodies of this radius, as contact theory requires; it should be at most {widest:g} mm."
        )
