"""A wire of hexahedra on several contacts, all of them on one factored matrix: what holds it at given deflections.

Of a contact, the wire sinks by what its body is bent, and gives way at the contact. The latter is known from a contact
alone on a wire that is held on its back, so that is subtracted here: both are worked out on the same elements under the
same forces, and what elements lack under a force cancels.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.linalg import splu

from geometry import Elastic
from geometry.arrays import Array, BoolArray, IntArray
from geometry.bar import bar_mesh
from geometry.elements import ELEMENT_KINDS
from geometry.solid import SolidMesh
from solvers.elasticity.embedding import solid_stiffness

#: Over the diameter: shortest and longest slices, and how far the wire goes on behind the last place.
_SHORT, _LONG, _BEYOND = 0.25, 4.0, 1.5
_GROWTH = 0.4  #: Length of a slice over its distance from the nearest place.


@dataclass(frozen=True)
class Bar:
    """A straight wire or tube. loads_at_mm: places of a force of load_N, in equal parts, spread over the section.
    clamped_at_mm: sections that neither sink nor turn; free without any. tension_N: pull between the outermost places.
    grip_half_angle_rad: of the back at which a contact alone is held.
    """

    load_N: float
    loads_at_mm: tuple[float, ...]
    tension_N: float
    clamped_at_mm: tuple[float, ...]
    radius_mm: float
    bore_radius_mm: float
    material: Elastic
    grip_half_angle_rad: float

    def at(self, places_mm: Array, /) -> tuple[Array, Array]:
        """(K (n, n) in N/mm, p (n,) in N): forces p − K u at contacts hold deflections u (n,) towards them. A
        deflection is the approach of the wire's contact, less that of a contact alone to the back of its wire. Those of
        the last places are kept.
        """
        return _kept(self, tuple(places_mm.tolist()))

    def computed_at(self, places: Array) -> tuple[Array, Array]:
        loads = np.array(self.loads_at_mm)
        marks = np.unique([*places, *loads, *self.clamped_at_mm])
        mesh = bar_mesh(self.radius_mm, self.bore_radius_mm, self._lines(marks))
        points, size = mesh.points, 3 * len(mesh.points)
        stiffness = solid_stiffness(mesh, np.zeros(mesh.size, dtype=np.int64), np.ones(mesh.size), (self.material,))
        forces = np.zeros((size, len(places) + len(loads)))
        tops = [self._top(points, at) for at in places]
        forces[3 * np.array(tops) + 2, np.arange(len(places))] = 1.0
        weights = _node_volumes(mesh)
        for column, at in enumerate(loads, len(places)):
            there = self._section(points, at)
            forces[3 * there + 2, column] = weights[there] / weights[there].sum()
        held = np.zeros((len(points), 3), dtype=bool)
        held[np.abs(points[:, 1]) < 1e-9 * self.radius_mm, 1] = True
        on_back = held | self._back(points)[:, None]
        for at in self.clamped_at_mm:
            held[self._section(points, at)[:, None], [0, 2]] = True
        modes = []
        if not self.clamped_at_mm:
            # As little as keeps it from moving as a whole; forces that balance leave it unloaded.
            held[self._top(points, points[:, 0].min())] = True
            modes = [np.ones(forces.shape[1])]
            if not self.tension_N:
                held[self._top(points, points[:, 0].max()), 2] = True
                modes.append(np.array([*places, *loads]))
        pulled = stiffness + self._pull(mesh, marks[0], marks[-1]) if self.tension_N else stiffness
        n, pressed = len(places), np.full(len(loads), self.load_N / max(1, len(loads)))
        moved = _flexibility(pulled, held.ravel(), forces)
        alone = np.diag(_flexibility(stiffness, on_back.ravel(), forces[:, :n]))
        rigid = np.array(modes).reshape(len(modes), forces.shape[1]).T
        k = rigid.shape[1]
        block = np.block([[moved[:n, :n] - np.diag(alone), -rigid[:n]], [rigid[:n].T, np.zeros((k, k))]])
        sinks = np.concatenate([moved[:n, n:] @ pressed, rigid[n:].T @ pressed])
        inverse = np.linalg.inv(block)[:n]
        return inverse[:, :n], inverse @ sinks

    def _lines(self, marks: Array) -> Array:
        """Places of the slices' ends, at each mark and the closer the nearer to one."""
        size = 2.0 * self.radius_mm
        ends = [marks[0] - _BEYOND * size, *marks, marks[-1] + _BEYOND * size]
        found = [np.array(ends[:1])]
        for low, high in pairwise(ends):
            x = np.linspace(low, high, 401)
            away = np.abs(x[:, None] - marks).min(axis=1)
            dense = 1.0 / np.clip(_GROWTH * away, _SHORT * size, _LONG * size)
            passed = np.concatenate([[0.0], np.cumsum(0.5 * (dense[1:] + dense[:-1]) * np.diff(x))])
            count = int(np.ceil(passed[-1] - 1e-9))
            found.append(np.interp(np.linspace(0.0, passed[-1], count + 1)[1:], passed, x))
        return np.concatenate(found)

    def _section(self, points: Array, at_mm: float) -> IntArray:
        return np.flatnonzero(np.abs(points[:, 0] - at_mm) < 1e-6 * self.radius_mm)

    def _top(self, points: Array, at_mm: float) -> int:
        place = np.array([at_mm, 0.0, self.radius_mm])
        return int(np.linalg.norm(points - place, axis=1).argmin())

    def _back(self, points: Array) -> BoolArray:
        outside = np.hypot(points[:, 1], points[:, 2]) > self.radius_mm * (1.0 - 1e-6)
        return np.asarray(outside & (np.arctan2(points[:, 1], -points[:, 2]) < self.grip_half_angle_rad + 1e-6))

    def _pull(self, mesh: SolidMesh, low: float, high: float) -> csr_matrix:
        """Stiffness (3 n, 3 n) by which the pull resists slopes along the wire."""
        stress = self.tension_N / (np.pi * (self.radius_mm**2 - self.bore_radius_mm**2))
        cells = mesh.cells[20]
        inside = (mesh.middles[:, 0] > low) & (mesh.middles[:, 0] < high)
        slopes, volumes = mesh.gradients(ELEMENT_KINDS[20], cells[inside])
        own = stress * np.einsum("mqi,mqj,mq->mij", slopes[..., 0], slopes[..., 0], volumes, optimize=True)
        values = np.repeat(own[..., None], 3, axis=3)
        rows, columns = (3 * np.broadcast_to(each, own.shape)[..., None] + np.arange(3)
                         for each in (cells[inside][:, :, None], cells[inside][:, None, :]))  # fmt: skip
        size = 3 * len(mesh.points)
        return csr_matrix(coo_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size)))


@lru_cache(maxsize=2)
def _kept(bar: Bar, places_mm: tuple[float, ...]) -> tuple[Array, Array]:
    return bar.computed_at(np.array(places_mm))


def _node_volumes(mesh: SolidMesh) -> Array:
    """Volume (n,) of the elements that have each node."""
    kind, cells = ELEMENT_KINDS[20], mesh.cells[20]
    _, volumes = mesh.gradients(kind, cells)
    return np.bincount(cells.ravel(), np.repeat(volumes.sum(axis=1), 20), len(mesh.points)).astype(np.float64)


def _flexibility(half: csr_matrix, held: BoolArray, forces: Array) -> Array:
    """Displacements (k, k) in mm along forces (3 n, k) by each of them; half: stiffness of half of the body."""
    free = np.flatnonzero(~held)
    factored = splu(half[free][:, free].tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    return np.asarray(0.5 * forces[free].T @ factored.solve(forces[free]))
