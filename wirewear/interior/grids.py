"""States of bodies as meshes of pyvista, with fields named with their units."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from geometry import HexMesh
from solvers.stress import hydrostatic, principal, turned, von_mises
from wirewear.interior.bodies import BodyState
from wirewear.interior.state import InnerState

if TYPE_CHECKING:
    import pyvista

Array = NDArray[np.float64]


def body_grid(state: BodyState) -> pyvista.UnstructuredGrid:
    """A body's hexahedra where they are at that moment but for the elastic displacement, in µm, in the test's axes.

    Point data: displacement_um, stress_MPa (xx, yy, zz, xy, yz, xz), von_mises_MPa, tresca_MPa, principal_MPa (largest
    first), hydrostatic_MPa, contact_traction_MPa, worn_depth_um, gripped.  Cell data: von_mises_MPa, the mean over the
    integration points, and scaled_jacobian.  Field data: cycle, position, drive_um.
    """
    import pyvista

    grid = stressed_grid(state, pyvista.CellType.HEXAHEDRON)
    grid.point_data["contact_traction_MPa"] = state.traction_MPa @ state.to_world.T
    grid.point_data["worn_depth_um"] = _worn_depth_um(state)
    grid.point_data["gripped"] = _gripped(state.body.mesh)
    forces = state.forces
    grid.field_data["cycle"] = [forces.cycle]
    grid.field_data["position"] = [state.position]
    grid.field_data["drive_um"] = [forces.drive_um[state.position]]
    grid.set_active_scalars("von_mises_MPa", preference="point")
    return grid


def stressed_grid(state: InnerState[Any, Any], kind: pyvista.CellType) -> pyvista.UnstructuredGrid:
    """A body's elements, all of one kind of cell, with the point and cell data that bodies of any dimension have.

    Point data: displacement_um, stress_MPa, von_mises_MPa, tresca_MPa, principal_MPa, hydrostatic_MPa.  Cell data:
    von_mises_MPa, scaled_jacobian.
    """
    import pyvista

    mesh, turn = state.body.mesh, state.to_world
    stress = turned(state.stress, turn)
    values = principal(stress)
    grid = pyvista.UnstructuredGrid({kind: mesh.cells}, state.world_points_um(state.places_mm))
    points, cells = grid.point_data, grid.cell_data
    points["displacement_um"] = 1e3 * state.displacement @ turn.T
    points["stress_MPa"] = stress
    points["von_mises_MPa"] = von_mises(stress)
    points["tresca_MPa"] = values[:, 0] - values[:, 2]
    points["principal_MPa"] = values
    points["hydrostatic_MPa"] = hydrostatic(stress)
    cells["von_mises_MPa"] = von_mises(state.stress_at_points).mean(axis=1)
    cells["scaled_jacobian"] = mesh.scaled_jacobians()
    return grid


def integration_point_cloud(state: BodyState) -> pyvista.PolyData:
    """The integration points of a body in µm, in the test's axes, with stress_MPa and von_mises_MPa as computed."""
    import pyvista

    points = state.body.points.positions.reshape(-1, 3)
    cloud = pyvista.PolyData(state.world_points_um(points))
    stress = turned(state.stress_at_points.reshape(-1, 6), state.to_world)
    cloud.point_data["stress_MPa"] = stress
    cloud.point_data["von_mises_MPa"] = von_mises(stress)
    return cloud


def _worn_depth_um(state: BodyState) -> Array:
    patch = state.body.patch
    depth = np.zeros(len(state.body.mesh.points))
    if patch.repositioned_depth_mm is not None:
        depth[patch.nodes] = 1e3 * patch.repositioned_depth_mm
    return depth


def _gripped(mesh: HexMesh) -> Array:
    marked = np.zeros(len(mesh.points))
    marked[mesh.surface_nodes("grip")] = 1.0
    return marked
