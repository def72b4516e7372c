"""Prints of bodies that yield, over the positions of a cycle: depths by which pressures above a limit flatten them for
good.
"""

from dataclasses import replace

import numpy as np

from geometry.arrays import Array
from solvers.contact import ContactProblem
from solvers.contact_state import ContactState, WearState
from solvers.fretting import CycleTrace
from solvers.laws.yielding import YieldAtNodes
from solvers.wear_step.surfaces import Cycle, Depths
from solvers.wear_step.symmetry import Symmetry


def mirrored_prints(state: ContactState, symmetry: Symmetry) -> ContactState:
    """The state with each print as deep as the deepest of its mirror images, itself included; unchanged without prints
    or symmetry.

    While half a cycle is traced, one side of the contact yields before the other; the other half of the cycle evens
    this out.
    """
    own, other = state.wear.prints
    if own is None or other is None or (symmetry.across is None and symmetry.half_cycle is None):
        return state
    own, other = _with_images((own, other), symmetry)
    return replace(state, wear=replace(state.wear, primary_print=own, secondary_print=other))


def _with_images(prints: Depths, symmetry: Symmetry) -> Depths:
    own, other = prints
    for mirror in (symmetry.across, symmetry.half_cycle):
        if mirror is not None:
            own = np.maximum(own, own.ravel()[mirror.primary].reshape(own.shape))
            other = np.maximum(other, other.ravel()[mirror.secondary].reshape(other.shape))
    return own, other


def as_printed(start: ContactState, trace: CycleTrace, symmetry: Symmetry) -> tuple[ContactState, CycleTrace]:
    """Start and trace with the prints that the traced cycle has left at its end, made symmetric, in all their states;
    unchanged if the start has none.
    """
    if all(depth is None for depth in start.wear.prints):
        return start, trace
    wear = mirrored_prints(trace.states[-1], symmetry).wear
    states = tuple(replace(state, wear=wear) for state in trace.states)
    begins = replace(start, wear=wear)
    return begins, replace(trace, states=states, start=begins)


def yield_at(problem: ContactProblem, cycle: Cycle) -> YieldAtNodes | None:
    """Pressure limits at the N unknowns of a cycle whose prints are those of its start; None if nothing yields."""
    own, other = cycle.wear.prints
    if problem.limit is None or own is None or other is None:
        return None
    shares = np.array([position.state.load_share for position in cycle.positions])[cycle.orbits.position]
    return problem.limit.at_nodes(problem.holder.normal_load_N * shares, cycle.orbits.opening(own, other))


def printed_by(
    problem: ContactProblem, cycle: Cycle, symmetry: Symmetry, wear: WearState, pressure: Array
) -> WearState:
    """The wear state with prints made deeper by pressures (N,) in MPa at all positions, and with their plastic work.

    A node becomes deeper by the most that it would yield at any position. `wear` is returned as it is if nothing
    yields.
    """
    yielding, (own, other), orbits = yield_at(problem, cycle), wear.prints, cycle.orbits
    if yielding is None or problem.limit is None or own is None or other is None:
        return wear
    closure, _ = yielding.closure(pressure)
    if not closure.any():
        return wear
    share = problem.limit.share(upper=problem.primary_is_upper)
    primary, secondary = np.zeros(problem.primary.patch.size), np.zeros(problem.secondary.patch.size)
    np.maximum.at(primary, orbits.nodes, share * closure)
    for begin, end in zip(orbits.start, orbits.start[1:], strict=False):
        left = (1.0 - share) * closure[begin:end] * (orbits.areas * orbits.twice)[begin:end]
        secondary = np.maximum(secondary, orbits.secondary[begin:end].T @ left / problem.secondary.node_areas)
    work = yielding.work(pressure) * orbits.areas * orbits.twice
    shapes = primary.reshape(own.shape), secondary.reshape(other.shape)
    more, facing = _with_images(shapes, symmetry)
    return replace(
        wear,
        primary_print=own + more,
        secondary_print=other + facing,
        # Positions that print the same place share its work.
        plastic_mJ=wear.plastic_mJ + float(np.bincount(orbits.position, work).max()),
    )
