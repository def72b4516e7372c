"""wirewear's side of the comparison, in a process of its own.

Usage: python -m studies.benchmarks.wirewear_side MESH_um RIG FILE
"""

import json
import time
from pathlib import Path

import click

from studies.study_script import StudyScript
from wirewear.simulation.workbench import advance, contact_problem, press, unloaded_state

from .crossed_wires import DRIVES_um, discretised, study


def solve(contact_mesh_um: float, rig: str) -> dict[str, object]:
    """Condense, press and slide; times are CPU seconds unless they say wall."""
    of = study(contact_mesh_um, rig)
    start = time.process_time()
    problem = contact_problem(of, discretised(of), lambda _stage: None)
    condensed = time.process_time()
    state, report = press(problem, unloaded_state(problem))
    pressed = time.process_time()
    approach = -1e3 * state.holder_z
    forces, rise, seconds, wall = [], [], [], []
    for drive in DRIVES_um:
        before, clock = time.process_time(), time.perf_counter()
        state, reports = advance(problem, state, 1e-3 * drive, 0.0)
        seconds.append(time.process_time() - before)
        wall.append(time.perf_counter() - clock)
        forces.append(reports[-1].tangential_force)
        rise.append(approach + 1e3 * state.holder_z)
    return {
        "condensation_s": condensed - start,
        "press_s": pressed - condensed,
        "increments_s": seconds,
        "increments_wall_s": wall,
        "peak_pressure_MPa": report.max_pressure,
        "approach_um": approach,
        "tangential_force_N": forces,
        "rise_um": rise,
    }


@click.command(cls=StudyScript)
@click.argument("mesh_um", type=click.FloatRange(0.0, min_open=True))
@click.argument("rig")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
def main(mesh_um: float, rig: str, file: Path) -> None:
    """Solve on elements of MESH_UM with a RIG of so many N/mm, or rigid, and write the figures to FILE."""
    file.write_text(json.dumps(solve(mesh_um, rig)), encoding="utf-8")


if __name__ == "__main__":
    main()
