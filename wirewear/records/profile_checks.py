"""What is odd about a line contact's record: its friction, what is assumed of its bodies, its profiles.

A cylinder that lies deeper in a flat by the sum of both depths touches it over x² = 2R·d_t. The pad's scar is as long;
the flat's is longer by the stroke. Sizes are second moments of what lies deeper than a quarter of the deepest point, of
a parabola 3/20 of its squared half width, as in `wirewear.records.scar_geometry`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from geometry import Elastic
from wirewear.loops import LoopFigures
from wirewear.records.remarks import CheckedRecord, Remark
from wirewear.records.scar_geometry import CLEAR, LEVEL, NARROWEST, WIDEST
from wirewear.records.surfaces import MeasuredProfile
from wirewear.records.values import LineRecord
from wirewear.reference.hertz import contact_modulus, hertz_line

# A worn area may differ from what is stated by this factor before units are suspected.
_AREA = 30.0
# Share of the largest depth that may stand at the end of a profile.
_AT_END = 0.1
#: The flat's scar is never shorter: in kinematic wear, whichever body wears more, its spread is 1.00 to 1.42 times the
#: pad's, in simulated records 1.03 to 1.44. Repeats scatter by 0.01.
SHORTER = 0.95


def profile_remarks(checked: CheckedRecord) -> Iterator[Remark]:
    """What is odd about friction, bodies and profiles of a line contact's record."""
    record: LineRecord = checked.record
    yield from _friction_remarks(record, checked.figures.values())
    yield from _bodies_remarks(record)
    for profile in record.scars:
        yield from _profile_remarks(record, profile)
    for text in unlike_profiles(record):
        yield Remark("problem", "profiles", text)


def _friction_remarks(record: LineRecord, figures: Iterable[LoopFigures]) -> Iterator[Remark]:
    if record.tables.stated.friction is not None:
        known = (one.friction_max.value for one in figures if one.friction_max is not None)
        largest = max(known, default=0.0)
        if largest > 3.0 * max(record.tables.stated.friction, 0.01):
            text = f"the largest Q/P is {largest:.3g}, three times the stated friction: forces may be per millimetre."
            yield Remark("problem", "friction", text)


def _bodies_remarks(record: LineRecord) -> list[Remark]:
    """What is assumed of bodies that are not described: their compliance adds to the rig's."""
    missing = record.tables.assumed_heights_mm
    if not missing:
        return []
    taken = " and ".join(f"the {body} is taken to be {height:.3g} mm high" for body, height in missing.items())
    text = (
        f"{taken[0].upper()}{taken[1:]} from the contact to where it is held, which gives way beside the rig: measured "
        f"stiffnesses and amplitudes depend on it; state height_mm (and half_width_mm) in "
        f"{' and '.join(f'[{body}]' for body in missing)}."
    )
    return [Remark("note", "bodies", text)]


def _profile_remarks(record: LineRecord, profile: MeasuredProfile) -> list[Remark]:
    who = f"the {profile.body}'s profile of repeat {profile.repeat}"
    deepest = float(profile.smooth_um.max())
    if deepest <= 0.0:
        return [Remark("note", "profiles", f"{who} shows no wear.")]
    found = []
    ends = max(profile.smooth_um[0], profile.smooth_um[-1])
    if ends > _AT_END * deepest:
        found.append(Remark("problem", "profiles", f"{who} ends inside the scar, {ends:.3g} µm deep."))
    expected = _expected_area(record, profile.body)
    if expected is not None and not 1.0 / _AREA < profile.area_um2 / expected < _AREA:
        text = f"{who} has lost {profile.area_um2:.3g} µm², expected {expected:.3g}: check its units."
        found.append(Remark("problem", "profiles", text))
    return found


def _expected_area(record: LineRecord, body: str) -> float | None:
    """Worn cross-section in gross slip on a rigid rig by what is stated, µm²; None where too little is."""
    stated, asked = record.tables.stated, record.tables.conditions
    energy = getattr(stated, f"{body}_energy_wear_coefficient_mm3_per_J")
    archard = getattr(stated, f"{body}_archard_wear_coefficient_mm3_per_N_m")
    sliding_N_m = 4e-6 * asked.normal_load_N * asked.displacement_amplitude_um * asked.cycles
    if archard is not None:
        volume = archard * sliding_N_m
    elif energy is not None and stated.friction is not None:
        volume = energy * stated.friction * sliding_N_m
    else:
        return None
    return 1e6 * volume / record.tables.contact.length_mm if volume > 0.0 else None


def unlike_profiles(record: LineRecord) -> Iterator[str]:
    """What the profiles of each repeat cannot be, sentences."""
    for repeat in record.repeats:
        of_repeat = [profile for profile in record.scars if profile.repeat == repeat]
        spreads = {profile.body: spread for profile in of_repeat if (spread := _spread_um2(profile)) is not None}
        if len(of_repeat) == len(spreads) == 2:
            depth_um = sum(float(profile.depth_um.max()) for profile in of_repeat)
            if found := next(_unlike(record, depth_um, spreads["pad"], spreads["specimen"]), None):
                yield f"{found} in repeat {repeat}: is one of the other body, of another scale or of another test?"


def _unlike(record: LineRecord, depth_um: float, pad_um2: float, specimen_um2: float) -> Iterator[str]:
    if specimen_um2 < SHORTER**2 * pad_um2:
        yield "The specimen's scar is shorter than the pad's that wore it"
    radius = record.tables.pad.radius_mm
    if radius is None:
        return
    bodies = [
        Elastic(body.youngs_modulus_MPa, body.poissons_ratio) for body in (record.tables.pad, record.tables.specimen)
    ]
    load = record.tables.conditions.normal_load_N / record.tables.contact.length_mm
    elastic = (1e3 * hertz_line(load, radius, contact_modulus(*bodies)).half_width_mm) ** 2
    worn = 2e3 * radius * depth_um * (1.0 - LEVEL) / 5.0
    reach = record.tables.conditions.displacement_amplitude_um / np.sqrt(2.0)
    for body, spread, stroke in (("pad", pad_um2, 0.0), ("specimen", specimen_um2, reach)):
        if not NARROWEST * worn < spread < (np.sqrt(WIDEST * worn + 2.0 * elastic) + stroke) ** 2:
            ratio = float(np.sqrt(spread / worn))
            yield f"The {body}'s scar is {ratio:.2g} times as long as both scars' depths make it"


def _spread_um2(profile: MeasuredProfile) -> float | None:
    """The second moment about the middle [µm²]; None where the scar does not stand out."""
    deepest, lowest = float(profile.depth_um.max()), float(np.percentile(profile.depth_um, 0.5))
    if deepest <= CLEAR * max(-lowest, 0.0) or deepest <= 0.0 or profile.x_um.size < 3:
        return None
    weights = np.maximum(profile.depth_um - LEVEL * deepest, 0.0) * np.gradient(profile.x_um)
    weights /= weights.sum()
    return float(np.sum(weights * (profile.x_um - np.sum(weights * profile.x_um)) ** 2))
