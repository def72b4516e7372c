"""Both bodies in a traced cycle, as a result keeps them: scars, contact forces at moments spread over it, pressures.

A trace is a simulated cycle, closed and without wear. Bodies come as (driven, held), the driven one below. The primary
body's nodes carry the contact tractions.
"""

from collections.abc import Sequence
from math import nan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geometry import BodyGeometry, Elastic
from geometry.arrays import Array, IntArray
from solvers import ContactProblem, ContactState, CycleTrace, PlacedBody
from solvers.contact.problem import facing_offset
from solvers.elasticity.quadrature import at_points
from solvers.stress.body_forces import forces_on_bodies
from solvers.transfer import spread_once
from wirewear.results import ContactForces, Scar, largest_means
from wirewear.results.scar import FURTHER_COLUMNS
from wirewear.test import Body, Study

MID_STROKE = 35.0 / 60.0  # Mid-stroke is where the drive is within this share of its amplitude: 35 µm of 60.
_PARTS = 32  # Of the way between two positions.


def pressure_figures(problem: ContactProblem, trace: CycleTrace, length_mm: float) -> dict[str, float]:
    """The pressure columns of the evolution's row in MPa for a closed loop, by name: largest at a node and largest mean
    over `length_mm`, each over the cycle and at mid-stroke.
    """
    reports = [(report.drive, report.max_pressure, report.inner_pressure) for report in trace.reports]
    drives, largest, inner = np.array(reports).T
    means = mean_pressures(problem, trace.states, length_mm)
    return {
        "max_pressure_MPa": float(largest.max()),
        "mid_stroke_pressure_MPa": at_mid_stroke(drives, inner),
        "max_mean_pressure_MPa": float(means.max()),
        "mid_stroke_mean_pressure_MPa": at_mid_stroke(trace.drive, means),
    }


def mean_pressures(problem: ContactProblem, states: Sequence[ContactState], length_mm: float) -> Array:
    """Largest mean pressure (k,) in MPa over discs or segments of `length_mm`, in k states with the same wear."""
    patch = problem.primary.patch
    pressures = nodal_pressures(problem, states).reshape(len(states), *patch.shape)
    return largest_means(pressures, patch.axial_mm, patch.transverse_mm, length_mm)


def nodal_pressures(problem: ContactProblem, states: Sequence[ContactState]) -> Array:
    """Pressures (k, n) in MPa at the primary's nodes, normal to its own worn surface, in k states with the same wear.
    The solver's own pressures are normal to the mean of both surfaces.
    """
    tractions = np.array([state.traction for state in states])
    nodes = np.flatnonzero(tractions[:, :, 2].any(axis=0))
    slope = problem.surface.mean_slope(nodes, states[0].wear.primary_depth)
    pressures = np.zeros(tractions.shape[:2])
    own = tractions[:, nodes]
    normal = own[..., 2] - np.einsum("knc,nc->kn", own[..., :2], slope)
    pressures[:, nodes] = normal / (1.0 + (slope**2).sum(axis=1))
    return pressures


def at_mid_stroke(drive: ArrayLike, pressure: ArrayLike) -> float:
    """Median of a pressure (k,) over the way near mid-stroke, from its values at the displacements `drive` (k,) of a
    closed loop. Mid-stroke is where |displacement| is below MID_STROKE times the amplitude. Pressures are interpolated
    linearly between increments; the median of the k values would be that of a single increment.
    """
    ends, values = np.asarray(drive, dtype=float), np.asarray(pressure, dtype=float)
    share = (np.arange(_PARTS) + 0.5)[:, None] / _PARTS
    step = np.roll(ends, -1) - ends
    between = (values + share * (np.roll(values, -1) - values)).ravel()
    way = np.where(np.abs(ends + share * step) < MID_STROKE * np.abs(ends).max(), np.abs(step), 0.0).ravel()
    order = np.argsort(between)
    passed = np.cumsum(way[order])
    return float(between[order][np.searchsorted(passed, 0.5 * passed[-1])])


def forces_on(
    problem: ContactProblem,
    trace: CycleTrace,
    cycle: int,
    count: int,
    bodies: tuple[str, str],
    made_of: Sequence[tuple[BodyGeometry, Elastic] | tuple[None, None]] = ((None, None), (None, None)),
) -> tuple[ContactForces, ...]:
    """(driven, held): contact forces at about `count` positions of a traced cycle; empty for a count of 0.
    cycle: its number. bodies: their names. made_of: each body's geometry and material as `ContactForces` keeps them,
    both None for line contacts.
    """
    if count == 0:
        return ()
    chosen = positions(trace, count)
    states = [trace.states[k] for k in chosen]
    upper, lower = (np.array(each) for each in zip(*(forces_on_bodies(problem, one) for one in states), strict=True))
    found = []
    bulk = [None if own.none else own.nominal(trace.time[chosen]) for own in problem.timing.drive.bulk]
    placed = zip(bodies, (problem.lower, problem.upper), (lower, upper), made_of, bulk or (None, None), strict=True)
    for name, body, force, (geometry, material), stress in placed:
        nodes = np.flatnonzero((force != 0.0).any(axis=(0, 2)))
        found.append(
            ContactForces(
                cycle=cycle,
                body=name,
                axis_angle_deg=float(np.degrees(body.axis_angle_rad)),
                phase=trace.phase[chosen],
                drive_um=1e3 * trace.drive[chosen],
                holder_x_um=np.array([1e3 * state.holder_x for state in states]),
                holder_z_um=np.array([1e3 * state.holder_z for state in states]),
                tangential_force_N=trace.tangential_force[chosen],
                nodes=nodes,
                force_N=force[:, nodes],
                bulk_stress_MPa=stress,
                geometry=geometry,
                material=material,
            )
        )
    return tuple(found)


def positions(trace: CycleTrace, count: int) -> IntArray:
    """Indices of about `count` increments of a closed loop, in the order in time from its end at +x. They include both
    ends, mid-strokes and the increments just after reversals; the others are spread evenly over the strokes.
    """
    order = np.argsort(trace.phase)
    phase, drive = trace.phase[order], trace.drive[order]
    last = len(phase) - 1
    if count > last:
        return order
    back = int(np.argmin(np.abs(phase - 0.5)))
    named = {0, back, back + 1, last, int(np.argmin(np.abs(phase - 0.25))), int(np.argmin(np.abs(phase - 0.75)))}
    within = max(count - len(named), 0) // 2 + 2
    between: set[int] = set()
    for first, end in ((0, back), (back + 1, last)):
        stroke = drive[first : end + 1]
        places = np.linspace(drive[first], drive[end], within)[1:-1]
        between |= {first + int(np.argmin(np.abs(stroke - place))) for place in places}
    return np.asarray(order[sorted(named | between)])


Worn = tuple[PlacedBody, Array, Array, Array, Array, dict[str, Any]]


def scars_of(problem: ContactProblem, trace: CycleTrace, cycle: int, study: Study) -> tuple[Scar, Scar]:
    """(driven, held): scars of both bodies after `cycle` cycles, with the pressure at mid-stroke of the trace."""
    driven, other = worn_bodies(problem, trace)
    return _scar(*driven, cycle, study.bodies[0]), _scar(*other, cycle, study.bodies[1])


def worn_bodies(problem: ContactProblem, trace: CycleTrace) -> tuple[Worn, Worn]:
    """(lower, upper), each as (body, worn depth (n_a, n_t) in mm, friction energy per area (n_a, n_t) in mJ/mm², nodal
    forces (n, 3) in N at mid-stroke, slip path (n,) of the cycle in mm, further fields (n_a, n_t) in mm by the names of
    `FURTHER_COLUMNS`).

    Forces are those of one field of tractions. The forces that the solver transfers to the secondary body's nodes are
    spread over its elements, and smaller by a tenth where two of them span a contact's radius.
    """
    state = trace.middle
    wear, (primary_slid, secondary_slid) = state.wear, trace.slid
    pairs = zip(wear.prints, (None, None) if problem.debris is None else wear.debris(problem.retained), strict=True)
    further: list[dict[str, Any]] = [
        {name: field for name, field in zip(FURTHER_COLUMNS, pair, strict=True) if field is not None} for pair in pairs
    ]
    primary = wear.primary_depth, wear.primary_energy, state.primary_force, primary_slid, further[0]
    # Forces (n, 3) in N on the nodes of the secondary body, from the primary's tractions that they face.
    body, facing = problem.secondary, facing_offset(problem, state, state.drive, state.holder_x)
    places = (body.node_positions + facing) @ problem.primary.world_to_patch.T
    force = at_points(places, problem.primary.patch, body.node_areas).averaged(state.traction)
    secondary = wear.secondary_depth, wear.secondary_energy, force, secondary_slid, further[1]
    lower, upper = (secondary, primary) if problem.primary_is_upper else (primary, secondary)
    return (problem.lower, *lower), (problem.upper, *upper)


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
    further: dict[str, Any],
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
        **{name: 1e3 * field[:, order] for name, field in further.items()},
    )


def volume_mismatch(problem: ContactProblem, state: ContactState, scars: tuple[Scar, Scar]) -> float:
    """Largest relative difference of a scar's volume from what the wear law has removed; 0 without wear."""
    driven, other = scars
    wear = state.wear
    volumes = (wear.primary_volume_mm3, wear.secondary_volume_mm3)
    upper, lower = volumes if problem.primary_is_upper else volumes[::-1]
    expected = ((driven, lower), (other, upper))
    return max((abs(scar.volume_mm3 / volume - 1.0) for scar, volume in expected if volume > 0.0), default=0.0)
