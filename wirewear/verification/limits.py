"""Limits and symmetries: nothing but the discretisation may change when roles, signs or units do."""

from dataclasses import dataclass

import numpy as np

from geometry import Elastic, build_body
from geometry.arrays import Array
from solvers import ContactProblem, Holder, WearRates, advance, condense, press, unloaded_state
from wirewear.verification import sliding
from wirewear.verification.hertz import LOAD_N, STEEL, crossed, scaled, wire_geometry
from wirewear.verification.rows import Level, Row, compared

_WEAR = WearRates(upper_mm3_per_mJ=5e-8, lower_mm3_per_mJ=5e-8)


@dataclass(frozen=True)
class _UnitSystem:
    """mm, N, MPa in the system's own units of length and stress."""

    length: float
    stress: float


_MILLIMETRES = _UnitSystem(1.0, 1.0)
_SI = _UnitSystem(1e-3, 1e6)


def limit_rows(level: Level) -> tuple[Row, ...]:
    """Swapped roles, mirrored motion, rigid and frictionless limits, and SI units against mm, N, MPa."""
    resolution = level.loop_resolution
    plain = sliding.whole_loop(sliding.sliding_wires(resolution)).tangential_force
    swapped = sliding.whole_loop(sliding.sliding_wires(resolution, primary_is_upper=False)).tangential_force
    mirrored = sliding.whole_loop(sliding.sliding_wires(resolution), -sliding.AMPLITUDE_mm).tangential_force
    rigid = sliding.whole_loop(sliding.sliding_wires(resolution, rig_compliance_mm_per_N=0.0)).tangential_force
    stiff = sliding.whole_loop(sliding.sliding_wires(resolution, rig_compliance_mm_per_N=1e-12)).tangential_force
    return (
        _difference("Swapped roles", "largest difference of loops over µP", swapped, plain, 1e-2),
        _difference("Mirrored motion", "largest difference of mirrored loops over µP", -mirrored, plain, 1e-9),
        _difference("Rig 10¹² N/mm against rigid", "largest difference of loops over µP", stiff, rigid, 1e-6),
        _frictionless(resolution),
        *_units(resolution),
    )


def _difference(problem: str, quantity: str, one: Array, other: Array, tolerance: float) -> Row:
    largest = float(np.abs(one - other).max())
    return compared(problem, quantity, largest / (sliding.FRICTION * LOAD_N), 0.0, tolerance, scale=1.0)


def _frictionless(resolution: float) -> Row:
    problem = sliding.sliding_wires(resolution, friction=0.0, wear=_WEAR)
    worn = sliding.jumped(problem, sliding.at_end_of_stroke(problem), 1.0)
    deepest = float(max(worn.wear.primary_depth.max(), worn.wear.secondary_depth.max()))
    return compared("No friction", "deepest wear under the energy law [mm]", deepest, 0.0, 0.0, scale=1.0)


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
    """Pressing, a quarter of a cycle and the reversal after it, in a unit system."""
    problem = _in_units(resolution, units)
    state, report = press(problem, unloaded_state(problem))
    path = sliding.AMPLITUDE_mm * np.concatenate([np.linspace(0.1, 1.0, 10), np.linspace(0.95, 0.5, 6)])
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


def _in_units(resolution: float, units: _UnitSystem) -> ContactProblem:
    meshed = scaled(build_body(wire_geometry(resolution, long_patch=True)), units.length)
    material = Elastic(STEEL.youngs_modulus_MPa * units.stress, STEEL.poissons_ratio)
    body = condense(meshed.mesh, meshed.patch, material)
    return crossed(body, body, Holder(LOAD_N, units.length / sliding.RIG_STIFFNESS_N_per_mm), friction=sliding.FRICTION)
