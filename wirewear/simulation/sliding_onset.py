"""Whether a drive is too weak to make its contact slide: the middle then sticks, and meshes are for what slips beside.

One rule for every kind of contact, drive and held figure. What a contact comes to as it begins to slide is that of the
fresh one between half-spaces, or of a line contact that of its bodies, in series with the rig.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from wirewear import reference
from wirewear.effects import Age, ContactLaw, Loading, Seam, applied
from wirewear.test import AnyStudy, Study
from wirewear.test.bodies import hertz_of
from wirewear.test.programme import held_by

_AGES = 200


@dataclass(frozen=True)
class SlidingOnset:
    """What a contact has come to that just slides, without its rig."""

    force_N: float
    motion_mm: float  #: Of the bodies against each other, where they are held.
    slip_mm: float  #: Amplitude, half of the loop's width.
    energy_mJ: float  #: Of a cycle.


def least_friction_N(study: AnyStudy[Any]) -> float:
    """Tangential force that swings with the drive and that friction bears at any time of the cycle and of the test; 0
    where effects let bodies touch elsewhere than they would.
    """
    law, loading = ContactLaw(study.contact.friction), Loading(study.conditions.normal_load_N)
    ages = np.linspace(0.0, float(study.conditions.cycles), _AGES if study.effects else 1)
    least = np.inf
    for age in (Age(cycles, 0.0) for cycles in ages):
        aged, loaded = (
            applied(study.effects, Seam.CONTACT, law, age),
            applied(study.effects, Seam.LOADING, loading, age),
        )
        if aged.layers or loaded.misalignment_rad:
            return 0.0
        least = min(least, aged.friction * loaded.normal_load_N)
    return float(least * study.drive.least_load_per_place)


def expected_to_stick(study: AnyStudy[Any], onset_at: Callable[[float], SlidingOnset]) -> bool:
    """Whether the drive of a study of one block does not make its contact slide; onset_at: by the friction force."""
    friction_N = least_friction_N(study)
    if friction_N <= 0.0:
        return False
    onset, stated = onset_at(friction_N), held_by(study.conditions)
    rig = applied(study.effects, Seam.HOLDER, study.tables.rig, Age.new())
    driven_um = 1e3 * (onset.motion_mm + friction_N * rig.compliance_at_contact_mm_per_N)
    if stated is None:
        return bool(study.conditions.displacement_amplitude_um < driven_um)
    slides_from = {
        "tangential": onset.force_N,
        "energy": onset.energy_mJ,
        "slip": 1e3 * onset.slip_mm,
        "motion": 1e3 * onset.motion_mm,
        "reading": driven_um,
    }
    return bool(stated.value < slides_from[stated.figure])


def point_sticks(study: Study) -> bool:
    """Whether a contact at a point is expected to stick in its middle, by Cattaneo and Mindlin.

    The contact between gripped bodies is softer and slides later.
    """
    driven, held = study.bodies
    hertz = hertz_of(study.conditions.drive.load.largest * study.conditions.normal_load_N, driven, held)
    radius = (hertz.major_semi_axis_mm * hertz.minor_semi_axis_mm) ** 0.5
    modulus = reference.tangential_contact_modulus(driven.material, held.material)

    def onset(friction_N: float) -> SlidingOnset:
        contact = reference.partial_slip_point(friction_N, 1.0, radius, modulus)
        motion = contact.full_slip_displacement_mm
        slip, energy = reference.slip_amplitude(contact, motion), reference.energy_per_cycle(contact, friction_N)
        return SlidingOnset(friction_N, motion, slip, energy)

    return expected_to_stick(study, onset)
