"""Time per simulated increment against the number of nodes in contact, and where it goes.

Usage: python -m studies.benchmarks.bench_scaling [--contact-mesh-um 8 5 3.5]

Crossed wires behind a rigid rig, ten increments over ±20 µm. The exponent is fitted to CPU seconds per increment. The
shares come from one more pass under cProfile, whose own cost weighs on functions that are called often.
"""

from __future__ import annotations

import argparse
import cProfile
import pstats
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wirewear.contact_problem import ContactProblem, ContactState, advance, contact_problem, press, unloaded_state

from .crossed_wires import DRIVES_um, discretised, study

#: Parts of an increment and the functions that they are: name -> (end of the file's path, function).
PARTS = {
    "pairing": ("solvers/pairing.py", "pair"),
    "paired compliance": ("solvers/compliance.py", "paired_compliance"),
    "Newton solve": ("solvers/newton.py", "solve_contact"),
}


@dataclass(frozen=True)
class Measurement:
    """One mesh: mean nodes in contact, CPU seconds per increment, share of each part in the time of all increments."""

    contact_mesh_um: float
    active: float
    seconds: float
    shares: dict[str, float]


def fitted_exponent(active: Sequence[float], seconds: Sequence[float]) -> float:
    """Exponent n of seconds ~ active^n by least squares in logarithms; ValueError for fewer than two sizes."""
    if len(set(active)) < 2:
        raise ValueError("an exponent needs at least two sizes")
    return float(np.polyfit(np.log(active), np.log(seconds), 1)[0])


def measure(contact_mesh_um: float) -> Measurement:
    """Slide once for the time and once for the shares."""
    of = study(contact_mesh_um, "rigid")
    problem = contact_problem(of, discretised(of), lambda _stage: None)
    pressed, _ = press(problem, unloaded_state(problem))
    start = time.process_time()
    active, final = _slide(problem, pressed)
    seconds = (time.process_time() - start) / len(DRIVES_um)
    profile = cProfile.Profile()
    with tempfile.TemporaryDirectory() as folder:
        profile.enable()
        _slide(problem, pressed)
        _write(final, Path(folder) / "increment.npz")
        profile.disable()
    return Measurement(contact_mesh_um, active, seconds, shares(profile))


def shares(profile: cProfile.Profile) -> dict[str, float]:
    """Share of PARTS and of output in a profile's total time, and the rest."""
    statistics = pstats.Stats(profile).get_stats_profile()
    total = statistics.total_tt or 1.0
    named = PARTS | {"output": ("bench_scaling.py", "_write")}
    found = {
        part: sum(
            function.cumtime
            for name, function in statistics.func_profiles.items()
            if name == wanted and function.file_name.endswith(file)
        )
        / total
        for part, (file, wanted) in named.items()
    }
    return found | {"rest": 1.0 - sum(found.values())}


def table(measurements: Sequence[Measurement]) -> list[str]:
    """One line for each mesh, and the exponent."""
    parts = list(measurements[0].shares)
    rows = [f"{'mesh [um]':>10}{'nodes':>8}{'ms/increment':>14}" + "".join(f"{part:>19}" for part in parts)]
    rows += [
        f"{one.contact_mesh_um:10.1f}{one.active:8.0f}{1e3 * one.seconds:14.2f}"
        + "".join(f"{100.0 * one.shares[part]:18.1f}%" for part in parts)
        for one in measurements
    ]
    exponent = fitted_exponent([one.active for one in measurements], [one.seconds for one in measurements])
    return [*rows, f"time per increment grows as nodes in contact to the power {exponent:.2f}"]


def _slide(problem: ContactProblem, state: ContactState) -> tuple[float, ContactState]:
    active = []
    for drive in DRIVES_um:
        state, reports = advance(problem, state, 1e-3 * drive, 0.0)
        active.append(reports[-1].active)
    return float(np.mean(active)), state


def _write(state: ContactState, path: Path) -> None:
    np.savez(path, traction=state.traction, primary=state.wear.primary_depth, secondary=state.wear.secondary_depth)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="time per increment against nodes in contact")
    parser.add_argument("--contact-mesh-um", type=float, nargs="+", default=[8.0, 5.0, 3.5])
    options = parser.parse_args()
    if len(options.contact_mesh_um) < 2:
        parser.error("give at least two meshes, such as --contact-mesh-um 8 5")
    print("\n".join(table([measure(mesh) for mesh in options.contact_mesh_um])))
    return 0


if __name__ == "__main__":
    sys.exit(main())
