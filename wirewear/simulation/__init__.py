"""A simulated test of crossed wires: `run_study` does it all; the rest is for those who watch a run or go beneath it.

A run is a `plan` (meshes, steps, milestones) that `cycling` goes through in jumps; `runs` says what is kept of it,
`folder` where. `workbench` has the parts for scripts that press and move wires themselves.
"""

from wirewear.simulation.budget import require_affordable_wires
from wirewear.simulation.contact_forces import mean_pressures
from wirewear.simulation.convergence import WIRES, Converged, converge, convergence_table, last_of, write_convergence
from wirewear.simulation.discretisation import discretise
from wirewear.simulation.observers import Moment, NoObserver, Observer, ProgressBar
from wirewear.simulation.problem import contact_problem
from wirewear.simulation.runs import ObserverOf, run_study, simulate
from wirewear.simulation.workbench import write_meshes

__all__ = [
    "WIRES",
    "Converged",
    "Moment",
    "NoObserver",
    "Observer",
    "ObserverOf",
    "ProgressBar",
    "contact_problem",
    "converge",
    "convergence_table",
    "discretise",
    "last_of",
    "mean_pressures",
    "require_affordable_wires",
    "run_study",
    "simulate",
    "write_convergence",
    "write_meshes",
]
