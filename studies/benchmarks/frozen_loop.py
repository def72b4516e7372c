"""A loop of many increments on the scars that a run has left, the wear frozen: its pressures about mid-stroke.

Usage: python -m studies.benchmarks.frozen_loop STUDY.toml RESULT.h5 [--cycles 30000 100000] [--increments 240]

Loops of a run have as many increments as their force needs; pressures need more. The wires are those of the run's last
meshes, so its cycles must have been on these. Nodes that `fine` moves into the worn surface stand where they stood at
first. Effects of age are left out. Printed are medians about mid-stroke: of the largest pressure away from the rim, and
of the largest mean over a length.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wirewear import WirewearError, load
from wirewear.results import RunResult, largest_mean_pressure_MPa, read_result
from wirewear.simulation.measure import MID_STROKE, mid_stroke_pressure
from wirewear.simulation.plan import RunPlan
from wirewear.simulation.workbench import (
    ContactProblem,
    ContactState,
    closed_cycle,
    contact_problem,
    first_quarter,
    press,
    unloaded_state,
)

Array = NDArray[np.float64]


def depth_mm(problem: ContactProblem, result: RunResult, cycle: int, wire: str) -> Array:
    """Worn depth (n_a, n_t) of a wire on its patch, as the solver has it.

    Raises:
        SystemExit: the scar stands on other meshes.
    """
    body = problem.upper if wire == "fixed" else problem.lower
    scar = result.scar(cycle, wire)
    if len(scar.axial_um) != len(body.patch.axial_mm) or not np.allclose(scar.axial_um, 1e3 * body.patch.axial_mm):
        raise SystemExit(f"the scars of cycle {cycle} stand on other meshes than the run's last.")
    # An upper body's transverse axis runs backwards in the common frame.
    return np.ascontiguousarray(1e-3 * scar.depth_um[:, :: body.facing])


def pressed(problem: ContactProblem, result: RunResult, cycle: int) -> ContactState:
    """The worn wires under the normal load, whose spring is as long as when the fresh ones were pressed."""
    start = unloaded_state(problem)
    fresh, _ = press(problem, start)
    upper, lower = (depth_mm(problem, result, cycle, wire) for wire in ("fixed", "moving"))
    primary, secondary = (upper, lower) if problem.primary_is_upper else (lower, upper)
    worn = replace(start.wear, primary_depth=primary, secondary_depth=secondary)
    state, _ = press(problem, replace(start, wear=worn))
    return replace(state, pressed_z=fresh.pressed_z)


def mean_over_MPa(problem: ContactProblem, states: tuple[ContactState, ...], amplitude_mm: float, over: float) -> float:
    """Median over mid-stroke of the largest mean pressure over a length in µm, on the primary."""
    patch = (problem.upper if problem.primary_is_upper else problem.lower).patch
    middle = [state.primary_force[:, 2] for state in states if abs(state.drive) < MID_STROKE * amplitude_mm]
    touched = np.any(middle, axis=0)
    places = 1e3 * patch.grid()[touched]
    return float(np.median([largest_mean_pressure_MPa(places, force[None, touched], over) for force in middle]))


def told(study: Path, result: RunResult, cycles: list[int], increments: int, over: float) -> None:
    """Print what loops of so many increments on the scars of these cycles tell."""
    given = load(study)
    plan = RunPlan.of(given.variant(result.variant) if given.variant_names else given, result.fidelity)
    problem = contact_problem(plan.study, plan.meshes.stages[-1], lambda _stage: None)
    amplitude, few = plan.test.motion.amplitude_mm, plan.discretisation.increments_per_wear_cycle
    for cycle in cycles:
        out = first_quarter(problem, pressed(problem, result, cycle), amplitude, few)
        _, trace = closed_cycle(problem, out, amplitude, increments, settling_increments=few)
        mean = mean_over_MPa(problem, trace.states, amplitude, over)
        pressures = f"{mid_stroke_pressure(trace):.0f} MPa at a node, {mean:.0f} MPa over {over:g} µm"
        force, energy = abs(trace.tangential_force).max(), 1e3 * trace.friction_work
        loop = f"largest force {force:.4f} N, energy {energy:.2f} µJ"
        print(f"{result.variant} {result.fidelity}, cycle {cycle}: {pressures}, {loop}", flush=True)


def main() -> None:
    """Read the command line and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("study", type=Path)
    parser.add_argument("result", type=Path)
    parser.add_argument("--cycles", type=int, nargs="+", default=[30_000, 100_000])
    parser.add_argument("--increments", type=int, default=240)
    parser.add_argument("--over", type=float, default=15.0, help="µm")
    given = parser.parse_args()
    try:
        told(given.study, read_result(given.result), given.cycles, given.increments, given.over)
    except WirewearError as problem:
        raise SystemExit(str(problem)) from None


if __name__ == "__main__":
    main()
