"""Strength of a body's material over a cycle: the largest von Mises stress, yield, and fatigue indicators, with places.

`states` are those of one body over a recorded cycle, see `InnerState`; stresses are rows of xx, yy, zz, xy, yz, xz.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.spatial import cKDTree

from geometry import Elastic
from geometry.arrays import Array, IntArray
from solvers.elasticity.linear_elasticity import von_mises
from solvers.stress.interior import CycleImage, Interior
from wirewear.base.errors import ResultError
from wirewear.base.words import counted
from wirewear.results import RunResult
from wirewear.results.scar import called
from wirewear.stress.bodies import INSIDE_POINTS
from wirewear.stress.planes import crossland, smith_watson_topper
from wirewear.stress.state import InnerState, Inside, averaging, one_thread

if TYPE_CHECKING:
    import pyvista


@dataclass(frozen=True, eq=False)
class MaterialPoints:
    """Points (k, 3) of a body in mm, stresses over a cycle (s, k, 6) in MPa, and nodes (k,) that show them."""

    points_mm: Array
    history: Array
    node: IntArray


def material_points(states: Sequence[InnerState[Any]], nodes: IntArray, planes: tuple[int, ...] = ()) -> MaterialPoints:
    """Stresses of a body over a cycle at nodes (k,) of its mesh and where the contact ends, corrected on the surface.

    Added to the nodes are the points where the contact ends at any of the positions, each shown at the nearest node;
    of a cycle that is its own image about `planes`, axes across which nodes are on one side, those on that side. Under
    layers of other materials both sides of their interface are added, shown at the node above.
    """
    body, places = states[0].body, states[0].places_mm
    patch, on_patch, image = body.patch, states[0].patch_nodes, _image(states)
    loaded = [body.surface.under(states[k].applied[on_patch]) for k in image.computed]
    number = np.full(len(places), -1)
    number[on_patch] = np.arange(patch.size)
    on_surface = np.flatnonzero(number[nodes] >= 0)
    grid = patch.grid()
    edges = np.vstack([one.edge() for one in loaded])
    if planes:
        edges[:, planes] = np.abs(edges[:, planes])
        # Images of one another to round-off in mm are one point.
        edges = np.unique(edges.round(12), axis=0)
    edges, of_edges = image.with_images(edges)
    at_nodes, at_edges = (
        image.completed(np.array([one.correction(at) for one in loaded]), of_each)
        for at, of_each in ((grid, number[image.node[on_patch]]), (edges, of_edges))
    )
    corners, weights, _ = patch.locate(edges)
    stresses = stresses_of(states, np.append(nodes, on_patch[corners]))
    history, around = stresses[:, : len(nodes)], stresses[:, len(nodes) :]
    history[:, on_surface] += at_nodes[:, number[nodes[on_surface]]]
    at_edges += np.einsum("kc,skcv->skv", weights, around.reshape(*around.shape[:1], *corners.shape, 6))
    shown = (edges[:, planes] >= 0.0).all(axis=1)
    edges, at_edges = edges[shown], at_edges[:, shown]
    nearest = cKDTree(grid[number[nodes[on_surface]]]).query(edges)[1]
    points = [places[nodes], np.column_stack([edges, patch.height(edges)])]
    above, stress = [nodes, nodes[on_surface[nearest]]], [history, at_edges]
    if (coat := states[0].coat) is not None:
        chosen, beneath = number[nodes[on_surface]], [0.0, 0.0, coat.coating.thickness_mm]
        for side in range(2):
            found = [both[side][chosen] for one in states if (both := one.at_interface) is not None]
            points.append(places[nodes[on_surface]] - beneath)
            stress.append(np.array(found))
            above.append(nodes[on_surface])
    return MaterialPoints(np.vstack(points), np.concatenate(stress, axis=1), np.concatenate(above))


def stresses_of(states: Sequence[InnerState[Any]], nodes: IntArray) -> Array:
    """Stresses (s, k, 6) of a body over a cycle at nodes (k,)."""
    body, image = states[0].body, _image(states)
    chosen, both = [states[k] for k in image.computed], np.append(nodes, image.node[nodes])
    found = body.interior.stresses(np.array([one.displacement for one in chosen]), both)
    found += [one.bulk(body.mesh.points[both]) for one in chosen]
    completed = image.completed(found, np.roll(np.arange(len(both)), len(nodes)))[:, : len(nodes)]
    if states[0].coat is not None:
        completed = completed + [one.by_coat(body.mesh.points[nodes]) for one in states]
    # Residual stress stays through the cycle, and need not be its own image.
    return completed if states[0].residual is None else completed + states[0].residual.at_nodes[nodes]


def _image(states: Sequence[InnerState[Any]]) -> CycleImage:
    """The mirror image by which most of the states of a cycle follow from the others."""
    interior: Interior = states[0].body.interior
    return interior.cycle_image(*_cycle(states))


def _cycle(states: Sequence[InnerState[Any]]) -> tuple[IntArray, Array, Array]:
    """Nodes, forces and what else acts, as `Interior.cycle_image` compares them."""
    forces, positions = states[0].forces, [state.position for state in states]
    bulk = np.zeros((len(states), 3)) if forces.bulk_stress_MPa is None else forces.bulk_stress_MPa[positions]
    # Torsion is its own image about no plane.
    even = np.arange(1.0 * len(states))[:, None] if bulk[:, 2].any() else bulk[:, :2]
    return states[0].loaded_nodes, forces.force_N[positions], even


def _own_images(states: Sequence[InnerState[Any]]) -> tuple[int, ...]:
    """The axes about which a body and its cycle are their own image; residual stress is not looked at."""
    interior: Interior = states[0].body.interior
    return () if states[0].residual is not None else interior.cycle_planes(*_cycle(states))


@dataclass(frozen=True)
class Where:
    """A largest value in MPa and its place in µm, in the test's axes from the body's point of first contact; the depth
    is below the worn surface. position: index of the recorded position where it occurs, -1 for one of a whole cycle.
    """

    value_MPa: float
    x_um: float
    y_um: float
    depth_um: float
    position: int = -1


@dataclass(frozen=True)
class StrengthAsked:
    """Limits that stresses are compared with: yield strength (None: not compared) and slope of Crossland's criterion;
    and the length over which stresses are averaged (0: not averaged).
    """

    yield_strength_MPa: float | None = None
    crossland_slope: float = 0.3
    averaging_length_um: float = 0.0


@dataclass(frozen=True, eq=False)
class Strength:
    """Strength of a body over one recorded cycle, at nodes `nodes` (k,) near the contact.

    name: of the body. grid: the body as `body_grid` gives it where its von Mises stress is largest, with the
    fields of the cycle at the nodes as point data: largest_von_mises_MPa, smith_watson_topper_MPa,
    critical_plane_normal, crossland_MPa, crossland_amplitude_MPa, largest_hydrostatic_MPa; all zero farther away.
    surface: (t, 4) facets of its contact patch, none of a line contact. von_mises, critical_plane, crossland: where
    each is largest. Stresses are averaged over a stated length; where it is 0, those at the surface are corrected
    between the nodes, and a node shows the worst of the points nearest to it. swing: largest half range of the stress
    of a cycle, as a von Mises stress: metal in which it exceeds the yield stress flows in every cycle, and other metal
    that hardens shakes down (Melan; residual stress does not change it). flowed: whether they include the residual
    stress of metal that has flowed.
    """

    cycle: int
    name: str
    grid: pyvista.UnstructuredGrid
    surface: IntArray
    nodes: IntArray
    asked: StrengthAsked
    von_mises: Where
    critical_plane: Where
    crossland: Where
    swing: Where
    flowed: bool = False

    @property
    def body(self) -> str:
        return called(self.name)

    @property
    def yields(self) -> bool | None:
        """True if the largest von Mises stress exceeds the stated yield strength; None without one."""
        limit = self.asked.yield_strength_MPa
        return None if limit is None else self.von_mises.value_MPa > limit


@one_thread()
def strength_of(
    result: RunResult, body: str, cycle: float, asked: StrengthAsked, inside: Inside[Any] = INSIDE_POINTS
) -> Strength:
    """The strength of a body over the cycle recorded nearest to `cycle`, from all its recorded positions.

    Stresses are averaged as `asked` over balls, of a line contact over discs. inside: INSIDE_POINTS or INSIDE_LINES, by
    the kind of contact. Raises ResultError if no contact forces of the body are recorded, or it is smaller than the
    averaging length; GeometryError if wear distorts the mesh too much.
    """
    states = inside.states(result, body, assessable(result, body, cycle, asked, inside))
    first = states[0]
    near, patch, planes = _near(first), first.body.patch, _own_images(states)
    # What is the image of another node has its strength.
    images, sides = first.body.interior.on_one_side(near, planes)
    chosen = np.unique(images)
    if asked.averaging_length_um > 0.0:
        material = _averaged(states, chosen, asked.averaging_length_um)
    else:
        material = material_points(states, chosen, planes)
    shown = Shown(
        cycle=first.forces.cycle,
        name=first.name,
        to_world=first.to_world,
        material=first.body.material,
        surface=first.body.outer_faces,
        grid=lambda position: inside.grid(states[position]),
        depth_mm=lambda point: float(patch.height(point[None, :2])[0] - point[2]),
        flowed=first.residual is not None,
        images=(images, sides),
    )
    return assessed(shown, material, near, asked)


def assessable(
    result: RunResult, body: str, cycle: float, asked: StrengthAsked, inside: Inside[Any] = INSIDE_POINTS
) -> int:
    """The number of the cycle recorded nearest to `cycle`, if `strength_of` can assess it as asked; checked without
    computation. Raises ResultError if no contact forces of the body are recorded, or it is smaller than the averaging
    length.
    """
    forces, over_um = result.forces(cycle, body), asked.averaging_length_um
    if over_um > 1e3 * inside.least_extent_mm(result, forces):
        over = f"stresses cannot be averaged over {over_um:g} µm"
        raise ResultError(f"{over}: the {called(body)} is thinner than that.")
    return forces.cycle


@dataclass(frozen=True)
class Shown:
    """A body to be assessed. to_world (3, 3): from its axes to the test's. surface: (t, 4) facets that may touch. grid:
    gives the grid of its state at a position. depth_mm: gives the depth of a point (3,) below its surface.
    flowed: as in `Strength`. images: for each node shown the node (k,) whose points it shows, and the signs (k, 3) of
    its vectors; None: its own.
    """

    cycle: int
    name: str
    to_world: Array
    material: Elastic
    surface: IntArray
    grid: Callable[[int], pyvista.UnstructuredGrid]
    depth_mm: Callable[[Array], float]
    flowed: bool = False
    images: tuple[IntArray, Array] | None = None


def assessed(body: Shown, points: MaterialPoints, nodes: IntArray, asked: StrengthAsked) -> Strength:
    """The strength of a body from the stresses of a cycle at points of it, shown at `nodes` near the contact."""
    equivalent = von_mises(points.history)
    planes = smith_watson_topper(points.history, body.material)
    limits = crossland(points.history)
    combined = limits.equivalent_MPa(asked.crossland_slope)
    worst = int(np.unravel_index(int(equivalent.argmax()), equivalent.shape)[0])
    grid = body.grid(worst)
    fields = {
        "largest_von_mises_MPa": (equivalent.max(axis=0), None),
        "smith_watson_topper_MPa": (planes.parameter, None),
        "critical_plane_normal": (planes.normal, planes.parameter),
        "crossland_MPa": (np.maximum(combined, 0.0), None),
        "crossland_amplitude_MPa": (limits.amplitude_MPa, combined),
        "largest_hydrostatic_MPa": (limits.hydrostatic_MPa, combined),
    }
    for name, (values, by) in fields.items():
        result = np.zeros((grid.n_points, *values.shape[1:]))
        order = np.argsort(values if by is None else by, kind="stable")
        result[points.node[order]] = values[order]
        if body.images is not None:
            result[nodes] = result[body.images[0]]
        if values.ndim > 1:
            result[nodes] = result[nodes] * (1.0 if body.images is None else body.images[1]) @ body.to_world.T
        grid.point_data[name] = result

    def where(values: Array, position: int = -1) -> Where:
        k = int(values.argmax())
        depth = body.depth_mm(points.points_mm[k])
        x, y, _ = 1e3 * body.to_world @ points.points_mm[k]
        return Where(float(values[k]), float(x), float(y), 1e3 * depth if depth > 1e-9 else 0.0, position)

    return Strength(
        cycle=body.cycle,
        name=body.name,
        grid=grid,
        surface=body.surface,
        nodes=nodes,
        asked=asked,
        von_mises=where(equivalent.max(axis=0), worst),
        critical_plane=where(planes.parameter),
        crossland=where(combined),
        swing=where(np.sqrt(3.0) * limits.amplitude_MPa),
        flowed=body.flowed,
    )


def _averaged(states: Sequence[InnerState[Any]], nodes: IntArray, length_um: float) -> MaterialPoints:
    """Means over balls, or discs, about nodes. They keep the elements' means, so nothing is to be corrected."""
    first = states[0]
    mean = averaging(first.body.mesh.points, first.node_sizes, nodes, 1e-3 * length_um)
    taken = np.unique(mean.indices)
    history = np.array([mean[:, taken] @ one for one in stresses_of(states, taken)])
    return MaterialPoints(first.places_mm[nodes], history, nodes)


def yield_sentence(course: Sequence[Strength]) -> str:
    """A sentence on where a body yields first and until which cycle, from its strengths over one cycle or more."""
    first, body = course[0], course[0].body
    if first.asked.yield_strength_MPa is None:
        return f"{body}: no yield strength is stated."
    yielding = [one for one in course if one.yields]
    limit = f"{first.asked.yield_strength_MPa:g} MPa"
    if not yielding:
        largest = max(one.von_mises.value_MPa for one in course)
        return f"{body}: nothing yields; the largest von Mises stress is {largest:.0f} of {limit}."
    begin, last = yielding[0], yielding[-1]
    after = [one.cycle for one in course if one.cycle > last.cycle]
    until = f"; the next one looked at, {counted(after[0])}, does not" if after else ", the last one looked at"
    flowing = [one for one in yielding if one.swing.value_MPa > first.asked.yield_strength_MPa]
    swing = max(one.swing.value_MPa for one in flowing or yielding)
    to = f"flows in every cycle until {counted(flowing[-1].cycle)}" if flowing else "can shake down"
    return (
        f"{body}: yields at {limit} from cycle {counted(begin.cycle)} ({begin.von_mises.value_MPa:.0f} MPa, "
        f"{begin.von_mises.depth_um:.1f} µm deep at x = {begin.von_mises.x_um:.0f} µm) to cycle {counted(last.cycle)}"
        f"{until}. Stresses beyond yield are elastic ones{', residual stress included' * first.flowed}: metal flows "
        f"instead, and bears its yield stress. They swing by ±{swing:.0f} MPa at most, so it {to}."
    )


def _near(state: InnerState[Any]) -> IntArray:
    """Nodes within a contact's extent of where there ever is contact."""
    places = state.places_mm
    loaded = places[state.loaded_nodes]
    extents = np.ptp(loaded, axis=0)[:2]
    reach = 0.5 * float(extents[: state.body.mesh.points.shape[1] - 1].min()) + 1e-3
    distance, _ = cKDTree(loaded).query(places, distance_upper_bound=reach)
    return np.flatnonzero(np.isfinite(distance))
