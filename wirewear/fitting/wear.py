"""Wear fitted to worn volumes and friction energies, or as it is given in place of volumes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from wirewear.base.errors import RecordError
from wirewear.fitting.values import FittedParameter
from wirewear.records.course_checks import accumulated_energy_J

if TYPE_CHECKING:
    from wirewear.fitting.subject import FitSubject


@dataclass(frozen=True)
class GivenWear:
    """What is known of wear without a measured scar: its coefficient, or the volume that both bodies lost in a test."""

    coefficient_mm3_per_J: float | None = None
    volume_mm3: float | None = None


def fitted_wear(subject: FitSubject) -> tuple[dict[str, FittedParameter], dict[str, FittedParameter], list[str]]:
    """Wear parameters, energies and volumes, and what is missing."""
    record = subject.record
    energies = {repeat: accumulated_energy_J(record, repeat) for repeat in record.repeats}
    known = {repeat: energy for repeat, energy in energies.items() if energy}
    volumes = subject.record.worn_volumes_mm3
    found = {
        f"worn_volume_{body}_mm3": FittedParameter.of_repeats([*own.values()], "mm3")
        for body, own in volumes.items()
        if own
    }
    if known:
        found["accumulated_energy_J"] = FittedParameter.of_repeats([*known.values()], "J")
    fitted, notes = subject.worn(volumes, known)
    return fitted, found, notes


def wear_given(
    given: GivenWear, subject: FitSubject, worn: dict[str, FittedParameter], found: dict[str, FittedParameter]
) -> tuple[dict[str, FittedParameter], list[str]]:
    """Wear as given; what scars say of it no longer counts but for the bodies' shares.

    Raises:
        RecordError: a volume is given, and nothing tells the energy that wore it.
    """
    energy = found.get("accumulated_energy_J")
    if given.coefficient_mm3_per_J is not None:
        value = given.coefficient_mm3_per_J
        coefficient = FittedParameter(value, (value, value), "mm3_per_J", 0)
        source = "the wear coefficient is the given one, not a fitted one"
    elif given.volume_mm3 is not None and energy is not None:
        # The volume is one number; only the energies of the tests differ.
        low, high = (given.volume_mm3 / end for end in reversed(energy.interval95))
        coefficient = FittedParameter(given.volume_mm3 / energy.value, (low, high), "mm3_per_J", energy.repeats)
        source = f"the wear coefficient is the given volume of {given.volume_mm3:g} mm³ over the tests' energy"
    else:
        raise RecordError("a worn volume is given, but neither loops nor an evolution tell the energy that wore it.")
    measured = subject.total_of(worn)
    beside = "" if measured is None else f"; the scars of the record say {measured:.3g} mm³/J"
    parts, notes = subject.parted(coefficient)
    return worn | parts, [source + beside, *notes]
