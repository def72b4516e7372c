"""Sliding wires in the proportions of the steel wires' test: loop behind a rig's spring, energies, symmetries.

The resolution of a mesh is its number of elements per contact radius.
"""

from dataclasses import dataclass
from math import nan

import numpy as np

import solvers
from geometry import Elastic, HexMesh, build_body
from geometry.arrays import Array
from solvers import Holder, WearRates, advance, condense, press, unloaded_state
from wirewear import reference
from wirewear.loops.sensor import enclosed_area
from wirewear.verification import hertz
from wirewear.verification.hertz import LOAD_N, STEEL, RADIUS_mm, crossed, scaled_patch, wire_geometry
from wirewear.verification.rows import Level, Row, compared

_TOLERANCE = 0.01

_RATES = solvers.WearRates(upper_mm3_per_mJ=6e-8, lower_mm3_per_mJ=4e-8)
_CYCLES = 50.0
_ROUND_OFF = 1e-10
_MIRROR_TOLERANCE = 0.02


FRICTION = 0.6
#: Sliding bends the rig by half a contact radius; the contact slides by about two to each side.
RIG_STIFFNESS_N_per_mm = FRICTION * hertz.LOAD_N / (0.5 * hertz.CONTACT_RADIUS_mm)
AMPLITUDE_mm = 2.4 * hertz.CONTACT_RADIUS_mm
INCREMENTS = 40

_WEAR = WearRates(upper_mm3_per_mJ=5e-8, lower_mm3_per_mJ=5e-8)


def rig_loop_rows(level: Level) -> tuple[Row, ...]:
    """Rows on friction work, area, half-width at zero force and largest force of a loop behind the rig's spring."""
    body = hertz.condensed(hertz.wire_geometry(level.loop_resolution, long_patch=True))
    bulk = hertz.crossed_bulk_compliance(body, normal=False, contact_radius_mm=hertz.CONTACT_RADIUS_mm)
    contact = reference.partial_slip_point(
        hertz.LOAD_N, FRICTION, hertz.CONTACT_RADIUS_mm, reference.tangential_contact_modulus(hertz.STEEL, hertz.STEEL)
    )
    rig = 1.0 / (1.0 / RIG_STIFFNESS_N_per_mm + bulk)
    energy = reference.dissipated_energy(contact, AMPLITUDE_mm, rig)
    width = reference.slip_amplitude(contact, AMPLITUDE_mm, rig)
    raw_energy = energy - reference.dissipated_energy(contact, AMPLITUDE_mm, RIG_STIFFNESS_N_per_mm)
    raw_width = width - reference.slip_amplitude(contact, AMPLITUDE_mm, RIG_STIFFNESS_N_per_mm)
    trace = whole_loop(sliding_wires(level.loop_resolution))
    name = f"Rig loop, mesh a/{level.loop_resolution:g}"
    work, half_width = trace.friction_work, half_width_at_zero_force(trace.drive, trace.tangential_force)
    force = float(trace.tangential_force.max())
    area = abs(enclosed_area(trace.drive, trace.tangential_force))
    return (
        compared(name, "E_d as friction work [mJ]", work, energy, _TOLERANCE, raw=work + raw_energy),
        compared(name, "E_d as loop area [mJ]", area, energy, _TOLERANCE, raw=area + raw_energy),
        compared(name, "δ0 [mm]", half_width, width, _TOLERANCE, raw=half_width + raw_width),
        compared(name, "largest force [N]", force, contact.limit_N, 1e-3),
    )


def book_keeping_rows(level: Level) -> tuple[Row, ...]:
    """Rows on energy and worn volumes after a cycle jump, and on area and work of a closed loop on the worn wires."""
    problem = sliding_wires(level.loop_resolution, wear=_RATES)
    fresh = at_end_of_stroke(problem)
    _, first = solvers.closed_adaptive_cycle(problem, fresh, solvers.Drive(AMPLITUDE_mm), INCREMENTS)
    worn = jumped(problem, fresh, _CYCLES)
    wear, energy = worn.wear, worn.wear.energy_mJ
    upper = float((problem.upper.patch.node_areas() * wear.primary_depth.ravel()).sum())
    lower = float((problem.lower.patch.node_areas() * wear.secondary_depth.ravel()).sum())
    _, closed = solvers.closed_adaptive_cycle(problem, worn, solvers.Drive(AMPLITUDE_mm), INCREMENTS)
    name = f"Book-keeping, {_CYCLES:g} cycles"
    before, area = (abs(enclosed_area(loop.drive, loop.tangential_force)) for loop in (first, closed))
    mirror = solvers.mirror_error(problem, (closed.start, *closed.states), solvers.symmetry_of(problem))
    return (
        compared(name, "energy = loop area times cycles [mJ]", energy, 0.5 * _CYCLES * (before + area), 5e-3),
        compared(name, "volume of upper wire = αE [mm³]", upper, _RATES.upper_mm3_per_mJ * energy, _ROUND_OFF),
        compared(name, "volume of lower wire = αE [mm³]", lower, _RATES.lower_mm3_per_mJ * energy, _ROUND_OFF),
        compared(name, "loop area = friction work [mJ]", area, closed.friction_work, 2e-3),
        compared(
            name, "mirror error of the pressures", nan if mirror is None else mirror, 0.0, _MIRROR_TOLERANCE, scale=1.0
        ),
    )


def sliding_wires(
    resolution: float,
    *,
    friction: float = FRICTION,
    rig_compliance_mm_per_N: float = 1.0 / RIG_STIFFNESS_N_per_mm,
    wear: solvers.WearRates | None = None,
    primary_is_upper: bool = True,
) -> solvers.ContactProblem:
    """Contact problem of equal wires crossed at right angles behind the rig's spring; as in `hertz.crossed`."""
    body = hertz.condensed(hertz.wire_geometry(resolution, long_patch=True))
    holder = solvers.Holder(hertz.LOAD_N, rig_compliance_mm_per_N)
    return hertz.crossed(body, body, holder, friction=friction, wear=wear, primary_is_upper=primary_is_upper)


def at_end_of_stroke(problem: solvers.ContactProblem, amplitude_mm: float = AMPLITUDE_mm) -> solvers.ContactState:
    """The state after pressing and moving from mid-stroke to `amplitude_mm`, which may be negative."""
    pressed, _ = solvers.press(problem, solvers.unloaded_state(problem))
    return solvers.first_quarter(problem, pressed, solvers.Drive(amplitude_mm), INCREMENTS)


def whole_loop(problem: solvers.ContactProblem, amplitude_mm: float = AMPLITUDE_mm) -> solvers.CycleTrace:
    """The first full cycle from the end of the stroke at `amplitude_mm`, without wear."""
    start = at_end_of_stroke(problem, amplitude_mm)
    return solvers.run_cycle(problem, start, solvers.Drive(abs(amplitude_mm)), INCREMENTS, 0.0)[1]


def jumped(problem: solvers.ContactProblem, start: solvers.ContactState, cycles: float) -> solvers.ContactState:
    """The state after one jump over `cycles` cycles from the state `start` at the end of the stroke."""
    symmetry = solvers.symmetry_of(problem)
    begin, trace = solvers.closed_trace(problem, start, solvers.Drive(AMPLITUDE_mm), INCREMENTS, symmetry)
    return solvers.jump_cycles(lambda *_: problem, begin, trace, symmetry, 1.0, cycles).state


def half_width_at_zero_force(drive_mm: Array, force_N: Array) -> float:
    """Half the distance in mm between the zero crossings of a closed loop of displacements and forces (n,)."""
    before = np.roll(force_N, 1)
    crossing = np.flatnonzero((force_N > 0.0) != (before > 0.0))
    share = before[crossing] / (before[crossing] - force_N[crossing])
    previous = np.roll(drive_mm, 1)[crossing]
    return float(0.5 * np.ptp(previous + share * (drive_mm[crossing] - previous)))


@dataclass(frozen=True)
class _UnitSystem:
    """Units of length and stress: the size of 1 mm and 1 MPa in them."""

    length: float
    stress: float


_MILLIMETRES = _UnitSystem(1.0, 1.0)
_SI = _UnitSystem(1e-3, 1e6)


def limit_rows(level: Level) -> tuple[Row, ...]:
    """Rows on how loops differ with exchanged roles of the bodies, mirrored motion, a stiff rig and in SI units, and on
    wear without friction.
    """
    resolution = level.loop_resolution
    plain = whole_loop(sliding_wires(resolution)).tangential_force
    swapped = whole_loop(sliding_wires(resolution, primary_is_upper=False)).tangential_force
    mirrored = whole_loop(sliding_wires(resolution), -AMPLITUDE_mm).tangential_force
    rigid = whole_loop(sliding_wires(resolution, rig_compliance_mm_per_N=0.0)).tangential_force
    stiff = whole_loop(sliding_wires(resolution, rig_compliance_mm_per_N=1e-12)).tangential_force
    problem = sliding_wires(resolution, friction=0.0, wear=_WEAR)
    worn = jumped(problem, at_end_of_stroke(problem), 1.0)
    deepest = float(max(worn.wear.primary_depth.max(), worn.wear.secondary_depth.max()))
    return (
        _difference("Swapped roles", "largest difference of loops over µP", swapped, plain, 1e-2),
        _difference("Mirrored motion", "largest difference of mirrored loops over µP", -mirrored, plain, 1e-9),
        _difference("Rig 10¹² N/mm against rigid", "largest difference of loops over µP", stiff, rigid, 1e-6),
        compared("No friction", "deepest wear under the energy law [mm]", deepest, 0.0, 0.0, scale=1.0),
        *_units(resolution),
    )


def _difference(problem: str, quantity: str, one: Array, other: Array, tolerance: float) -> Row:
    largest = float(np.abs(one - other).max())
    return compared(problem, quantity, largest / (FRICTION * LOAD_N), 0.0, tolerance, scale=1.0)


def _units(resolution: float) -> tuple[Row, ...]:
    here, there = _quarter_cycle(resolution, _MILLIMETRES), _quarter_cycle(resolution, _SI)
    name = "SI against mm, N, MPa"
    changed = float(np.abs(here.iterations - there.iterations).sum())
    rows = [compared(name, "difference of Newton iterations", changed, 0.0, 0.0, scale=1.0)]
    for quantity, one, other in (
        ("tangential force", here.force, there.force),
        ("tractions", here.traction / _MILLIMETRES.stress, there.traction / _SI.stress),
        ("holder's position", here.holder / _MILLIMETRES.length, there.holder / _SI.length),
    ):
        largest = float(np.abs(one - other).max() / np.abs(one).max())
        rows.append(compared(name, f"{quantity}, relative difference", largest, 0.0, 1e-8, scale=1.0))
    return tuple(rows)


@dataclass(frozen=True)
class _Motion:
    iterations: Array
    force: Array
    holder: Array
    traction: Array


def _quarter_cycle(resolution: float, units: _UnitSystem) -> _Motion:
    material = Elastic(STEEL.youngs_modulus_MPa * units.stress, STEEL.poissons_ratio)
    meshed = build_body(wire_geometry(resolution, long_patch=True))
    mesh = HexMesh(meshed.mesh.points * units.length, meshed.mesh.cells, meshed.mesh.surfaces)
    body = condense(mesh, scaled_patch(meshed.patch, RADIUS_mm, units.length), material)
    problem = crossed(body, body, Holder(LOAD_N, units.length / RIG_STIFFNESS_N_per_mm), friction=FRICTION)
    state, report = press(problem, unloaded_state(problem))
    path = AMPLITUDE_mm * np.concatenate([np.linspace(0.1, 1.0, 10), np.linspace(0.95, 0.5, 6)])
    iterations, force, holder = [report.iterations], [], [(state.holder_x, state.holder_z)]
    for drive in path:
        state, reports = advance(problem, state, float(drive) * units.length, 0.0)
        iterations += [report.iterations for report in reports]
        force.append(reports[-1].tangential_force)
        holder.append((state.holder_x, state.holder_z))
    # Cut increments would make the lists differ in length: compare their sums as well as each.
    padded = np.zeros(8 * len(path))
    padded[: len(iterations)] = iterations
    return _Motion(padded, np.array(force), np.array(holder), state.traction)
