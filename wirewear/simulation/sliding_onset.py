"""The onset of gross sliding: whether a drive makes its contact slide, or the middle of the contact sticks for good.

One rule holds for every kind of contact, drive and held quantity. The onset of the fresh contact is that between
half-spaces, for a line contact that of its bodies, in series with the rig.
"""

from collections.abc import Callable

import numpy as np

from solvers.laws.friction_law import Coulomb
from wirewear import reference
from wirewear.effects import Age, ContactLaw, Loading, Seam, applied
from wirewear.simulation.control import HELD_FIGURES, SlidingOnset
from wirewear.test import AnyStudy, Study
from wirewear.test.bodies import hertz_of
from wirewear.test.conditions import held_by

_AGES = 200


def least_friction_N(study: AnyStudy) -> float:
    """Largest amplitude in N of a tangential force, in proportion to the drive, that friction bears at all times of the
    test.
    0 if effects such as layers or misalignment let the bodies touch elsewhere.
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


def expected_to_stick(study: AnyStudy, onset_at: Callable[[float], SlidingOnset]) -> bool:
    """True if the drive of a study without programme does not make its contact slide as a whole.
    onset_at: from a friction force in N, the onset of sliding without the rig.
    """
    friction_N = least_friction_N(study)
    if friction_N <= 0.0:
        return False
    onset, stated = onset_at(friction_N), held_by(study.conditions)
    rig = applied(study.effects, Seam.HOLDER, study.tables.rig, Age.new())
    carried_um = 1e3 * friction_N * rig.compliance_at_contact_mm_per_N
    if stated is None:
        return bool(study.conditions.displacement_amplitude_um < onset.motion_um + carried_um)
    return bool(stated.value < HELD_FIGURES[stated.figure].slides_from(onset, carried_um))


def round_contact(study: Study, load_N: float) -> tuple[float, float]:
    """Radius in mm of the circle with the area of the fresh contact under a load, and tangential contact modulus G* in
    MPa.
    """
    hertz = hertz_of(load_N, *study.bodies)
    modulus = reference.tangential_contact_modulus(*(body.material for body in study.bodies))
    return (hertz.major_semi_axis_mm * hertz.minor_semi_axis_mm) ** 0.5, modulus


def point_sticks(study: Study) -> bool:
    """True if a contact at a point, of a study without programme, is expected to stick in its middle, by Cattaneo and
    Mindlin.
    The contact between gripped bodies is softer and slides at larger strokes.
    """
    radius, modulus = round_contact(study, study.conditions.drive.load.largest * study.conditions.normal_load_N)

    def onset(friction_N: float) -> SlidingOnset:
        contact = reference.partial_slip_point(friction_N, 1.0, radius, modulus)
        motion = contact.full_slip_displacement_mm
        slip, energy = reference.slip_amplitude(contact, motion), reference.energy_per_cycle(contact, friction_N)
        return SlidingOnset(friction_N, 1e3 * slip, energy, lambda: 1e3 * motion)

    return expected_to_stick(study, onset)


def stated_core(study: Study) -> float | None:
    """Share (0 to 1) of a fresh contact's axes that sticks at the end of the first loading by the tangential force that
    a study holds, by Cattaneo and Mindlin.

    None where that is to be seen: the drive holds something else, friction is not Coulomb's alone, or loads change.
    """
    held, plain = study.conditions.held_tangential_force_N, type(study.contact.friction_law) is Coulomb
    if held is None or study.effects or not plain or not study.drive.steady:
        return None
    friction_N = least_friction_N(study)
    return float(1.0 - held / friction_N) ** (1.0 / 3.0) if held < friction_N else None
