"""A simulated test of a contact at a point: `run_study` does it all; the rest is for those who go beneath a run.

A run is a `plan` (meshes, steps, milestones) that `cycling` goes through in jumps; `runs` says what is kept of it,
`folder` where. `workbench` has the parts for scripts that press and move bodies themselves.
"""

from wirewear.simulation.contact_forces import mean_pressures
from wirewear.simulation.convergence import (
    Converged,
    converge,
    convergence_table,
    last_of,
    point_contact,
    write_convergence,
)
from wirewear.simulation.discretisation import discretise
from wirewear.simulation.observers import Moment, NoObserver, Observer, ProgressBar
from wirewear.simulation.plan import require_affordable_wires
from wirewear.simulation.problem import contact_problem
from wirewear.simulation.runs import ObserverOf, run_study, simulate
from wirewear.simulation.workbench import write_meshes

__all__ = [
    "Converged", "Moment", "NoObserver", "Observer", "ObserverOf", "ProgressBar", "contact_problem", "converge",
    "convergence_table", "discretise", "last_of", "mean_pressures", "point_contact", "require_affordable_wires",
    "run_study", "simulate", "write_convergence", "write_meshes",
]  # fmt: skip
