"""Bodies whose condensed stiffness a file gives: the matrix, its nodes, and the grid of those that may touch.

In numpy's .npz the arrays are `stiffness_N_per_mm` (3 n, 3 n), `nodes_mm` (n, 3), for each set of nodes (those that may
touch, those held) its indices under its name and, where the elements form layers under the contact,
`layers_mm_and_growth` (2,). A Matrix Market file .mtx has beside it a table .csv of the same name with the columns
x_mm, y_mm, z_mm and set. Unknown 3 i + k is the displacement of node i along axis k. The axes are the body's: x along
it, z outwards from where it touches, the origin.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from geometry.arrays import Array, IntArray
from geometry.body import BodyMesh
from geometry.embedded import OwnGrid, on_grid
from geometry.errors import GeometryError
from geometry.grading import GivenAxis, Layering
from geometry.mesh_files import digest_of
from geometry.own_surface import FittedFace, MeshSource, face_through
from geometry.patch import ContactPatch

_ROUND_OFF = 1e-6  #: Of a matrix: asymmetry, and forces of a rigid motion, over its entries.


@dataclass(frozen=True, eq=False)
class FileStiffness:
    """The stiffness of a body of n nodes without its holder."""

    nodes_mm: Array  #: (n, 3).
    matrix: Array  #: (3 n, 3 n) in N/mm, symmetric; no rigid motion meets a force.
    contact: IntArray  #: Indices of the nodes on the contact surface.
    held: IntArray  #: Indices of the nodes that the holder grips.
    #: Thickness in mm of the uppermost elements under the contact, and the factor by which it grows from layer to
    #: layer; None if unknown.
    layers: tuple[float, float] | None

    @property
    def of_free(self) -> tuple[Array, ContactPatch]:
        """Stiffness (3 f, 3 f) in N/mm between f nodes that are not held, the patch's first in order; and the patch."""
        patch = self.patch
        others = np.setdiff1d(np.arange(len(self.nodes_mm)), np.concatenate([self.contact, self.held]))
        free = (3 * np.concatenate([patch.nodes.ravel(), others])[:, None] + np.arange(3)).ravel()
        return self.matrix[np.ix_(free, free)], patch

    @property
    def patch(self) -> ContactPatch:
        """The grid of nodes that may touch. Raises GeometryError if they form none about the origin."""
        found = on_grid(self.nodes_mm[:, :2], self.contact)
        if found is None or any(lines[0] >= 0.0 or lines[-1] <= 0.0 for lines in found[0]):
            raise GeometryError("the nodes that may touch are no grid of lines along x and y about the origin")
        (along, across), nodes = found
        return ContactPatch(along, across, nodes, self.face)

    @property
    def face(self) -> FittedFace:
        return face_through(self.nodes_mm[self.contact])


@dataclass(frozen=True)
class OwnStiffness(OwnGrid):
    """The geometry of a body whose stiffness a file gives: a contact patch, but no elements."""

    @property
    def read(self) -> FileStiffness:
        return read_stiffness(self.source)

    @property
    def profile(self) -> FittedFace:
        return self.read.face

    @property
    def half_length_mm(self) -> float:
        return float(np.abs(self.read.nodes_mm[:, 0]).max())

    @property
    def least_extent_mm(self) -> float:
        return float(np.ptp(self.read.nodes_mm, axis=0).min())

    def built(self) -> BodyMesh:
        """Raise GeometryError, always: it has no elements."""
        raise GeometryError(
            f"of {Path(self.source.file).name} the stiffness is known and no elements: it can be run, but it has no "
            "mesh and no stresses inside"
        )


def of_stiffness(source: MeshSource) -> OwnStiffness:
    """The geometry of the body in a stiffness file. Raises GeometryError, with the reason, if it cannot be used."""
    read = read_stiffness(source)
    axial, transverse = (GivenAxis(tuple(each.tolist())) for each in (read.patch.axial_mm, read.patch.transverse_mm))
    finest = min(axial.finest_mm, transverse.finest_mm)
    thickness, growth = read.layers or (finest, 1.0)
    coarse = max(axial.outer_mm, transverse.outer_mm)
    return OwnStiffness(source, axial, transverse, coarse, None, Layering(growth=growth, first=thickness / finest))


@lru_cache(maxsize=2)
def read_stiffness(source: MeshSource) -> FileStiffness:
    """The checked contents of a stiffness file; the last two are kept. Raises GeometryError, in one sentence, if they
    are no stiffness of a body.
    """
    name = Path(source.file).name
    if digest_of(source.file) != source.digest:
        raise GeometryError(f"{name} is not the file that it was: put the one back that was read before")
    try:
        read = _of_npz(source) if source.file.lower().endswith(".npz") else _of_matrix_market(source)
        matrix, nodes = read.matrix, read.nodes_mm
        if nodes.shape[1:] != (3,) or matrix.shape != (3 * len(nodes), 3 * len(nodes)):
            raise GeometryError(
                f"its matrix of {' × '.join(map(str, matrix.shape))} numbers does not fit its {len(nodes)} nodes of "
                "three unknowns each"
            )
        _require_stiffness(read)
    except GeometryError as problem:
        raise GeometryError(f"{name} gives no stiffness of a body: {problem}") from None
    except Exception as problem:  # noqa: BLE001 - numpy's, zipfile's and scipy's readers raise too many kinds to name
        raise GeometryError(f"{name} cannot be read as a matrix with its nodes ({problem})") from None
    return read


def _require_stiffness(read: FileStiffness) -> None:
    matrix, nodes = read.matrix, read.nodes_mm
    if not (np.isfinite(matrix).all() and np.isfinite(nodes).all()):
        raise GeometryError("a number in it is not finite")
    largest = float(np.abs(matrix).max())
    if (off := float(np.abs(matrix - matrix.T).max())) > _ROUND_OFF * largest:
        raise GeometryError(
            f"it is not symmetric: two entries that should be equal differ by {off / largest:.1e} of it"
        )
    about = nodes - nodes.mean(axis=0)
    motions = _by_motion(about / max(float(np.abs(about).max()), 1e-300))
    forces = np.abs(matrix @ motions).max(axis=0)
    which = int(forces.argmax())
    if forces[which] > _ROUND_OFF * float(np.abs(matrix).sum(axis=1).max()):
        raise GeometryError(
            f"a rigid {'displacement along' if which < 3 else 'rotation about'} {'xyz'[which % 3]} meets forces, but a "
            "body that nothing holds meets none: keep its held nodes in the matrix, and do not fix them"
        )
    if len(read.held) < 3 or np.linalg.matrix_rank(about[read.held] - about[read.held].mean(axis=0), tol=1e-9) < 2:
        raise GeometryError("its held nodes are fewer than three, or on one line, and do not hold it")
    if np.intersect1d(read.held, read.contact).size:
        raise GeometryError("a node is held that may touch")


def _of_npz(source: MeshSource) -> FileStiffness:
    with np.load(source.file) as data:
        layers = tuple(data["layers_mm_and_growth"].tolist()) if "layers_mm_and_growth" in data else None
        contact, held = (_named(data.get(name), name) for name in (source.contact, source.held))
        return FileStiffness(data["nodes_mm"], data["stiffness_N_per_mm"], contact, held, layers)


def _of_matrix_market(source: MeshSource) -> FileStiffness:
    from scipy.io import mmread

    matrix = mmread(source.file)
    table = np.genfromtxt(
        Path(source.file).with_suffix(".csv"), delimiter=",", names=True, dtype=None, encoding="utf-8", autostrip=True
    )
    nodes = np.stack([table[name] for name in ("x_mm", "y_mm", "z_mm")], axis=1).astype(np.float64)
    contact, held = (_named(np.flatnonzero(table["set"] == name), name) for name in (source.contact, source.held))
    full = np.asarray(matrix.toarray() if hasattr(matrix, "toarray") else matrix)
    return FileStiffness(nodes, full, contact, held, None)


def _named(nodes: IntArray | None, name: str) -> IntArray:
    if nodes is None or not len(nodes):
        raise GeometryError(f"it has no set {name!r} of nodes")
    return np.asarray(nodes, dtype=np.int64)


def write_stiffness(path: Path, patch: ContactPatch, of_contact: Array, layers: tuple[float, float]) -> None:
    """Write a body to `path`, an .npz, from the stiffness `of_contact` (3 n, 3 n) in N/mm of its patch's n nodes
    relative to a rigid holder; layers: as in `FileStiffness`.

    Three nodes behind the patch stand for the holder and carry its motion.
    """
    plane = patch.grid()
    nodes = np.column_stack([plane, patch.height(plane)])
    size = float(np.ptp(plane, axis=0).max())
    held = np.array([[-size, -size, -size], [size, -size, -size], [0.0, size, -size]])
    moved = _by_motion(nodes) @ np.linalg.pinv(_by_motion(held))
    pulled = of_contact @ moved
    stiffness = np.block([[of_contact, -pulled], [-pulled.T, moved.T @ pulled]])
    with path.open("wb") as file:
        np.savez(
            file,
            stiffness_N_per_mm=stiffness,
            nodes_mm=np.vstack([nodes, held]),
            contact=np.arange(len(nodes)),
            grip=len(nodes) + np.arange(3),
            layers_mm_and_growth=np.array(layers),
        )


def _by_motion(nodes: Array) -> Array:
    """Displacements (3 n, 6) of nodes by a rigid body's unit displacements and rotations."""
    turns = np.stack([np.cross(axis, nodes) for axis in np.eye(3)], axis=-1)
    return np.concatenate([np.tile(np.eye(3), (len(nodes), 1)), turns.reshape(-1, 3)], axis=1)
