"""Local wear on both surfaces, by the law of `solvers.laws.wear_law`, each body's coefficient, its layers and oxygen.

The primary's nodes take their share of the wear work directly, the secondary's by the transposed transfer operator, so
worn volume equals coefficient times work to round-off on both bodies.

Oxygen diffuses into the contact from its edge and friction consumes it; where none is left, wear is different. With a
consumption per area in proportion to the friction power density q at any concentration (zero order), diffusion in the
gap gives D h c'' = κ q in a wide contact, with c = 1 at its edge: c = (1 − s/d)² at the distance s from the edge, and 0
beyond d = √(2 D h/(κ q)). So q d² is a constant of the pair of materials, called its supply. Contact oxygenation:
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
from solvers.laws.heat import FrictionHeat
from solvers.laws.layers import SurfaceLayer, friction_factor, receded
from solvers.laws.local_state import LocalState
from solvers.laws.wear_law import EnergyLaw, WearLaw, WornCycle

if TYPE_CHECKING:
    from solvers.elasticity.pairing import Pairing
    from solvers.elasticity.placement import PlacedBody


_FADING = 0.3  #: Last share of the distance d over which the wear coefficient changes.


# Wear work over which a further rate is taken: a constant, and a share of the work done.
_LITTLE_mJ_per_mm2, _LITTLE = 1e-3, 1e-6


@dataclass(frozen=True)
class OxygenSupply:
    """The distance from a contact's edge that oxygen reaches, and the wear coefficient without it.

    Over the last 30 % of the distance the wear coefficient changes linearly from its value with oxygen to that without.
    supply_W: friction power density (W/mm²) times the square of that distance (mm²). starved_factor: wear coefficient
    without oxygen over that with it. Raises SolverError if the supply is not positive or the factor negative.
    """

    supply_W: float
    starved_factor: float

    def __post_init__(self) -> None:
        if not (self.supply_W > 0.0 and self.starved_factor >= 0.0):
            raise SolverError("oxygen needs a positive supply, and a factor that is not negative")

    def reach_mm(self, power_density_W_per_mm2: float) -> float:
        """Distance from the contact's edge that oxygen reaches at a friction power density."""
        return float(np.sqrt(self.supply_W / max(power_density_W_per_mm2, 1e-300)))

    def factors(self, distance_mm: Array, power_density_W_per_mm2: float) -> Array:
        """Factors on the wear coefficient at distances in mm from the contact's edge, of their shape."""
        reach = self.reach_mm(power_density_W_per_mm2)
        breathes = np.clip((1.0 - distance_mm / reach) / _FADING, 0.0, 1.0)
        return np.asarray(self.starved_factor + (1.0 - self.starved_factor) * breathes)


Rate = float | Array  #: A wear coefficient, one for all nodes of a patch or one for each, (n_a, n_t).


class Recession(NamedTuple):
    """Wear rates of (primary, secondary), depth in mm per wear work in mJ/mm²; each one number, or (n_a, n_t) by node.

    secant: depth over all of the work done in a step, exact for layers and thresholds. tangent: depth per further work.
    beyond: depth (n_a, n_t) in mm by which secant times work exceeds tangent times work; None where both rates are
    equal.
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
    #: Reduces coefficients far from the contact's edge, in cycle jumps only.
    oxygen: OxygenSupply | None = None
    upper_layers: tuple[SurfaceLayer, ...] = ()  #: Coatings of the upper body, the outermost first.
    lower_layers: tuple[SurfaceLayer, ...] = ()  #: Coatings of the lower body, the outermost first.
    heat: FrictionHeat | None = None  #: What temperatures change, and how friction raises them, in cycle jumps only.

    def factor(self, cycle: WornCycle) -> float | Array:
        """Factor on the wear work of a traced cycle by the law and by oxygen: one for all, or (N,) for the N places of
        the cycle, see `WornCycle`.
        """
        factor = self.law.factor(cycle)
        if self.oxygen is None:
            return factor
        warm = 1.0 if self.heat is None else float(self.heat.oxidising(np.asarray(cycle.rise_K)))
        return factor * self.oxygen.factors(cycle.edge_distance_mm, warm * cycle.power_density_W_per_mm2)

    def scaled(self, factor: float) -> WearRates:
        """This wear law with both coefficients multiplied by `factor`."""
        return replace(
            self, upper_mm3_per_mJ=factor * self.upper_mm3_per_mJ, lower_mm3_per_mJ=factor * self.lower_mm3_per_mJ
        )

    @property
    def none(self) -> bool:
        return self.upper_mm3_per_mJ == 0.0 and self.lower_mm3_per_mJ == 0.0

    def recession(self, wear: WearState, work: tuple[Array, Array], primary_is_upper: bool) -> Recession:
        """Wear rates of (primary, secondary) from a state of wear, for wear work (n_a, n_t) in mJ/mm² done on each from
        there. primary_is_upper: which of both is the upper body.
        """
        pair = (self.upper_mm3_per_mJ, self.lower_mm3_per_mJ)
        both: tuple[Rate, Rate] = pair if primary_is_upper else pair[::-1]
        layers = self.upper_layers, self.lower_layers
        if self.heat is not None and self.heat.wear_J_per_mol and (rises := wear.rises) is not None:
            both = both[0] * self.heat.wearing(rises[0]), both[1] * self.heat.wearing(rises[1])
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
        """Factor on the coefficient of friction at k nodes by the coatings exposed there and the temperature: one for
        all, or (k,).
        """
        factor = friction_factor(self.upper_layers, self.lower_layers, local)
        if self.heat is None or not self.heat.friction_per_K:
            return factor
        return factor * self.heat.friction_factor(local.rise_K)


@dataclass(frozen=True)
class Sliding:
    """Sliding at k paired nodes, (k,) each: friction energy, wear work per plane area in mJ/mm², slip length in mm."""

    pairing: Pairing
    energy: Array
    wear_work: Array
    length: Array
    #: Work of the pressure on motion along the normals, mJ/mm²; positive where it presses the bodies apart.
    lifting: Array

    @property
    def friction_work(self) -> float:
        """Work in mJ that all nodes take from the drive: their friction energy less the lifting work."""
        return float(self.pairing.areas @ (self.energy - self.lifting))


def deposited(
    wear: WearState,
    parts: Sequence[Sliding],
    cycles: float,
    rates: WearRates,
    bodies: tuple[PlacedBody, PlacedBody],
    retained: float,
) -> WearState:
    """The wear state after sliding in one or more pairings, repeated `cycles` times (0: no wear); bodies: (primary,
    secondary). retained: share of the worn depths that becomes debris.
    """
    before = wear
    for part in parts if cycles > 0.0 else ():
        wear = _after(wear, part, cycles, rates, bodies)
    if before.primary_debris is None or before.secondary_debris is None or wear is before:
        return wear
    return replace(
        wear,
        primary_debris=before.primary_debris + retained * (wear.primary_depth - before.primary_depth),
        secondary_debris=before.secondary_debris + retained * (wear.secondary_depth - before.secondary_depth),
    )


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
    """The wear state after friction energy and wear work per plane area, (n_a, n_t) in mJ/mm², on (primary, secondary).

    rates: depth in mm per wear work of each. totals_mJ: friction energy and wear work of the whole contact.
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
