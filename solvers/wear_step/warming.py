"""How the friction of a cycle warms both surfaces.

At a time t of a cycle of the period T that has gone on long, a surface is heated by q(t), a sum of harmonics of the
cycle, and each harmonic warms it by its own response (`solvers.conduction`). The rise that counts for friction and wear
at a place is its mean over the cycle with the friction power there as weight: the mean temperature, and the flash
temperature of the moments at which the place is rubbed. Both bodies share the power such that, on average over what
heat enters, both surfaces are as hot.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy

from geometry.arrays import Array, BoolArray, ComplexArray, IntArray
from geometry.patch import linear_weights
from solvers.conduction import Conductor, response, spread
from solvers.contact import ContactProblem
from solvers.elasticity.placement import PlacedBody
from solvers.laws.heat import FrictionHeat
from solvers.wear_step.orbits import Orbits, Position
from solvers.wear_step.places import WearStop
from solvers.wear_step.symmetry import Mirror

_CELLS = 32  # Along the longer side of what is rubbed.
_MOMENTS = 8  # Between two positions.


class Rises(NamedTuple):
    """Rises (n_a, n_t) in K of the temperature of (primary, secondary), and their mean where heat enters."""

    primary: Array
    secondary: Array
    mean_K: float


class _Surface(NamedTuple):
    """A body's surface in cells: values at nodes (n_a, n_t) are brought to cells (c_a, c_t) and back by matrices."""

    to_along: Array  #: (c_a, n_a)
    to_across: Array  #: (c_t, n_t)
    from_along: Array  #: (n_a, c_a)
    from_across: Array  #: (n_t, c_t)
    kernel: ComplexArray  #: (harmonics, ...) responses, see `solvers.conduction.response`.
    areas: Array  #: (n_a, n_t) mm² of the nodes.
    through_K_per_mW: float  #: Rise of the whole surface by the mean power.

    def warmed(self, heat: ComplexArray) -> tuple[Array, float]:
        """Rises (n_a, n_t) in K if all heat flowed into this body, and their mean where it enters. heat: (harmonics,
        n_a, n_t) in mW/mm².
        """
        power = float((heat[0].real * self.areas).sum())
        cells = self.to_along @ heat @ self.to_across.T
        cells *= power / max(float(cells[0].real.sum()), 1e-300)
        rises = spread(cells, self.kernel)
        # A cell's mean, and of its other harmonics what is in step with its own heat.
        flow = cells[0].real
        flash = 2.0 * (np.conj(cells[1:]) * rises[1:]).real.sum(axis=0)
        rise = rises[0].real + np.divide(flash, flow, out=np.zeros_like(flow), where=flow > 1e-9 * flow.max())
        rise += self.through_K_per_mW * power
        return self.from_along @ rise @ self.from_across.T, float((flow * rise).sum() / max(flow.sum(), 1e-300))


@dataclass(frozen=True)
class Warming:
    """How work at the N unknowns of a cycle warms both surfaces."""

    positions: tuple[Position, ...]
    orbits: Orbits
    half_cycle: Mirror | None
    bodies: tuple[PlacedBody, PlacedBody]  #: (primary, secondary)
    surfaces: tuple[_Surface, _Surface]
    turns: ComplexArray  #: (harmonics, positions of the whole cycle) heat in a harmonic by work at a position, 1/s.

    def by(self, work: Array) -> Rises:
        """Rises by friction work (N,) of one cycle per area in mJ/mm² at the unknowns."""
        primary, secondary = (
            surface.warmed(heat) for surface, heat in zip(self.surfaces, self._heats(work), strict=True)
        )
        if not primary[1] or not secondary[1]:
            return Rises(0.0 * primary[0], 0.0 * secondary[0], 0.0)
        share = secondary[1] / (primary[1] + secondary[1])
        return Rises(share * primary[0], (1.0 - share) * secondary[0], share * primary[1])

    def _heats(self, work: Array) -> tuple[ComplexArray, ComplexArray]:
        primary, secondary = spread_works(self.positions, self.orbits, self.bodies, work)
        if (later := self.half_cycle) is not None:
            images = np.empty_like(primary), np.empty_like(secondary)
            images[0][:, later.primary], images[1][:, later.secondary] = primary, secondary
            primary, secondary = np.concatenate([primary, images[0]]), np.concatenate([secondary, images[1]])
        shapes = (body.patch.shape for body in self.bodies)
        own, other = (
            (self.turns @ field).reshape(-1, *shape) for field, shape in zip((primary, secondary), shapes, strict=True)
        )
        return own, other


def spread_works(
    positions: Sequence[Position], orbits: Orbits, bodies: tuple[PlacedBody, PlacedBody], work: Array
) -> tuple[Array, Array]:
    """Work per area (positions, n) in mJ/mm² on the nodes of (primary, secondary) at each position, by work (N,) per
    area at the unknowns and their images within the position.
    """
    own, other = (np.zeros((len(positions), body.patch.size)) for body in bodies)
    areas = bodies[1].node_areas
    for k, position in enumerate(positions):
        part = np.zeros(len(position.nodes))
        part[orbits.rows[k]] = part[orbits.images[k]] = work[orbits.start[k] : orbits.start[k + 1]]
        own[k, position.nodes] = part
        other[k] = position.pairing.opposite.spread(part) / areas
    return own, other


def warming_of(
    problem: ContactProblem,
    heat: FrictionHeat,
    positions: tuple[Position, ...],
    orbits: Orbits,
    half_cycle: Mirror | None,
    times: tuple[Array, Array],
) -> Warming:
    """How a traced cycle warms surfaces. times: (positions,) shares of the cycle passed at the positions, and
    (positions, 2) shares that pass from the position before and to the next.
    """
    count = len(positions) if half_cycle is None else 2 * len(positions)
    orders, frequency = np.arange(max(count, 8) // 2 + 1), problem.timing.frequency_Hz
    turns = frequency * _turns(positions, orders, *times, 1.0 if half_cycle is None else 0.5)
    if half_cycle is not None:
        turns = np.concatenate([turns, turns * (-1.0) ** orders[:, None]], axis=1)
    pressed = [np.maximum(position.state.traction[position.nodes, 2], 0.0) for position in positions]
    work = np.concatenate([own[rows] for own, rows in zip(pressed, orbits.rows, strict=True)])
    bodies = problem.primary, problem.secondary
    rubbed = [np.asarray(field.any(axis=0)) for field in spread_works(positions, orbits, bodies, work)]
    if half_cycle is not None:
        rubbed = [
            own | own[image] for own, image in zip(rubbed, (half_cycle.primary, half_cycle.secondary), strict=True)
        ]
    conductors = (heat.upper, heat.lower) if problem.primary_is_upper else (heat.lower, heat.upper)
    surfaces = [
        _surface(body, own, conductor, orders, 1.0 / frequency, heat.length_mm)
        for body, own, conductor in zip(bodies, rubbed, conductors, strict=True)
    ]
    return Warming(positions, orbits, half_cycle, bodies, (surfaces[0], surfaces[1]), turns)


def times_of(passed: Sequence[WearStop], times: Array, kept: list[int], whole: float) -> tuple[Array, Array]:
    """Shares of the cycle passed at the stops that are kept, and (stops, 2) those from the stop before and to the next.

    times: of all increments' ends. whole: share of the cycle that they cover.
    """
    at = times[[stop.increment for stop in passed]]
    gaps = np.diff(at, prepend=at[-1] - whole)
    return at[kept], np.column_stack([gaps, np.roll(gaps, -1)])[kept]


def _turns(positions: Sequence[Position], orders: IntArray, at: Array, gaps: Array, whole: float) -> ComplexArray:
    """Harmonics (orders, positions) of heat by unit work at each position, which is done on the way from the position
    before and to the next, where the bodies slide as smoothly as the course of all slips. whole: share of the cycle
    that the positions cover.
    """
    slips = np.array([(position.before.sum(), position.after.sum()) for position in positions])
    slips[~slips.any(axis=1)] = 1.0
    ways = slips[:, 0] + 1e-9 * slips.max()
    done = scipy.interpolate.PchipInterpolator(
        np.concatenate([at - whole, at, at + whole]), np.cumsum(np.tile(ways, 3))
    )
    found = np.zeros((len(orders), len(positions)), dtype=complex)
    for slip, gap, side in zip(slips.T, gaps.T, (-1.0, 0.0), strict=True):
        lines = at[:, None] + gap[:, None] * (side + np.arange(_MOMENTS + 1) / _MOMENTS)
        parts, middles = np.diff(done(lines), axis=1), 0.5 * (lines[:, 1:] + lines[:, :-1])
        shares = (slip / slips.sum(axis=1))[:, None] * parts / parts.sum(axis=1, keepdims=True)
        found += (shares * np.exp(-2j * np.pi * orders[:, None, None] * middles)).sum(axis=2)
    return found


def _surface(
    body: PlacedBody, rubbed: BoolArray, conductor: Conductor, orders: IntArray, period_s: float, length_mm: float
) -> _Surface:
    """The cells over nodes (n,) that are rubbed, and the responses of a conductor."""
    patch = body.patch
    both, line = (patch.axial_mm, patch.transverse_mm), len(patch.transverse_mm) == 1
    where = np.nonzero(rubbed.reshape(patch.shape))
    ends = [
        (lines[max(own.min() - 1, 0)], lines[min(own.max() + 1, len(lines) - 1)])
        for lines, own in zip(both, where, strict=True)
    ]
    cell = max(high - low for low, high in ends) / _CELLS
    along, across = (
        0.5 * (low + high) + cell * (np.arange(count) - 0.5 * (count - 1))
        for low, high in ends
        for count in [max(1, round((high - low) / cell))]
    )
    shape, length = (len(along), len(across)), length_mm if line else 0.0
    return _Surface(
        to_along=linear_weights(both[0], along),
        to_across=linear_weights(both[1], across),
        from_along=linear_weights(along, both[0]),
        from_across=linear_weights(across, both[1]),
        kernel=np.stack([response(order, shape, cell, period_s, conductor, length) for order in orders]),
        areas=body.node_areas.reshape(patch.shape),
        through_K_per_mW=1e-3 * conductor.resistance_K_per_W * (length_mm if line else 1.0),
    )
