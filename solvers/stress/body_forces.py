"""Forces of a contact on its two bodies, in the axes of their meshes."""

import numpy as np

from geometry.arrays import Array
from solvers.contact import ContactProblem
from solvers.contact.linearising import paired_before
from solvers.contact.problem import facing_offset, open_depths
from solvers.contact_state import ContactState
from solvers.elasticity.pairing import frames_on, pair


def forces_on_bodies(problem: ContactProblem, state: ContactState) -> tuple[Array, Array]:
    """Forces (n, 3) in N on the patch nodes of the upper and of the lower body, each in the body's own axes.

    The contact lumps the primary's tractions to its nodes. Here they act as the field between the nodes that they stand
    for, as they do on the secondary. Pressure is normal to the surface that both bodies share once they are deformed.
    Each body has turned its own surface into that one; as its elements are not turned, the tractions are, back by as
    much: so they have the friction law's share of shear on either body.
    """
    surface, pairing = problem.surface, paired_before(problem, state)
    traction, common = state.traction[pairing.nodes], pairing.frames[:, 0]
    # Elements are moved with what wears, so a body's own surface is the worn one.
    own_depth, other_depth = open_depths(problem, state)
    offset = facing_offset(problem, state, state.drive, state.holder_x)
    mean = pair(surface, problem.secondary, pairing.nodes, offset, own_depth, other_depth).frames[:, 0]
    own_slope = surface.mean_slope(pairing.nodes, own_depth)
    other_slope = -2.0 * mean[:, :2] / mean[:, 2:] - own_slope
    on_nodes = np.zeros_like(state.traction)
    on_nodes[pairing.nodes] = _turned(traction, common, frames_on(own_slope)[:, 0])
    primary = surface.averaging.spread(on_nodes)
    secondary = pairing.opposite.spread(_turned(traction, common, frames_on(other_slope)[:, 0]))
    upper, lower = (primary, -secondary) if problem.primary_is_upper else (secondary, -primary)
    return upper @ problem.upper.folded.rotation, lower @ problem.lower.folded.rotation


def _turned(vectors: Array, before: Array, after: Array) -> Array:
    """Vectors (k, 3) turned as the unit normals `before` (k, 3) turn into `after`, the shortest way."""

    def along(one: Array, other: Array) -> Array:
        return np.asarray(np.einsum("ki,ki->k", one, other)[:, None])

    def crossed(some: Array) -> Array:
        """(before × after) × some, by products alone."""
        return after * along(before, some) - before * along(after, some)

    once = crossed(vectors)
    return np.asarray(vectors + once + crossed(once) / (1.0 + along(before, after)))
