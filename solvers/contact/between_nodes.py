"""A contact between its nodes: where its edge lies, how pressure varies within elements, and friction laws integrated
there.

A pressure that falls as the root of the distance from the contact's edge has a square that is smooth up to the edge
(Johnson, Contact Mechanics, 1985, section 5.1). The square is fitted to the nodes (`fitted_square`) and evaluated at
samples within elements. The outermost nodes also bear load of open nodes beside them, by an amount that depends on
where the mesh lies, so they hardly count in the fit; the edge lies where the load is carried.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import pi

import numpy as np
from scipy.sparse import csr_matrix

from geometry import ContactPatch
from geometry.arrays import Array, BoolArray, IntArray
from solvers.laws.friction_law import Friction
from solvers.stress.subgrid_traction import SubgridTraction, areas_of, carrying, fitted_square, refined, refined_lines

#: Samples across a contact that few elements span, and of an element each way at least and at most.
_ACROSS, _FEWEST, _MOST = 72, 2, 8
_AROUND = 4  #: Nodes without pressure about the contact that are looked at.
_LARGEST = 1.5  #: Largest allowed ratio of an integral over elements and the sum over nodes, either way.


@dataclass(frozen=True, eq=False)
class SpreadPressure:
    """Pressure at m samples within the elements of a patch of n nodes, carrying the load of the nodal pressures."""

    nodal_MPa: Array  #: (n,) nodal pressures as solved for.
    areas_mm2: Array  #: (n,) of the nodes.
    places_mm: Array  #: (m, 2) of the samples under pressure, in the patch's axes.
    pressure_MPa: Array  #: (m,) at the samples.
    parts_mm2: Array  #: (m,) areas of the samples.
    edge_mm: Array  #: (e, 2) points in the patch's axes where lines of samples cross the contact's edge.
    weights: csr_matrix  #: (n, m) value of each node's hat function at each sample.
    samples: int = 1  #: Number of samples of an element in each direction.

    @classmethod
    def of(cls, patch: ContactPatch, pressure_MPa: Array, smooth: bool = True) -> "SpreadPressure":
        """Fit to nodal pressures (n,) in MPa on a patch, negative ones as 0; without samples if no node is pressed.

        smooth: True for unworn surfaces, whose inner nodes and load fix the contact's edge; False to fit all nodes
        alike.
        """
        nodal, shape = np.maximum(pressure_MPa, 0.0), patch.shape
        areas = patch.node_areas()
        rows, columns = (_about(np.asarray(nodal.reshape(shape).any(axis=1 - axis))) for axis in (0, 1))
        inner = nodal.reshape(shape)[rows][:, columns]
        if not inner.size:
            nothing = np.zeros((0, 2))
            return cls(nodal, areas, nothing, np.zeros(0), np.zeros(0), nothing, csr_matrix((len(nodal), 0)))
        narrow = min(size - 2 * _AROUND for size in inner.shape if size > 1)
        samples = min(max(-(-_ACROSS // max(narrow, 1)), _FEWEST), _MOST)
        nodes = patch.axial_mm[rows], patch.transverse_mm[columns]
        tractions = -inner[..., None] * np.array([0.0, 0.0, 1.0])
        # Weight of the outermost nodes: where few lie inside, they keep the fit determined.
        fitted = fitted_square(inner, 0.02) if smooth else SubgridTraction.of_nodes(tractions).square
        square = refined(carrying(fitted, inner, nodes) if smooth else fitted, samples)
        lines = refined_lines(nodes, samples)
        parts = areas_of(lines)
        load = float(areas @ nodal)
        inside = square > 0.0
        parts, found = parts[inside], np.sqrt(square[inside])
        carried = float(parts @ found)
        places = np.column_stack([part[inside] for part in np.meshgrid(*lines, indexing="ij")])
        edge = _edge(square, lines)
        scale = load / carried if carried > 0.0 else 1.0
        hats = _hats(shape, rows, columns, inside, samples)
        return cls(nodal, areas, places, scale * found, parts, edge, hats, samples)

    @property
    def area_mm2(self) -> float:
        return float(self.parts_mm2.sum())

    @cached_property
    def edge_distance_mm(self) -> Array:
        """Distance (m,) of each sample from the contact's edge; infinite if the contact has none on the patch."""
        from scipy.spatial import KDTree

        if not len(self.edge_mm):
            return np.full(len(self.places_mm), np.inf)
        return np.asarray(KDTree(self.edge_mm).query(self.places_mm)[0])

    def averaged(self, values: Array, elsewhere: float) -> Array:
        """Load-weighted means (n,), over each node's support, of values (m,) at the samples; `elsewhere` at nodes
        without load.

        They are scaled so that their mean over nodes, weighted with nodal loads, equals that over samples, weighted
        with theirs.
        """
        weights, of_nodes = self.pressure_MPa * self.parts_mm2, self.areas_mm2 * self.nodal_MPa
        load, of_values = self.weights @ weights, self.weights @ (weights * values)
        mean = np.divide(of_values, load, out=np.full(len(load), elsewhere), where=load > 0.0)
        wanted, found = float(weights @ values) * float(of_nodes.sum()), float(of_nodes @ mean) * float(weights.sum())
        return np.asarray(mean * wanted / found if found > 0.0 else mean)

    def integrals(self, friction: Friction) -> tuple[float, float]:
        """Friction force in N at the law's limit: integrated over the samples, and summed over the nodes.

        Where the coefficient differs between nodes, its mean counts.
        """
        coefficient = float(np.mean(friction.coefficient))
        of_elements = self.parts_mm2 @ friction.law.limit(coefficient, self.pressure_MPa)
        return float(of_elements), float(self.areas_mm2 @ friction.law.limit(coefficient, self.nodal_MPa))

    def share(self, friction: Friction) -> float:
        """Friction force integrated over the samples, over that summed over the nodes (see `integrals`), kept between
        1/1.5 and 1.5; 1 if either is 0.
        """
        of_elements, of_nodes = self.integrals(friction)
        if not of_nodes > 0.0 or not of_elements > 0.0:
            return 1.0
        return min(max(of_elements / of_nodes, 1.0 / _LARGEST), _LARGEST)

    def law_error(self, friction: Friction) -> float:
        """Relative error of the integral of a friction law's limit by the uncertainty of the contact's area,
        `edge_error`; 0 for a law proportional to pressure.

        At the same load a larger area has pressures lower in proportion, to which only another law responds.
        """
        if friction.law.proportional or not len(self.pressure_MPa):
            return 0.0
        coefficient, pressure = float(np.mean(friction.coefficient)), self.pressure_MPa
        limit = float(self.parts_mm2 @ friction.law.limit(coefficient, pressure))
        slope = float((self.parts_mm2 * pressure) @ friction.law.derivative(coefficient, pressure))
        return 2.0 * self.edge_error * abs(1.0 - slope / limit) if limit > 0.0 else 0.0

    @cached_property
    def edge_error(self) -> float:
        """Half the relative error of the contact's area: half the share of it that is swept if its edge moves by 0.06
        elements.

        Each line of samples crosses the edge twice: for convex contacts the crossings along both axes add up to 4/π of
        the perimeter (Cauchy-Crofton). For an ellipse along the grid the result is 0.06 over its half-width in
        elements.
        """
        # Uncertainty of the edge's position in elements, from Hertz's ellipses on meshes of all levels.
        return 0.06 * pi / 8.0 * self.samples * len(self.edge_mm) / max(len(self.pressure_MPa), 1)


@dataclass(frozen=True, eq=False)
class WithinElements:
    """Pressure within a patch's elements around k nodes, each at its own position in a cycle; computed on first use."""

    patch: ContactPatch
    pressures_MPa: Sequence[Array]  #: Nodal pressures (n,) at each position in the cycle.
    position: IntArray  #: (k,) index in `pressures_MPa` of each node's position.
    #: Weight in [0, 1] of integrals over elements: 0 for worn bodies, which touch in bands that move over the patch.
    fresh: float = 1.0

    @cached_property
    def spreads(self) -> tuple[SpreadPressure, ...]:
        return tuple(SpreadPressure.of(self.patch, pressure, self.fresh > 0.5) for pressure in self.pressures_MPa)

    def among(self, chosen: slice | IntArray) -> "WithinElements":
        """Pressure within elements around some of the k nodes, `chosen` by index or slice."""
        return WithinElements(self.patch, self.pressures_MPa, self.position[chosen], self.fresh)

    def share(self, friction: Friction) -> Array:
        """Friction force integrated over elements over its sum of nodal pressures, (k,) by each node's position; 1 for
        worn bodies.
        """
        if self.fresh == 0.0:
            return np.ones(len(self.position))
        return 1.0 + self.fresh * (np.array([own.share(friction) for own in self.spreads])[self.position] - 1.0)


def _about(loaded: BoolArray) -> slice:
    """Slice of the lines (n,) that bear load, with `_AROUND` more on either side."""
    found = np.flatnonzero(loaded)
    if not found.size:
        return slice(0, 0)
    return slice(max(int(found[0]) - _AROUND, 0), int(found[-1]) + _AROUND + 1)


def _edge(square: Array, lines: Sequence[Array]) -> Array:
    """Positions (e, 2) where a field changes its sign between neighbouring samples."""
    found = []
    for axis in (0, 1):
        along, others = np.moveaxis(square, axis, 0), lines[1 - axis]
        i, j = np.nonzero((along[1:] > 0.0) != (along[:-1] > 0.0))
        share = along[i, j] / (along[i, j] - along[i + 1, j])
        crossed = lines[axis][i] + share * (lines[axis][np.minimum(i + 1, len(lines[axis]) - 1)] - lines[axis][i])
        found.append(np.column_stack([crossed, others[j]][:: 1 if axis == 0 else -1]))
    return np.concatenate(found)


def _hats(shape: tuple[int, ...], rows: slice, columns: slice, inside: BoolArray, samples: int) -> csr_matrix:
    """Hat functions (n, m) of a patch's nodes at the samples inside the contact; rows, columns: the patch's lines in
    use.
    """
    i, j = np.nonzero(inside)
    sample, node, value = [], [], []
    for di in (0, 1):
        for dj in (0, 1):
            a, b = i // samples + di, j // samples + dj
            weight = np.ones(len(i))
            for place, step in ((i, di), (j, dj)):
                part = (place % samples) / samples
                weight = weight * (part if step else 1.0 - part)
            kept = weight > 0.0
            sample.append(np.flatnonzero(kept))
            node.append((a + rows.start)[kept] * shape[1] + (b + columns.start)[kept])
            value.append(weight[kept])
    entries = (np.concatenate(value), (np.concatenate(node), np.concatenate(sample)))
    return csr_matrix(entries, (shape[0] * shape[1], len(i)))
