"""Time per simulated increment against the number of nodes in contact, and where the time of a run goes.

Usage: python -m studies.benchmarks.bench_scaling [--contact-mesh-um 10 --contact-mesh-um 7] [--cycles 20000]

Crossed steel wires on the compliant rig wear by cycle jumps that double, so that the contact grows from some ten nodes
to hundreds. Every increment's CPU time is put to its nodes in contact; the exponent is fitted to the means of classes
of nodes, each twice the last. The shares are those of a whole run of the same test on the first mesh, with its loops,
maps and checkpoints written, but without its condensation.
"""

import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from wirewear import Study, run_study
from wirewear.faces.study_script import StudyScript
from wirewear.simulation.workbench import (
    ContactState,
    IncrementReport,
    contact_problem,
    press,
    run_cycle,
    unloaded_state,
)

from .crossed_wires import AMPLITUDE_um, discretised, of_contact_meshes, study
from .sampled_time import SampledTime

Array = NDArray[np.float64]

#: Parts of a run and the functions that they are.
PARTS = {
    "condensation": (("wirewear/simulation/problem.py", "contact_problem"),),
    "pairing": (("solvers/pairing.py", "pair"), ("solvers/pairing.py", "vertical_gap")),
    "assembly": (("solvers/compliance.py", "paired_compliance"),),
    "solve": (("solvers/newton/iteration.py", "solve_contact"),),
    "wear": (("solvers/wear.py", "deposited"),),
    "output": (
        ("wirewear/results/hdf5.py", "write_result"),
        ("wirewear/simulation/folder.py", "write_checkpoint"),
        ("wirewear/simulation/recorded.py", "scars_of"),
    ),
}
WEAR_mm3_per_J = 3e-5


@dataclass(frozen=True)
class Increments:
    """Nodes in contact (n,) and CPU seconds (n,) of n increments."""

    active: Array
    seconds: Array


@dataclass(frozen=True)
class SizeClass:
    """Increments with a similar number of nodes in contact: how many, mean nodes and mean CPU seconds."""

    count: int
    active: float
    seconds: float


def fitted_exponent(active: Sequence[float], seconds: Sequence[float]) -> float:
    """Exponent n of seconds ~ active^n by least squares in logarithms; ValueError for fewer than two sizes."""
    if len(set(active)) < 2:
        raise ValueError("an exponent needs at least two sizes")
    return float(np.polyfit(np.log(active), np.log(seconds), 1)[0])


def size_classes(increments: Increments, least: int = 10) -> list[SizeClass]:
    """Means over classes from 1, 2, 4, ... nodes, without those of fewer than `least` increments."""
    octave = np.floor(np.log2(np.maximum(increments.active, 1.0)))
    found = []
    for one in np.unique(octave):
        inside = octave == one
        if inside.sum() >= least:
            means = (float(values[inside].mean()) for values in (increments.active, increments.seconds))
            found.append(SizeClass(int(inside.sum()), *means))
    return found


def measure(of: Study) -> Increments:
    """Wear the study's wires by jumps that double until its cycles are reached; time every increment."""
    meshes = discretised(of)
    problem = contact_problem(of, meshes, lambda _stage: None)
    state, _ = press(problem, unloaded_state(problem))
    amplitude = 1e-3 * of.conditions.displacement_amplitude_um
    active, seconds = list[float](), list[float]()
    last = time.process_time()

    def watch(_state: ContactState, report: IncrementReport) -> None:
        nonlocal last
        now = time.process_time()
        active.append(float(report.active))
        seconds.append(now - last)
        last = now

    guide, done = None, 1.0
    while done < of.conditions.cycles:
        jump = min(done, of.conditions.cycles - done)
        state, trace = run_cycle(
            problem, state, amplitude, meshes.increments_per_wear_cycle, jump, watch=watch, guide=guide
        )
        guide, done = trace.guide, done + jump
        last = time.process_time()
    return Increments(np.array(active), np.array(seconds))


def shares_of_a_run(of: Study) -> dict[str, float]:
    """Shares of a whole run's CPU time without its condensation."""
    sampled = SampledTime(PARTS)
    with tempfile.TemporaryDirectory() as folder, sampled:
        run_study(of, fidelity="standard", output=Path(folder))
    seconds = {part: one for part, one in sampled.seconds.items() if part != "condensation"}
    total = sum(seconds.values())
    return {part: one / total for part, one in seconds.items()}


def table(classes: Sequence[SizeClass]) -> list[str]:
    """One line for each class, and the exponents: of all and of the larger half."""
    rows = [f"{'nodes in contact':>18}{'increments':>12}{'CPU ms/increment':>18}"]
    rows += [f"{one.active:18.0f}{one.count:12d}{1e3 * one.seconds:18.2f}" for one in classes]
    for name, chosen in (("all", classes), ("the larger half", classes[len(classes) // 2 :])):
        if len(chosen) > 1:
            exponent = fitted_exponent([one.active for one in chosen], [one.seconds for one in chosen])
            rows.append(f"time per increment grows as nodes in contact to the power {exponent:.2f} ({name})")
    return rows


@click.command(cls=StudyScript)
@of_contact_meshes
@click.option("--cycles", type=click.IntRange(1), default=20_000, show_default=True)
def main(contact_mesh_um: tuple[float, ...], cycles: int) -> None:
    """Measure the time of an increment against the nodes in contact, and print."""
    studies = [
        study(mesh_um, amplitude_um=AMPLITUDE_um, wear_mm3_per_J=WEAR_mm3_per_J, cycles=cycles)
        for mesh_um in contact_mesh_um
    ]
    measured = [measure(of) for of in studies]
    every = Increments(
        np.concatenate([one.active for one in measured]), np.concatenate([one.seconds for one in measured])
    )
    click.echo("\n".join(table(size_classes(every))))
    shares = shares_of_a_run(studies[0])
    listed = ", ".join(f"{part} {100.0 * share:.1f} %" for part, share in shares.items())
    click.echo(f"CPU time of a whole run at {contact_mesh_um[0]:g} um: {listed}")


if __name__ == "__main__":
    main()
