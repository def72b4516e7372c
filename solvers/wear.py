"""Local wear on both surfaces, by the law of `solvers.laws.wear_law` and each body's coefficient.

The primary's nodes take their share of the wear work directly; the secondary's by the transposed transfer operator, so
worn volume equals coefficient times work to round-off on both bodies.

Oxygen in the contact: it diffuses in from the edges and friction uses it up; where none is left, wear is another.

Consumption per area in proportion to the friction power density q, whatever oxygen is left (zero order), and diffusion
in the gap give D h c'' = κ q in a wide contact, with c = 1 at its edge: c = (1 − s/d)² at the distance s from the edge,
and none beyond d = √(2 D h/(κ q)). So q d² is a constant of the pair of materials, its supply. Contact oxygenation:
Baydoun, Arnaud and Fouvry, Wear 458-459 (2020) 203397, and Arnaud, Baydoun and Fouvry, Tribol. Int. 161 (2021) 107077.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.arrays import Array
from solvers.contact_state import WearState
from solvers.errors import SolverError
from solvers.laws.layers import SurfaceLayer, friction_factor, receded
from solvers.laws.local_state import LocalState
from solvers.laws.wear_law import EnergyLaw, WearLaw, WornCycle

if TYPE_CHECKING:
    from solvers.elasticity.pairing import Pairing
    from solvers.elasticity.placement import PlacedBody


_FADING = 0.3  #: That part, of the whole way.


# Wear work over which a rate is taken: beside what is done, and of it.
_LITTLE_mJ_per_mm2, _LITTLE = 1e-3, 1e-6


@dataclass(frozen=True)
class OxygenSupply:
    """How far oxygen gets, and what its lack does: little is left of it over the last part of the way, where the wear
    coefficient passes linearly from one value to the other.

    supply_W: friction power density (W/mm²) times the square of the distance (mm²) that oxygen gets from the edge.
    starved_factor: wear coefficient without oxygen over that with it.
    Raises SolverError for a number that cannot be.
    """

    supply_W: float
    starved_factor: float

    def __post_init__(self) -> None:
        if not (self.supply_W > 0.0 and self.starved_factor >= 0.0):
            raise SolverError("oxygen needs a positive supply, and a factor that is not negative")

    def reach_mm(self, power_density_W_per_mm2: float) -> float:
        """Distance from the contact's edge that oxygen gets at a friction power density."""
        return float(np.sqrt(self.supply_W / max(power_density_W_per_mm2, 1e-300)))

    def factors(self, distance_mm: Array, power_density_W_per_mm2: float) -> Array:
        """Factors on wear at distances from the contact's edge."""
        reach = self.reach_mm(power_density_W_per_mm2)
        breathes = np.clip((1.0 - distance_mm / reach) / _FADING, 0.0, 1.0)
        return np.asarray(self.starved_factor + (1.0 - self.starved_factor) * breathes)


Rate = float | Array  #: A wear coefficient, one for all nodes of a patch or one for each, (n_a, n_t).


class Recession(NamedTuple):
    """How the primary and the secondary recede by wear work: per work in all, exact however much it is; per further
    work; and the depth (n_a, n_t) in mm by which they are beyond the latter times the work, if they are.
    """

    secant: tuple[Rate, Rate]
    tangent: tuple[Rate, Rate]
    beyond: tuple[Array, Array] | None = None


@dataclass(frozen=True)
class WearRates:
    """Wear law of the two bodies, with coefficients in mm³ per mJ of friction energy or, by Archard's law, per N mm of
    load times sliding.
    """

    upper_mm3_per_mJ: float = 0.0
    lower_mm3_per_mJ: float = 0.0
    law: WearLaw = field(default_factory=EnergyLaw)
    #: Where it lacks, coefficients are smaller; single increments do not know of it.
    oxygen: OxygenSupply | None = None
    upper_layers: tuple[SurfaceLayer, ...] = ()  #: The outermost first, as the next.
    lower_layers: tuple[SurfaceLayer, ...] = ()

    def factor(self, cycle: WornCycle) -> float | Array:
        """Factor on the wear work of a cycle, one for all places or one for each, (N,)."""
        factor = self.law.factor(cycle)
        if self.oxygen is None:
            return factor
        return factor * self.oxygen.factors(cycle.edge_distance_mm, cycle.power_density_W_per_mm2)

    def scaled(self, factor: float) -> WearRates:
        """This law with both coefficients multiplied by a factor."""
        return replace(
            self, upper_mm3_per_mJ=factor * self.upper_mm3_per_mJ, lower_mm3_per_mJ=factor * self.lower_mm3_per_mJ
        )

    @property
    def none(self) -> bool:
        return self.upper_mm3_per_mJ == 0.0 and self.lower_mm3_per_mJ == 0.0

    def recession(self, wear: WearState, work: tuple[Array, Array], primary_is_upper: bool) -> Recession:
        """How the primary and the secondary recede from a state of wear over wear work per area, each (n_a, n_t)."""
        pair = (self.upper_mm3_per_mJ, self.lower_mm3_per_mJ)
        both, layers = pair if primary_is_upper else pair[::-1], (self.upper_layers, self.lower_layers)
        if not (self.law.remembers or any(layers)):
            return Recession(both, both)
        energies = wear.primary_energy, wear.secondary_energy
        secants, tangents = [], []
        for of, own, depth, energy, done in zip(
            both, layers if primary_is_upper else layers[::-1], wear.depths, energies, work, strict=True
        ):
            more = _LITTLE_mJ_per_mm2 + _LITTLE * float(done.max())
            now, then = (receded(own, depth, of * self.law.counted(energy, one)) for one in (done, done + more))
            tangents.append((then - now) / more)
            secants.append(np.divide(now, done, out=tangents[-1].copy(), where=done > 0.0))
        offsets = tuple(
            (secant - tangent) * done for secant, tangent, done in zip(secants, tangents, work, strict=True)
        )
        return Recession((secants[0], secants[1]), (tangents[0], tangents[1]), (offsets[0], offsets[1]))

    def friction_factor(self, local: LocalState) -> float | Array:
        """Factor on friction by the layers that lie on the surfaces at k nodes, one for all or (k,)."""
        return friction_factor(self.upper_layers, self.lower_layers, local)


@dataclass(frozen=True)
class Sliding:
    """What sliding at k paired nodes did: friction energy and wear work per plane area, mJ/mm², and length, mm."""

    pairing: Pairing
    energy: Array
    wear_work: Array
    length: Array
    #: The pressure's work on what moves along the normals, mJ/mm²; positive where it presses the bodies apart.
    lifting: Array

    @property
    def friction_work(self) -> float:
        """What all nodes took from the drive, mJ: their friction energy, less what lifting gave back."""
        return float(self.pairing.areas @ (self.energy - self.lifting))


def deposited(
    wear: WearState, parts: Sequence[Sliding], cycles: float, rates: WearRates, bodies: tuple[PlacedBody, PlacedBody]
) -> WearState:
    """The wear state after sliding in one or more pairings, repeated `cycles` times.

    bodies: the primary and the secondary.
    """
    for part in parts if cycles > 0.0 else ():
        wear = _after(wear, part, cycles, rates, bodies)
    return wear


def _after(
    wear: WearState, part: Sliding, cycles: float, rates: WearRates, bodies: tuple[PlacedBody, PlacedBody]
) -> WearState:
    pairing = part.pairing
    if not part.wear_work.any():
        return wear

    def spread(work: Array) -> tuple[Array, Array]:
        primary = np.zeros(wear.primary_depth.shape)
        primary.flat[pairing.nodes] = cycles * work
        secondary = cycles * pairing.opposite.spread(work) / bodies[1].patch.node_areas()
        return primary, np.asarray(secondary).reshape(wear.secondary_depth.shape)

    energy = spread(part.energy)
    work = energy if part.wear_work is part.energy else spread(part.wear_work)
    totals = cycles * float(pairing.areas @ part.energy), cycles * float(pairing.areas @ part.wear_work)
    return after_work(wear, rates.recession(wear, work, bodies[0].facing < 0).secant, energy, work, totals, bodies)


def after_work(
    wear: WearState,
    rates: tuple[Rate, Rate],
    energy: tuple[Array, Array],
    work: tuple[Array, Array],
    totals_mJ: tuple[float, float],
    bodies: tuple[PlacedBody, PlacedBody],
) -> WearState:
    """The wear state after friction energy and wear work per area, each (n_a, n_t) on the primary and the secondary
    body, and of both in total.
    """
    volumes = (
        rate * totals_mJ[1] if isinstance(rate, float) else float(body.node_areas @ (rate * done).ravel())
        for rate, done, body in zip(rates, work, bodies, strict=True)
    )
    primary_volume, secondary_volume = volumes
    return replace(
        wear,
        primary_depth=wear.primary_depth + rates[0] * work[0],
        secondary_depth=wear.secondary_depth + rates[1] * work[1],
        primary_energy=wear.primary_energy + energy[0],
        secondary_energy=wear.secondary_energy + energy[1],
        energy_mJ=wear.energy_mJ + totals_mJ[0],
        primary_volume_mm3=wear.primary_volume_mm3 + primary_volume,
        secondary_volume_mm3=wear.secondary_volume_mm3 + secondary_volume,
    )
