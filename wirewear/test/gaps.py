"""The gap between two unworn bodies, and how they touch: along a line, or at a point as Hertz says."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import radians
from typing import Self, TypeVar

import numpy as np

from geometry import Elastic
from geometry.arrays import Array
from solvers import Coating
from wirewear import reference
from wirewear.base.errors import StudyError
from wirewear.test.bodies import Body
from wirewear.test.faces import half_width_of
from wirewear.test.surfaces import coating_of

Found = TypeVar("Found")


@dataclass(frozen=True)
class Gap:
    """The gap rᵀHr between two unworn bodies, with r along and across the motion; `form` is H (2, 2) in 1/mm.

    Sheared by x → x + shear·y, which does not affect motion along x, the gap is (along·x² + y²)/2R: crossed wires of
    radius R have along = sin²θ and shear = −cot θ; a ball on a flat has the gap of wires at 90°.
    """

    form: Array

    @classmethod
    def of(cls, driven: Body, held: Body, turned_deg: float = 0.0) -> Self:
        """The gap of two bodies, the held one turned by `turned_deg` about the normal beyond its angle.
        Raises StudyError if one has the face of a pad, whose worn shapes are not similar to each other.
        """
        if driven.face or held.face:
            raise StudyError(
                "what a pad wears under other loads and strokes is not known: it has no radius of its own."
            )
        return cls(0.5 * (driven.curvature_per_mm() + held.curvature_per_mm(turned_deg)))

    @classmethod
    def like(cls, normal_load_N: float, driven: Body, held: Body) -> Self:
        """The gap of two bodies; with a pad, of a ball on a flat whose Hertz contact under this load is as wide."""
        if not (driven.face or held.face):
            return cls.of(driven, held)
        modulus = reference.contact_modulus(driven.material, held.material)
        radius_mm = hertz_of(normal_load_N, driven, held).contact_radius_mm
        return cls(np.eye(2) * 0.375 * normal_load_N / (modulus * radius_mm**3))

    @property
    def spot_mm(self) -> Array:
        """H⁻¹ (2, 2) in mm. Times a depth, its diagonal holds the squares of the half-widths, along x and y, of the
        ellipse where the gap is below that depth.
        """
        return np.asarray(np.linalg.inv(self.form), dtype=np.float64)

    @property
    def radius_mm(self) -> float:
        """Effective radius R in mm of the sheared gap (along·x² + y²)/2R."""
        return 0.5 * float(self.spot_mm[1, 1])

    @property
    def along(self) -> float:
        """Ratio of the sheared gap's curvatures, along the motion over across it."""
        return 2.0 * float(self.form[0, 0]) * self.radius_mm

    @property
    def shear(self) -> float:
        """λ = H_xy/H_xx, by which x → x + λ·y removes the gap's term in x·y."""
        return float(self.form[0, 1] / self.form[0, 0])


def touch_along_line(driven: Body, held: Body) -> bool:
    """True if two unworn bodies touch along a line or nearly so: their gap's curvatures differ a thousandfold."""
    crossing = radians(held.axis_angle_deg - driven.axis_angle_deg)
    small, large, _ = reference.gap_curvatures(driven.curvatures_per_mm, held.curvatures_per_mm, crossing)
    # Gaps flatter one way than the other by this are those of lines; equal cylinders come to it at 3.6°.
    return small <= 1e-3 * large


def hertz_of(normal_load_N: float, driven: Body, held: Body) -> reference.PointContact:
    """Hertz's contact of two unworn bodies; its angle is from the driven body's axis to the contact's major axis.
    Bodies under layers of other materials count as the half-spaces that yield as much under this contact.
    Raises StudyError if a pad is too small for the load.
    """
    both = driven, held
    return under_coats(
        lambda first, second: _hertz_of(normal_load_N, driven, held, first, second),
        (driven.material, held.material),
        [coating_of(body.layers, body.material) for body in both],
        lambda found: found.contact_radius_mm,
    )


def under_coats(
    contact: Callable[[Elastic, Elastic], Found],
    own: tuple[Elastic, Elastic],
    coatings: Sequence[Coating | None],
    radius_mm: Callable[[Found], float],
) -> Found:
    """The contact of two materials, each under its coating or None: that of the half-spaces that yield as much under a
    contact of the radius that it has then.
    """
    found = contact(*own)
    for _ in range(6 if any(coatings) else 0):  # rounds in which the radius settles
        felt = [
            one if coating is None else coating.felt(radius_mm(found))
            for one, coating in zip(own, coatings, strict=True)
        ]
        found = contact(*felt)
    return found


def _hertz_of(
    normal_load_N: float, driven: Body, held: Body, of_driven: Elastic, of_held: Elastic
) -> reference.PointContact:
    if (face := driven.face or held.face) is not None:
        modulus = reference.contact_modulus(of_driven, of_held)
        return on_pad(lambda: reference.turned_contact(face, normal_load_N, modulus, half_width_of(face)))
    pair = driven.curvatures_per_mm, held.curvatures_per_mm, radians(held.axis_angle_deg - driven.axis_angle_deg)
    return reference.hertz_bodies(normal_load_N, *pair, first=of_driven, second=of_held)


def unworn_stiffness_N_per_um(normal_load_N: float, driven: Body, held: Body) -> float:
    """Mindlin's tangential stiffness of a circular contact with the radius of Hertz's contact of two unworn bodies."""
    modulus = reference.tangential_contact_modulus(driven.material, held.material)
    return 1e-3 * reference.mindlin_stiffness(modulus, hertz_of(normal_load_N, driven, held).contact_radius_mm)


def on_pad(found: Callable[[], Found]) -> Found:
    """A pad's contact or scar, as the function `found` returns it. Raises StudyError where that raises ValueError,
    because the pad's face does not reach far enough.
    """
    try:
        return found()
    except ValueError as problem:
        raise StudyError(f"the pad is too small for this test: {problem}; lower load, cycles or wear.") from None
