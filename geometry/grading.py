"""Positions of mesh lines on one axis: gradings of a contact patch's grid, and layers of elements below it.

Below a contact, columns of elements go down into the body; a transition row joins three neighbouring columns into one.
"""

from dataclasses import dataclass, replace
from math import log

import numpy as np

from geometry.arrays import Array
from geometry.errors import GeometryError


@dataclass(frozen=True)
class GradedAxis:
    """Mesh lines on one axis of a contact patch, symmetric about zero, fine in the middle.

    Elements measure `fine_mm` for |x| up to `fine_half_extent_mm`, then grow by the factor `growth` from one to the
    next, never beyond `outer_mm`, up to the patch's edge at |x| = `half_extent_mm`. All sizes are scaled by a common
    factor, a change of the whole by less than one element, so that the last element ends on the edge. Raises
    GeometryError if the patch holds no element.
    """

    fine_mm: float
    fine_half_extent_mm: float
    outer_mm: float
    half_extent_mm: float
    growth: float = 1.2

    def __post_init__(self) -> None:
        if self.fine_mm > self.half_extent_mm:
            raise GeometryError(
                f"an element of {self.fine_mm} mm does not fit between the middle and the edge of a contact patch of "
                f"half-extent {self.half_extent_mm} mm; give a finer mesh"
            )

    @property
    def finest_mm(self) -> float:
        return float(self.half_lines()[1])

    def half_lines(self) -> Array:
        """Mesh lines (n,) in mm from 0 to the patch's edge, both included."""
        lines = [0.0]
        size = self.fine_mm
        while lines[-1] < self.half_extent_mm - 0.3 * size:
            lines.append(lines[-1] + size)
            if lines[-1] >= self.fine_half_extent_mm - 1e-9 * self.fine_mm:
                size = min(size * self.growth, self.outer_mm)
        half_lines = np.array(lines) * (self.half_extent_mm / lines[-1])
        half_lines[-1] = self.half_extent_mm
        return half_lines

    def lines(self) -> Array:
        """Mesh lines (2 n - 1,) in mm over the whole patch, exactly antisymmetric about 0."""
        half_lines = self.half_lines()
        return np.concatenate([-half_lines[:0:-1], half_lines])


@dataclass(frozen=True)
class EdgeGradedAxis:
    """Mesh lines of a contact patch, symmetric about zero, that are fine near its ends and coarser in the middle.

    Elements measure at most `fine_mm` from |x| = `fine_from_mm` to the patch's edge at `half_extent_mm`, and grow by
    the factor `growth` from one to the next towards the middle, never beyond `coarse_mm`. Raises GeometryError if
    either zone holds no element.
    """

    fine_mm: float
    coarse_mm: float
    fine_from_mm: float
    half_extent_mm: float
    growth: float = 1.2

    def __post_init__(self) -> None:
        if not self.fine_mm <= self.fine_from_mm <= self.half_extent_mm - self.fine_mm:
            raise GeometryError(
                f"the fine zones of a contact patch of half-extent {self.half_extent_mm} mm must hold an element of "
                f"{self.fine_mm} mm and leave one in the middle, but begin at {self.fine_from_mm} mm"
            )

    def half_lines(self) -> Array:
        """Mesh lines (n,) in mm from 0 to the patch's edge, both included."""
        middle = graded_layers(self.fine_mm, self.growth, self.coarse_mm, self.fine_from_mm)[::-1]
        width = self.half_extent_mm - self.fine_from_mm
        fine = np.linspace(self.fine_from_mm, self.half_extent_mm, int(np.ceil(width / self.fine_mm - 1e-9)) + 1)
        return np.concatenate([[0.0], np.cumsum(middle)[:-1], fine])


@dataclass(frozen=True)
class RimGradedAxis:
    """Mesh lines of a contact patch, symmetric about zero, that are finest at the contact's rim and coarser inside.

    From the middle to the rim at |x| = `rim_mm` there are `elements` elements; line i is at rim_mm sin(i q / elements)
    / sin(q) with q = `share` π / 2. Beyond the rim the sizes grow again in the reverse order, then by the factor
    `growth` from one to the next, up to the patch's edge at `half_extent_mm`. Raises GeometryError for fewer than two
    elements, or a rim that is not inside the patch.
    """

    rim_mm: float
    elements: int
    half_extent_mm: float
    share: float = 0.7
    growth: float = 1.4

    def __post_init__(self) -> None:
        if not (self.elements >= 2 and 0.0 < self.rim_mm < self.half_extent_mm):
            raise GeometryError(
                f"a contact patch of half-extent {self.half_extent_mm} mm must reach beyond the rim at {self.rim_mm} "
                f"mm that {self.elements} elements lead to, at least 2"
            )

    @property
    def fine_mm(self) -> float:
        """Spacing of the mesh lines just inside the rim."""
        return float(self.rim_mm - self._to_rim()[-2])

    @property
    def finest_mm(self) -> float:
        return float(np.diff(self.half_lines()).min())

    @property
    def outer_mm(self) -> float:
        """Spacing of the mesh lines in the middle, the largest inside the rim."""
        return float(self._to_rim()[1])

    def _to_rim(self) -> Array:
        turned = np.linspace(0.0, 0.5 * np.pi * self.share, self.elements + 1)
        return np.asarray(np.sin(turned) * (self.rim_mm / np.sin(turned[-1])))

    def half_lines(self) -> Array:
        """Mesh lines (n,) in mm from 0 to the patch's edge, both included."""
        within = self._to_rim()
        sizes, rest = np.diff(within)[::-1], self.half_extent_mm - self.rim_mm
        beyond = [0.0]
        for size in sizes:
            if beyond[-1] >= rest - 0.3 * size:
                break
            beyond.append(beyond[-1] + float(size))
        while beyond[-1] < rest - 0.3 * size:
            size *= self.growth
            beyond.append(beyond[-1] + float(size))
        beyond_rim = np.array(beyond[1:]) * (rest / beyond[-1])
        beyond_rim[-1] = rest
        return np.concatenate([within, self.rim_mm + beyond_rim])

    def lines(self) -> Array:
        """Mesh lines (2 n - 1,) in mm over the whole patch, exactly antisymmetric about 0."""
        half_lines = self.half_lines()
        return np.concatenate([-half_lines[:0:-1], half_lines])


@dataclass(frozen=True)
class GivenAxis:
    """Mesh lines of a contact patch that a file gives, increasing; they need not be symmetric."""

    lines_mm: tuple[float, ...]

    @property
    def fine_mm(self) -> float:
        return float(np.diff(self.lines_mm).min())

    @property
    def finest_mm(self) -> float:
        return self.fine_mm

    @property
    def outer_mm(self) -> float:
        return float(np.diff(self.lines_mm).max())

    @property
    def half_extent_mm(self) -> float:
        """Distance from zero up to which the lines reach on both sides."""
        return min(-self.lines_mm[0], self.lines_mm[-1])

    def half_lines(self) -> Array:
        """Mesh lines (n,) in mm that are not negative."""
        return np.array([line for line in self.lines_mm if line >= 0.0])

    def lines(self) -> Array:
        return np.array(self.lines_mm)


@dataclass(frozen=True)
class Layering:
    """Layers of elements under a contact patch, from the surface to the first row in which columns are joined."""

    #: Number of layers above each row that joins columns. Refined together with the patch, they reach to the same
    #: depth; were their number fixed, refining would make the body coarse ever closer under the contact.
    count: int = 5
    growth: float = 1.3  #: Thickness of a layer over that of the layer above it.
    first: float = 0.6  #: Thickness of the uppermost layer over the patch's finest spacing.

    @classmethod
    def resolving(cls, per_contact_radius: float, elongation: float = 1.0) -> "Layering":
        """The layering for a mesh of `per_contact_radius` elements per contact radius: the standard one up to 4, finer
        beyond.

        elongation: geometric mean of the contact's two half-axes over the shorter one. Stresses of a long contact reach
        deeper, so the columns of elements are first joined at a depth greater by this factor.
        """
        layers = cls().refined(max(1.0, per_contact_radius / 4.0))
        count = log(1.0 + elongation * (layers.growth**layers.count - 1.0)) / log(layers.growth)
        return replace(layers, count=round(count))

    def refined(self, factor: float) -> "Layering":
        """Layers thinner by `factor`, and more of them, that reach to about the same depth."""
        return Layering(max(2, round(self.count * factor)), float(self.growth ** (1.0 / factor)), self.first)

    def deeper(self, factor: float) -> "Layering":
        """About `factor` times as many layers, of the same thicknesses, above each row that joins columns."""
        return Layering(round(self.count * factor), self.growth, self.first)


def graded_layers(first_mm: float, growth: float, largest_mm: float, extent_mm: float) -> Array:
    """Thicknesses (n,) in mm of layers that grow from `first_mm` by the factor `growth` up to `largest_mm` and fill
    `extent_mm`.

    All are scaled by a common factor so that their sum is `extent_mm`. Raises GeometryError unless 0 < `first_mm` <=
    `extent_mm`, `largest_mm` > 0 and `growth` >= 1.
    """
    if not (0.0 < first_mm <= extent_mm and largest_mm > 0.0 and growth >= 1.0):
        raise GeometryError(
            f"layers that grow from {first_mm} mm by the factor {growth} to at most {largest_mm} mm cannot fill "
            f"{extent_mm} mm; sizes must be positive, the growth at least 1, and the first layer must fit"
        )
    thicknesses: list[float] = []
    size = first_mm
    while sum(thicknesses) < extent_mm - 0.3 * size:
        thicknesses.append(size)
        size = min(size * growth, largest_mm)
    layers = np.array(thicknesses)
    return layers * (extent_mm / sum(thicknesses))
