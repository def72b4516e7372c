"""Unworn surfaces of bodies, as they may lie under a map or profile of heights.

A surface's parameters first give its position (placing), then its form: the deviation of the body's shape from the
stated one. The crown is the highest line or point of a round body. Along and across are meant of the body's axis.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from geometry import Barrel, Flat
from geometry.arrays import Array
from wirewear.results.scar import called
from wirewear.test.faces import Face

ALIKE = 1e-3  #: A radius that differs by less is the stated one.


class Surface(Protocol):
    """Unworn surface of a body with `placing` parameters for its position and `forms` further ones for its form.

    A parameter of 1 moves the border of the map by about 1 µm in height.
    """

    @property
    def placing(self) -> int: ...
    @property
    def forms(self) -> int: ...

    def form_text(self, parameters: Array, body: str) -> str:
        """Beginning of a sentence on how the form at these parameters, as of `height`, deviates from the stated shape;
        "" for a plane. body: its name.
        """

    def height(self, parameters: Array, at: Array) -> Array:
        """Heights (m,) in µm at places (2, m) in µm. parameters: (placing + forms,), or fewer, of which the missing
        last ones are 0.
        """


@dataclass(frozen=True)
class RoundSurface:
    """Body that is round or straight along and across its axis, under a map of half sizes `half_um`, both along and
    across.

    Placing: level, shift (if round) or tilt (if straight) along and across, and rotation of an axis. Forms: curvature
    if round, for a ball also its change outwards and its difference along and across; bending if straight.
    """

    curvatures_per_mm: tuple[float, float]
    half_um: tuple[float, float]

    @property
    def placing(self) -> int:
        along, across = self.curvatures_per_mm
        return 3 if along == across else 4

    @property
    def forms(self) -> int:
        along, across = self.curvatures_per_mm
        return 2 if along != across else 4 if along else 3

    @cached_property
    def scales(self) -> Array:
        """Level in µm, shifts in µm or tilts along and across, and tangent of the rotation, each for a parameter of 1
        (4,).
        """
        k, half = 1e-3 * np.array(self.curvatures_per_mm), np.array(self.half_um)
        moves = np.where(k > 0.0, 1.0 / np.maximum(k * half, 1e-12), 1.0 / half)
        twist = abs(k[0] - k[1]) * half[0] * half[1]
        return np.array([1.0, *moves, 1.0 / max(twist, 1e-12)])

    def beside(self, parameters: Array, at: Array) -> Array:
        """Coordinates (2, m) in µm, along and across the axis, of places (2, m) from the crown; from the map's middle
        if straight.
        """
        _, along, across, turn = self._placed(parameters)
        moved = np.where(np.array(self.curvatures_per_mm) > 0.0, (along, across), 0.0)
        return np.asarray((at - turn * np.stack([-at[1], at[0]])) / np.sqrt(1.0 + turn**2) - moved[:, None])

    def turned_deg(self, parameters: Array) -> float:
        """Angle in degrees by which, at these parameters, the axis is rotated against the stated direction."""
        return float(np.degrees(np.arctan(self._placed(parameters)[3])))

    def moving(self, places_um: Array) -> Array:
        """Position parameters that put the crown of a round body at `places_um` (2,); all others are 0."""
        return np.array([0.0, *places_um / self.scales[1:3], 0.0][: self.placing])

    def curvatures(self, parameters: Array) -> Array:
        """Curvatures (2,) along and across in 1/mm, the stated ones plus the form's."""
        k, half = np.array(self.curvatures_per_mm), np.array(self.half_um)
        form = np.zeros(4)
        form[: max(parameters.size - self.placing, 0)] = parameters[self.placing :]
        if k[0] == k[1] > 0.0:
            form[1] = form[0] = form[0] / 2.0
        return np.asarray(np.where(k > 0.0, k, 0.0) + 2e3 * form[:2] / half**2)

    def form_text(self, parameters: Array, body: str) -> str:
        """Beginning of a sentence on the radius that differs most from the stated one, or on a body that is not
        straight.
        """
        stated, near = np.array(self.curvatures_per_mm), np.array(parameters)
        if self.placing == 3 and stated.all() and near.size == self.placing + self.forms:
            # The radius that comes nearest over the map, not that of the crown.
            # What a bow of fourth order has of second order, by the least squares of a parabola over a square.
            near[self.placing] += 0.76 * near[self.placing + 1]
        found = self.curvatures(near)
        one = int(np.argmax(np.abs(found - stated) * np.array(self.half_um) ** 2))
        if not stated[one]:
            return f"where it is unworn, the {called(body)} is not straight"
        if abs(found[one] / stated[one] - 1.0) < ALIKE:
            return f"where it is unworn, the {called(body)} is not round"
        return (
            f"where it is unworn, the {called(body)} has a radius of {1.0 / found[one]:.5g} mm, not of "
            f"{1.0 / stated[one]:.5g} mm as stated (diameter_mm = {2.0 / found[one]:.5g})"
        )

    def height(self, parameters: Array, at: Array) -> Array:
        """Heights (m,) in µm at places (2, m) in µm along and across the axis."""
        level, along, across, _ = self._placed(parameters)
        straight = np.array(self.curvatures_per_mm) == 0.0
        tilt, beside = np.where(straight, (along, across), 0.0), self.beside(parameters, at)
        k = self.curvatures(parameters)
        face = Barrel(*np.where(straight, 0.0, np.maximum(k, 0.1 * np.array(self.curvatures_per_mm))))
        bows = -5e-4 * np.where(straight, k, 0.0) @ beside**2
        whole, (u, v) = parameters.size == self.placing + self.forms, beside / np.array(self.half_um)[:, None]
        if whole and self.placing == 3 and not straight.any():
            outwards, unlike, twist = parameters[self.placing + 1 :]
            outer = np.sum(beside**2, axis=0) / np.sum(np.square(self.half_um))
            bows = bows - outwards * outer**2 - unlike * (u**2 - v**2) - twist * u * v
        if whole and straight.all():
            bows = bows - parameters[-1] * u * v
        return np.asarray(level + tilt @ at + 1e3 * face.height(1e-3 * beside.T) + bows)

    def _placed(self, parameters: Array) -> Array:
        return self.scales * np.append(parameters[: self.placing], np.zeros(4 - self.placing))


@dataclass(frozen=True)
class FaceSurface:
    """Face of a line contact's body under a profile of half length `half_um`.

    Placing: level, tilt and, if `shifts` is True as for a face with edges, a shift (for a cylinder, a shift is a tilt).
    Forms: bending, if the face does not shift.
    """

    face: Face | Flat
    half_um: float
    shifts: bool

    @property
    def placing(self) -> int:
        return 3 if self.shifts else 2

    @property
    def forms(self) -> int:
        return 0 if self.shifts else 1

    def form_text(self, parameters: Array, body: str) -> str:  # noqa: ARG002
        return f"where it is unworn, the {body} bows"

    def height(self, parameters: Array, at: Array) -> Array:
        """Heights (m,) in µm at places (2, m) in µm, of which the second coordinate has no effect. parameters: level in
        µm, tilt, then shift or bending, as the class says.
        """
        level, tilt, *more = parameters
        beside = at[0] - (self.half_um * 0.1 * more[0] if self.shifts else 0.0)
        shape = 1e3 * self.face.height(1e-3 * np.column_stack([beside, np.zeros_like(beside)]))
        bow = more[0] if more and not self.shifts else 0.0
        return np.asarray(level + tilt * at[0] / self.half_um + shape - bow * (at[0] / self.half_um) ** 2)


@dataclass(frozen=True)
class LevelSurface:
    """Horizontal plane; its only parameter is its height in µm."""

    placing: int = 1
    forms: int = 0

    def form_text(self, parameters: Array, body: str) -> str:  # noqa: ARG002
        return ""

    def height(self, parameters: Array, at: Array) -> Array:
        return np.full(at.shape[1], parameters[0])


def jacobian(surface: Surface, parameters: Array, at: Array, size: int) -> tuple[Array, Array]:
    """Heights (m,) in µm of a surface at places (2, m), and their derivatives (m, size) by its first `size`
    parameters.
    """
    whole = np.append(parameters, np.zeros(max(size - parameters.size, 0)))
    middle, steps = surface.height(parameters, at), 0.01 * np.eye(whole.size)[:size]
    return middle, np.stack([(surface.height(whole + step, at) - middle) / 0.01 for step in steps], axis=1)
