"""What the sizes of a pad's and a flat's worn profile must have in common, as they wore each other.

A cylinder that lies deeper in a flat by the sum of both depths touches it over x² = 2R·d_t. The pad's scar is as long;
the flat's is longer by the stroke. Sizes are second moments of what lies deeper than a quarter of the deepest point, of
a parabola 3/20 of its squared half width, as in `wirewear.records.scar_geometry`.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from geometry import Elastic
from wirewear.records.line_values import LineRecord, MeasuredProfile
from wirewear.records.scar_geometry import CLEAR, LEVEL, NARROWEST, WIDEST
from wirewear.reference.hertz import contact_modulus, hertz_line

#: The flat's scar may seem shorter than the pad's by noise and by unlike wear of both, but not by this share.
SHORTER = 0.8


def unlike_profiles(record: LineRecord) -> Iterator[str]:
    """What the profiles of each repeat cannot be, sentences."""
    for repeat in record.repeats:
        of_repeat = [profile for profile in record.profiles if profile.repeat == repeat]
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
