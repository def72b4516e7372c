"""Scars of both bodies of a run, from a closed loop, and how well they agree with what the wear law has removed.

A trace is a simulated cycle, closed and without wear. Bodies come as (driven, held), the driven one below.
"""

from math import nan

import numpy as np

from geometry.arrays import Array
from solvers import ContactProblem, ContactState, CycleTrace, PlacedBody
from solvers.contact.problem import facing_offset
from solvers.elasticity.quadrature import at_points
from solvers.transfer import spread_once
from wirewear.results import Scar
from wirewear.test import Body, Study

Worn = tuple[PlacedBody, Array, Array, Array, Array, Array | None]


def scars_of(problem: ContactProblem, trace: CycleTrace, cycle: int, study: Study) -> tuple[Scar, Scar]:
    """(driven, held): scars of both bodies after `cycle` cycles, with the pressure at mid-stroke of the trace."""
    driven, other = worn_bodies(problem, trace)
    return _scar(*driven, cycle, study.bodies[0]), _scar(*other, cycle, study.bodies[1])


def worn_bodies(problem: ContactProblem, trace: CycleTrace) -> tuple[Worn, Worn]:
    """(lower, upper), each as (body, worn depth (n_a, n_t) in mm, friction energy per area (n_a, n_t) in mJ/mm², nodal
    forces (n, 3) in N at mid-stroke, slip path (n,) of the cycle in mm, print (n_a, n_t) in mm or None).

    Forces are those of one field of tractions. The forces that the solver transfers to the secondary body's nodes are
    spread over its elements, and smaller by a tenth where two of them span a contact's radius.
    """
    state = trace.middle
    wear, (primary_slid, secondary_slid) = state.wear, trace.slid
    primary = wear.primary_depth, wear.primary_energy, state.primary_force, primary_slid, wear.primary_print
    force, left = _faced_force(problem, state), wear.secondary_print
    secondary = wear.secondary_depth, wear.secondary_energy, force, secondary_slid, left
    lower, upper = (secondary, primary) if problem.primary_is_upper else (primary, secondary)
    return (problem.lower, *lower), (problem.upper, *upper)


def _faced_force(problem: ContactProblem, state: ContactState) -> Array:
    """Forces (n, 3) in N on the nodes of the secondary body, from the primary's tractions that they face."""
    body, facing = problem.secondary, facing_offset(problem, state, state.drive, state.holder_x)
    places = (body.node_positions + facing) @ problem.primary.world_to_patch.T
    return at_points(places, problem.primary.patch, body.node_areas).averaged(state.traction)


def depth_spread(problem: ContactProblem, state: ContactState) -> float:
    """Estimated relative error of the largest depth, the larger one of both bodies; NaN if neither has worn.

    It is the share that the largest depth loses if depths are spread over elements once, as wear transferred to the
    secondary body is: the gap then opens by less, and the other body wears for it.
    """
    depths = zip(state.wear.depths, (problem.primary.patch, problem.secondary.patch), strict=True)
    return max(
        (1.0 - float(spread_once(depth, patch).max() / depth.max()) for depth, patch in depths if depth.any()),
        default=nan,
    )


def _scar(
    body: PlacedBody,
    depth: Array,
    energy: Array,
    force: Array,
    slid: Array,
    pressed: Array | None,
    cycle: int,
    described: Body,
) -> Scar:
    patch = body.patch
    # An upper body's transverse axis runs backwards in the common frame.
    order = slice(None, None, body.facing)
    slope = body.sample(body.node_positions, depth).slope
    size = np.sqrt(1.0 + (slope**2).sum(axis=1))
    normal_force = (force[:, 2] - (force[:, :2] * slope).sum(axis=1)) / size
    pressure = (normal_force / size / patch.node_areas()).reshape(patch.shape)
    return Scar(
        cycle=cycle,
        body=described.name,
        diameter_mm=described.diameters_mm[1],
        diameter_along_mm=described.diameters_mm[0],
        axis_angle_deg=float(np.degrees(body.axis_angle_rad)),
        axial_um=1e3 * patch.axial_mm,
        transverse_um=np.sort(1e3 * patch.transverse_mm * body.facing),
        depth_um=1e3 * depth[:, order],
        energy_density_mJ_per_mm2=energy[:, order],
        pressure_MPa=np.maximum(pressure, 0.0)[:, order],
        slip_distance_um=1e3 * slid.reshape(patch.shape)[:, order],
        print_um=None if pressed is None else 1e3 * pressed[:, order],
    )


def volume_mismatch(problem: ContactProblem, state: ContactState, scars: tuple[Scar, Scar]) -> float:
    """Largest relative difference of a scar's volume from what the wear law has removed; 0 without wear."""
    driven, other = scars
    wear = state.wear
    volumes = (wear.primary_volume_mm3, wear.secondary_volume_mm3)
    upper, lower = volumes if problem.primary_is_upper else volumes[::-1]
    expected = ((driven, lower), (other, upper))
    return max((abs(scar.volume_mm3 / volume - 1.0) for scar, volume in expected if volume > 0.0), default=0.0)
