"""A rope's contacts, read from its file and sorted by severity, for the command line and Python."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, isnan, nan
from pathlib import Path
from typing import Any

from wirewear.base.errors import StudyError
from wirewear.base.words import counted
from wirewear.strand.construction import Strand
from wirewear.strand.contacts import Bend, LoadedWire, SheaveGroove, contacts_of
from wirewear.strand.estimates import ContactEstimate, estimates
from wirewear.strand.studies import file_name, has_study, notes, studies_of
from wirewear.strand.tables import RopeTables, load_rope, rope_of
from wirewear.test import LineStudy, Study


@dataclass(frozen=True, eq=False)
class RopeContacts:
    """A strand or rope with an estimate of each kind of contact in it, the worst first."""

    tables: RopeTables
    rope: Strand
    contacts: tuple[ContactEstimate, ...]

    @property
    def name(self) -> str:
        return self.tables.name

    @property
    def figures(self) -> dict[str, float]:
        """Diameter, axial and bending stiffness and torque of the whole rope, by name with unit."""
        least, most = self.rope.bending_N_mm2
        return {
            "diameter_mm": self.rope.diameter_mm,
            "axial_stiffness_N": self.rope.stiffness_N,
            "least_bending_stiffness_N_mm2": least,
            "largest_bending_stiffness_N_mm2": most,
            "torque_N_mm": self.rope.torque_N_mm(self.tables.conditions.tension_N),
        }

    @property
    def notes(self) -> list[str]:
        """Sentences on contacts whose estimates need caution; empty if none does."""
        found = [note for one in self.contacts for note in notes(one)]
        if all(isnan(one.yield_ratio) for one in self.contacts):
            found.append("No yield_stress_MPa is stated in [wires]: whether contacts yield is not known.")
        return found

    @property
    def rows(self) -> list[dict[str, Any]]:
        """A row of plain values for each kind of contact, by column with its unit; None where unknown."""
        return [_row(one) for one in self.contacts]

    def studies(self) -> dict[str, Study | LineStudy]:
        """The study of each contact whose slip is known and at least 0.1 µm, by the contact's name.

        Raises StudyError if a value lies outside the range of a study.
        """
        return studies_of(self.contacts, self.tables)


def strand_contacts(rope: str | Path | dict[str, object]) -> RopeContacts:
    """Contacts of a rope, given by its file's path or by the nested tables of one.

    Raises StudyError, in one sentence, if the file cannot be read or its data are not consistent.
    """
    if isinstance(rope, dict):
        tables, where = rope_of(rope, "the rope"), "the rope"
    else:
        tables, where = load_rope(rope), str(rope)
    made, c, groove = tables.construction(where), tables.conditions, None
    if c.tension_amplitude_N >= c.tension_N:
        raise StudyError(
            f"tension_amplitude_N in [conditions] of {where} is {c.tension_amplitude_N:g}, but the rope stays taut "
            f"only if it is below tension_N, {c.tension_N:g}."
        )
    if (sheave := tables.sheave) is not None:
        if sheave.groove_radius_mm < 0.5 * made.diameter_mm:
            raise StudyError(
                f"groove_radius_mm in [sheave] of {where} is {sheave.groove_radius_mm:g}, but the rope needs more than "
                f"its own radius, {0.5 * made.diameter_mm:.4g} mm."
            )
        curvatures = (1.0 / c.bending_radius_mm, -1.0 / sheave.groove_radius_mm)
        groove = SheaveGroove(sheave.elastic, curvatures)
    bend = Bend(
        c.curvature_amplitude_per_mm,
        c.bending == "pulsating",
        tables.contact.friction,
        c.tension_amplitude_N / c.tension_N,
    )
    wear = 0.0 if tables.wear is None else tables.wear.energy_wear_coefficient_mm3_per_J
    found = contacts_of(made, c.tension_N, bend, groove)
    stresses = [(own.mean_MPa + own.amplitude_MPa, own.name) for one in found for own in one.wires]
    # Stresses beyond this are no wire's.
    if stresses and max(stresses)[0] > 1e4:
        raise StudyError(
            f"a wire ({max(stresses)[1]}) would bear {counted(max(stresses)[0])} MPa in {where}, which no wire does: "
            "look at tension_N and bending_radius_mm in [conditions]."
        )
    return RopeContacts(tables, made, tuple(estimates(found, bend.friction, wear, c.cycles, tables.life)))


def _row(one: ContactEstimate) -> dict[str, Any]:
    contact, wire = one.contact, one.contact.upper
    below = contact.lower if isinstance(contact.lower, LoadedWire) else None
    along, across = contact.along_across_mm
    lower, upper = one.lives
    values = {
        "normal_load_N": contact.load_N,
        "length_mm": 1.0 if contact.is_line else nan,
        "angle_deg": contact.angle_deg,
        "spacing_mm": contact.spacing_mm,
        "contacts_per_mm": contact.per_axial_mm,
        "peak_pressure_MPa": one.peak_pressure_MPa,
        "major_semi_axis_mm": one.major_mm,
        "minor_semi_axis_mm": one.minor_mm,
        "yield_ratio": one.yield_ratio,
        "plastic_area_mm2": one.plastic_area_mm2,
        "free_slip_amplitude_um": 1e3 * contact.free_slip_mm,
        "slip_amplitude_um": 1e3 * contact.slip_amplitude_mm,
        "slip_along_lower_um": 1e3 * along,
        "slip_across_lower_um": 1e3 * across,
        "force_ratio": contact.slip.share,
        "wire_tension_N": wire.tension_N,
        "mean_stress_MPa": wire.mean_MPa,
        "axial_stress_amplitude_MPa": wire.axial_amplitude_MPa,
        "bending_stress_amplitude_MPa": wire.bending_amplitude_MPa,
        "lower_mean_stress_MPa": below.mean_MPa if below else nan,
        "lower_stress_amplitude_MPa": below.amplitude_MPa if below else nan,
        "friction_energy_mJ": one.energy_mJ,
        "worn_volume_per_cycle_mm3": one.worn_mm3,
        "worn_depth_um": 1e3 * one.worn_depth_mm,
        "life_lower_cycles": lower,
        "life_upper_cycles": upper,
    }
    head = {"contact": contact.name, "kind": contact.sort, "regime": one.regime}
    # Lives may be endless; a length that is endless is none.
    known = {key: isfinite(value) if "life" not in key else not isnan(value) for key, value in values.items()}
    plain = {key: value if known[key] else None for key, value in values.items()}
    return {**head, **plain, "study": file_name(contact.name) if has_study(one) else None}
