"""How largest pressures of the worn contact depend on jumps and mesh: at single nodes, and as means over a length.

Usage: python -m studies.mccoll2004.pressures [--cycles 10000] [--fidelity quick]

At the ends of the stroke the pad's edge meets the wall of the flat's scar, in a crest as narrow as an element. All
are the largest over the recorded positions of the last cycle.
"""

from __future__ import annotations

from pathlib import Path
from typing import cast

import click

from wirewear.cli.study_kinds import load_any_study
from wirewear.planar import PlanarStudy, run_planar_study
from wirewear.planar.results import PlanarResult
from wirewear.results import largest_mean_pressure_MPa
from wirewear.study.fidelity import FIDELITIES
from wirewear.study_script import StudyScript

STUDY = Path(__file__).parent / "study.toml"
OVER_um = (20.0, 30.0, 50.0)
#: Jump tolerance and refinement of the mesh.
CASES = ((0.15, 1), (0.07, 1), (0.03, 1), (0.07, 2))


def pressures(result: PlanarResult, cycle: int) -> list[float]:
    """At a node, and means over the lengths, of the pad."""
    (forces,) = (one for one in result.forces if one.body == "pad" and one.cycle == cycle)
    (profile,) = (one for one in result.profiles if one.body == "pad" and one.cycle == cycle)
    places = profile.x_um[forces.nodes.astype(int)]
    means = [largest_mean_pressure_MPa(places, forces.force_N_per_mm[:, :, 2], over) for over in OVER_um]
    return [float(result.evolution["max_pressure_MPa"][-1]), *means]


def study_of(cycles: int, tolerance: float, refinement: int) -> PlanarStudy:
    """The study with these jumps and this mesh, which keeps its contact forces."""
    study = cast("PlanarStudy", load_any_study(STUDY))
    mesh = study.mesh.model_copy(update={"jump_tolerance": tolerance, "mesh_refinement": refinement})
    conditions = study.conditions.model_copy(update={"cycles": cycles})
    log = study.log.model_copy(update={"contact_states": 64, "loop_cycles": (cycles,)})
    return study.model_copy(update={"mesh": mesh, "conditions": conditions, "log": log})


@click.command(cls=StudyScript)
@click.option("--cycles", type=click.IntRange(1), default=10_000, show_default=True)
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="quick", show_default=True)
def main(cycles: int, fidelity: str) -> None:
    """Print how the largest pressures of the worn contact depend on jumps and mesh."""
    for tolerance, refinement in CASES:
        result = run_planar_study(study_of(cycles, tolerance, refinement), fidelity=fidelity)
        node, *means = pressures(result, cycles)
        told = ", ".join(f"{mean:.0f} over {over:g} µm" for mean, over in zip(means, OVER_um, strict=True))
        click.echo(f"jump tolerance {tolerance:g}, mesh × {refinement}: {node:.0f} MPa at a node, {told}")


if __name__ == "__main__":
    main()
