"""Two crossed wires on an elastic foundation: pressures and forces at every position of the stroke at once.

Each point of the plane carries p = k · overlap on its own (Winkler). Heights are those of exact cylinders less what is
worn; the fixed wire's lie on a grid (n_y, n_x), the moving wire's on one longer by the stroke, (n_y, n_x + 2 n_s), so
that a stroke position is a shift by whole columns. Lengths in mm, forces in N.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

Array = NDArray[np.float64]

#: Newton steps for the approach; the force is convex in it, so few are needed.
NEWTON_STEPS, NEWTON_TOLERANCE = 60, 1e-10
MOMENTS = 7  #: Powers of the slope in the series of the tangential force.


@dataclass(frozen=True, eq=False)
class Grid:
    """A square grid over the contact, and stroke positions a spacing apart."""

    spacing_mm: float
    half_columns: int
    half_rows: int
    half_positions: int

    @classmethod
    def around(cls, extent_mm: float, stroke_mm: float, points: int) -> "Grid":
        """A grid over ±extent with that many points to each side, for slip to ±stroke."""
        spacing = extent_mm / points
        return cls(spacing, points, points, int(np.ceil(stroke_mm / spacing)) + 1)

    @cached_property
    def x_mm(self) -> Array:
        """Columns of the fixed wire's grid (n_x,)."""
        return self.spacing_mm * np.arange(-self.half_columns, self.half_columns + 1.0)

    @cached_property
    def y_mm(self) -> Array:
        """Rows of both grids (n_y,)."""
        return self.spacing_mm * np.arange(-self.half_rows, self.half_rows + 1.0)

    @cached_property
    def positions_mm(self) -> Array:
        """Stroke positions (n_p,): the moving wire's displacement against the fixed one."""
        return self.spacing_mm * np.arange(-self.half_positions, self.half_positions + 1.0)

    @cached_property
    def moving_x_mm(self) -> Array:
        """Columns of the moving wire's grid (n_x + 2 n_s,) in its own frame."""
        half = self.half_columns + self.half_positions
        return self.spacing_mm * np.arange(-half, half + 1.0)

    def windows(self, moving: Array) -> Array:
        """A field of the moving wire above the fixed grid, at every position: a view (n_y, n_p, n_x)."""
        return np.asarray(sliding_window_view(moving, self.x_mm.size, axis=1)[:, ::-1, :])

    def gathered(self, field: Array) -> Array:
        """The transpose of `windows`: a field (n_y, n_p, n_x) summed where it lies on the moving wire."""
        rows, positions, columns = field.shape
        out = np.zeros((rows, columns + positions - 1))
        for place in range(positions):
            start = positions - 1 - place
            out[:, start : start + columns] += field[:, place, :]
        return out

    def path_weights(self, low_mm: float, high_mm: float) -> Array:
        """How much of a path from low to high belongs to each position (n_p,)."""
        edges = np.append(self.positions_mm - 0.5 * self.spacing_mm, self.positions_mm[-1] + 0.5 * self.spacing_mm)
        inside = np.clip(edges, low_mm, high_mm)
        return np.diff(inside)


@dataclass(frozen=True, eq=False)
class Shapes:
    """What both wires have lost: `fixed` (n_y, n_x), `moving` (n_y, n_x + 2 n_s), heights [mm]."""

    fixed: Array
    moving: Array

    def plus(self, share: float, rate: "Shapes") -> "Shapes":
        """These and a multiple of others."""
        return Shapes(self.fixed + share * rate.fixed, self.moving + share * rate.moving)


@dataclass(frozen=True, eq=False)
class Bodies:
    """Unworn wires above each other; `crossing_error_rad` turns the fixed wire, `tilt_rad` lets the moving one fall
    along the motion in its own frame, so that moving on pushes the fixed wire up. The fixed wire's section is an
    ellipse as large as the circle; its radius at the crown is `fixed_crown` times the circle's.
    """

    grid: Grid
    radius_mm: float
    crossing_error_rad: float = 0.0
    tilt_rad: float = 0.0
    fixed_crown: float = 1.0

    @cached_property
    def distance_mm(self) -> Array:
        """Vertical distance of the unworn wires at every position, first touch at 0: (n_y, n_p, n_x)."""
        x, y = self.grid.x_mm[None, :], self.grid.y_mm[:, None]
        across = x * np.cos(self.crossing_error_rad) + y * np.sin(self.crossing_error_rad)
        apart = self._fixed_sagitta(across) + _sagitta(y, self.radius_mm)
        along = np.tan(self.tilt_rad) * (x[None] - self.grid.positions_mm[None, :, None])
        return np.asarray(apart[:, None, :] + along)

    @cached_property
    def fixed_slope(self) -> Array:
        """Slope of the unworn fixed wire along the motion (n_y, n_x)."""
        x, y = self.grid.x_mm[None, :], self.grid.y_mm[:, None]
        turn = np.cos(self.crossing_error_rad)
        across = x * turn + y * np.sin(self.crossing_error_rad)
        if self.fixed_crown == 1.0:
            return np.asarray(turn * across / np.sqrt(self.radius_mm**2 - across**2))
        wide, high = self._fixed_axes_mm
        return np.asarray(turn * high * across / (wide * np.sqrt(wide**2 - across**2)))

    @property
    def _fixed_axes_mm(self) -> tuple[float, float]:
        """Half-axes of the fixed wire's section, across the load and along it: a c = R², a²/c = f R."""
        return self.radius_mm * self.fixed_crown ** (1.0 / 3.0), self.radius_mm / self.fixed_crown ** (1.0 / 3.0)

    def _fixed_sagitta(self, across: Array) -> Array:
        if self.fixed_crown == 1.0:
            return _sagitta(across, self.radius_mm)
        wide, high = self._fixed_axes_mm
        return np.asarray(high - high * np.sqrt(1.0 - (across / wide) ** 2))


def _sagitta(across: Array, radius: float) -> Array:
    return np.asarray(radius - np.sqrt(radius**2 - across**2))


@dataclass(frozen=True, eq=False)
class Foundation:
    """Stiffness of the foundation [MPa/mm], and a layer of debris: thickness (n_y, n_x) [mm] and modulus [MPa]."""

    stiffness: float
    layer: Array | None = None
    layer_modulus: float = 1.0

    @property
    def field(self) -> Array | float:
        """Stiffness at each point of the fixed grid, the layer in series: broadcasts to (n_y, n_p, n_x)."""
        if self.layer is None:
            return self.stiffness
        return np.asarray(1.0 / (1.0 / self.stiffness + self.layer / self.layer_modulus))[:, None, :]


@dataclass(frozen=True, eq=False)
class Load:
    """The load on a guide: at each position (n_p,) [N], less what the loading spring loses as the wires approach."""

    at_positions_N: Array
    spring_N_per_mm: float
    reference_mm: float


@dataclass(frozen=True, eq=False)
class Contact:
    """Equilibrium at every position: pressures (n_y, n_p, n_x) per plane area, approach (n_p,), load (n_p,)."""

    pressure: Array
    approach_mm: Array
    load_N: Array

    def effective_radius_mm(self, grid: Grid, weights: Array) -> float:
        """Radius of the paraboloid of pressure that is as concentrated as this one, on average over the path."""
        squares = np.einsum("ypx,ypx->p", self.pressure, self.pressure)
        sums = np.einsum("ypx->p", self.pressure)
        area = grid.spacing_mm**2 * sums**2 / np.maximum(squares, 1e-300)
        mean = np.average(area, weights=weights) if weights.sum() > 0.0 else area[area.size // 2]
        return float(np.sqrt(4.0 / 3.0 * mean / np.pi))


def solve_contact(
    bodies: Bodies, shapes: Shapes, foundation: Foundation, load: Load, start_mm: Array | None = None
) -> Contact:
    """Pressures that carry the load at every position, by Newton's method for the approach of each.
    Raises ArithmeticError if no approach carries the load.
    """
    grid = bodies.grid
    distance = bodies.distance_mm + shapes.fixed[:, None, :] + grid.windows(shapes.moving)
    if foundation.layer is not None:
        distance -= foundation.layer[:, None, :]
    lowest = distance.min(axis=(0, 2))
    approach = lowest + 1e-3 * bodies.radius_mm if start_mm is None else np.maximum(start_mm, lowest + 1e-9)
    closest = distance.min(axis=1)
    stiffness = np.broadcast_to(foundation.field, (closest.shape[0], 1, closest.shape[1]))
    bound = float(approach.max())
    pressure = np.zeros_like(distance)
    for _ in range(NEWTON_STEPS):
        # Most of the grid lies outside the contact until the scar has grown.
        bound += 0.2 * (bound - float(lowest.min()))
        rows, columns = (_span(np.any(closest < bound, axis=axis)) for axis in (1, 0))
        approach, held, inner = _newton(
            distance[rows, :, columns], stiffness[rows, :, columns], grid.spacing_mm**2, load, approach
        )
        if float(approach.max()) < bound:
            pressure[rows, :, columns] = inner
            return Contact(pressure, approach, held)
        bound = float(approach.max())
    raise ArithmeticError("no approach of the wires carries the load.")


def _span(marked: NDArray[np.bool_]) -> slice:
    places = np.flatnonzero(marked)
    return slice(int(places[0]), int(places[-1]) + 1)


def _newton(distance: Array, stiffness: Array, area: float, load: Load, approach: Array) -> tuple[Array, Array, Array]:
    """Approach and load (n_p,), and pressures, where the foundation carries what the spring leaves of the load."""
    lowest = distance.min(axis=(0, 2))
    for _ in range(NEWTON_STEPS):
        overlap = approach[None, :, None] - distance
        touching = overlap > 0.0
        pressure = stiffness * np.maximum(overlap, 0.0)
        held = load.at_positions_N - load.spring_N_per_mm * (approach - load.reference_mm)
        excess = area * pressure.sum(axis=(0, 2)) - held
        if float(np.abs(excess).max()) < NEWTON_TOLERANCE * float(np.abs(load.at_positions_N).max()):
            return approach, held, pressure
        slope = area * np.sum(touching * stiffness, axis=(0, 2)) + load.spring_N_per_mm
        approach = np.maximum(approach - excess / slope, lowest + 1e-12)
    raise ArithmeticError("no approach of the wires carries the load.")


def slopes(bodies: Bodies, shapes: Shapes) -> Array:
    """Slope up which the moving wire is pushed, the mean of both surfaces' (n_y, n_p, n_x).

    The moving wire lies below: where the interface falls along the motion, the fixed wire bears against it.
    """
    grid = bodies.grid
    fixed = bodies.fixed_slope + np.gradient(shapes.fixed, grid.spacing_mm, axis=1)
    moving = -np.tan(bodies.tilt_rad) - np.gradient(shapes.moving, grid.spacing_mm, axis=1)
    return np.asarray(-0.5 * (fixed[:, None, :] + grid.windows(moving)))


def friction_work(contact: Contact, slope: Array, friction: float) -> Array:
    """Work of friction per plane area and length of slip, over a path to and fro (n_y, n_p, n_x).

    A contact that slopes by θ carries p per plane area by a normal force p/(cos θ ∓ µ sin θ) when it slides up or down.
    """
    return np.asarray(2.0 * friction * contact.pressure * (1.0 + slope**2) / (1.0 - (friction * slope) ** 2))


def force_moments(bodies: Bodies, contact: Contact, slope: Array) -> Array:
    """Σ p θ^k dA at every position (MOMENTS, n_p), of which `tangential_force` is made."""
    rows, places, columns = np.nonzero(contact.pressure)
    steep = slope[rows, places, columns]
    power = contact.pressure[rows, places, columns] * bodies.grid.spacing_mm**2
    moments = np.empty((MOMENTS, bodies.grid.positions_mm.size))
    for k in range(MOMENTS):
        moments[k] = np.bincount(places, weights=power, minlength=moments.shape[1])
        power = power * steep
    return moments


def tangential_force(moments: Array, mobilised: Array) -> Array:
    """Force that resists motion when friction is mobilised to m (n,): Σ p (θ + m)/(1 − θ m) dA as a series in θ.

    `moments` (MOMENTS, n) belong to the same positions. This is p tan(atan θ + atan m), a block on a slope.
    """
    force = moments[0] * mobilised
    factor = 1.0 + mobilised**2
    for k in range(1, MOMENTS):
        force = force + moments[k] * factor
        factor = factor * mobilised
    return np.asarray(force)
