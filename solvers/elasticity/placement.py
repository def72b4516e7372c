"""Bodies placed in the world: orientation, worn surface as a height field, compliance in world axes.

World axes: x is the direction of motion, z the contact normal from the lower to the upper body, the origin the point of
first contact. Positions on a surface are plane coordinates (x, y) in mm. The worn depth is vertical and measured below
the unworn surface, also where the mesh's nodes have been moved into the worn surface: that affects the compliance
alone.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import cos, log, sin
from typing import Any

import numpy as np

from geometry import ContactPatch
from geometry.arrays import Array, BoolArray, IntArray
from solvers.elasticity.body import Compliance, ContactBody
from solvers.elasticity.coats import CoatedPatch, Coating
from solvers.elasticity.patch_compliance import Bricks, PatchCompliance, missing_displacement
from solvers.elasticity.quadrature import gradient
from solvers.errors import SolverError

_ALIKE = 2.0  #: Elements whose sizes differ by less than this factor are corrected alike, in proportion to their size.
# Meshes are mirrored to the last bit, their compliance to round-off of the factorisation.
_PLACE_TOLERANCE_mm = 1e-10
_COMPLIANCE_TOLERANCE = 1e-8
_ROUND_OFF = 1e-6  #: Of a power of `_ALIKE`.
_KINDS = 2  #: Elements larger than the finest by more than so many of these factors are corrected as those are.


@dataclass(frozen=True)
class SurfaceSample:
    """A worn surface at n plane points."""

    height: Array  #: (n,) in mm, in world z relative to the body's origin.
    slope: Array  #: (n, 2) its gradient in world axes.
    nodes: IntArray  #: (n, 4) patch nodes that interpolate at the points; (n, 2) on planar bodies.
    weights: Array  #: (n, 4) or (n, 2) bilinear weights of the nodes.
    inside: BoolArray  #: (n,) True for points on the patch.


@dataclass(frozen=True)
class WornNodes:
    """Surface worn by `depth` (n_a, n_t) in mm: heights (n,) in mm, and gradient of the depth (n, 2), at n nodes."""

    depth: Array
    heights: Array  #: (n,) in world z relative to the body's origin.
    gradient: Array  #: (n, 2) gradient of the depth along the patch's axes.


@dataclass(frozen=True)
class PlacedBody:
    """A body placed in world axes: x along the motion, z upwards."""

    patch: ContactPatch
    facing: int  #: +1 for the lower body (its patch faces +z), -1 for the upper one.
    axis_angle_rad: float  #: Angle of the body's axis from the motion, counter-clockwise from above.
    folded: Compliance  #: Compliance of the patch in mm/N, in world axes.
    world_to_patch: Array  #: (2, 2) turns plane vectors into the patch's axes.
    incline: float = 0.0  #: Rise of the whole surface along x, mm per mm.
    bricks: Bricks | None = None  #: The elements under the patch, see `ContactBody.bricks`.
    yielding: ContactBody | None = None  #: The body in its own axes if forces can leave a print on it.
    #: Coatings in the compliance, on this body and on the one that faces it, and what is left of them; None for none.
    coats: tuple[CoatedPatch, Array] | None = None

    @property
    def compliance(self) -> Array:
        return self.folded.dense

    def worn_through(self, own_mm: Array, facing_mm: Array) -> "PlacedBody":
        """The body with what is left of the coatings where surfaces are worn by these depths (n,) at its nodes; itself
        if nothing has changed by as much as counts.
        """
        if self.coats is None:
            return self
        coated, before = self.coats
        left = coated.left_mm(own_mm, facing_mm)
        if not coated.differs(before, left):
            return self
        return replace(self, folded=coated.compliance(left), coats=(coated, left))

    def printed(self, print_mm: Array | None, force_N: Array) -> Array | None:
        """Depth (n_a, n_t) in mm of the body's print after forces, where it was `print_mm` before; `print_mm` itself,
        maybe None, for a body that does not yield.

        force_N: (n, 3) on the patch's nodes in world axes, with the sign of the force on the upper body.
        """
        if self.yielding is None or print_mm is None:
            return print_mm
        return self.yielding.update(print_mm, -self.facing * force_N @ self.folded.rotation)

    @cached_property
    def node_positions(self) -> Array:
        """(n, 2) plane positions (x, y) in mm of the patch's nodes relative to the body's origin, world axes."""
        return self.patch.grid() @ self.world_to_patch

    @cached_property
    def node_areas(self) -> Array:
        return self.patch.node_areas()

    @cached_property
    def nodal_compliance(self) -> Array:
        """Displacements (3,) of a typical node along x, y and z by a unit traction on its own area, mm per MPa."""
        own = self.folded.diagonal().reshape(-1, 3) * self.node_areas[:, None]
        return np.asarray(np.median(own, axis=0))

    @cached_property
    def edge_nodes(self) -> BoolArray:
        return self.patch.edge_nodes()

    @cached_property
    def mirror_images(self) -> dict[tuple[float, float], IntArray | None]:
        """Cache of `known_images`: for signs (sign_x, sign_y) each node's image (n,), or None without this symmetry."""
        return {}

    @cached_property
    def _fresh_node_heights(self) -> Array:
        return np.asarray(self.patch.profile.height(self.patch.grid()))

    def worn(self, depth_mm: Array) -> WornNodes:
        """Heights and depth gradients at the patch's nodes, of the surface worn by `depth_mm` (n_a, n_t).

        The latest result is kept and returned for the same array object, which callers must not change.
        """
        latest = self._latest_worn
        if not latest or latest[0].depth is not depth_mm:
            height = self.facing * (self._fresh_node_heights - depth_mm.ravel())
            height += self.incline * self.node_positions[:, 0]
            latest[:] = [WornNodes(depth_mm, height, gradient(depth_mm, self.patch))]
        return latest[0]

    def receded(self, depth_mm: Array, print_mm: Array) -> Array:
        """Depth (n_a, n_t) in mm of the surface with a print beside what has worn, both of that shape.

        The latest result is kept and returned for the same array objects, which callers must not change.
        """
        latest = self._latest_receded
        if not latest or latest[0] is not depth_mm or latest[1] is not print_mm:
            latest[:] = [depth_mm, print_mm, depth_mm + print_mm]
        return latest[2]

    @cached_property
    def _latest_receded(self) -> list[Array]:
        return []

    @cached_property
    def _latest_worn(self) -> list[WornNodes]:
        return []

    def forget(self) -> None:
        """Drop matrices and pairings that were kept from earlier increments."""
        for latest in (self.latest_block, self.latest_pairing, self.latest_compliance):
            latest.clear()

    @cached_property
    def latest_block(self) -> list[Any]:
        """The block of compliance gathered last, in a list of at most one; see `solvers.elasticity.compliance`."""
        return []

    @cached_property
    def latest_pairing(self) -> list[Any]:
        """The pairing around a core made last, and of what, in a list of at most one; see `solvers.contact.problem`."""
        return []

    @cached_property
    def latest_compliance(self) -> list[tuple["PlacedBody", Any]]:
        """The body faced last and the `PairedCompliance` with it, in a list of at most one."""
        return []

    def sample(self, points_mm: Array, depth_mm: Array) -> SurfaceSample:
        """The surface worn by `depth_mm` (n_a, n_t) at points (n, 2) in mm, in world axes, from the body's origin."""
        local = points_mm @ self.world_to_patch.T
        patch = self.patch
        nodes, weights, inside = patch.locate(local)
        worn = interpolated(depth_mm.ravel(), nodes, weights)
        along, across = patch.gradient(depth_mm).T
        wear_slope = np.column_stack([interpolated(along, nodes, weights), interpolated(across, nodes, weights)])
        height = self.facing * (patch.profile.height(local) - worn) + self.incline * points_mm[:, 0]
        slope = self.facing * (patch.profile.slope(local) - wear_slope) @ self.world_to_patch
        slope[:, 0] += self.incline
        return SurfaceSample(height, slope, nodes, weights, inside)


def place(body: ContactBody, *, upper: bool, axis_angle_rad: float) -> PlacedBody:
    """The body below or, as `upper`, above the plane of contact, its axis at an angle to the motion, counter-clockwise
    from above.
    """
    rotation = rotation_to_world(upper=upper, axis_angle_rad=axis_angle_rad)
    folded = body.folded.turned(rotation)
    return PlacedBody(
        body.patch,
        -1 if upper else 1,
        axis_angle_rad,
        folded,
        rotation[:2, :2].T,
        bricks=body.bricks,
        yielding=body if body.yields else None,
    )


def rotation_to_world(*, upper: bool, axis_angle_rad: float) -> Array:
    """Matrix (3, 3) from a body's axes to world axes; an upper body is first turned over about its own axis."""
    c, s = cos(axis_angle_rad), sin(axis_angle_rad)
    # Rounding of cos(pi/2) would break the exact symmetry of wires crossed at right angles.
    c, s = (0.0 if abs(c) < 1e-15 else c), (0.0 if abs(s) < 1e-15 else s)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    flip = np.diag([1.0, -1.0, -1.0]) if upper else np.eye(3)
    return np.asarray(turn @ flip)


def interpolated(nodal: Array, nodes: IntArray, weights: Array) -> Array:
    """Values (n,) of a nodal field at n points; nodes, weights: (n, c) the c nodes around each, and their weights."""
    return np.asarray(np.einsum("ij,ij->i", nodal[nodes], weights))


def facing(primary: PlacedBody, secondary: PlacedBody) -> PlacedBody:
    """The primary body with the near-field correction of `patch_compliance` for both bodies added to its compliance.

    The correction depends on the pair: a force on a node of the primary reaches the secondary spread over elements of
    both. Without `bricks` on either body the primary is returned unchanged.
    """
    own, other, folded = primary.bricks, secondary.bricks, primary.folded
    if own is None or other is None or not isinstance(folded, PatchCompliance):
        return primary
    turn = secondary.world_to_patch @ primary.world_to_patch.T
    finest = (*_finest(primary.patch), *_finest(secondary.patch))
    sizes = _sizes(primary, secondary)[folded.piece_nodes()]
    steps, weights = _steps(np.log(sizes / finest) / log(_ALIKE))
    # Alike lattices answer with displacements that go with one over their size.
    shares = (finest * _ALIKE**steps / sizes[:, None])[..., :2].prod(axis=-1) ** 0.5
    kinds, places = np.unique(steps.reshape(-1, 4).astype(int), axis=0, return_inverse=True)
    near = _near_fields(kinds, finest, own, other, turn)
    parts = np.concatenate([places.reshape(weights.shape), weights * shares / shares[:, :1]], axis=1)
    mixed, kind = np.unique(parts.round(12), axis=0, return_inverse=True)
    count = weights.shape[1]
    near = sum(mixed[:, count + k, *[None] * 4] * near[mixed[:, k].astype(int)] for k in range(count))
    share = shares[:, 0]
    return replace(primary, folded=folded.with_neighbours(near, kind.ravel(), share))


def coated(primary: PlacedBody, own: Coating | None, other: Coating | None) -> PlacedBody:
    """The primary, as `facing` gives it, with what unworn coatings on it and on the other body add to its compliance;
    unchanged for None. Raises SolverError for a body whose compliance is no `PatchCompliance`.
    """
    if own is None and other is None:
        return primary
    if not isinstance(primary.folded, PatchCompliance):
        raise SolverError("layers of other materials need bodies whose compliance is known as a matrix")
    patch = CoatedPatch(primary.patch, primary.folded, (own, other))
    left = patch.left_mm(*np.zeros((2, primary.patch.size)))
    return replace(primary, folded=patch.compliance(left), coats=(patch, left))


def _steps(logs: Array) -> tuple[Array, Array]:
    """(n, 5, 4) powers of `_ALIKE` between which corrections of n nodes are interpolated, and their weights (n, 5).
    logs: (n, 4) the powers by which the elements about a node are larger than the finest.

    Where elements are larger than in the middle of a patch, as outside a contact, the nearest power serves. Towards a
    contact's rim they may be smaller: there each of the four powers is lowered in turn, the one with most to go first.
    """
    nearest = np.clip(np.rint(logs - 1e-6), -_KINDS, _KINDS)
    inner = logs < -_ROUND_OFF
    upper = np.where(inner, np.ceil(np.maximum(logs, -_KINDS)), nearest)
    lacks = np.where(inner, upper - np.maximum(logs, -_KINDS), 0.0)
    order = np.argsort(-lacks, axis=1, kind="stable")
    sorted_lacks = np.take_along_axis(lacks, order, axis=1)
    bounds = np.pad(sorted_lacks, ((0, 0), (1, 1)), constant_values=((0, 0), (1.0, 0.0)))
    lowered = np.cumsum(np.eye(4)[order], axis=1)
    steps = upper[:, None] - np.pad(lowered, ((0, 0), (1, 0), (0, 0)))
    weights = bounds[:, :-1] - bounds[:, 1:]
    return np.where(weights[..., None] > 0.0, steps, upper[:, None]), weights


def _near_fields(kinds: IntArray, finest: tuple[float, ...], own: Bricks, other: Bricks, turn: Array) -> Array:
    """Displacements (m, 2 a + 1, 2 t + 1, 3, 3) in mm/N that `facing` adds at nodes around a loaded one.

    kinds: (m, 4) powers of `_ALIKE` by which the elements about the loaded node are larger than the `finest`: along and
    across, of this body and of the other. turn: (3, 3) from this body's axes to the other's.
    """
    ways = ((float(turn[0, 0]), float(turn[0, 1])), (float(turn[1, 0]), float(turn[1, 1])))
    found = []
    for steps in kinds:
        a, t, b, u = (float(size * _ALIKE**step) for size, step in zip(finest, steps, strict=True))
        found.append(missing_displacement(own, (a, t), other, (b, u), ways))
    width = np.max([each.shape[:2] for each in found], axis=0)
    near = np.zeros((len(found), *width, 3, 3))
    for place, each in zip(near, found, strict=True):
        low = (width - each.shape[:2]) // 2
        place[low[0] : low[0] + each.shape[0], low[1] : low[1] + each.shape[1]] = each
    return near


def _finest(patch: ContactPatch) -> tuple[float, float]:
    """Size (along, across) in mm of the elements in the middle of a patch."""
    along, across = (float(np.diff(lines)[len(lines) // 2]) for lines in (patch.axial_mm, patch.transverse_mm))
    return along, across


def _sizes(primary: PlacedBody, secondary: PlacedBody) -> Array:
    """Sizes (n, 4) in mm, along and across, of the elements around the primary's nodes and of those that face them at
    rest.
    """
    own, other = primary.patch, secondary.patch
    there = primary.node_positions @ secondary.world_to_patch.T
    along, across = np.meshgrid(np.gradient(own.axial_mm), np.gradient(own.transverse_mm), indexing="ij")
    facing_along = np.interp(there[:, 0], other.axial_mm, np.gradient(other.axial_mm))
    facing_across = np.interp(there[:, 1], other.transverse_mm, np.gradient(other.transverse_mm))
    return np.column_stack([along.ravel(), across.ravel(), facing_along, facing_across])


def known_images(body: PlacedBody, signs: tuple[float, float]) -> IntArray | None:
    """Mirror image (n,) of each of the patch's nodes under the signs (sign_x, sign_y) on world positions.

    None unless the mirror maps the body onto itself, compliance included. Computed once for each body.
    """
    if signs not in body.mirror_images:
        body.mirror_images[signs] = _images(body, np.array(signs))
    return body.mirror_images[signs]


def _images(body: PlacedBody, signs: Array) -> IntArray | None:
    places, there = (np.rint(xy / _PLACE_TOLERANCE_mm) for xy in (body.node_positions, body.node_positions * signs))
    order, order_there = (np.lexsort(xy.T) for xy in (places, there))
    if not np.array_equal(places[order], there[order_there]):
        return None
    images = np.empty(len(order), dtype=np.int64)
    images[order_there] = order
    heights = body.worn(np.zeros(body.patch.shape)).heights
    if np.abs(heights - heights[images]).max() > _PLACE_TOLERANCE_mm:
        return None
    return images if _compliance_is_mirrored(body, images, np.append(signs, 1.0)) else None


def _compliance_is_mirrored(body: PlacedBody, images: IntArray, signs: Array) -> bool:
    """True if loads on some sample nodes move the patch as loads on their images move the image of the patch."""
    everywhere = np.arange(body.patch.size)
    # Loads by which a mirror is tried.
    for j in np.linspace(0, body.patch.size - 1, 7).astype(int):
        own, image = (
            body.folded.between(everywhere[node : node + 1], of).reshape(3, -1, 3)
            for node, of in ((j, everywhere), (images[j], images))
        )
        own = own * signs[:, None, None] * signs
        if np.abs(own - image).max() > _COMPLIANCE_TOLERANCE * np.abs(own).max():
            return False
    return True
