"""Criteria of life: what a cycle of stresses takes of the life of a material point, and on which plane.

Each makes a parameter of a cycle, and has a curve of the lives that go with it. Histories are (s, n, 6) in MPa: s
positions of a closed cycle, n material points; (s, n, 3, 3) as tensors. Planes are unit normals (n, k, 3), k a point. A
cycle that goes to and fro more than once is taken apart by rainflow counting.
"""

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
import rainflow

from geometry import Elastic
from geometry.arrays import Array, IntArray
from solvers.elasticity.linear_elasticity import tensors
from wirewear.stress.planes import critical_planes, crossland, in_plane, normal_stresses, stress_vectors, swt_on_planes
from wirewear.test.life import CURVE_KEYS, LifeTable

_STEPS = 60  #: Of Newton's method, at most.
#: Directions in a plane in which shear is looked at; the largest range is missed by 1 % at most.
_SHEARS = 12


@dataclass(frozen=True)
class LifeCurve:
    """A parameter as a sum of powers of the reversals 2N to initiation, Basquin's and Coffin and Manson's. terms:
    (positive factor, negative exponent) of each. endurance_cycles: longer lives are infinite.
    """

    terms: tuple[tuple[float, float], ...]
    endurance_cycles: float = np.inf

    def cycles(self, parameter: Array) -> Array:
        """Cycles N to initiation (n,) under parameters (n,); infinite where the parameter is not positive, or N would
        exceed `endurance_cycles`.
        """
        working = parameter > 0.0
        goal = np.log(parameter[working])
        factor, exponent = np.log([a for a, _ in self.terms]), np.array([p for _, p in self.terms])
        # Either term alone gives too short a life. From there Newton's method on the logarithm of the sum, which is
        # convex in that of the reversals and falls, comes to the root from one side.
        reversals = ((goal[:, None] - factor) / exponent).max(axis=1)
        for _ in range(_STEPS):
            parts = factor + exponent * reversals[:, None]
            value = np.logaddexp.reduce(parts, axis=1)
            slope = np.exp(parts - value[:, None]) @ exponent
            step = (goal - value) / slope
            reversals = reversals + step
            if np.all(np.abs(step) < 1e-12):
                break
        found = np.full(parameter.shape, np.inf)
        found[working] = 0.5 * np.exp(reversals)
        return np.where(found > self.endurance_cycles, np.inf, found)

    def parameter(self, cycles: Array) -> Array:
        """The parameter at which a crack begins after `cycles` cycles, of the same shape."""
        return np.asarray(sum(a * (2.0 * np.asarray(cycles)) ** p for a, p in self.terms))


@dataclass(frozen=True, eq=False)
class CycleDamage:
    """Share (n,) of n points' lives that one cycle takes, and unit normals (n, 3) of their planes, 0 for none."""

    share: Array
    normal: Array


class LifeCriterion(Protocol):
    """A criterion by which a cycle of stresses takes a share of a point's life, with the data of the material. curve:
    lives by the criterion's parameter.
    """

    @property
    def name(self) -> str:
        """Name of the criterion in studies."""

    @property
    def curve(self) -> LifeCurve: ...

    def damage(self, history: Array) -> CycleDamage:
        """Share of life that one cycle of stresses (s, n, 6) in MPa takes at each of n points, and its plane."""


@dataclass(frozen=True)
class _OnPlanes:
    """A criterion on the plane of its largest parameter."""

    material: Elastic
    curve: LifeCurve

    @abstractmethod
    def value(self, stress: Array, normals: Array) -> Array:
        """The parameter (n, k) of a cycle of tensors (s, n, 3, 3) on planes (n, k, 3)."""

    @abstractmethod
    def counted(self, stress: Array, normal: Array) -> Array:
        """The stress or strain (s, n) whose cycles are counted, of tensors (s, n, 3, 3) on one plane (n, 3) a point."""

    def damage(self, history: Array) -> CycleDamage:
        """Share of life by the largest cycle on the critical plane and, by Miner's sum, smaller ones on that plane."""
        planes = critical_planes(history, self.value)
        share = 1.0 / self.curve.cycles(planes.parameter)
        stress = tensors(history)
        point, weight, ends = _smaller_cycles(self.counted(stress, planes.normal))
        if len(point):
            pairs = stress[ends, point]
            values = self.value(pairs, planes.normal[point, None])[:, 0]
            share += np.bincount(point, weight / self.curve.cycles(values), len(share))
        return CycleDamage(share, planes.normal)


@dataclass(frozen=True)
class SmithWatsonTopper(_OnPlanes):
    """Criterion σ_n,max Δε_n / 2 in MPa on the plane where it is largest (Smith, Watson & Topper, J. Materials 5 (1970)
    767).

    By Neuber's rule an elastic product of stress and strain stands for that of a yielding point.
    """

    name = "smith-watson-topper"

    def value(self, stress: Array, normals: Array) -> Array:
        return swt_on_planes(stress, normals, self.material)

    def counted(self, stress: Array, normal: Array) -> Array:
        return normal_stresses(stress, normal[:, None])[..., 0]


@dataclass(frozen=True)
class StressLife(SmithWatsonTopper):
    """Criterion of the normal stress's amplitude in MPa, corrected for its mean as by Morrow, σ_a / (1 − σ_m / σ_f'),
    on the plane where it is largest; 0 on planes that are never pulled.

    Morrow in Fatigue Design Handbook, SAE (1968). strength_coefficient_MPa: σ_f'.
    """

    strength_coefficient_MPa: float
    name = "stress-life"

    def value(self, stress: Array, normals: Array) -> Array:
        normal = normal_stresses(stress, normals)
        highest, lowest = normal.max(axis=0), normal.min(axis=0)
        left = 1.0 - 0.5 * (highest + lowest) / self.strength_coefficient_MPa
        amplitude = 0.5 * (highest - lowest)
        return np.where(highest > 0.0, amplitude / np.maximum(left, 1e-6), 0.0)


@dataclass(frozen=True)
class FatemiSocie(_OnPlanes):
    """Criterion Δγ / 2 · (1 + k σ_n,max / σ_y) (Fatemi & Socie, Fatigue Fract. Eng. Mater. Struct. 11 (1988) 149) on
    the plane where it is largest; σ_n,max counts as 0 where a plane is never pulled. weight_per_MPa: k / σ_y.
    """

    weight_per_MPa: float
    name = "fatemi-socie"

    def value(self, stress: Array, normals: Array) -> Array:
        normal = normal_stresses(stress, normals)
        shears = np.max([np.ptp(shear, axis=0) for shear in _shears(stress, normals)], axis=0)
        pulled = np.maximum(normal.max(axis=0), 0.0)
        return np.asarray(0.5 * shears / self.material.shear_modulus_MPa * (1.0 + self.weight_per_MPa * pulled))

    def counted(self, stress: Array, normal: Array) -> Array:
        shears = np.array(list(_shears(stress, normal[:, None])))[..., 0]
        best = np.ptp(shears, axis=1).argmax(axis=0)
        return np.asarray(shears[best, :, np.arange(len(best))].T)


@dataclass(frozen=True)
class CrosslandLife:
    """Criterion √J2,a + slope · σ_H,max in MPa of a cycle (Crossland, Proc. Int. Conf. Fatigue of Metals, 1956)."""

    slope: float
    curve: LifeCurve
    name = "crossland"

    def damage(self, history: Array) -> CycleDamage:
        stresses = crossland(history)
        share = 1.0 / self.curve.cycles(stresses.equivalent_MPa(self.slope))
        return CycleDamage(share, np.zeros((len(share), 3)))


def criterion_of(table: LifeTable, material: Elastic) -> LifeCriterion:
    """The criterion that a table states for a material of these constants. Raises StudyError if data are lacking."""
    modulus, shear = material.youngs_modulus_MPa, material.shear_modulus_MPa
    limit = table.endurance_cycles
    if table.criterion in ("crossland", "stress-life"):
        strength, b = table.required(*CURVE_KEYS[:2])
        if table.criterion == "stress-life":
            return StressLife(material, LifeCurve(((strength, b),), limit), strength)
        # In tension without a mean, √J2,a is σ_a/√3 and σ_H,max a third of σ_a.
        slope = table.slope
        return CrosslandLife(slope, LifeCurve(((strength * (3.0**-0.5 + slope / 3.0), b),), limit))
    strength, b, ductility, c = table.required(*CURVE_KEYS)
    if table.criterion == "fatemi-socie":
        factor = table.fatemi_socie_factor
        weight = 1.0 / strength if factor is None else factor / table.required("yield_strength_MPa")[0]
        terms = ((strength / 3.0**0.5 / shear, b), (3.0**0.5 * ductility, c))
        return FatemiSocie(material, LifeCurve(terms, limit), weight)
    terms = ((strength**2 / modulus, 2.0 * b), (strength * ductility, b + c))
    return SmithWatsonTopper(material, LifeCurve(terms, limit))


def _shears(stress: Array, normals: Array) -> Iterator[Array]:
    """Shear stresses (s, n, k) in directions spread evenly over half a turn, as tensors have them on planes."""
    across = stress_vectors(stress, normals)
    first, second = (np.einsum("snki,nki->snk", across, one, optimize=True) for one in in_plane(normals))
    for angle in np.arange(_SHEARS) * np.pi / _SHEARS:
        yield np.cos(angle) * first + np.sin(angle) * second


def _smaller_cycles(signals: Array) -> tuple[IntArray, Array, IntArray]:
    """All cycles but the largest in closed signals (s, n), by rainflow counting (ASTM E1049).

    Returns the point (c,) of each, how often it comes (c,), and its ends (2, c) among the positions.
    """
    count = len(signals)
    begin = signals.argmax(axis=0)
    turned = (np.arange(count + 1)[:, None] + begin) % count
    closed = np.take_along_axis(signals, turned, axis=0)
    rising = np.sign(np.diff(closed, axis=0))
    for earlier, later in pairwise(rising):
        later[later == 0.0] = earlier[later == 0.0]
    many = np.flatnonzero((rising[1:] * rising[:-1] < 0.0).sum(axis=0) > 1)
    found = []
    for point in many:
        cycles = sorted(rainflow.extract_cycles(closed[:, point]), reverse=True)
        left = 1.0  # of the largest cycle, often two halves
        for span, _, weight, i, j in cycles:
            rest = max(weight - left, 0.0)
            left = max(left - weight, 0.0)
            # Ranges below this share of the largest count nothing.
            if rest and span > 1e-3 * cycles[0][0]:
                found.append((point, rest, turned[i, point], turned[j, point]))
    if not found:
        return np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros((2, 0), dtype=np.int64)
    points, weights, first, second = (np.array(column) for column in zip(*found, strict=True))
    return points, weights, np.array([first, second])
