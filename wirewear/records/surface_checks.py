"""Checks of worn surfaces: their sizes must fit together, as the bodies wore each other.

Two bodies that overlap by a depth d_t, the sum of both scars' depths, touch where their gap rᵀHr is below it: a spot
whose second moments go with d_t H⁻¹. For wires, the moving one along the motion, it reaches y² = 2R·d_t across at any
crossing angle, on both. Along the motion it is longer by 1/sin θ · √(1 + cos² θ), and on the moving wire by the stroke.
It leans towards the bisector of the wires' axes: its mixed moment is cot θ of that across, unaffected by the stroke.
Sizes are second moments of what lies deeper than a quarter of the deepest point; for a paraboloid that is 1/8 of its
squared half width. A ball on a flat is as wires at 90°.

In the records of the frozen blind batches, with every effect that rigs have, and in kinematic wear at 30° to 90°, the
moment across is 0.74 to 1.04 of that, both wires' differ by 3 %, along the motion the fixed wire's is 0.73 to 0.86 of
the spot's, and the moving wire's spread exceeds the spot's by 0.3 to 0.61 stroke amplitudes.

A cylinder in a flat touches it over x² = 2R·d_t. The pad's scar is as long; the flat's is longer by the stroke. For a
parabola the second moment is 3/20 of its squared half width.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from geometry import Elastic
from geometry.arrays import Array
from wirewear.records.evolution_checks import accumulated_energy_J
from wirewear.records.profiles import MeasuredProfile
from wirewear.records.remarks import CheckedRecord, Remark, listed
from wirewear.records.scars import MeasuredScar
from wirewear.records.swap_checks import copied_scars
from wirewear.records.values import ExperimentRecord, LineRecord
from wirewear.reference.hertz import contact_modulus, hertz_line
from wirewear.results.scar import called
from wirewear.test.gaps import Gap, hertz_of

#: Curvatures along the motion that carry a contact nowhere, and leans that are none, by round-off.
STRAIGHT_per_mm, UPRIGHT = 1e-9, 1e-9

LEVEL = 0.25  #: Of the deepest point: what is less deep may be noise.
CLEAR = 8.0  #: A scar that is not this many times as deep as what its map falls below zero is none whose size is known.

#: Factors on moments that no scar of the same test reached by far: half again of the largest and half of the least.
WIDEST, NARROWEST, UNLIKE = 1.5, 0.5, 1.25

#: Along the motion, over the spot's: of the fixed wire at most, of the moving wire at least.
LONGEST_FIXED, SHORTEST_MOVING = 1.15, 0.9

ASKEW_deg = 6.0  #: By what crossing angles may be wrong [deg].

_WHY = "are x and y exchanged, or is a map of the other body, of another scale or of another test?"

RAISED = 0.1  #: Depth below zero, as a share of the deepest point, that noise does not explain.
BEYOND_NOISE_um = 1.0  #: Depths that no profilometer's noise reaches [µm].

#: Factors between worn volume and what energy and stated wear make it: wear is seldom known better than within the
#: first, and off by the second only where units are wrong.
OTHER_WEAR, IMPOSSIBLE_WEAR = 5.0, 30.0
_AREA = 30.0  # A worn area may differ from what is stated by this factor before units are suspected.


@dataclass(frozen=True)
class ScarSize:
    """Depth of a scar, and its second moments about its centre: along the motion, across it, and mixed."""

    depth_um: float
    along_um2: float
    across_um2: float
    mixed_um2: float

    @classmethod
    def of(cls, scar: MeasuredScar) -> "ScarSize | None":
        """Size of a map's scar; None if it is less than CLEAR times as deep as the map falls below zero."""
        lowest, depth = float(np.percentile(scar.worn_um, 0.5)), scar.figures["depth"]
        if depth <= CLEAR * max(-lowest, 0.0) or depth <= 0.0:
            return None
        cells = np.gradient(scar.x_um)[:, None] * np.gradient(scar.y_um)[None, :]
        weights = np.clip(scar.worn_um, LEVEL * depth, depth) - LEVEL * depth
        weights = weights * cells / np.sum(weights * cells)
        x = scar.x_um - np.sum(weights.sum(axis=1) * scar.x_um)
        y = scar.y_um - np.sum(weights.sum(axis=0) * scar.y_um)
        products = x[:, None] ** 2, y[None, :] ** 2, x[:, None] * y[None, :]
        return cls(depth, *(float(np.sum(weights * product)) for product in products))


def unlike_sizes(record: ExperimentRecord) -> Iterator[str]:
    """Sentences on scars of a repeat whose sizes do not fit together; none for bodies that are curved along the
    motion.
    """
    driven, held = record.tables.bodies_of_test
    # What is curved along the motion carries the contact about on the held body; a pad's face has no radius.
    along_motion = driven.curvature_per_mm()[:, 0]
    known = np.abs(along_motion).max() < STRAIGHT_per_mm and not (driven.face or held.face)
    for repeat in record.repeats if known else ():
        sizes = {scar.body: ScarSize.of(scar) for scar in record.scars if scar.repeat == repeat}
        clear = {body: size for body, size in sizes.items() if size is not None}
        askew = -ASKEW_deg, 0.0, ASKEW_deg
        spots = np.stack([Gap.of(driven, held, turned).spot_mm for turned in askew])
        if found := next(_unlike_shapes(record, clear, spots), None):
            yield f"{found} in repeat {repeat}: {_WHY}"
        for mirrored in _mirrored(clear, spots):
            yield f"{mirrored}, in repeat {repeat}."


def _unlike_shapes(record: ExperimentRecord, sizes: dict[str, ScarSize], spots_mm: Array) -> Iterator[str]:
    # Square of the unworn contact's larger half width [µm²]: where little is worn, scars may be rings of that size.
    contact = hertz_of(record.tables.conditions.normal_load_N, *record.tables.bodies_of_test)
    elastic, amplitude = (1e3 * contact.major_semi_axis_mm) ** 2, record.tables.conditions.displacement_amplitude_um
    driven = record.tables.body_names[0]
    if len(sizes) == 2:
        first, second = (size.across_um2 for size in sizes.values())
        if not 1.0 / UNLIKE < first / second < UNLIKE:
            ratio = max(first, second) / min(first, second)
            yield f"One scar is {ratio**0.5:.2g} times as wide across the motion as the other, of the body that wore it"
        worn = 1e3 * float(spots_mm[1, 1, 1]) * sum(size.depth_um for size in sizes.values())
        expected = (1.0 - LEVEL) * worn / 6.0
        for body, size in sizes.items():
            if not NARROWEST * expected < size.across_um2 < WIDEST * expected + elastic:
                ratio = float(np.sqrt(size.across_um2 / expected))
                yield f"The {called(body)}'s scar is {ratio:.2g} times as wide as both scars' depths make it"
    longer = spots_mm[:, 0, 0] / spots_mm[:, 1, 1]
    for body, size in sizes.items():
        shortest, longest = (float(end) * size.across_um2 for end in (longer.min(), longer.max()))
        reach = amplitude / np.sqrt(2.0) if body == driven else 0.0
        if size.along_um2 > (np.sqrt(LONGEST_FIXED * longest + elastic) + reach) ** 2:
            yield f"The {called(body)}'s scar is longer along the motion than its width and the stroke make it"
        if body == driven and size.along_um2 < SHORTEST_MOVING * shortest:
            yield f"The {called(body)}'s scar is shorter along the motion than its width makes it"


def _mirrored(scars: dict[str, ScarSize], spots_mm: Array) -> Iterator[str]:
    """Sentences on scars that lean to the wrong side; none if the crossing angle leaves the side uncertain."""
    leans = spots_mm[:, 0, 1] / spots_mm[:, 1, 1]
    if float((leans * leans[1]).min()) > UPRIGHT:
        for body, size in scars.items():
            if size.mixed_um2 * np.sign(leans[1]) < -0.5 * abs(leans[1]) * size.across_um2:
                yield (
                    f"The {called(body)}'s scar leans away from the other body's axis, as one does whose x or y is "
                    "mirrored"
                )


def scar_remarks(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on missing, implausible, cut-off, copied or mismatched scars of a record."""
    record = checked.record
    diameter_um = 1e3 * min(min(body.diameters_mm) for body in record.tables.bodies_of_test)
    for body in record.tables.body_names:
        scars = record.scars_of(body)
        without = sorted(set(record.repeats) - {scar.repeat for scar in scars})
        if not scars:
            yield Remark("note", "scars", f"There is no scar of the {called(body)}.")
        elif without:
            yield Remark("note", "scars", f"There is no scar of the {called(body)} for the repeats {listed(without)}.")
        for scar in scars:
            yield from _findings(scar, diameter_um)
    for text in unlike_sizes(record):
        yield Remark("problem", "scars", text)
    noisy = record.tables.noise.displacement_um or record.tables.noise.tangential_force_N
    simulated = record.tables.metadata.source == "simulated"
    for text in copied_scars(record.scars):
        yield Remark("problem" if noisy and not simulated else "note", "scars", text)
    yield from _unlike_wear(record)


def _unlike_wear(record: ExperimentRecord) -> Iterator[Remark]:
    """Remarks on worn volumes far from the tests' energies times the stated wear coefficient."""
    stated = record.tables.stated.energy_wear_coefficient_mm3_per_J
    for repeat in record.repeats if stated else ():
        volumes = [scar.volume_mm3 for scar in record.scars if scar.repeat == repeat]
        energy_J = accumulated_energy_J(record, repeat) if len(volumes) == 2 else None
        if not stated or not energy_J or not sum(volumes) > 0.0:
            continue
        ratio = sum(volumes) / (stated * energy_J)
        if not 1.0 / OTHER_WEAR < ratio < OTHER_WEAR:
            text = (
                f"The scars of repeat {repeat} have lost {ratio:.3g} times what {energy_J:.3g} J of friction wear at "
                f"the stated {stated:g} mm³/J: they may be of another test, or in another unit."
            )
            yield Remark("problem" if not 1.0 / IMPOSSIBLE_WEAR < ratio < IMPOSSIBLE_WEAR else "note", "scars", text)


def _findings(scar: MeasuredScar, diameter_um: float) -> Iterator[Remark]:
    name = f"the {called(scar.body)}'s scar of repeat {scar.repeat}"
    depth = scar.depth_um
    if not np.isfinite(depth).any():
        yield Remark("problem", "scars", f"All depths are missing in {name}.")
        return
    # Missing points, as a share of the map, from which on it is worth a remark.
    if scar.gaps > 0.01:
        text = f"{100.0 * scar.gaps:.2g} % of the points are missing in {name}"
        yield Remark("note", "scars", f"{'; '.join(filter(None, (text, scar.lost)))}.")
    if scar.spikes_note:
        yield Remark("note", "scars", f"{scar.spikes_note}.")
    lowest, deepest = float(np.nanpercentile(depth, 0.5)), scar.figures["depth"]
    if (most := float(np.nanmax(depth))) > diameter_um:
        text = f"Depths reach {most:.3g} µm in {name}, more than the smallest diameter of {diameter_um:.3g} µm."
        yield Remark("problem", "scars", text, refuses=True)
        return
    if lowest < -BEYOND_NOISE_um and -lowest > deepest:
        text = f"Depths fall to {lowest:.3g} µm in {name} and rise to {deepest:.3g} µm only: their sign seems wrong."
        yield Remark("problem", "scars", text, refuses=True)
    elif lowest < -max(RAISED * deepest, BEYOND_NOISE_um):
        text = f"Depths fall to {lowest:.3g} µm in {name}: material is piled up there, or the zero is off."
        yield Remark("note", "scars", text)
    if deepest <= 0.0:
        yield Remark("note", "scars", f"Nothing is worn in {name}.")
        return
    edge = float(np.percentile(scar.rim_um, 98))
    # Depth at the map's edge, as a share of the deepest point, from which on the scar seems cut off.
    if edge > 0.2 * deepest:
        text = f"The map seems to cut off {name}: at its edge the depth is still {edge:.3g} µm of {deepest:.3g} µm."
        yield Remark("problem", "scars", text)
    elif scar.border_note:
        yield Remark("note", "scars", f"{scar.border_note}.")


def profile_remarks(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on implausible friction, assumed heights of bodies, and profiles of a line contact's record."""
    record: LineRecord = checked.record
    if (friction := record.tables.stated.friction) is not None:
        known = (one.friction_max.value for one in checked.figures.values() if one.friction_max is not None)
        if (largest := max(known, default=0.0)) > 3.0 * max(friction, 0.01):
            text = f"the largest force over load is {largest:.3g}, three times the stated friction: is one per mm?"
            yield Remark("problem", "friction", text)
    yield from _bodies_remarks(record)
    for profile in record.scars:
        yield from _profile_remarks(record, profile)
    for text in unlike_profiles(record):
        yield Remark("problem", "profiles", text)


def _bodies_remarks(record: LineRecord) -> list[Remark]:
    """Remarks on assumed heights of bodies, whose compliance adds to the rig's."""
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
    found = [Remark("note", "profiles", f"{profile.spikes_note}.")] if profile.spikes_note else []
    if deepest <= 0.0:
        return [*found, Remark("note", "profiles", f"{who} shows no wear.")]
    ends = max(profile.smooth_um[0], profile.smooth_um[-1])
    # Share of the largest depth that may stand at the end of a profile.
    if ends > 0.1 * deepest:
        found.append(Remark("problem", "profiles", f"{who} ends inside the scar, {ends:.3g} µm deep."))
    elif profile.border_note:
        found.append(Remark("note", "profiles", f"{profile.border_note}."))
    expected = _expected_area(record, profile.body)
    if expected is not None and not 1.0 / _AREA < profile.area_um2 / expected < _AREA:
        text = f"{who} has lost {profile.area_um2:.3g} µm², expected {expected:.3g}: check its units."
        found.append(Remark("problem", "profiles", text))
    return found


def _expected_area(record: LineRecord, body: str) -> float | None:
    """Worn cross-section in µm² in gross slip on a rigid rig, from stated values; None if too little is stated."""
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
    """Sentences on profiles of a repeat whose lengths do not fit together."""
    for repeat in record.repeats:
        of_repeat = [profile for profile in record.scars if profile.repeat == repeat]
        spreads = {profile.body: spread for profile in of_repeat if (spread := _spread_um2(profile)) is not None}
        if len(of_repeat) == len(spreads) == 2:
            depth_um = sum(float(profile.depth_um.max()) for profile in of_repeat)
            if found := next(_unlike(record, depth_um, spreads["pad"], spreads["specimen"]), None):
                yield f"{found} in repeat {repeat}: is one of the other body, of another scale or of another test?"


def _unlike(record: LineRecord, depth_um: float, pad_um2: float, specimen_um2: float) -> Iterator[str]:
    # In kinematic wear, whichever body wears more, the flat's spread is 1.00 to 1.42 times the pad's, in simulated
    # records 1.03 to 1.44; repeats scatter by 0.01.
    if specimen_um2 < 0.95**2 * pad_um2:
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
    """Second moment in µm² of a profile about its middle; None if the scar does not stand out."""
    deepest, lowest = float(profile.depth_um.max()), float(np.percentile(profile.depth_um, 0.5))
    if deepest <= CLEAR * max(-lowest, 0.0) or deepest <= 0.0 or profile.x_um.size < 3:
        return None
    weights = np.maximum(profile.depth_um - LEVEL * deepest, 0.0) * np.gradient(profile.x_um)
    weights /= weights.sum()
    return float(np.sum(weights * (profile.x_um - np.sum(weights * profile.x_um)) ** 2))
