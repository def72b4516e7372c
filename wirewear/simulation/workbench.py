"""A study's wires for scripts that go beneath a whole run: meshes, stiffness, condensation, single increments."""

from geometry import Elastic, HexMesh, WireMesh, build_wire
from solvers import (
    ContactProblem,
    ContactState,
    IncrementReport,
    advance,
    closed_cycle,
    first_quarter,
    press,
    run_cycle,
    unloaded_state,
)
from solvers.condensation import compliance_of, piece_to_condense
from solvers.elasticity import stiffness_matrix
from solvers.substructuring import schur_complement, schur_complements
from wirewear.simulation.discretisation import Discretisation, discretise
from wirewear.simulation.problem import contact_problem

__all__ = [
    "ContactProblem",
    "ContactState",
    "Discretisation",
    "Elastic",
    "HexMesh",
    "IncrementReport",
    "WireMesh",
    "advance",
    "build_wire",
    "closed_cycle",
    "compliance_of",
    "contact_problem",
    "discretise",
    "first_quarter",
    "piece_to_condense",
    "press",
    "run_cycle",
    "schur_complement",
    "schur_complements",
    "stiffness_matrix",
    "unloaded_state",
]
