"""Ways of computing the same wear beside each other: explicit and implicit updates, offset surfaces and moved nodes.

Usage: python -m studies.benchmarks.bench_wear_paths [--explicit-jump 10] [--fidelity quick] [--no-full] [--output DIR]

The steel wires on the compliant rig, 1 000 cycles: implicit, implicit with short jumps, explicit with jumps of
--explicit-jump cycles, and with nodes moved into the worn surface at every jump. Then, unless --no-full, all 100 000
cycles as an offset and with nodes moved every 2 µm. Differences of depth are those along the section in the direction
of motion through the middle of the fixed and the moving wire's scar, relative to the largest depth. Runs that are
complete in the output folder stay.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np
from rich.table import Table

from studies.study_script import StudyScript
from wirewear import RunResult, Study, load_study, run_study
from wirewear.app.cli.consoles import wide_console
from wirewear.base.writing import prepared_folder
from wirewear.test.fidelity import FIDELITIES

STUDY = Path(__file__).parents[1] / "steel_wires" / "study.toml"
SHORT = 1_000
JUMP_TOLERANCE = 0.02  #: For jumps whose error is small against one per cent.


def study_with(
    cycles: int,
    mesh: dict[str, object] | None = None,
    wear: dict[str, object] | None = None,
    jump_tolerance: float | None = None,
) -> Study:
    """The steel wires on the compliant rig with some keys changed, on one mesh for the whole run."""
    study = load_study(STUDY).variant("compliant")
    changes: dict[str, Any] = {
        "conditions": {"cycles": cycles},
        "log": {"loop_cycles": (cycles,)},
        "mesh": {"follow_scar": False, **(mesh or {})},
        "wear": wear or {},
    }
    if jump_tolerance is not None:
        changes["fidelity"] = {name: {"jump_tolerance": jump_tolerance} for name in FIDELITIES}
    return replace(study.changed(changes), variant_name="")


def depth_difference(one: RunResult, other: RunResult, wire: str) -> float:
    """Largest difference of depth along the motion over the largest depth of the other."""
    cycle = other.scar_cycles()[-1]
    x, expected = other.scar(cycle, wire).section_along_motion()
    found = one.scar(cycle, wire).depth_at(x, 0.0)
    return float(abs(found - expected).max() / expected.max())


@click.command(cls=StudyScript)
@click.option("--explicit-jump", type=click.IntRange(1), default=10, show_default=True, help="Cycles.")
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="quick", show_default=True)
@click.option("--no-full", is_flag=True, help="Leave out the runs to the study's last cycle.")
@click.option("--output", type=click.Path(path_type=Path), default=Path("runs/wear_paths"), show_default=True)
def main(explicit_jump: int, fidelity: str, no_full: bool, output: Path) -> None:
    """Run the ways of computing the same wear, compare them and print."""
    prepared_folder(output)
    cases = {
        "implicit": study_with(SHORT),
        "implicit_short_jumps": study_with(SHORT, jump_tolerance=JUMP_TOLERANCE),
        "explicit": study_with(SHORT, wear={"update": "explicit", "explicit_jump_cycles": explicit_jump}),
        "moved": study_with(SHORT, mesh={"move_nodes_every_um": 0.0}),
    }
    if not no_full:
        full = load_study(STUDY).conditions.cycles
        cases["offset_to_the_end"] = study_with(full)
        cases["moved_to_the_end"] = study_with(full, mesh={"move_nodes_every_um": 2.0})
    results = {}
    for name, study in cases.items():
        click.echo(f"running: {name}")
        folder = output / fidelity / name
        (results[name],) = run_study(study, fidelity=fidelity, output=folder, resume=True)
    wide_console(150).print(difference_table(results))


def difference_table(results: dict[str, RunResult]) -> Table:
    """Differences between the runs, as a table."""
    pairs = [
        ("explicit", "implicit_short_jumps"),
        ("implicit", "implicit_short_jumps"),
        ("moved", "implicit"),
        ("moved_to_the_end", "offset_to_the_end"),
    ]
    table = Table(title="Differences in per cent")
    columns = ("max_depth_fixed_um", "max_depth_moving_um", "slip_amplitude_um", "max_tangential_force_N")
    for heading in ("runs", "cycles", "profile, fixed", "profile, moving", *columns, "worst scaled Jacobian"):
        table.add_column(heading, justify="right")
    for one, other in pairs:
        if one not in results:
            continue
        found, expected = results[one], results[other]
        last = [100.0 * (found.evolution[name][-1] / expected.evolution[name][-1] - 1.0) for name in columns]
        changes = found.settings["mesh_changes"]
        worst = min((c["smallest_scaled_jacobian"] for c in changes if "smallest_scaled_jacobian" in c), default=np.nan)
        table.add_row(
            f"{one} – {other}",
            f"{expected.scar_cycles()[-1]}",
            *(f"{100.0 * depth_difference(found, expected, wire):.2f}" for wire in ("fixed", "moving")),
            *(f"{value:+.2f}" for value in last),
            f"{worst:.2f}",
        )
    return table


if __name__ == "__main__":
    raise SystemExit(main())
