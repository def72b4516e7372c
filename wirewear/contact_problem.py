"""The contact of a study's wires for scripts that take single increments: meshes, condensation, press and advance."""

from geometry import HexMesh, WireMesh, build_wire
from solvers import ContactProblem, ContactState, IncrementReport, advance, press, unloaded_state
from wirewear.discretisation import Discretisation, discretise
from wirewear.model import contact_problem

__all__ = [
    "ContactProblem",
    "ContactState",
    "Discretisation",
    "HexMesh",
    "IncrementReport",
    "WireMesh",
    "advance",
    "build_wire",
    "contact_problem",
    "discretise",
    "press",
    "unloaded_state",
]
