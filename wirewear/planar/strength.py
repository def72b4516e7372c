"""What a cycle does to the material of a line contact: yield and fatigue indicators of pad and specimen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from solvers.strain import scattered
from wirewear.interior.fatigue import averaging
from wirewear.interior.strength import Asked, Shown, Strength, assessed
from wirewear.interior.surface import MaterialPoints
from wirewear.planar.fields import state_grid
from wirewear.planar.inside import PlanarState, planar_states
from wirewear.planar.results import PlanarResult

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def planar_strength(result: PlanarResult, body: str, cycle: int, asked: Asked) -> Strength:
    """Stresses of the pad or specimen over a recorded cycle, at all its recorded positions, at nodes near the contact.

    Averages are over discs. Raises ResultError when no contact forces of it are recorded, GeometryError when wear
    distorts the mesh too much.
    """
    states = planar_states(result, body, cycle)
    first = states[0]
    meshed, points = first.body.meshed, first.body.points
    mesh, nodes = meshed.mesh, _near(first)
    areas = scattered(mesh.cells, np.einsum("mq,qc->mc", points.volumes, points.shapes)[:, :, None], len(mesh.points))[
        :, 0
    ]
    mean = averaging(mesh.points, areas, nodes, 1e-3 * asked.averaging_length_um)
    places = np.column_stack([mesh.points[nodes, 0], np.zeros(len(nodes)), mesh.points[nodes, 1]])
    shown = Shown(
        cycle=cycle,
        wire=body,
        to_world=first.to_world,
        material=first.body.material,
        surface=np.zeros((0, 4), dtype=np.int64),
        grid=lambda position: state_grid(states[position]),
        depth_mm=lambda point: float(meshed.patch.height(np.array([[point[0], 0.0]]))[0] - point[2]),
    )
    history = np.array([mean @ state.stress for state in states])
    return assessed(shown, MaterialPoints(places, history, nodes), nodes, asked)


def _near(state: PlanarState) -> IntArray:
    """Nodes within a contact's half-width of where there ever is contact."""
    meshed = state.body.meshed
    loaded = meshed.mesh.points[meshed.patch.nodes.ravel()[state.forces.nodes.astype(int)]]
    reach = 0.5 * float(np.ptp(loaded[:, 0])) + 1e-3
    distance, _ = cKDTree(loaded).query(meshed.mesh.points, distance_upper_bound=reach)
    return np.flatnonzero(np.isfinite(distance))
