"""Surface-to-surface coupling of two bodies by a mortar method on the plane of contact.

The primary body carries the contact tractions, one per node and unit plane area. The secondary body's surface is
averaged over the support of each primary node: its heights and displacements are integrated with the node's shape
function at Gauss points of the primary's facets, projected along z. On the primary the same integrals are lumped to the
node, which keeps the pressure free of the oscillations that consistent integration gives on coarse meshes. The same
operators transfer forces and displacements, so the coupling conserves forces and work. A uniform pressure arrives as
the exact nodal forces between equally spaced grids; otherwise single nodal forces err by the quadrature, up to 2 % when
the primary is the finer grid and ten times that when it is half as coarse again as the secondary (Puso & Laursen,
Comput. Methods Appl. Mech. Eng. 193 (2004) 601; for lumping: Wohlmuth, SIAM J. Numer. Anal. 38 (2000) 989).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from geometry.arrays import Array, BoolArray, IntArray
from geometry.profiles import Arc
from solvers.elasticity.nodal_transfer import GaussLines, NodalTransfer, gauss_lines, weighted_sums
from solvers.elasticity.placement import PlacedBody
from solvers.elasticity.quadrature import at_points, field_at, integrals, points_about
from solvers.jit_cache import compiled


@dataclass(frozen=True)
class PrimarySurface:
    """The surface of the primary body's patch, with the part of its quadrature that no secondary body changes."""

    body: PlacedBody
    along: GaussLines  #: Gauss points along the patch.
    across: GaussLines  #: Gauss points across it.
    areas: Array  #: (n,) plane area of each node.
    fresh_slope: Array  #: (n, 2) mean slope of the unworn surface about each node, in the patch's axes.
    averaging: NodalTransfer  #: From a nodal field of this patch to its integrals over the nodes' supports.
    rise: Array  #: (n,) in mm along z, by which the unworn surface is taken higher than at each node.

    def mean_slope(self, nodes: IntArray, depth_mm: Array) -> Array:
        """Slopes (k, 2) in world axes of the surface worn by `depth_mm` (n_a, n_t), averaged around each of `nodes`
        (k,).
        """
        worn = self.averaging.averaged(self.body.worn(depth_mm).gradient, nodes)
        local = self.fresh_slope[nodes] - worn / self.areas[nodes, None]
        return np.asarray(self.body.facing * local @ self.body.world_to_patch + [self.body.incline, 0.0])


@dataclass(frozen=True)
class Pairing:
    """Both surfaces at one position of the secondary relative to the primary, for k chosen primary nodes."""

    nodes: IntArray  #: (k,) primary nodes.
    areas: Array  #: (k,), mm².
    gap: Array  #: (k,) vertical gap of the undeformed worn surfaces at zero approach, mm, the secondary averaged.
    gap_rate: Array  #: (k,) change of the gap per motion of the upper body along x.
    #: (k, 3, 3), rows are the normal (from lower to upper) and two tangents, in world axes; the first tangent is the
    #: motion's direction x projected on the tangent plane.
    frames: Array
    #: Transfer of the primary: force per area -> nodal forces (`spread`), nodal displacements -> means times area
    #: (`averaged`).
    own: NodalTransfer
    opposite: NodalTransfer  #: The secondary's, between the k nodes and its patch.
    depths: NodalTransfer  #: From the secondary's worn depths to the opened gap times area.
    inside: BoolArray  #: (k,) True if the secondary patch faces the whole support of the node.

    def faces_as(self, other: "Pairing") -> bool:
        """True if another pairing of the same two bodies has the same nodes at the same relative position."""
        pairs = zip((self.nodes, *self.opposite[:3]), (other.nodes, *other.opposite[:3]), strict=True)
        return self is other or all(np.array_equal(own, its) for own, its in pairs)

    def among(self, rows: IntArray) -> "Pairing":
        """The nodes of index `rows` (m,) alone."""
        return Pairing(
            nodes=self.nodes[rows],
            areas=self.areas[rows],
            gap=self.gap[rows],
            gap_rate=self.gap_rate[rows],
            frames=self.frames[rows],
            own=self.own.among(rows),
            opposite=self.opposite.among(rows),
            depths=self.depths.among(rows),
            inside=self.inside[rows],
        )

    @cached_property
    def primary(self) -> csr_matrix:
        return self.own.sparse

    @cached_property
    def secondary(self) -> csr_matrix:
        return self.opposite.sparse


def primary_surface(body: PlacedBody) -> PrimarySurface:
    """Set up the quadrature on the patch of the body that carries the tractions."""
    patch = body.patch
    along, across = (gauss_lines(lines, 5) for lines in (patch.axial_mm, patch.transverse_mm))
    nodes = np.arange(patch.size)
    points = points_about(nodes, along, across, np.eye(2), np.zeros(2))
    own = integrals(nodes, points, along, across, patch, np.zeros(patch.shape), np.zeros((patch.size, 2)))
    rise = np.zeros(patch.size)
    if isinstance(patch.profile, Arc):
        rise = body.facing * (own.height / own.area - patch.profile.height(patch.grid()))
    if body.incline != 0.0:
        # The secondary's is averaged, too; where elements differ in size, nodes are not the middles of their supports.
        middle = own.moment @ body.world_to_patch[:, 0] / own.area
        rise = rise + body.incline * (middle - body.node_positions[:, 0])
    return PrimarySurface(body, along, across, own.area, own.slope / own.area[:, None], own.transfer, rise)


def vertical_gap(
    surface: PrimarySurface, secondary: PlacedBody, offset_mm: Array, primary_depth: Array, secondary_depth: Array
) -> Array:
    """Gaps (n,) in mm along z at the primary's nodes, undeformed and at zero approach; infinite where no secondary
    patch faces a node, negative where bodies overlap.

    offset_mm: (2,) of the secondary's origin from the primary's. primary_depth, secondary_depth: (n_a, n_t) worn depths
    in mm. The secondary's surface is taken at the nodes' positions, not averaged.
    """
    body, patch = surface.body, secondary.patch
    local = (body.node_positions - offset_mm) @ secondary.world_to_patch.T
    return _vertical_gap(
        *(local, patch.axial_mm, patch.transverse_mm, patch.profile.height(local)),
        # Depths come in either order of memory, for each of which it would be compiled.
        np.ascontiguousarray(secondary_depth),
        *(secondary.facing, secondary.incline, offset_mm),
        *(body.node_positions, body.worn(primary_depth).heights, body.facing),
    )


@compiled
def _vertical_gap(
    local: Array,
    along: Array,
    across: Array,
    fresh: Array,
    depth: Array,
    other_facing: int,
    incline: float,
    offset: Array,
    positions: Array,
    heights: Array,
    facing: int,
) -> Array:
    """Gap (n,) at world positions (n, 2); `local` (n, 2) are these in the secondary's axes, `fresh` (n,) its unworn
    heights there.
    """
    worn, inside = field_at(depth, local, along, across)
    gap = np.full(len(local), np.inf)
    for k in range(len(local)):
        if inside[k]:
            other = other_facing * (fresh[k] - worn[k]) + incline * (positions[k, 0] - offset[0])
            # Upper height minus lower height, whichever of the two is the primary.
            gap[k] = facing * (other - heights[k])
    return gap


def pair(
    surface: PrimarySurface,
    secondary: PlacedBody,
    nodes: IntArray,
    offset_mm: Array,
    primary_depth: Array,
    secondary_depth: Array,
    upper_tilt_rad: float = 0.0,
    *,
    at_nodes: bool = False,
) -> Pairing:
    """Couple chosen primary nodes (k,) with the secondary body, whose origin lies `offset_mm` (2,) from the primary's.

    primary_depth, secondary_depth: (n_a, n_t) worn depths of the patches in mm.
    upper_tilt_rad: rotation of the upper body about y, which turns the normals; the gap is that of the upright body.
    at_nodes: True to read the secondary's worn depth where each node lies in place of averaging it over the support: at
    the edge of a zone that sticks the depth has a kink, and wear beside the zone must not open it.
    """
    body = surface.body
    # A point seen from the primary's patch at x stands at turn (x - offset) in the secondary's.
    turn = secondary.world_to_patch @ body.world_to_patch.T
    points = points_about(nodes, surface.along, surface.across, turn, body.world_to_patch @ offset_mm)
    gradient = secondary.worn(secondary_depth).gradient
    faced = integrals(nodes, points, surface.along, surface.across, secondary.patch, secondary_depth, gradient)
    areas = surface.areas[nodes]
    own, averaging = body.worn(primary_depth), surface.averaging
    gap, gap_rate, frames = _between(
        *(nodes, areas, own.heights + surface.rise, own.gradient, surface.fresh_slope),
        *(averaging.first, averaging.columns),
        *(averaging.weights, faced.height, faced.slope, faced.moment),
        body.facing,
        body.incline,
        np.ascontiguousarray(body.world_to_patch),
        secondary.facing,
        secondary.incline,
        np.ascontiguousarray(secondary.world_to_patch),
        upper_tilt_rad,
    )
    depths = faced.transfer
    if at_nodes:
        local = (body.node_positions[nodes] - offset_mm) @ secondary.world_to_patch.T
        depths = at_points(local, secondary.patch, areas)
        flat = secondary_depth.ravel()
        gap += (depths.averaged(flat) - faced.transfer.averaged(flat)) / areas
    return Pairing(
        nodes=nodes,
        areas=areas,
        gap=gap,
        gap_rate=gap_rate,
        frames=frames,
        own=NodalTransfer.single(nodes, areas, body.patch.size),
        opposite=faced.transfer,
        depths=depths,
        inside=~faced.outside,
    )


@compiled
def _between(
    nodes: IntArray,
    areas: Array,
    heights: Array,
    gradient: Array,
    fresh_slope: Array,
    first: IntArray,
    columns: IntArray,
    weights: Array,
    other_height: Array,
    other_slope: Array,
    moment: Array,
    facing: int,
    incline: float,
    to_patch: Array,
    other_facing: int,
    other_incline: float,
    to_other_patch: Array,
    upper_tilt: float,
) -> tuple[Array, Array, Array]:
    """Gaps (k,), their rates (k,) and frames (k, 3, 3) of a pairing's nodes, on the mean of both surfaces.

    heights (n,), gradient (n, 2): the primary's heights and its depth's gradient at its nodes; first, columns and
    weights average the latter. other_height (k,), other_slope, moment (k, 2): integrals of the secondary over the
    nodes' supports.
    """
    worn = weighted_sums(first, columns, weights, gradient, nodes)
    gap, rate, slope = np.empty(len(nodes)), np.empty(len(nodes)), np.empty((len(nodes), 2))
    for k in range(len(nodes)):
        node, area = nodes[k], areas[k]
        rise = (moment[k, 0] * to_other_patch[0, 0] + moment[k, 1] * to_other_patch[1, 0]) * other_incline
        gap[k] = facing * ((other_facing * other_height[k] + rise) / area - heights[node])
        for c in range(2):
            other = other_slope[k, 0] * to_other_patch[0, c] + other_slope[k, 1] * to_other_patch[1, c]
            own = (fresh_slope[node, 0] - worn[k, 0] / area) * to_patch[0, c]
            own += (fresh_slope[node, 1] - worn[k, 1] / area) * to_patch[1, c]
            slope[k, c] = 0.5 * (facing * own + other_facing * other / area)
        slope[k, 0] += 0.5 * (incline + other_incline + upper_tilt)
        other = other_slope[k, 0] * to_other_patch[0, 0] + other_slope[k, 1] * to_other_patch[1, 0]
        rate[k] = -(other_facing * other / area + other_incline + (upper_tilt if facing > 0 else 0.0))
    return gap, rate, frames_on(slope)


@compiled
def frames_on(slope: Array) -> Array:
    """Frames (k, 3, 3) for surface slopes (k, 2) in world axes; rows: the normal and two tangents as in `Pairing`."""
    frames = np.empty((len(slope), 3, 3))
    for k in range(len(slope)):
        size = np.sqrt(1.0 + slope[k, 0] ** 2 + slope[k, 1] ** 2)
        n0, n1, n2 = -slope[k, 0] / size, -slope[k, 1] / size, 1.0 / size
        along = np.sqrt(1.0 - n0 * n0)
        t0, t1, t2 = along, -n0 * n1 / along, -n0 * n2 / along
        frames[k, 0, 0], frames[k, 0, 1], frames[k, 0, 2] = n0, n1, n2
        frames[k, 1, 0], frames[k, 1, 1], frames[k, 1, 2] = t0, t1, t2
        frames[k, 2, 0] = n1 * t2 - n2 * t1
        frames[k, 2, 1] = n2 * t0 - n0 * t2
        frames[k, 2, 2] = n0 * t1 - n1 * t0
    return frames
