"""Contact forces of a recorded cycle, at positions spread over it, as a result keeps them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry import WireGeometry
from solvers import ContactProblem, CycleTrace, PlacedBody
from solvers.interior import forces_on_bodies
from wirewear.results import ContactForces
from wirewear.results.scar import WIRES
from wirewear.simulation.plan import RunPlan

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def forces_of(problem: ContactProblem, trace: CycleTrace, cycle: int, plan: RunPlan) -> tuple[ContactForces, ...]:
    """Forces on the moving and the fixed wire; nothing where the study asks for none."""
    study = plan.study
    stage = next(
        stage
        for stage in plan.meshes.all_stages
        if _is_of(stage.moving, problem.lower) and _is_of(stage.fixed, problem.upper)
    )
    made_of: tuple[dict[str, Any], dict[str, Any]] = (
        {"geometry": stage.moving, "material": study.moving_wire.material},
        {"geometry": stage.fixed, "material": study.fixed_wire.material},
    )
    return forces_on(problem, trace, cycle, study.log.contact_states, WIRES, made_of)


def forces_on(
    problem: ContactProblem,
    trace: CycleTrace,
    cycle: int,
    count: int,
    bodies: tuple[str, str],
    made_of: Sequence[Mapping[str, Any]] = ({}, {}),
) -> tuple[ContactForces, ...]:
    """Forces on the driven body and the other at about so many positions, nothing for none.

    made_of: geometry and material of wires.
    """
    if count == 0:
        return ()
    chosen = positions(trace, count)
    states = [trace.states[k] for k in chosen]
    upper, lower = (np.array(each) for each in zip(*(forces_on_bodies(problem, one) for one in states), strict=True))
    found = []
    placed = zip(bodies, (problem.lower, problem.upper), (lower, upper), made_of, strict=True)
    for name, body, force, further in placed:
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
                **further,
            )
        )
    return tuple(found)


def positions(trace: CycleTrace, count: int) -> IntArray:
    """Places in a closed loop, at most about so many: both ends, mid-strokes, just after reversals, others between.

    Those between are spread evenly over the strokes, each the increment nearest to its place. They are in the order in
    which the cycle passes them from its end at +x.
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


def _is_of(geometry: WireGeometry, body: PlacedBody) -> bool:
    patch = body.patch
    return np.array_equal(geometry.axial.lines(), patch.axial_mm) and np.array_equal(
        geometry.transverse.lines(), patch.transverse_mm
    )
