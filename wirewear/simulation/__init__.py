"""Simulated tests of any contact: `run_study` runs a study, and the other names are for scripts that go beneath a run.

A run is planned (meshes, steps, milestones) by `point_runs` or `line_runs` and goes through `cycling` in cycle jumps;
`recorded` says what is kept of it, `store` where. `workbench` offers the parts to scripts that press and move bodies
themselves. Beneath plans stand `plan` (meshes of contacts at a point) and `line_model`.
"""

from typing import TYPE_CHECKING

from geometry.lazy import loaded_late

if TYPE_CHECKING:
    from wirewear.simulation.convergence import (
        LINES,
        POINTS,
        Converged,
        converge,
        convergence_table,
        last_of,
        write_convergence,
    )
    from wirewear.simulation.discretisation import discretise
    from wirewear.simulation.line_model import bodies_stiffness_N_per_mm2, line_plan
    from wirewear.simulation.observers import Moment, Observer, ProgressBar
    from wirewear.simulation.point_runs import require_affordable_wires
    from wirewear.simulation.problem import contact_problem
    from wirewear.simulation.runs import ObserverOf, files_of_runs, needed_memory, run_study, simulate
    from wirewear.simulation.traced_bodies import mean_pressures
    from wirewear.simulation.workbench import write_line_meshes, write_meshes

__all__ = [
    "LINES", "POINTS", "Converged", "Moment", "Observer", "ObserverOf", "ProgressBar",
    "bodies_stiffness_N_per_mm2", "contact_problem", "converge", "convergence_table", "discretise", "files_of_runs",
    "last_of", "line_plan", "mean_pressures", "needed_memory", "require_affordable_wires",
    "run_study", "simulate", "write_convergence", "write_line_meshes", "write_meshes",
]  # fmt: skip

__getattr__ = loaded_late(__name__)
