"""Studies of a strand's contacts, to be simulated by `wirewear run`.

A contact has a study if its motion is known and at least 0.1 µm in amplitude.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from math import degrees
from pathlib import Path
from typing import Any

from wirewear.base.errors import ResultError
from wirewear.base.files import toml_text
from wirewear.base.writing import write_text, writing
from wirewear.kinds import any_study
from wirewear.strand.contacts import LoadedWire, WireContact
from wirewear.strand.estimates import ContactEstimate
from wirewear.strand.tables import RopeTables
from wirewear.test import LineStudy, Study

_CROSSED = (
    "Straight wires in place of helices. The slip is that at the neutral axis, bulk stresses are those of the\n"
    "extrados, in step with it: each is worst there, a quarter of a lay apart."
)
_LINE = (
    "One millimetre of the line. Wires slide along it, a line contact in plane strain slides across: load, slip and\n"
    "bulk stress along the motion are kept. Energy and wear of a contact that slides as a whole are the same."
)


def file_name(contact_name: str) -> str:
    """Name of the file with the study of the contact with this name."""
    return re.sub(r"[^a-z0-9]+", "_", contact_name.lower()).strip("_") + ".toml"


def has_study(found: ContactEstimate) -> bool:
    """True if the contact's motion, slip and elastic displacement, is known and at least 0.1 µm in amplitude."""
    # Smallest amplitude of a study.
    return _amplitude_um(found) >= 0.1


def _amplitude_um(found: ContactEstimate) -> float:
    return 1e3 * (found.contact.slip_amplitude_mm + found.elastic_mm)


def study_tables(found: ContactEstimate, rope: RopeTables) -> dict[str, object] | None:
    """Nested tables of a contact's study, as a file states them; None if it has none."""
    contact = found.contact
    lower, upper, amplitude_um = contact.lower, contact.upper, _amplitude_um(found)
    if not isinstance(lower, LoadedWire) or not has_study(found):
        return None
    crossing, motion = degrees_of(contact)
    conditions = {
        "normal_load_N": _figure(contact.load_N),
        "displacement_amplitude_um": _figure(amplitude_um),
        "frequency_Hz": rope.conditions.frequency_Hz,
        "cycles": rope.conditions.cycles,
    }
    friction = {"friction": rope.contact.friction}
    wear = {} if rope.wear is None else {"wear": _wear(rope.wear.energy_wear_coefficient_mm3_per_J, contact.is_line)}
    life = {} if rope.life is None else {"life": rope.life.model_dump(mode="json", exclude_unset=True)}
    head = {"format": 1, "name": f"{rope.name}: {contact.name}"}
    if contact.is_line:
        height = {"height_mm": _figure(0.5 * min(lower.wire.diameter_mm, upper.wire.diameter_mm))}
        bodies = {
            "pad": {
                "radius_mm": _figure(0.5 / contact.gap_per_mm[1]),
                **_material(upper),
                **height,
                "bulk": _bulk(upper),
            },
            "specimen": {**_material(lower), **height, "bulk": _bulk(lower)},
        }
        return {
            **head, "kind": "line-contact", **bodies, "conditions": conditions,
            "contact": {**friction, "length_mm": contact.length_mm}, **wear, **life,
        }  # fmt: skip
    of_upper = {"diameter_mm": upper.wire.diameter_mm, **_material(upper)}
    shared = {"diameter_mm": lower.wire.diameter_mm, **_material(lower)}
    own = {key: value for key, value in of_upper.items() if shared.get(key) != value}
    wires = {
        **shared,
        "crossing_angle_deg": _figure(crossing),
        "moving": {"bulk": _bulk(lower)},
        "fixed": {**own, "bulk": _bulk(upper)},
    }
    conditions["motion_angle_deg"] = _figure(motion)
    return {
        **head,
        "kind": "crossed-wires",
        "wires": wires,
        "conditions": conditions,
        "contact": friction,
        **wear,
        **life,
    }


def studies_of(found: Sequence[ContactEstimate], rope: RopeTables) -> dict[str, Study | LineStudy]:
    """The study of each contact that has one, by the contact's name.

    Raises StudyError, in one sentence, if a value lies outside the range of a study.
    """
    tables = {one.contact.name: study_tables(one, rope) for one in found}
    return {name: any_study(own, f"the study of {name!r}") for name, own in tables.items() if own is not None}


def write_studies(found: Sequence[ContactEstimate], rope: RopeTables, folder: Path) -> dict[str, Path]:
    """Write the study of each contact that has one to `folder`, and return the files by the contacts' names.

    Raises ResultError if the folder cannot be written; StudyError as `studies_of` does.
    """
    studies_of(found, rope)
    return dict(_written(found, rope, folder))


def _written(found: Sequence[ContactEstimate], rope: RopeTables, folder: Path) -> Iterator[tuple[str, Path]]:
    with writing(ResultError, f"cannot write studies to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        for one in found:
            tables = study_tables(one, rope)
            if tables is not None:
                path = folder / file_name(one.contact.name)
                comment = "\n".join([*notes(one), _LINE if one.contact.is_line else _CROSSED])
                text = "".join(f"# {line}\n" for line in comment.splitlines()) + toml_text(tables)
                yield one.contact.name, write_text(path, text)


def notes(found: ContactEstimate) -> list[str]:
    """Sentences on a contact whose estimates need caution, as it yields, arches, or lies on a sheave; else empty."""
    contact, said = found.contact, []
    if found.yield_ratio > 2.0:
        said.append(
            f"{contact.name}: far beyond yield. The elastic peak pressure, {found.peak_pressure_MPa:.0f} MPa, is "
            f"{found.yield_ratio:.2g} times that of first yield: the estimates are of wires that do not flow; the "
            f"plastic area is some {found.plastic_area_mm2:.2g} mm²."
        )
    elif found.yield_ratio > 1.0:
        said.append(
            f"{contact.name}: yields. The elastic peak pressure, {found.peak_pressure_MPa:.0f} MPa, is "
            f"{found.yield_ratio:.2g} times that of first yield."
        )
    if contact.sort == "side by side":
        said.append(f"{contact.name}: the layer arches, and does not press on what lies below.")
    if contact.sort == "sheave":
        said.append(f"{contact.name}: load by one crown at a time, an estimate; how it creeps there is not computed.")
    return said


def _material(wire: LoadedWire) -> dict[str, Any]:
    own = wire.wire
    yields = {} if own.yield_stress_MPa is None else {"yield_stress_MPa": own.yield_stress_MPa}
    if own.material is not None:
        return {"material": own.material, **yields}
    elastic = {"youngs_modulus_MPa": own.elastic.youngs_modulus_MPa, "poissons_ratio": own.elastic.poissons_ratio}
    return elastic | yields


def _bulk(wire: LoadedWire) -> dict[str, float]:
    found = {
        "axial_stress_MPa": wire.axial_MPa,
        "axial_stress_amplitude_MPa": wire.axial_amplitude_MPa,
        "bending_stress_MPa": wire.bending_MPa,
        "bending_stress_amplitude_MPa": wire.bending_amplitude_MPa,
    }
    return {key: _figure(value) for key, value in found.items() if value}


def _wear(coefficient: float, is_line: bool) -> Mapping[str, float]:
    if not is_line:
        return {"energy_wear_coefficient_mm3_per_J": coefficient}
    return {f"{body}_energy_wear_coefficient_mm3_per_J": 0.5 * coefficient for body in ("pad", "specimen")}


def _figure(value: float) -> float:
    """Value rounded to six digits."""
    return float(f"{value:.6g}")


def degrees_of(contact: WireContact) -> tuple[float, float]:
    """(crossing angle, 0 to 180°, direction of slip, −90 to 90°), as a study of crossed wires states them.

    Both are about the outward normal; the lower wire is the driven one. Axis, direction around it and outward normal
    form a left-handed system.
    """
    crossing = degrees(contact.lower_rad - contact.upper_rad) % 180.0
    motion = degrees(contact.lower_rad - contact.motion_rad)
    return crossing, (motion + 90.0) % 180.0 - 90.0
