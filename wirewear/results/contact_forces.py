"""Contact forces on a body at positions of a recorded cycle, and largest mean pressures over a stated length.

A position is a moment of a cycle; its phase is the share of the cycle passed since the end of the stroke at +x.
Stresses inside a body follow from these forces. At a crest as narrow as an element, nodal pressures show the mesh;
means do not: for contacts at a point over a disc of the stated diameter in the plane of contact, for line contacts over
a segment of the stated length. Each node's pressure counts in the node's cell, which reaches halfway to its neighbours,
so the nodal forces are kept to round-off.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_matrix

from geometry import BlockGeometry, BodyGeometry, Elastic, GradedAxis, Layering, RimGradedAxis, WireGeometry
from geometry.arrays import Array, BoolArray, IntArray
from geometry.embedded import EmbeddedGeometry, OwnGrid
from geometry.grading import GivenAxis
from geometry.mesh_files import MATRICES
from geometry.own_surface import MeshSource
from geometry.stiffness_files import OwnStiffness
from wirewear.base.errors import ResultError
from wirewear.base.kinds import POSITIONS
from wirewear.results.scar import float_array, require_finite

POSITION_COLUMNS = ("phase", "drive_um", "holder_x_um", "holder_z_um", "tangential_force_N")


def largest_mean_pressure_MPa(
    pressure_MPa: ArrayLike, axial_um: ArrayLike, transverse_um: ArrayLike | None = None, *, over_um: float
) -> float:
    """Largest mean pressure over a disc of diameter `over_um` about any node or, on a line, over a segment of that
    length.

    pressure_MPa: (n_a, n_t) at the nodes, or (n_a,) for a line contact. axial_um, transverse_um: (n_a,) and (n_t,)
    increasing grid lines of a scar; None across for a line contact. Raises ResultError if the length is not positive,
    or pressures and lines do not fit together.
    """
    pressure, axial = np.asarray(pressure_MPa, dtype=float), np.asarray(axial_um, dtype=float)
    transverse = np.zeros(1) if transverse_um is None else np.asarray(transverse_um, dtype=float)
    if not 0.0 < over_um < np.inf:
        raise ResultError(f"a mean pressure is over a positive length, not over {over_um:g} µm")
    wanted = axial.shape if transverse_um is None else axial.shape + transverse.shape
    if axial.ndim != 1 or transverse.ndim != 1 or pressure.shape != wanted or pressure.size == 0:
        raise ResultError(f"pressures of shape {pressure.shape} are not those at nodes on lines of shape {wanted}")
    if np.any(np.diff(axial) <= 0.0) or np.any(np.diff(transverse) <= 0.0):
        raise ResultError("the lines of the nodes must increase")
    states = pressure.reshape(1, axial.size, transverse.size)
    return float(largest_means(states, axial, transverse, over_um)[0])


def largest_means(pressure: Array, axial: Array, transverse: Array, length: float) -> Array:
    """Largest mean (k,) about any node in each of k states of nodal pressures (k, n_a, n_t), in their unit; 0 without
    contact. axial, transverse: (n_a,) and (n_t,) increasing grid lines; a single one across for a line contact. length:
    diameter of the discs, or length of the segments, in the unit of the lines.
    """
    touched: BoolArray = np.asarray(pressure.any(axis=0))
    if not touched.any():
        return np.zeros(len(pressure))
    # A disc about the nearest node of the rectangle around all that touch holds whatever one about another node does.
    along, across = _reached(touched, 1), _reached(touched, 0)
    within = np.ascontiguousarray(pressure[:, along, across].reshape(len(pressure), -1).T)
    weighed = averaging(axial, transverse, length, along, across)
    return np.asarray(np.max([(means @ within).max(axis=0) for means in weighed], axis=0))


def averaging(
    axial: Array, transverse: Array, length: float, along: slice = slice(None), across: slice = slice(None)
) -> Iterator[csr_matrix]:
    """Yields sparse matrices that average nodal pressures about nodes: entries are shares of a disc's (or segment's)
    area in the nodes' cells.

    axial, transverse, length: as in `largest_means`. along, across: the lines that bound a rectangle outside which
    nothing carries load. Each matrix has rows for some lines of the rectangle's nodes, in order, and columns for all of
    its nodes, flattened.
    """
    a, t = _near(axial, along, length), _near(transverse, across, length)
    # Pairs of a node and a cell weighed at once, some 100 MB: wide discs pair every node with every cell of a scar.
    at_once = max(1, 1_000_000 // max(1, a.count * len(t.about)))
    for first in range(0, a.count, at_once):
        yield _weights(a.of_lines(first, min(first + at_once, a.count)), t, plane=len(transverse) > 1)


def _weights(a: "_Near", t: "_Near", *, plane: bool) -> csr_matrix:
    if plane:
        (low_a, high_a), (low_t, high_t) = 2.0 * a.sides.T[:, :, None], 2.0 * t.sides.T[:, None, :]
        inside = _disc_below(high_a, high_t) - _disc_below(low_a, high_t)
        inside -= _disc_below(high_a, low_t) - _disc_below(low_a, low_t)
        shares = inside.ravel() / np.pi
    else:
        shares = np.diff(np.clip(a.sides, -0.5, 0.5), axis=1)[:, 0]
    about = (t.count * a.about[:, None] + t.about).ravel()
    node = (t.count * a.node[:, None] + t.node).ravel()
    found = shares > 0.0
    return csr_matrix((shares[found], (about[found], node[found])), shape=(a.rows * t.count, a.count * t.count))


def _reached(touched: BoolArray, axis: int) -> slice:
    """Slice from the first to the last line with a True entry; `axis` is the one along the lines."""
    places = np.flatnonzero(touched.any(axis=axis))
    return slice(int(places[0]), int(places[-1]) + 1)


@dataclass(frozen=True)
class _Near:
    """Pairs (p,) of a line among `rows` and a line among `count` whose cell is near.

    about, node: (p,) their indices, the former increasing. sides: (p, 2) where the latter's cell begins and ends,
    relative to the former line, over the length.
    """

    rows: int
    count: int
    about: IntArray
    node: IntArray
    sides: Array

    def of_lines(self, first: int, end: int) -> "_Near":
        """The pairs of the lines from `first` to before `end`, which are then numbered from 0."""
        here = slice(*np.searchsorted(self.about, [first, end]))
        return _Near(end - first, self.count, self.about[here] - first, self.node[here], self.sides[here])


def _near(every: Array, chosen: slice, length: float) -> _Near:
    halfway = 0.5 * (every[1:] + every[:-1])
    lines = every[chosen]
    begin, end = np.concatenate([every[:1], halfway])[chosen], np.concatenate([halfway, every[-1:]])[chosen]
    about, node = np.nonzero((begin < lines[:, None] + 0.5 * length) & (end > lines[:, None] - 0.5 * length))
    sides = np.stack([begin[node], end[node]], axis=1) - lines[about, None]
    return _Near(len(lines), len(lines), about, node, sides / length)


def _disc_below(x: Array, y: Array) -> Array:
    """Area of the part of a disc of radius 1 with coordinates less than x and less than y; shapes broadcast."""
    x, y = np.broadcast_arrays(np.clip(x, -1.0, 1.0), np.clip(y, -1.0, 1.0))
    left, below = _disc_left(x), _disc_left(y)
    within = x * y + 0.5 * (left + below) - 0.25 * np.pi
    beside = np.where(x < 0.0, np.where(y < 0.0, 0.0, left), np.where(y < 0.0, below, left + below - np.pi))
    return np.where(x**2 + y**2 < 1.0, within, beside)


def _disc_left(x: Array) -> Array:
    return x * np.sqrt(1.0 - x**2) + np.arcsin(x) + 0.5 * np.pi


@dataclass(frozen=True, eq=False)
class ContactForces:
    """Forces on one body at k positions of a cycle, in their order in time.

    `phase` (k,), in (0, 1], as above; `drive_um` (k,): displacement of the driven body; `holder_x_um`, `holder_z_um`
    (k,): of the held body's holder; `tangential_force_N` (k,): on the held body along x. `nodes` (m,): indices in the
    patch's flattened grid of the nodes that carry force at any position; `force_N` (k, m, 3) acts on the body, in its
    own axes: along it, across it, out of its surface. `geometry` and `material` serve to build the body's mesh again,
    None for a line contact, whose mesh follows from its study. `bulk_stress_MPa` (k, 3): axial, bending and torsion
    stress at the contact that the body carries besides (`solvers.BulkStress`); None without any.

    Raises ResultError if arrays do not fit together, or are not finite.
    """

    cycle: int
    body: str
    phase: Array
    drive_um: Array
    holder_x_um: Array
    holder_z_um: Array
    tangential_force_N: Array
    nodes: IntArray
    force_N: Array
    axis_angle_deg: float = 0.0
    geometry: BodyGeometry | None = None
    material: Elastic | None = None
    bulk_stress_MPa: Array | None = None

    def __post_init__(self) -> None:
        where = f"contact forces of cycle {self.cycle}"
        columns = {name: float_array(f"{where}: {name}", getattr(self, name), 1) for name in POSITION_COLUMNS}
        columns["force_N"] = float_array(f"{where}: force_N", self.force_N, 3)
        if self.bulk_stress_MPa is not None:
            columns["bulk_stress_MPa"] = float_array(f"{where}: bulk_stress_MPa", self.bulk_stress_MPa, 2)
        for name, values in columns.items():
            require_finite(f"{where}: {name}", values)
            object.__setattr__(self, name, values)
        wanted = (len(self.phase), len(self.nodes), 3)
        if self.force_N.shape != wanted or any(len(columns[name]) != wanted[0] for name in POSITION_COLUMNS):
            raise ResultError(f"{where}: force_N must have shape {wanted}, not {self.force_N.shape}")
        if self.bulk_stress_MPa is not None and self.bulk_stress_MPa.shape != (wanted[0], 3):
            raise ResultError(f"{where}: bulk_stress_MPa must have shape {(wanted[0], 3)}")

    @property
    def meshed(self) -> tuple[BodyGeometry, Elastic]:
        """(geometry, material) of the body's mesh; ResultError for a line contact."""
        if self.geometry is None or self.material is None:
            raise ResultError(f"contact forces of the {self.body} of a line contact say nothing of its mesh")
        return self.geometry, self.material

    def named(self) -> dict[str, int]:
        """Index of the recorded position for each name in POSITIONS, as from `named_positions`."""
        return named_positions(self.phase)

    def position(self, at: str | int) -> int:
        """Index of a position among those recorded, from its name in POSITIONS or the index itself, also as text;
        ResultError if there is none.
        """
        return position_of(at, self.phase, self.cycle)


def geometry_of(table: Mapping[str, Any]) -> BodyGeometry:
    """A body's geometry from the nested mapping that its `as_table` gives, lists in place of tuples allowed.
    Raises ResultError if the mapping was written by another version.
    """
    try:
        parts: dict[str, Any] = {name: _axis(table[name]) for name in ("axial", "transverse")}
        shape: type[BodyGeometry] = WireGeometry if "diameter_mm" in table else BlockGeometry
        if "source" in table:
            source = parts["source"] = MeshSource(**{key: _as_tuples(one) for key, one in table["source"].items()})
            of_nodes = OwnStiffness if source.file.endswith(MATRICES) else OwnGrid
            shape = EmbeddedGeometry if "height_mm" in table else of_nodes
        return shape(**{**table, **parts, "layering": Layering(**table["layering"])})
    except (KeyError, TypeError) as problem:
        raise ResultError(f"a body's geometry of another version of wirewear: {problem}") from problem


def _axis(table: Mapping[str, Any]) -> GradedAxis | RimGradedAxis | GivenAxis:
    if "lines_mm" in table:
        return GivenAxis(tuple(table["lines_mm"]))
    return (RimGradedAxis if "rim_mm" in table else GradedAxis)(**table)


def _as_tuples(value: Any) -> Any:
    """The value with all lists in it, at any depth, turned into tuples: JSON knows lists only."""
    return tuple(_as_tuples(each) for each in value) if isinstance(value, list) else value


def named_positions(phase: Array) -> dict[str, int]:
    """Index (0 to k - 1) of the position nearest to each of POSITIONS, by name. phase (k,): shares of the cycle passed
    since the end of the stroke at +x. "After" a reversal is the first position behind it.
    """
    passed = phase % 1.0
    mid_forward, mid_back = (int(np.argmin(np.abs(passed - at))) for at in (0.75, 0.25))
    end_forward = int(np.argmin(np.minimum(passed, 1.0 - passed)))
    end_back = int(np.argmin(np.abs(passed - 0.5)))
    count = len(passed)
    found = (mid_forward, end_forward, (end_forward + 1) % count, mid_back, end_back, (end_back + 1) % count)
    return dict(zip(POSITIONS, found, strict=True))


def position_of(at: str | int, phase: Array, cycle: int) -> int:
    """Index of the position `at`, a name in POSITIONS or an index, also as text, in a cycle with phases (k,).
    Raises ResultError, which names the cycle `cycle`, if there is no such position.
    """
    if isinstance(at, int) or at.isdecimal():
        if 0 <= int(at) < len(phase):
            return int(at)
        raise ResultError(f"there is no position {at}: cycle {cycle} has positions 0 to {len(phase) - 1}.")
    if at not in POSITIONS:
        raise ResultError(f"there is no position {at!r}: choose one of {', '.join(POSITIONS)}, or a number.")
    return named_positions(phase)[at]
