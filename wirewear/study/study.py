"""Studies as values, of contacts at a point and along a line: what the user states of bodies, rig and contact."""

from __future__ import annotations

from functools import cached_property
from typing import cast

from wirewear.study.any_study import AnyStudy
from wirewear.study.bodies import Body
from wirewear.study.fidelity import FIDELITIES, level_of
from wirewear.study.lines import (
    LineConditions,
    LineFriction,
    LineHolder,
    LineMeshing,
    LineTables,
    LineWear,
    Pad,
    Specimen,
)
from wirewear.study.tables import (
    Conditions,
    Contact,
    ContactTables,
    FidelitySettings,
    HolderTable,
    Mesh,
    StudyTables,
    Wear,
)
from wirewear.study.wires import Wires


class Study(AnyStudy[ContactTables]):
    """A study of a contact at a point; its tables are of the types named here."""

    conditions: Conditions
    contact: Contact
    wear: Wear | None
    holder: HolderTable
    mesh: Mesh

    @property
    def wires(self) -> Wires:
        """Both wires as the file of crossed wires states them; see also `bodies`."""
        return cast("StudyTables", self.tables).wires

    @cached_property
    def bodies(self) -> tuple[Body, Body]:
        """The driven body, which lies below, and the one above it, whose holder carries the rig's compliance."""
        return self.tables.bodies_of_test()

    @property
    def motion_angle_deg(self) -> float:
        """Direction of the motion against the driven body's axis."""
        return -self.bodies[0].axis_angle_deg

    @property
    def crossing_angle_deg(self) -> float:
        """Angle of the held body's axis to the driven body's."""
        return self.bodies[1].axis_angle_deg - self.bodies[0].axis_angle_deg

    def fidelity(self, name: str) -> FidelitySettings:
        """Settings of the level quick, standard or fine; None where the study leaves the choice to the program.
        Raises StudyError if there is no such level.
        """
        settings: FidelitySettings = level_of({own: getattr(self.tables.fidelity, own) for own in FIDELITIES}, name)
        return settings


class LineStudy(AnyStudy[LineTables]):
    """A study of a line contact, of one millimetre of its length; its tables are of the types named here."""

    conditions: LineConditions
    contact: LineFriction
    wear: LineWear
    holder: LineHolder
    mesh: LineMeshing

    @property
    def pad(self) -> Pad:
        """The pad, held by the rig."""
        return self.tables.pad

    @property
    def specimen(self) -> Specimen:
        """The flat, which is driven."""
        return self.tables.specimen

    def energy_coefficients(self) -> tuple[float, float]:
        """Wear of pad and specimen per dissipated energy, in mm³/J."""
        return self.tables.energy_coefficients()
