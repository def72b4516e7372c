"""Increments that are their own mirror image about the plane along the motion, solved for the nodes on one side.

A contact that sticks in its middle has three unknowns at each of its nodes, and needs many nodes: solving for half of
them takes an eighth of the work.
"""

from dataclasses import replace
from typing import cast

import numpy as np

from geometry.arrays import IntArray
from solvers.contact.problem import ContactProblem
from solvers.contact_conditions import ContactGuess, ContactOutcome, Linearisation
from solvers.contact_state import ContactState
from solvers.elasticity.compliance import ACROSS, MirroredCompliance, PairedCompliance
from solvers.elasticity.pairing import Pairing
from solvers.elasticity.placement import known_images

_TOLERANCE = 1e-6  # Of the largest traction or depth: a smaller difference from the mirror image counts as symmetry.
_FEWEST = 120  # Loaded nodes: fewer are solved for as fast as halved.


def images_across(problem: ContactProblem, state: ContactState) -> IntArray | None:
    """Mirror image (n,) of each node of the primary about the plane y = 0, along the motion.

    None unless the increment from this state is its own mirror image, by bodies, core, depths and tractions, and has a
    core or no friction, where halving the unknowns pays.
    """
    sticks = state.core.any() or problem.friction == 0.0
    plain = not (problem.layers or problem.yields or problem.fields or state.bulk.any() or state.bulk_step.any())
    if not (sticks and plain and problem.friction_law.proportional) or len(problem.primary.patch.transverse_mm) < 2:
        return None
    images, opposite = (known_images(body, (1.0, -1.0)) for body in (problem.primary, problem.secondary))
    if images is None or opposite is None or (state.core != state.core[images]).any():
        return None
    surfaces = zip((*state.wear.depths, *state.wear.prints), 2 * (images, opposite), strict=True)
    depths = ((depth.ravel()[:, None], of) for depth, of in surfaces if depth is not None)
    fields = ((state.traction, state.traction[images] * ACROSS), *((depth, depth[of]) for depth, of in depths))
    alike = all(np.abs(field - image).max() <= _TOLERANCE * np.abs(field).max() for field, image in fields)
    return images if alike else None


def solved_on_one_side(
    problem: ContactProblem, system: Linearisation, guess: ContactGuess, images: IntArray | None
) -> ContactOutcome:
    """The outcome of a system, for all its nodes, solved for those on one side of y = 0 if that pays: `images`, from
    `images_across`, is not None and 120 nodes or more touch in the guess.
    """
    nodes = system.pairing.nodes
    if images is None or np.count_nonzero(guess.active) < _FEWEST:
        return problem.algorithm.solve_contact(system, guess)
    order = np.argsort(nodes)
    local = order[np.searchsorted(nodes[order], images[nodes])]
    kept = np.flatnonzero(np.arange(len(nodes)) <= local)
    side = replace(
        system,
        pairing=_on_one_side(system.pairing, kept, local),
        # It is all that an algorithm asks a compliance for.
        compliance=cast("PairedCompliance", MirroredCompliance(system.compliance, kept, local)),
        old_displacement=system.old_displacement[kept],
        friction=system.friction.among(kept),
        lever=system.lever[kept],
        layers=None if system.layers is None else system.layers.among(kept),
        late=None if system.late is None else system.late[kept],
    )
    found = problem.algorithm.solve_contact(
        side, guess._replace(traction=guess.traction[kept], active=guess.active[kept])
    )
    traction, sliding, slip_length = np.empty((len(nodes), 3)), np.empty(len(nodes), dtype=bool), np.empty(len(nodes))
    for there, signs in ((local[kept], ACROSS), (kept, np.ones(3))):
        traction[there], sliding[there], slip_length[there] = found.traction * signs, found.sliding, found.slip_length
    sticking = int((~sliding & (traction[:, 2] > 0.0)).sum())
    return replace(found, traction=traction, sliding=sliding, slip_length=slip_length, sticking=sticking)


def _on_one_side(pairing: Pairing, kept: IntArray, images: IntArray) -> Pairing:
    """The nodes `kept` of a pairing, each with the area of its mirror image added to its own."""
    areas = np.where(images[kept] == kept, 1.0, 2.0) * pairing.areas[kept]
    return replace(
        pairing,
        nodes=pairing.nodes[kept],
        areas=areas,
        gap=pairing.gap[kept],
        gap_rate=pairing.gap_rate[kept],
        frames=pairing.frames[kept],
    )
