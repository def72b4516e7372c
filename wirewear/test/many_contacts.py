"""Tests in which one held wire touches several driven bodies: their places, and how the wire shares its load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi, radians, sin
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, PlainValidator

from geometry import Elastic
from geometry.arrays import Array
from wirewear.base.errors import StudyError
from wirewear.base.units import Quantity
from wirewear.test import keys
from wirewear.test.bodies import Body, Wire
from wirewear.test.messages import validated
from wirewear.test.study import SEVERAL, Study, point_study, read_study

Along = Annotated[float, PlainValidator(Quantity("mm", -1e4, 1e4))]
Gap = Annotated[float, PlainValidator(Quantity("um", -1e4, 1e4))]
Values = Mapping[str, Any]
_SHARED_STIFFNESSES = ("tangential_stiffness_N_per_mm", "rotational_stiffness_N_mm_per_rad")


class PlacedContact(keys.Table):
    """Keys of one of several contacts: its place, and values that differ from the study's."""

    at_mm: Along = Field(description="place of the contact along the held wire", examples=[0.0])
    gap_um: Gap = Field(
        0.0, description="gap that is left under the straight unloaded wire; below 0, the wire is bent over the contact"
    )
    conditions: Values = Field({}, description="stroke of the body that is driven in it")
    contact: Values = Field({}, description="friction in it")
    wear: Values = Field({}, description="wear in it")
    wires: Values = Field({}, description="wires in it")
    bodies: Values = Field({}, description="bodies in it")


class SpanTable(keys.Table):
    """Keys of the held wire between its contacts, which bends as a beam."""

    loads_at_mm: tuple[Along, ...] = Field(
        (), description="places along the held wire at which the normal load acts in equal parts; without it the middle"
    )
    clamped_at_mm: tuple[Along, ...] = Field(
        (), description="places at which the held wire is clamped, so that it neither sinks nor turns"
    )
    tension_N: Annotated[float, PlainValidator(Quantity("N", 0.0, 1e6))] = Field(
        0.0, description="pull along the held wire"
    )


class _Several(keys.Table):
    contacts: tuple[PlacedContact, ...] = Field(description="the contacts")
    span: SpanTable = Field(SpanTable(), description="the held wire between them")


@dataclass(frozen=True)
class LoadedBlock:
    """Cycles under one load of one contact. share: of the rig's stiffness that stands behind this contact."""

    cycles: int
    load_N: float
    share: float


@dataclass(frozen=True)
class ManyContacts:
    """A test of one held wire over several driven bodies. study, tables: of a contact that states nothing of its own;
    span: loads_at_mm are stated.
    """

    study: Study
    tables: Mapping[str, Any]
    contacts: tuple[PlacedContact, ...]
    span: SpanTable

    @property
    def load_N(self) -> float:
        return float(self.study.conditions.normal_load_N)

    @property
    def places_mm(self) -> Array:
        """Places (n,) of the contacts along the held wire, in the file's order."""
        return np.array([own.at_mm for own in self.contacts])

    @property
    def frictions(self) -> Array:
        """Coefficients of friction (n,) in the contacts."""
        return np.array([own.contact.get("friction", self.study.contact.friction) for own in self.contacts])

    @property
    def strokes_mm(self) -> Array:
        """Displacement amplitudes (n,) of the driven bodies."""
        key = "displacement_amplitude_um"
        stated = getattr(self.study.conditions, key)
        return 1e-3 * np.array([own.conditions.get(key, stated) for own in self.contacts])

    @property
    def rig_yields(self) -> bool:
        return any(self._rig(1.0))

    @property
    def bending_stiffness_N_mm2(self) -> float:
        """Bending stiffness EI of the held wire."""
        wire = _held_wire(self.study)
        return wire.youngs_modulus_MPa * pi / 64.0 * (wire.diameter_mm**4 - wire.bore_mm**4)

    @property
    def shear_stiffness_N(self) -> float:
        """Shear stiffness κGA of the held wire, with κ of bars and tubes (Cowper, J. Appl. Mech. 33 (1966) 335)."""
        wire = _held_wire(self.study)
        nu, m = wire.poissons_ratio, (wire.bore_mm / wire.diameter_mm) ** 2
        kappa = 6.0 * (1.0 + nu) * (1.0 + m) ** 2 / ((7.0 + 6.0 * nu) * (1.0 + m) ** 2 + (20.0 + 12.0 * nu) * m)
        modulus = wire.youngs_modulus_MPa / (2.0 * (1.0 + nu))
        return kappa * modulus * pi / 4.0 * (wire.diameter_mm**2 - wire.bore_mm**2)

    @property
    def are_near(self) -> bool:
        """True if two contacts are closer than four diameters of the held wire, so that elements take the beam's place:
        two diameters apart, a beam is 0.6 % off a solution of both contacts at once, elements 0.2 %.
        """
        return bool(np.diff(np.sort(self.places_mm)).min() < 4.0 * _held_wire(self.study).diameter_mm)

    @property
    def held_section(self) -> tuple[float, float, Elastic, float]:
        """Radius, inner radius and material of the held wire, and half the angle over which its back is gripped."""
        wire = _held_wire(self.study)
        return 0.5 * wire.diameter_mm, 0.5 * wire.bore_mm, wire.material, 0.5 * radians(wire.grip_angle_deg)

    @property
    def backing_mm_per_N(self) -> float:
        """How much farther the back of the held wire comes to a contact than its axis, over the force: a run has the
        approach of the back, the beam is the axis. 1.56/(E d) by elements for solid wires in their grips, of which
        several are to the diameter; 0 for tubes, whose walls bend, and for near contacts, whose elements show it.
        """
        wire = _held_wire(self.study)
        return 0.0 if wire.bore_mm or self.are_near else 1.56 / (wire.youngs_modulus_MPa * wire.diameter_mm)

    def alone(self, contact: int, blocks: Sequence[LoadedBlock]) -> Study:
        """The study of one contact, by its index from 0, whose programme are these blocks; a loop is recorded at the
        end of each.
        """
        own = {key: value for key, value in self.contacts[contact] if key not in ("at_mm", "gap_um") and value}
        ends = np.cumsum([block.cycles for block in blocks]).tolist()
        programme = [
            {"cycles": each.cycles, "conditions": {"normal_load_N": each.load_N}, "holder": self._rig(each.share)}
            for each in blocks
        ]
        change = {
            "conditions": {"normal_load_N": blocks[0].load_N, "cycles": ends[-1]},
            "holder": programme[0]["holder"],
            "log": {"loop_cycles": ends},
            "programme": programme,
        }
        name = f"{self.study.name}, contact {contact + 1}"
        return point_study(keys.merged(keys.merged(self.tables, own), {**change, "name": name}), name)

    def _rig(self, share: float) -> dict[str, float]:
        """Stiffnesses of the rig behind a contact that carries this share of its force; rigid ones are left out."""
        rig = self.study.holder
        stated = {key: getattr(rig, key) for key in _SHARED_STIFFNESSES}
        return {key: share * value for key, value in stated.items() if not isinstance(value, str)}


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
    loads = asked.span.loads_at_mm or (float(np.mean(places)),)
    found = ManyContacts(study, rest, asked.contacts, asked.span.model_copy(update={"loads_at_mm": loads}))
    if problem := _unfit(found):
        raise StudyError(f"{path} states several contacts, but {problem}.")
    return found


def _held_wire(study: Study) -> Wire:
    held: Body = study.bodies[1]
    if not isinstance(held, Wire):
        raise StudyError(f"the study {study.name} states several contacts, but its held body is no wire or tube")
    return held


def _unfit(test: ManyContacts) -> str | None:
    """The rest of a sentence on what does not go with several contacts; None if all does."""
    study, places, nearest = test.study, test.places_mm, 0.5 * _held_wire(test.study).diameter_mm
    if len(places) < 2:
        return "has one alone: leave [[contacts]] out"
    apart, driven = float(np.diff(np.sort(places)).min()), study.bodies[0]
    if apart < nearest:
        return f"two of them are closer than {nearest:g} mm, half the held wire's diameter, where they feel each other"
    if isinstance(driven, Wire) and apart * sin(radians(study.crossing_angle_deg)) < driven.diameter_mm:
        return f"driven wires of {driven.diameter_mm:g} mm overlap that cross it {apart:g} mm apart"
    conditions = study.conditions
    held = next((key for key, value in conditions if key.startswith("held_") and value is not None), None)
    own = next((key for one in test.contacts for key in ("normal_load_N", "cycles") if key in one.conditions), None)
    by_displacement = "in [conditions] is of one: drive them by displacement_amplitude_um under normal_load_N"
    refused = {
        f"{held} {by_displacement}": held is not None,
        f"approach_um {by_displacement}": conditions.approach_um is not None,
        f"{own} is one's own: the wire shares out the load, and all run as long": own is not None,
        "normal_spring_stiffness_N_per_mm of its [holder] acts on the wire and on none of them: leave it out": bool(
            study.holder.normal_spring_stiffness_N_per_mm
        ),
        "programme is stated, which changes with the loads: leave it out": bool(study.tables.programme),
        "variants are stated, which change with the loads: leave them out": bool(study.variant_names),
    }
    return next((said for said, given in refused.items() if given), None)
