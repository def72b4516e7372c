"""Cycle jumps of small bodies for the tests of the wear step."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
from threadpoolctl import threadpool_limits

import solvers
from geometry import Cylinder, Flat, GradedAxis, PlanarGeometry, build_planar
from geometry.arrays import Array
from solvers.wear_step.symmetry import Mirror, mirrored
from tests.bodies import FRICTION, STEEL, crossed_wires, pressed
from wirewear.reference import Elastic, LineContact, contact_modulus, hertz_line

MESH_mm = 0.010
RATES = (1.5e-8, 1.5e-8)
#: Of wires; the radius of their fresh contact is 14 µm.
STROKE_mm = 0.02
INCREMENTS = 16
RIG_N_per_mm = 167.0
LINE_LOAD_N_per_mm = 60.0
LINE_STROKE_mm = 0.04
_ONE_THREAD = {"limits": 1, "user_api": "blas"}


def wires(**changes: object) -> solvers.ContactProblem:
    """Steel wires crossed at right angles that wear, behind the article's rig unless it is changed."""
    usual: dict[str, object] = {"rig_N_per_mm": RIG_N_per_mm, "wear": RATES}
    return crossed_wires(MESH_mm, long_patch=True, **(usual | changes))  # type: ignore[arg-type]


@cache
def _line_bodies(element_mm: float) -> tuple[solvers.PlacedBody, solvers.PlacedBody]:
    pad = PlanarGeometry(Cylinder(6.0, curved_along=True), 2.0, 2.0, GradedAxis(element_mm, 0.16, 0.02, 0.24))
    flat = PlanarGeometry(Flat(), 2.0, 2.0, GradedAxis(element_mm, 0.2, 0.02, 0.28))
    bodies = [(build_planar(geometry), upper) for geometry, upper in ((pad, True), (flat, False))]
    placed = [
        solvers.place(solvers.condense(b.mesh, b.patch, STEEL), upper=upper, axis_angle_rad=0.0) for b, upper in bodies
    ]
    return placed[0], placed[1]


def hertz_of_line() -> LineContact:
    """The fresh contact of a cylinder on a flat."""
    steel = Elastic(STEEL.youngs_modulus_MPa, STEEL.poissons_ratio)
    return hertz_line(LINE_LOAD_N_per_mm, 6.0, contact_modulus(steel, steel))


def line_contact(
    element_mm: float = 0.008, *, primary_is_upper: bool = True, wear: solvers.WearRates | None = None
) -> solvers.ContactProblem:
    """A cylinder of 6 mm radius on a flat, both of steel, in plane strain; its contact is 65 µm wide on each side."""
    upper, lower = _line_bodies(element_mm)
    return solvers.ContactProblem(
        upper=upper, lower=lower, holder=solvers.Holder(LINE_LOAD_N_per_mm), friction=FRICTION,
        wear=wear or solvers.WearRates(*RATES), primary_is_upper=primary_is_upper,
    )  # fmt: skip


def at_the_end(
    problem: solvers.ContactProblem, stroke_mm: float = STROKE_mm, increments: int = INCREMENTS
) -> solvers.ContactState:
    """Fresh bodies pressed together and moved to the end of the stroke."""
    with threadpool_limits(**_ONE_THREAD):
        return solvers.first_quarter(problem, pressed(problem)[0], solvers.Drive(stroke_mm), increments)


def jumped(
    problem: solvers.ContactProblem,
    state: solvers.ContactState,
    cycles: float,
    *,
    symmetry: solvers.Symmetry | None = None,
    stroke_mm: float = STROKE_mm,
    increments: int = INCREMENTS,
    problem_at: Callable[[float, float], solvers.ContactProblem] | None = None,
) -> solvers.CycleJump:
    """One jump from the end of the stroke, by the symmetries that problem and state have unless some are given."""
    found = solvers.kept_by(solvers.symmetry_of(problem), state) if symmetry is None else symmetry
    with threadpool_limits(**_ONE_THREAD):
        start, trace = solvers.closed_trace(problem, state, solvers.Drive(stroke_mm), increments, found)
        return solvers.jump_cycles(problem_at or (lambda *_: problem), start, trace, found, 1.0, cycles)


def worn(problem: solvers.ContactProblem, *jumps: float, stroke_mm: float = STROKE_mm) -> solvers.ContactState:
    """Fresh bodies after jumps of so many cycles each."""
    state = at_the_end(problem, stroke_mm)
    for cycles in jumps:
        state = jumped(problem, state, cycles, stroke_mm=stroke_mm).state
    return state


def depths(problem: solvers.ContactProblem, state: solvers.ContactState) -> tuple[Array, Array]:
    """Worn depth of the upper and the lower body, each of the shape of its patch."""
    wear = state.wear
    pair = wear.primary_depth, wear.secondary_depth
    return pair if problem.primary_is_upper else pair[::-1]


def even_across(state: solvers.ContactState, across: Mirror) -> solvers.ContactState:
    """The state made its own mirror image to the last bit."""
    image = mirrored(state, across)
    return replace(
        state,
        traction=0.5 * (state.traction + image.traction),
        primary_force=0.5 * (state.primary_force + image.primary_force),
        secondary_force=0.5 * (state.secondary_force + image.secondary_force),
    )


def whole_of(start: solvers.ContactState, half: solvers.CycleTrace, mirror: Mirror) -> solvers.CycleTrace:
    """A cycle made of its first half and the mirror image of that, from a start that is the image of the half's end."""
    end = half.states[-1]

    def later(state: solvers.ContactState) -> solvers.ContactState:
        slid, other_slid = end.primary_slid.copy(), end.secondary_slid.copy()
        slid[mirror.primary] += state.primary_slid - start.primary_slid
        other_slid[mirror.secondary] += state.secondary_slid - start.secondary_slid
        return replace(mirrored(state, mirror), primary_slid=slid, secondary_slid=other_slid)

    return replace(
        half,
        phase=np.concatenate([half.phase, (half.phase + 0.5) % 1.0]),
        work=np.concatenate([half.work, half.work]),
        states=(*half.states, *(later(state) for state in half.states)),
    )
