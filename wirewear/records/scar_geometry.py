"""What the sizes of two scars must have in common, as the wires wore each other: in widths, depths, stroke and volume.

Two cylinders that overlap by a depth d_t, the sum of both scars' depths, touch where their gap is below it. Across the
motion, which runs along the moving wire, this spot reaches y² = 2R·d_t at any crossing angle, on both wires. Along the
motion it is longer by 1/sin θ · √(1 + cos² θ), and on the moving wire by the stroke. It leans towards the bisector of
the wires' axes: its mixed moment is cot θ of that across, which the stroke leaves alone. Sizes are second moments of
what lies deeper than a quarter of the deepest point, of a paraboloid 1/8 of its squared half width.

In the records of the frozen blind batches, with every effect that rigs have, and in kinematic wear at 30° to 90°, the
moment across is 0.74 to 1.04 of that, both wires' differ by 3 %, along the motion the fixed wire's is 0.73 to 0.86 of
the spot's, and the moving wire's spread exceeds the spot's by 0.3 to 0.61 stroke amplitudes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from geometry import Elastic
from wirewear.records.surfaces import MeasuredScar
from wirewear.records.values import ExperimentRecord
from wirewear.reference.hertz import hertz_crossed_cylinders

#: Of the deepest point: what is less deep may be noise.
LEVEL = 0.25

#: A scar that is not this many times as deep as what its map falls below zero is none whose size is known.
CLEAR = 8.0

#: Factors on moments that no scar of the same test reached by far: half again of the largest and half of the least.
WIDEST, NARROWEST, UNLIKE = 1.5, 0.5, 1.25

#: Along the motion, over the spot's: of the fixed wire at most, of the moving wire at least.
LONGEST_FIXED, SHORTEST_MOVING = 1.15, 0.9

#: By what crossing angles may be wrong [deg].
ASKEW_deg = 6.0

_WHY = "are x and y exchanged, or is a map of the other wire, of another scale or of another test?"


@dataclass(frozen=True)
class ScarSize:
    """Depth [µm] and second moments along and across the motion [µm²] of a scar, and the mixed one."""

    depth_um: float
    along_um2: float
    across_um2: float
    mixed_um2: float

    @classmethod
    def of(cls, scar: MeasuredScar) -> ScarSize | None:
        """Those of a map, or None where the scar does not stand out from the map."""
        known = scar.depth_um[np.isfinite(scar.depth_um)]
        if not known.size:
            return None
        lowest, depth = (float(v) for v in np.percentile(known, [0.5, 99.5]))
        if depth <= CLEAR * max(-lowest, 0.0) or depth <= 0.0:
            return None
        cells = np.gradient(scar.x_um)[:, None] * np.gradient(scar.y_um)[None, :]
        weights = np.clip(np.nan_to_num(scar.depth_um), LEVEL * depth, depth) - LEVEL * depth
        weights = weights * cells / np.sum(weights * cells)
        x = scar.x_um - np.sum(weights.sum(axis=1) * scar.x_um)
        y = scar.y_um - np.sum(weights.sum(axis=0) * scar.y_um)
        products = x[:, None] ** 2, y[None, :] ** 2, x[:, None] * y[None, :]
        return cls(depth, *(float(np.sum(weights * product)) for product in products))


def unlike_sizes(record: ExperimentRecord) -> Iterator[str]:
    """What the scars of each repeat cannot be, sentences."""
    # Across its own axis the moving wire carries the contact about on the fixed one.
    for repeat in record.repeats if not record.tables.wires.motion_angle_deg else ():
        sizes = {scar.body: ScarSize.of(scar) for scar in record.scars if scar.repeat == repeat}
        known = {wire: size for wire, size in sizes.items() if size is not None}
        if found := next(_unlike(record, known), None):
            yield f"{found} in repeat {repeat}: {_WHY}"
        for mirrored in _mirrored(record, known):
            yield f"{mirrored}, in repeat {repeat}."


def _unlike(record: ExperimentRecord, sizes: dict[str, ScarSize]) -> Iterator[str]:
    wires, amplitude = record.tables.wires, record.tables.conditions.displacement_amplitude_um
    elastic = _elastic_um2(record)
    if len(sizes) == 2:
        first, second = (size.across_um2 for size in sizes.values())
        if not 1.0 / UNLIKE < first / second < UNLIKE:
            ratio = max(first, second) / min(first, second)
            yield f"One wire's scar is {ratio**0.5:.2g} times as wide across the motion as the other's that wore it"
        worn = 1e3 * wires.diameter_mm * sum(size.depth_um for size in sizes.values())
        expected = (1.0 - LEVEL) * worn / 6.0
        for wire, size in sizes.items():
            if not NARROWEST * expected < size.across_um2 < WIDEST * expected + elastic:
                ratio = float(np.sqrt(size.across_um2 / expected))
                yield f"The {wire} wire's scar is {ratio:.2g} times as wide as both scars' depths make it"
    angles = np.radians(np.clip(wires.crossing_angle_deg + np.array([-ASKEW_deg, 0.0, ASKEW_deg]), 1.0, 90.0))
    longer = (1.0 + np.cos(angles) ** 2) / np.sin(angles) ** 2
    for wire, size in sizes.items():
        shortest, longest = (float(end) * size.across_um2 for end in (longer.min(), longer.max()))
        reach = amplitude / np.sqrt(2.0) if wire == "moving" else 0.0
        if size.along_um2 > (np.sqrt(LONGEST_FIXED * longest + elastic) + reach) ** 2:
            yield f"The {wire} wire's scar is longer along the motion than its width and the stroke make it"
        if wire == "moving" and size.along_um2 < SHORTEST_MOVING * shortest:
            yield "The moving wire's scar is shorter along the motion than its width makes it"


def _mirrored(record: ExperimentRecord, scars: dict[str, ScarSize]) -> Iterator[str]:
    """Scars that lean to the wrong side; where wires cross at 90° within what angles may be wrong, none leans."""
    crossing = record.tables.wires.crossing_angle_deg
    if crossing + ASKEW_deg < 90.0:
        lean = 1.0 / float(np.tan(np.radians(crossing)))
        for wire in (wire for wire, size in scars.items() if size.mixed_um2 < -0.5 * lean * size.across_um2):
            yield (
                f"The {wire} wire's scar leans away from the other wire, which crosses at {crossing:g}°, as one does "
                "whose x or y is mirrored"
            )


def _elastic_um2(record: ExperimentRecord) -> float:
    """Square of the unworn contact's larger half width [µm²]: where little is worn, scars may be rings of that size."""
    wires, load = record.tables.wires, record.tables.conditions.normal_load_N
    body, radius = Elastic(wires.youngs_modulus_MPa, wires.poissons_ratio), 0.5 * wires.diameter_mm
    contact = hertz_crossed_cylinders(load, radius, radius, wires.crossing_angle_deg, first=body, second=body)
    return (1e3 * contact.major_semi_axis_mm) ** 2
