"""How much farther nodes slide when friction on them fades, where the bodies' strain takes much of the motion.

A cycle is traced with the wear frozen. What wears beside a sticking core then loses pressure and friction, and springs
back towards where the bodies would have it: it slides farther than traced, by as much as the slip itself in partial
slip. The core does not move; it takes over what the others no longer bear. In a contact that barely slides more of the
motion is strain where friction grows. Only the ends of both strokes matter, for there everything beside the core
slides: the slip of a stroke is the motion from one end to the other. Layers between the surfaces are sheared less when
they bear less, or wear in.
"""

import numpy as np

from geometry.arrays import Array
from solvers.contact import ContactProblem
from solvers.contact_layer import ContactLayer, layers_at_nodes
from solvers.friction_law import Friction
from solvers.wear_step.strokes import ends_of_strokes
from solvers.wear_step.surfaces import Cycle, Depths, Facing

_LEAST, _LARGEST = 0.25, 4.0
_LEAST_SLIP = 0.02  # Of the largest slip of a stroke: nodes that slide less keep the slip that they have.


def released_slip(
    problem: ContactProblem, cycle: Cycle, facing: Facing, pressure: Array, worn: Depths, friction: Friction
) -> tuple[Array, Array]:
    """Factors (N,) on the slip before and after each position of a strained cycle, under pressures (N,).

    worn: depths of the surfaces that carry them.  friction: the law at the unknowns there.
    """
    half_cycle, ends = cycle.half_cycle, ends_of_strokes(cycle.positions, cycle.half_cycle)
    before, after = cycle.traced_slips
    laws = cycle.law_at(problem, cycle.wear, 0.5 * (before + after)), friction
    moved = [_released(problem, cycle, facing, pressure, worn, laws, end) for end in ends]
    starts = [half_cycle.image(moved[0], half_cycle.primary)] if half_cycle is not None else moved[::-1]
    fields, begin = [], 0
    for end, there, here in zip(ends, starts, moved, strict=True):
        fields.append(_longer(cycle, range(begin, end + 1), end, facing, here - there))
        begin = end + 1
    stroke = np.searchsorted(ends, np.arange(len(cycle.positions)))
    following = np.append(stroke[1:], 0)
    if half_cycle is not None:
        # The next stroke is the mirror image of this one.
        fields.append(half_cycle.image(fields[0], half_cycle.primary))
        following[-1] = 1
    nodes = [p.nodes[rows] for p, rows in zip(cycle.positions, cycle.orbits.rows, strict=True)]
    before = np.concatenate([fields[of][own] for of, own in zip(stroke, nodes, strict=True)])
    return before, np.concatenate([fields[of][own] for of, own in zip(following, nodes, strict=True)])


def _released(
    problem: ContactProblem,
    cycle: Cycle,
    face: Facing,
    pressure: Array,
    worn: Depths,
    laws: tuple[Friction, Friction],
    end: int,
) -> Array:
    """By how much (n, 3) all the primary's nodes move against what they face, from traced to these pressures, mm.

    laws: at the unknowns, as traced and now.
    """
    position, orbits = cycle.positions[end], cycle.orbits
    own, rows = slice(orbits.start[end], orbits.start[end + 1]), orbits.rows[end]
    traction = position.state.traction[position.nodes[rows]]
    normals, frictions = face.normals[cycle.at(end)][rows], face.frictions[cycle.at(end)][rows]
    before = np.maximum(np.einsum("ij,ij->i", traction, position.pairing.frames[rows, 0, :]), 0.0)
    now = np.maximum(pressure[own], 0.0)
    more = (laws[1].among(own).limit(now) - laws[0].among(own).limit(before))[:, None]
    change = (now - before)[:, None] * normals + more * frictions
    held = np.flatnonzero((before > 0.0) & ~frictions.any(axis=1))
    influence, weights = cycle.influences.dense(end), orbits.areas[own] * orbits.twice[own]
    moved = np.einsum("iajb,jb->ia", influence, change)
    sheared = _shear_compliance(problem.layers, cycle, worn, now, own)
    if len(sheared):
        tangential = traction - before[:, None] * position.pairing.frames[rows, 0, :]
        moved += (sheared - _shear_compliance(cycle.layers, cycle, cycle.wear.depths, before, own))[
            :, None
        ] * tangential
        moved += sheared[:, None] * more * frictions
    compliance = problem.holder.compliance_at_contact_mm_per_N
    size = 2 * len(held)
    # Tractions of the core along x and y, and the holder's motion, so that the core stays and the forces balance.
    matrix, rhs = np.zeros((size + 1, size + 1)), np.zeros(size + 1)
    matrix[:size, :size] = influence[held][:, :2, held, :2].reshape(size, size)
    if len(sheared):
        matrix[np.arange(size), np.arange(size)] += np.repeat(sheared[held], 2)
    matrix[:size:2, size] = 1.0
    matrix[size, :size:2] = compliance * weights[held]
    matrix[size, size] = -1.0
    rhs[:size] = -moved[held, :2].ravel()
    rhs[size] = -compliance * float(weights @ change[:, 0])
    found = np.linalg.solve(matrix, rhs)
    moved += np.einsum("iajb,jb->ia", influence[:, :, held, :2], found[:size].reshape(-1, 2))
    moved[:, 0] += found[size]
    everywhere = np.zeros((problem.primary.patch.size, 3))
    everywhere[position.nodes[rows]] = moved
    images = position.nodes[orbits.images[end]]
    across = images != position.nodes[rows]
    everywhere[images[across]] = moved[across] * np.array([1.0, -1.0, 1.0])
    return everywhere


def _shear_compliance(
    layers: tuple[ContactLayer, ...], cycle: Cycle, worn: Depths, pressure: Array, own: slice
) -> Array:
    """Shear (u,) of layers by unit tractions on a position's unknowns, mm per MPa; (0,) where there are none."""
    if not layers:
        return np.zeros(0)
    none = np.zeros((len(pressure), 3))
    return layers_at_nodes(layers, cycle.orbits.opening(*worn)[own], none, none).shear_compliance(pressure)[0]


def _longer(cycle: Cycle, stroke: range, end: int, face: Facing, released: Array) -> Array:
    """Factors (n,) on the slip of a stroke at all the primary's nodes, which move by `released` (n, 3) more over it."""
    slip = np.zeros(len(released))
    for k in stroke:
        position = cycle.positions[k]
        slip[position.nodes] += position.before
    nodes = cycle.positions[end].nodes
    more = -np.einsum("ij,ij->i", released[nodes], face.frictions[cycle.at(end)])
    factors = np.ones(len(released))
    slides = slip[nodes] > _LEAST_SLIP * float(slip.max())
    chosen = nodes[slides]
    factors[chosen] = np.clip(1.0 + more[slides] / slip[chosen], _LEAST, _LARGEST)
    return factors
