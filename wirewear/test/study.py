"""Studies of contacts at a point, of line contacts and of joints as values, and how they are read from TOML.

`where` names the origin of tables in messages. A variant is a set of values that replaces some of a study's own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Self, cast

from wirewear.base import kinds
from wirewear.base.errors import StudyError
from wirewear.base.files import parsed_toml, read_toml
from wirewear.base.recognising import Held, require_no_other
from wirewear.base.words import shown
from wirewear.test.any_study import AnyStudy
from wirewear.test.bodies import Body
from wirewear.test.conditions import Conditions, Contact, FidelitySettings, HolderTable, Mesh, Wear
from wirewear.test.consistency import checked_tables
from wirewear.test.fidelity import FIDELITIES, level_of
from wirewear.test.joints import JointConditions, JointContact, JointTables
from wirewear.test.kinds import kind_named
from wirewear.test.line_bodies import Pad, Specimen
from wirewear.test.lines import LineConditions, LineContactTable, LineMeshing, LineTables, LineWear
from wirewear.test.tables import ContactTables, StudyTables
from wirewear.test.wires import Wires

FILE_KEYS = ("profile_file", "file")  #: Keys that name a file.
#: Names of the tables that a study of several contacts has beside the usual ones.
SEVERAL = frozenset({"contacts", "span"})


class Study(AnyStudy[ContactTables]):
    """A study of a contact at a point, with the tables of its keys as attributes."""

    of: ClassVar = ContactTables

    conditions: Conditions
    contact: Contact
    wear: Wear | None
    holder: HolderTable
    mesh: Mesh

    @property
    def wires(self) -> Wires:
        """The table [wires] of a study of crossed wires; studies of other kinds have none (AttributeError)."""
        return cast("StudyTables", self.tables).wires

    @cached_property
    def bodies(self) -> tuple[Body, Body]:
        """(driven body, held body) as they are meshed; the held one, above, is held by the rig's springs."""
        return self.tables.bodies_of_test()

    @property
    def motion_angle_deg(self) -> float:
        """Angle from the driven body's axis to the motion, about the normal that points upwards."""
        return -self.bodies[0].axis_angle_deg

    @property
    def crossing_angle_deg(self) -> float:
        """Angle from the driven body's axis to the held body's, about the normal that points upwards."""
        return self.bodies[1].axis_angle_deg - self.bodies[0].axis_angle_deg

    def fidelity(self, name: str) -> FidelitySettings:
        """The settings that the study states for the level "quick", "standard" or "fine"; StudyError for another."""
        settings: FidelitySettings = level_of({own: getattr(self.tables.fidelity, own) for own in FIDELITIES}, name)
        return settings


class LineStudy(AnyStudy[LineTables]):
    """A study of a line contact, with the tables of its keys as attributes."""

    of: ClassVar = LineTables

    conditions: LineConditions
    contact: LineContactTable
    wear: LineWear
    holder: HolderTable
    mesh: LineMeshing

    @property
    def pad(self) -> Pad:
        return self.tables.pad

    @property
    def specimen(self) -> Specimen:
        return self.tables.specimen

    def energy_coefficients(self) -> tuple[float, float]:
        """(pad, specimen): worn volume per dissipated energy in mm³/J, 0 where nothing wears."""
        return self.tables.energy_coefficients()

    def of_length(self, length_mm: float) -> Self:
        """A copy, variants included, for a contact of length_mm with equal load, force and energy per millimetre."""
        variants = tuple((name, tables.of_length(length_mm)) for name, tables in self.variants)
        return type(self)(self.tables.of_length(length_mm), variants, self.variant_name)


class JointStudy(AnyStudy[JointTables]):
    """A study of a joint, which cannot be simulated, with the tables of its keys as attributes."""

    of: ClassVar = JointTables

    conditions: JointConditions
    contact: JointContact
    holder: HolderTable


def load_study(path: str | Path) -> Study:
    """Read a study of a contact at a point from a TOML file.

    Raises StudyError, in one sentence, if the file cannot be read, or is not a valid study of this kind.
    """
    return point_study(read_study(path), str(path))


def point_study(data: Mapping[str, object], where: str) -> Study:
    """A study of a contact at a point from nested tables. Raises StudyError, in one sentence, if they are not one."""
    if not issubclass(kind_named(data.get("kind")).tables, ContactTables):
        raise StudyError(
            f'{where} is a study of kind "{data["kind"]}", which is not taken here: give one of kind '
            f'"{kinds.CROSSED_WIRES}".'
        )
    study: Study = study_from_tables(data, where)
    return study


def read_study(path: str | Path) -> dict[str, Any]:
    """The nested tables in a study file of any kind, unchecked; names of files in them become relative to the working
    folder.
    Raises StudyError, in one sentence, if the file cannot be read, or is another file of this program or of a
    laboratory.
    """
    require_no_other(Path(path), StudyError, Held.STUDY)
    return found_from(Path(path).parent, read_toml(Path(path), StudyError, "study file"))


def found_from(folder: Path, table: dict[str, object]) -> dict[str, object]:
    """A copy of a nested table in which names of files, relative to `folder`, become paths from here."""
    return {
        key: found_from(folder, value)
        if isinstance(value, dict)
        else str(folder / value)
        if key in FILE_KEYS and isinstance(value, str)
        else value
        for key, value in table.items()
    }


def parse_study(text: str, where: str) -> Study:
    """Read a study of a contact at a point from TOML text; `where` names its origin in messages.

    Raises StudyError, in one sentence, if the text is not a valid study.
    """
    return point_study(parsed_toml(text, where, StudyError), where)


def study_from_tables(data: Mapping[str, object], where: str) -> Any:
    """The study (`Study`, `LineStudy` or `JointStudy`) in nested tables such as `Study.resolved()` returns.
    Raises StudyError, in one sentence, if they are not a valid study of any kind.
    """
    if data.keys() & SEVERAL:
        raise StudyError(f"{where} states several contacts in [[contacts]], which wirewear run takes and nothing else.")
    known = kind_named(data.get("kind")).tables.known
    base = {key: value for key, value in data.items() if key != "variants"}
    tables: Any = checked_tables(known(base, where), where)
    variants: tuple[tuple[str, Any], ...] = tuple(
        (name, checked_tables(known(base, where, own), where, known(own, where), f"variants.{name}"))
        for name, own in variants_in(data, where)
    )
    return next(own for own in (Study, LineStudy, JointStudy) if isinstance(tables, own.of))(tables, variants)


def variants_in(data: Mapping[str, object], where: str) -> Iterator[tuple[str, Mapping[str, object]]]:
    """Yields (name, nested values that replace the study's own) for each variant in a study's tables.
    Raises StudyError if variants are not tables, or have names that are not allowed.
    """
    variants = data.get("variants", {})
    if not isinstance(variants, Mapping):
        raise StudyError(
            f"variants in {where} is {shown(variants)}, but must hold tables like [variants.rigid.holder]."
        )
    for name, overrides in variants.items():
        if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}", name):
            raise StudyError(
                f"the variant {shown(name)} in {where} needs another name: letters, digits, _ and - only, 64 at most."
            )
        if not isinstance(overrides, Mapping):
            raise StudyError(
                f"variants.{name} in {where} is {shown(overrides)}, but must be a table like [variants.{name}.holder]."
            )
        for key, value in overrides.items():
            if not isinstance(value, Mapping) and key not in ("effects", "programme"):
                raise StudyError(
                    f"{shown(key)} in [variants.{name}] of {where} is {shown(value)}, but a variant holds only tables "
                    f"such as [variants.{name}.holder]."
                )
        yield name, overrides
