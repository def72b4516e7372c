"""What a cycle does to a wire's material: the largest von Mises stress, yield, and fatigue indicators, with places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from solvers.strain import scattered
from solvers.stress import von_mises
from wirewear.interior.bodies import BodyState, body_states
from wirewear.interior.fatigue import averaging, crossland, smith_watson_topper
from wirewear.interior.grids import body_grid
from wirewear.quantity import counted
from wirewear.results import RunResult

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class Where:
    """A largest value in MPa and its place in µm, in the axes of the test about the wire's own origin.

    depth_um: below the worn surface.  position: the recorded position at which it occurs, -1 for one of a whole cycle.
    """

    value_MPa: float
    x_um: float
    y_um: float
    depth_um: float
    position: int = -1


@dataclass(frozen=True, eq=False)
class Strength:
    """A wire over one recorded cycle at its nodes `nodes` (k,) near the contact.

    grid: the wire as `body_grid` gives it where its von Mises stress is largest, with the fields of the cycle at the
    nodes as point data: largest_von_mises_MPa, smith_watson_topper_MPa, critical_plane_normal, crossland_MPa,
    crossland_amplitude_MPa, largest_hydrostatic_MPa; all zero farther away.  surface: (t, 3) triangles of its contact
    patch.  All are of stresses averaged over `averaging_length_um`.  yield_strength_MPa: None where none was stated.
    """

    cycle: int
    wire: str
    grid: pyvista.UnstructuredGrid
    surface: IntArray
    nodes: IntArray
    averaging_length_um: float
    crossland_slope: float
    yield_strength_MPa: float | None
    von_mises: Where
    critical_plane: Where
    crossland: Where

    @property
    def yields(self) -> bool | None:
        """Whether the largest von Mises stress exceeds the stated yield strength."""
        return None if self.yield_strength_MPa is None else self.von_mises.value_MPa > self.yield_strength_MPa


def strength_of(
    result: RunResult,
    wire: str,
    cycle: float,
    *,
    yield_strength_MPa: float | None = None,
    crossland_slope: float = 0.3,
    averaging_length_um: float = 0.0,
) -> Strength:
    """Stresses of a wire over the cycle recorded nearest to `cycle`, at all its recorded positions.

    Raises:
        ResultError: no contact forces of it are recorded.
        GeometryError: wear distorts the mesh too much.
    """
    states = body_states(result, wire, cycle)
    first = states[0]
    mesh, points = first.body.wire.mesh, first.body.points
    chosen = _near(first)
    volumes = scattered(
        mesh.cells,
        np.einsum("mq,qc->mc", points.volumes, points.shapes)[:, :, None],
        len(mesh.points),
    )[:, 0]
    mean = averaging(mesh.points, volumes, chosen, 1e-3 * averaging_length_um)
    history = np.array([mean @ state.stress for state in states])
    equivalent = von_mises(history)
    planes = smith_watson_topper(history, first.body.material)
    limits = crossland(history)
    combined = limits.equivalent_MPa(crossland_slope)
    worst = states[int(np.unravel_index(int(equivalent.argmax()), equivalent.shape)[0])]
    grid = body_grid(worst)
    fields = {
        "largest_von_mises_MPa": equivalent.max(axis=0),
        "smith_watson_topper_MPa": planes.parameter_MPa,
        "critical_plane_normal": planes.normal @ first.to_world.T,
        "crossland_MPa": np.maximum(combined, 0.0),
        "crossland_amplitude_MPa": limits.amplitude_MPa,
        "largest_hydrostatic_MPa": limits.hydrostatic_MPa,
    }
    for name, values in fields.items():
        everywhere = np.zeros((len(mesh.points), *values.shape[1:]))
        everywhere[chosen] = values
        grid.point_data[name] = everywhere
    facets = mesh.surfaces["contact"]
    return Strength(
        cycle=first.forces.cycle,
        wire=wire,
        grid=grid,
        surface=np.vstack([facets[:, [0, 1, 2]], facets[:, [0, 2, 3]]]),
        nodes=chosen,
        averaging_length_um=averaging_length_um,
        crossland_slope=crossland_slope,
        yield_strength_MPa=yield_strength_MPa,
        von_mises=_where(first, chosen, equivalent.max(axis=0), worst.position),
        critical_plane=_where(first, chosen, planes.parameter_MPa),
        crossland=_where(first, chosen, combined),
    )


def yield_sentence(course: Sequence[Strength]) -> str:
    """Where a wire yields first and until which recorded cycle, from its strengths over the cycles."""
    first, wire = course[0], course[0].wire
    if first.yield_strength_MPa is None:
        return f"{wire} wire: no yield strength is stated."
    yielding = [one for one in course if one.yields]
    limit = f"{first.yield_strength_MPa:g} MPa"
    if not yielding:
        largest = max(one.von_mises.value_MPa for one in course)
        return f"{wire} wire: nothing yields; the largest von Mises stress is {largest:.0f} of {limit}."
    begin, last = yielding[0], yielding[-1]
    after = [one.cycle for one in course if one.cycle > last.cycle]
    until = f"the next recorded cycle, {counted(after[0])}, does not" if after else "as does the last recorded cycle"
    return (
        f"{wire} wire: yields at {limit} from cycle {counted(begin.cycle)} ({begin.von_mises.value_MPa:.0f} MPa, "
        f"{begin.von_mises.depth_um:.1f} µm deep at x = {begin.von_mises.x_um:.0f} µm) to cycle {counted(last.cycle)}; "
        f"{until}. Stresses beyond it are elastic ones."
    )


def _near(state: BodyState) -> IntArray:
    """Nodes within a contact's extent of where there ever is contact."""
    mesh = state.body.wire.mesh
    loaded = mesh.points[state.body.patch_nodes[state.forces.nodes]]
    reach = 0.5 * float(np.ptp(loaded, axis=0)[:2].min()) + 1e-3
    distance, _ = cKDTree(loaded).query(mesh.points, distance_upper_bound=reach)
    return np.flatnonzero(np.isfinite(distance))


def _where(state: BodyState, chosen: IntArray, values: Array, position: int = -1) -> Where:
    k = int(values.argmax())
    patch, point = state.body.wire.patch, state.body.wire.mesh.points[chosen[k]]
    depth = float(patch.height(point[None, :2])[0] - point[2])
    x, y, _ = 1e3 * state.to_world @ point
    return Where(float(values[k]), float(x), float(y), max(1e3 * depth, 0.0) if depth > 1e-9 else 0.0, position)
