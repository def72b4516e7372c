"""Tests in which one held wire touches several driven bodies: their places, and how the wire shares its load."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, PlainValidator

from geometry.arrays import Array
from wirewear.base.errors import StudyError
from wirewear.base.units import Quantity
from wirewear.test import keys
from wirewear.test.bodies import Body, Wire
from wirewear.test.messages import validated
from wirewear.test.study import SEVERAL, Study, point_study, read_study

Along = Annotated[float, PlainValidator(Quantity("mm", -1e4, 1e4))]
Values = Mapping[str, Any]


class PlacedContact(keys.Table):
    """Keys of one of several contacts: its place, and values that differ from the study's."""

    at_mm: Along = Field(description="place of the contact along the held wire", examples=[0.0])
    contact: Values = Field({}, description="friction in it")
    wear: Values = Field({}, description="wear in it")
    wires: Values = Field({}, description="wires in it")
    bodies: Values = Field({}, description="bodies in it")


class SpanTable(keys.Table):
    """Keys of the held wire between its contacts, which bends as a beam."""

    loads_at_mm: tuple[Along, ...] = Field(
        (), description="places along the held wire at which the normal load acts in equal parts; without it the middle"
    )


class _Several(keys.Table):
    contacts: tuple[PlacedContact, ...] = Field(description="the contacts")
    span: SpanTable = Field(SpanTable(), description="the held wire between them")


@dataclass(frozen=True)
class ManyContacts:
    """A test of one held wire over several driven bodies, which move alike. study, tables: of a contact that states
    nothing of its own; loads_at_mm: places along the held wire at which equal parts of the load act.
    """

    study: Study
    tables: Mapping[str, Any]
    contacts: tuple[PlacedContact, ...]
    loads_at_mm: tuple[float, ...]

    @property
    def load_N(self) -> float:
        return float(self.study.conditions.normal_load_N)

    @property
    def places_mm(self) -> Array:
        """Places (n,) of the contacts along the held wire, in the file's order."""
        return np.array([own.at_mm for own in self.contacts])

    @property
    def bending_stiffness_N_mm2(self) -> float:
        """Bending stiffness EI of the held wire."""
        wire = _held_wire(self.study)
        return wire.youngs_modulus_MPa * pi / 64.0 * (wire.diameter_mm**4 - wire.bore_mm**4)

    def alone(self, contact: int, blocks: list[tuple[int, float]]) -> Study:
        """The study of one contact. contact: its index from 0; blocks: (number of cycles, normal load in N) of each
        block of its programme, at whose end a loop is recorded.
        """
        own = {key: value for key, value in self.contacts[contact] if key != "at_mm" and value}
        ends = np.cumsum([cycles for cycles, _ in blocks]).tolist()
        programme = [{"cycles": cycles, "conditions": {"normal_load_N": load}} for cycles, load in blocks]
        change = {"conditions": {"normal_load_N": blocks[0][1]}, "log": {"loop_cycles": ends}, "programme": programme}
        name = f"{self.study.name}, contact {contact + 1}"
        return point_study(keys.merged(self.tables, {**own, **change, "name": name}), name)


def many_contacts(path: Path) -> ManyContacts | None:
    """The test in a study file with several contacts; None if it states none. Raises StudyError, in one sentence, if it
    is not valid or states what is not taken with several contacts.
    """
    data = read_study(path)
    if not data.keys() & SEVERAL:
        return None
    rest = {key: value for key, value in data.items() if key not in SEVERAL}
    asked = validated(_Several, {key: value for key, value in data.items() if key in SEVERAL}, str(path), StudyError)
    study = point_study(rest, str(path))
    places = [own.at_mm for own in asked.contacts]
    found = ManyContacts(study, rest, asked.contacts, asked.span.loads_at_mm or (float(np.mean(places)),))
    if problem := _unfit(found, places):
        raise StudyError(f"{path} states several contacts, but {problem}.")
    return found


def _held_wire(study: Study) -> Wire:
    held: Body = study.bodies[1]
    if not isinstance(held, Wire):
        raise StudyError(f"the study {study.name} states several contacts, but its held body is no wire or tube")
    return held


def _unfit(test: ManyContacts, places: list[float]) -> str | None:
    """The rest of a sentence on what does not go with several contacts; None if all does."""
    study, least = test.study, 2.0 * _held_wire(test.study).diameter_mm
    if len(places) < 2:
        return "has one alone: leave [[contacts]] out"
    if np.diff(np.sort(places)).min() < least:
        return f"two of them are closer than {least:g} mm, two diameters of the held wire, where they feel each other"
    conditions = study.conditions
    held = next((key for key, value in conditions if key.startswith("held_") and value is not None), None)
    for key, given in ((held, held is not None), ("approach_um", conditions.approach_um is not None)):
        if given:
            return f"{key} in [conditions] is of one: drive them by displacement_amplitude_um under normal_load_N"
    if study.holder.tangential_stiffness_N_per_mm != "rigid":
        return 'its [rig] gives way, which is not shared among them: state tangential_stiffness_N_per_mm = "rigid"'
    for key, stated in (("programme", study.tables.programme), ("variants", study.variant_names)):
        if stated:
            return f"{key} is stated, which changes with the loads: leave it out"
    return None
