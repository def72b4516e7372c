"""What friction bears at the nodes of a core that sticks, on a mesh.

Where wear has taken the load from all else, a core is a punch: at its edge pressure and friction both rise without
bound, at one ratio all along it (on a circle or an ellipse: Mindlin, J. Appl. Mech. 16 (1949) 259). Nodes at the edge
have either by a few hundredths too large or too small, by how the mesh lies, and would come to slip where nothing does.
So friction is compared with the pressure node by node as the mesh has them of a punch that is moved and of one that is
pressed, for the part of the pressure that is a punch's: before the annulus has worn there is none. On unlike meshes
pressure alone would move the bodies' nodes apart sideways; in the core friction holds them together,
and carries that, too.
"""

import numpy as np

from geometry.arrays import Array
from solvers.contact import ContactProblem
from solvers.contact.problem import faced
from solvers.contact_state import ContactState
from solvers.wear_step.influence import Influences
from solvers.wear_step.symmetry import Mirror


def grip_of_core(problem: ContactProblem, state: ContactState, across: Mirror | None) -> Array:
    """Factors (n,) by which friction at the primary's nodes may exceed its law: 1 outside the core (nodes that have
    stuck ever since the bodies were pressed together). across: the mirror y -> -y; None without symmetry.
    """
    nodes = np.flatnonzero(state.core)
    pairing = faced(problem, state, nodes, state.drive, state.holder_x, state.holder_tilt)
    side = problem.primary.node_positions[nodes, 1]
    rows = np.flatnonzero(side > -1e-10) if across else np.arange(len(nodes))
    influences = Influences((problem.primary, problem.secondary), [pairing], [rows], across)
    influences.know(np.ones(len(rows), dtype=bool))
    moved = influences.dense(0)
    weights = pairing.areas[rows]
    if across:
        weights = weights * np.where(across.primary[nodes[rows]] == nodes[rows], 1.0, 2.0)
    pressure = np.linalg.solve(moved[:, 2, :, 2], np.ones(len(rows)))
    friction = np.linalg.solve(moved[:, 0, :, 0], np.ones(len(rows)))
    punch = pressure / (weights @ pressure)
    kept = np.abs(np.linalg.solve(moved[:, 0, :, 0], moved[:, 0, :, 2] @ punch)) / problem.friction
    ratio = (friction / (weights @ friction) + kept) / punch
    # A smaller core shows no shape of its pressure.
    share = _of_punch(state.traction[nodes[rows], 2], punch, weights) if len(nodes) > 8 else 1.0
    own = 1.0 + (ratio - 1.0) * share
    grip = np.ones(len(state.core))
    grip[nodes[rows]] = own
    if across:
        grip[across.primary[nodes[rows]]] = own
    return grip


def _of_punch(pressure: Array, punch: Array, weights: Array) -> Array:
    """Shares (k,) of pressures that are a punch's, 0 to 1; the rest is smooth. punch: its pressures by a unit load."""
    # A punch's pressure is as one over a root, which is Hertz's.
    root, scale = punch.min() / punch, np.sqrt(weights)
    columns = np.column_stack([1.0 / root, np.ones(len(root)), root, root**2]) * scale[:, None]
    part = np.linalg.lstsq(columns, pressure * scale, rcond=None)[0][0] / root
    return np.asarray(np.clip(part / np.maximum(pressure, 1e-300), 0.0, 1.0))
