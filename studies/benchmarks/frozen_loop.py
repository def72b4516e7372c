"""A loop of many increments on the scars that a run has left, the wear frozen: its pressures about mid-stroke.

Usage: python -m studies.benchmarks.frozen_loop STUDY.toml RESULT.h5 [--cycle 30000 --cycle 100000] [--increments 240]

Loops of a run have as many increments as their force needs; pressures need more. The wires are those of the run's last
meshes, so its cycles must have been on these. Nodes that `fine` moves into the worn surface stand where they stood at
first. Effects of age are left out. Printed are pressures about mid-stroke and the largest of the cycle.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import ceil
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from wirewear import load
from wirewear.base.errors import ResultError
from wirewear.faces.study_script import StudyScript
from wirewear.results import RunResult, read_result
from wirewear.simulation.contact_forces import pressure_figures
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

#: Means over the study's length, and those of single nodes.
KINDS = ("mean_pressure_MPa", "pressure_MPa")


def depth_mm(problem: ContactProblem, result: RunResult, cycle: int, wire: str) -> Array:
    """Worn depth (n_a, n_t) of a wire on its patch, as the solver has it.

    Raises:
        ResultError: the scar stands on other meshes.
    """
    body = problem.upper if wire == "fixed" else problem.lower
    scar = result.scar(cycle, wire)
    if len(scar.axial_um) != len(body.patch.axial_mm) or not np.allclose(scar.axial_um, 1e3 * body.patch.axial_mm):
        raise ResultError(f"the scars of cycle {cycle} stand on other meshes than the run's last.")
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


def told(study: Path, result: RunResult, cycles: Sequence[int], increments: int) -> None:
    """Print what loops of about so many increments, a multiple of four, on the scars of these cycles tell."""
    increments = 4 * ceil(increments / 4)
    given = load(study)
    plan = RunPlan.of(given.variant(result.variant) if given.variant_names else given, result.fidelity)
    problem = contact_problem(plan.study, plan.meshes.stages[-1], lambda _stage: None)
    amplitude, few = plan.test.motion.amplitude_mm, plan.discretisation.increments_per_wear_cycle
    for cycle in cycles:
        out = first_quarter(problem, pressed(problem, result, cycle), amplitude, few)
        _, trace = closed_cycle(problem, out, amplitude, increments, settling_increments=few)
        found = pressure_figures(problem, trace, plan.pressure_length_mm)
        means, nodes = (f"{found[f'mid_stroke_{name}']:.0f}, at most {found[f'max_{name}']:.0f} MPa" for name in KINDS)
        pressures = f"{means} over {1e3 * plan.pressure_length_mm:.3g} µm; {nodes} at a node"
        force, energy = abs(trace.tangential_force).max(), 1e3 * trace.friction_work
        loop = f"largest force {force:.4f} N, energy {energy:.2f} µJ"
        print(f"{result.variant} {result.fidelity}, cycle {cycle}: {pressures}, {loop}", flush=True)


@click.command(cls=StudyScript)
@click.argument("study", metavar="STUDY.toml", type=click.Path(path_type=Path))
@click.argument("result", metavar="RESULT.h5", type=click.Path(path_type=Path))
@click.option("--cycle", "cycles", type=click.IntRange(1), multiple=True, default=(30_000, 100_000), show_default=True)
@click.option("--increments", type=click.IntRange(16), default=240, show_default=True)
def main(study: Path, result: Path, cycles: tuple[int, ...], increments: int) -> None:
    """Print the pressures of loops of many increments on the scars that a run has left."""
    told(study, read_result(result), cycles, increments)


if __name__ == "__main__":
    main()
