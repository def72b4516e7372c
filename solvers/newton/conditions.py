"""The contact conditions of one pairing: gaps and slips under given tractions, and which nodes open, stick or slip.

Per node, with normal traction p, tangential traction q, mean gap g and mean slip s of the upper body against the
lower one over the increment:
    open: p = q = 0, g >= 0;  stick: g = 0, s = 0, |q| <= tau(p);  slip: g = 0, q = -tau(p) s / |s|,
with tau the friction law, mu p by Coulomb's.
The augmentation that decides between stick and slip is scaled with the whole compliance that a change of friction
meets, the rig's included; with the local one alone a soft rig makes nodes alternate between both slip directions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from solvers.compiled import compiled
from solvers.newton.system import Linearisation
from solvers.newton.terms import Nodes, nodes_of

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]

# Slipping nodes keep their tangential unknowns while their slip is below this share of the displacement that full
# friction on all nodes would cause; beyond, iterating the direction converges fast.
_NEAR_STICK = 2.0
# Of the largest friction: what is so near to its limit may stick or slip.
_ROUND_OFF = 1e-12


@dataclass(frozen=True)
class Iterate:
    """Tractions (k,) and (k, 2) in local frames, the holder's position, and what follows from them.

    gap, slip: (k,) and (k, 2).  elastic: largest elastic displacement.  Lengths in mm, tractions in MPa.
    """

    normal: Array
    tangential: Array
    height: float
    holder_x: float
    tilt: float
    gap: Array
    slip: Array
    elastic: float


@dataclass(frozen=True)
class FrictionStatus:
    """Nodes that stick (k,), those near enough to it to keep tangential unknowns (k,), direction of friction (k, 2).

    verge: (k,) nodes at their limit but for round-off, which may stick or slip as well.
    """

    stick: BoolArray
    verge: BoolArray
    near_stick: BoolArray
    direction: Array


@dataclass(frozen=True)
class Scales:
    """What the augmentation and the equations are measured by.

    collective, local, rig: displacement by unit traction on all nodes, on one of them, and by what that moves the rig,
    mm per MPa.  series_compliance: of contact and rig, mm per N.  pressure: mean one, MPa.
    """

    collective: float
    local: float
    rig: float
    series_compliance: float
    pressure: float


@dataclass(frozen=True)
class ContactConditions:
    """The conditions on the k nodes of a pairing."""

    system: Linearisation
    scales: Scales

    @classmethod
    def of(cls, system: Linearisation, loaded: BoolArray) -> ContactConditions:
        """The conditions, scaled as for a contact of the loaded nodes (k,)."""
        return cls(system, _scales(system, loaded))

    @cached_property
    def count(self) -> int:
        """Number k of nodes."""
        return len(self.system.pairing.nodes)

    @cached_property
    def normals(self) -> Array:
        """Unit normals, (k, 3)."""
        return self.system.pairing.frames[:, 0, :]

    @cached_property
    def tangents(self) -> Array:
        """Both unit tangents of each node, (k, 2, 3)."""
        return self.system.pairing.frames[:, 1:, :]

    @cached_property
    def nodes(self) -> Nodes:
        """The nodes as compiled functions take them."""
        return nodes_of(self.system)

    @property
    def areas(self) -> Array:
        """Plane areas of the nodes, mm², (k,)."""
        return self.system.pairing.areas

    def world(self, normal: Array, tangential: Array) -> Array:
        """Tractions (k, 3) in world axes."""
        return _world(normal, tangential, self.system.pairing.frames)

    def iterate(self, normal: Array, tangential: Array, height: float, holder_x: float, tilt: float) -> Iterate:
        """Gaps and slips under these tractions at this position of the holder."""
        layers = self.system.layers
        elastic = self.system.compliance.displacement(self.world(normal, tangential))
        gap, slip, largest = _gaps_and_slips(elastic, self.nodes, height, holder_x, tilt)
        if layers is not None:
            gap = gap + layers.closure(normal)[0]
            sheared = layers.shear_compliance(normal)[0][:, None] * tangential
            slip = slip + sheared - np.einsum("ij,ikj->ik", layers.old_displacement, self.tangents)
        return Iterate(normal, tangential, height, holder_x, tilt, gap, slip, largest)

    def in_contact(self, state: Iterate) -> BoolArray:
        """The nodes (k,) that are pressed or overlap."""
        return np.asarray(state.normal - self._normal_augmentation(state.normal) * state.gap > 0.0)

    def _normal_augmentation(self, normal: Array) -> Array | float:
        """Pressure per gap, MPa per mm, by which nodes open or close."""
        layers, local = self.system.layers, self.scales.local
        return 1.0 / local if layers is None else 1.0 / (local + layers.closure(normal)[1])

    def tangential_compliance(self, normal: Array) -> Array:
        """Displacement of each node per tangential traction on all of them, mm per MPa, (k,); the rig's apart."""
        layers = self.system.layers
        return self.scales.collective + (np.zeros(self.count) if layers is None else layers.shear_compliance(normal)[0])

    def friction_status(self, state: Iterate, active: BoolArray) -> FrictionStatus:
        """Which of the nodes in contact stick, and where friction points."""
        if self.system.friction.none:
            nowhere = np.zeros_like(active)
            return FrictionStatus(nowhere, nowhere, nowhere, np.zeros((self.count, 2)))
        return FrictionStatus(
            *_friction_status(
                active,
                state.tangential,
                state.slip,
                self.system.friction.limit(state.normal),
                self.tangential_compliance(state.normal),
                self.scales.rig,
                float(np.sign(self.system.drive_step)),
            )
        )


@compiled
def _world(normal: Array, tangential: Array, frames: Array) -> Array:
    result = np.empty((len(normal), 3))
    for k in range(len(normal)):
        for c in range(3):
            sideways = tangential[k, 0] * frames[k, 1, c] + tangential[k, 1] * frames[k, 2, c]
            result[k, c] = normal[k] * frames[k, 0, c] + sideways
    return result


@compiled
def _gaps_and_slips(
    elastic: Array, nodes: Nodes, height: float, holder_x: float, tilt: float
) -> tuple[Array, Array, float]:
    """Gaps (k,) and slips (k, 2) under displacements (k, 3), and the largest component of these."""
    frames, old, count = nodes.frames, nodes.old_displacement, len(nodes.gap)
    gap, slip, largest = np.empty(count), np.empty((count, 2)), 0.0
    along = holder_x - nodes.old_holder_x - nodes.drive_step
    for k in range(count):
        lever = nodes.lever[k]
        moved = nodes.gap_rate[k] * (holder_x - nodes.paired_holder_x)
        gap[k] = frames[k, 0, 2] * (nodes.gap[k] + height + lever * tilt + moved)
        for c in range(3):
            gap[k] += elastic[k, c] * frames[k, 0, c]
            largest = max(largest, abs(elastic[k, c]))
        x, y = elastic[k, 0] - old[k, 0] + along, elastic[k, 1] - old[k, 1]
        z = elastic[k, 2] - old[k, 2] + (height - nodes.old_height + lever * (tilt - nodes.old_tilt))
        for t in range(2):
            slip[k, t] = x * frames[k, 1 + t, 0] + y * frames[k, 1 + t, 1] + z * frames[k, 1 + t, 2]
    return gap, slip, largest


@compiled
def _friction_status(
    active: BoolArray, tangential: Array, slip: Array, limit: Array, compliance: Array, rig: float, forward: float
) -> tuple[BoolArray, BoolArray, BoolArray, Array]:
    count = len(active)
    stick, verge, near = np.zeros(count, np.bool_), np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    direction = np.zeros((count, 2))
    largest = 0.0
    for k in range(count):
        largest = max(largest, limit[k])
    round_off = _ROUND_OFF * largest
    for k in range(count):
        s0, s1 = slip[k, 0], slip[k, 1]
        soft = compliance[k] + rig
        t0, t1 = tangential[k, 0] - s0 / soft, tangential[k, 1] - s1 / soft
        length, size = np.sqrt(s0 * s0 + s1 * s1), np.sqrt(t0 * t0 + t1 * t1)
        stick[k] = active[k] and size <= limit[k]
        near[k] = active[k] and (stick[k] or length < _NEAR_STICK * limit[k] * compliance[k])
        verge[k] = abs(size - limit[k]) <= round_off
        if active[k] and not near[k] and t0 * s0 + t1 * s1 < 0.0 and length > 0.0:
            # Far from stick the slip alone gives the direction; the trial traction would turn into it only slowly.
            direction[k, 0], direction[k, 1] = -s0 / length, -s1 / length
        elif size > 0.0:
            direction[k, 0], direction[k, 1] = t0 / size, t1 / size
        else:
            direction[k, 0] = forward
    return stick, verge, near, direction


def _scales(system: Linearisation, loaded: BoolArray) -> Scales:
    normals, areas = system.pairing.frames[:, 0, :], system.pairing.areas
    nodes = loaded if loaded.any() else np.ones(len(areas), dtype=bool)
    uniform = np.where(nodes[:, None], normals, 0.0)
    lift = np.einsum("ij,ij->i", system.compliance.displacement(uniform), normals)
    collective = float(lift[nodes].max())
    area = float(areas[nodes].sum())
    rig = system.holder.compliance_at_contact_mm_per_N * area
    return Scales(
        collective=collective,
        local=collective / max(1.0, 0.5 * float(np.sqrt(nodes.sum()))),
        rig=rig,
        series_compliance=(collective + rig) / area,
        pressure=system.holder.normal_load_N / area,
    )
