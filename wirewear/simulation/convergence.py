"""How far a study's results depend on its resolution: the study again with mesh, increments and jumps refined."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil
from pathlib import Path

from rich.table import Table

from wirewear.errors import StudyError
from wirewear.results import RunResult
from wirewear.simulation.discretisation import Discretisation, discretise
from wirewear.simulation.runs import ObserverOf, run_study
from wirewear.study import Study

#: By how much each resolution is refined.
MESH_FACTOR, INCREMENT_FACTOR, TOLERANCE_FACTOR = 1.5, 1.5, 2.0

BASE = "base"

_FIGURES: dict[str, Callable[[RunResult], float]] = {
    "depth of the moving wire [µm]": lambda result: float(result.evolution["max_depth_moving_um"][-1]),
    "depth of the fixed wire [µm]": lambda result: float(result.evolution["max_depth_fixed_um"][-1]),
    "worn volume [10⁻³ mm³]": lambda result: (
        1e3 * float(result.evolution["worn_volume_moving_mm3"][-1] + result.evolution["worn_volume_fixed_mm3"][-1])
    ),
    "slip amplitude δ0 [µm]": lambda result: float(result.evolution["slip_amplitude_um"][-1]),
    "largest tangential force [N]": lambda result: float(result.evolution["max_tangential_force_N"][-1]),
    "energy of the last cycle [mJ]": lambda result: float(result.evolution["dissipated_energy_mJ"][-1]),
}


@dataclass(frozen=True)
class ConvergenceRow:
    """A figure at the end of the run: its value, and its relative change by each refinement."""

    figure: str
    value: float
    changes: dict[str, float]

    @property
    def largest_change(self) -> float:
        """The largest of the changes, without its sign."""
        return max(abs(change) for change in self.changes.values())


def refined_study(study: Study, fidelity: str) -> Study:
    """The study with itself and its three refinements as variants.

    Raises:
        StudyError: the study has variants of its own; choose one of them.
    """
    if study.variant_names:
        raise StudyError(
            f"the study {study.name!r} has the variants {', '.join(study.variant_names)}: choose one with --variant"
        )
    plan = discretise(study, fidelity)
    refinements: dict[str, dict[str, float]] = {
        BASE: {},
        "mesh": _finer_mesh(study, fidelity),
        "increments": _more_increments(study, fidelity, plan),
        "jumps": _shorter_jumps(plan),
    }
    variants = ((name, study.changed({"fidelity": {fidelity: settings}})) for name, settings in refinements.items())
    return replace(study, variants=tuple((name, refined.tables) for name, refined in variants), variant_name="")


def converge(
    study: Study, *, fidelity: str, output: Path, observer_of: ObserverOf | None = None, jobs: int = 1
) -> list[ConvergenceRow]:
    """Run the study and its refinements, each in a folder of OUTPUT (those that are complete stay), and compare."""
    results = run_study(
        refined_study(study, fidelity),
        fidelity=fidelity,
        output=output,
        resume=True,
        observer_of=observer_of,
        jobs=jobs,
    )
    return compared({result.variant: result for result in results})


def compared(results: dict[str, RunResult]) -> list[ConvergenceRow]:
    """The figures of the base run beside those of its refinements."""
    rows = []
    for figure, of in _FIGURES.items():
        value = of(results[BASE])
        changes = {name: of(result) / value - 1.0 if value else 0.0 for name, result in results.items() if name != BASE}
        rows.append(ConvergenceRow(figure, value, changes))
    return rows


def convergence_table(rows: list[ConvergenceRow]) -> Table:
    """The rows as a table for the terminal."""
    shown = Table(title="Change of the last cycle's figures by refinement")
    shown.add_column("figure")
    shown.add_column("value", justify="right")
    factors = {"mesh": MESH_FACTOR, "increments": INCREMENT_FACTOR, "jumps": TOLERANCE_FACTOR}
    for name, factor in factors.items():
        shown.add_column(f"{name} × {factor:g}", justify="right")
    for row in rows:
        shown.add_row(row.figure, f"{row.value:.4g}", *(f"{100.0 * row.changes[name]:+.2f} %" for name in factors))
    return shown


def _finer_mesh(study: Study, fidelity: str) -> dict[str, float]:
    chosen = study.fidelity(fidelity)
    given = {"contact_mesh_um": chosen.contact_mesh_um, "outer_mesh_um": chosen.outer_mesh_um}
    finer = {name: size / MESH_FACTOR for name, size in given.items() if size is not None}
    return {"mesh_refinement": MESH_FACTOR * chosen.mesh_refinement} | finer


def _more_increments(study: Study, fidelity: str, plan: Discretisation) -> dict[str, float]:
    wearing = study.fidelity(fidelity).increments_per_wear_cycle
    given = {"increments_per_cycle": plan.increments_per_cycle, "increments_per_wear_cycle": wearing}
    return {name: 4 * ceil(INCREMENT_FACTOR * n / 4) for name, n in given.items() if n is not None}


def _shorter_jumps(plan: Discretisation) -> dict[str, float]:
    return {"jump_tolerance": plan.jump_tolerance / TOLERANCE_FACTOR}
