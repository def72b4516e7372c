"""CalculiX input of two crossed wires on wirewear's own meshes: the same nodes, hexahedra, grips and holder.

The upper wire's grip moves as one along x (against the rig's spring) and z (under the load); the lower wire's grip is
driven along x. Steps: a prescribed approach, which finds the contact; the normal load; out to +amplitude; back to
-amplitude.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wirewear.simulation.workbench import BodyMesh

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

ContactMethod = Literal["linmortar", "penalty"]

#: CalculiX's name of a contact method, its pressure-overclosure and its stick slope, both in MPa/mm.
CONTACT: dict[ContactMethod, tuple[str, float, float]] = {
    "linmortar": ("LINMORTAR", 1e9, 1e8),
    "penalty": ("SURFACE TO SURFACE", 1e8, 1e7),
}

# Sides S1 to S6 of a C3D8 as positions of its nodes (CalculiX manual, *SURFACE).
_SIDES = np.array([[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]])


@dataclass(frozen=True)
class CalculixTest:
    """What is done to the wires, in N, mm and MPa.

    approach_mm: prescribed in the first step, about what the load will bring.
    out, back: increments of the two sliding steps; no increments, no step.
    """

    normal_load_N: float
    approach_mm: float
    amplitude_mm: float
    out: int
    back: int
    friction: float
    rig_stiffness_N_per_mm: float | Literal["rigid"]
    youngs_modulus_MPa: float
    poissons_ratio: float
    method: ContactMethod = "linmortar"


def upper_points(points: Array) -> Array:
    """A wire's points (n, 3) in its own frame, turned face down with its axis along y: (x, y, z) -> (y, x, -z)."""
    return np.asarray(points[:, [1, 0, 2]] * np.array([1.0, 1.0, -1.0]))


def element_sides(cells: IntArray, facets: IntArray) -> list[tuple[int, int]]:
    """Element (from 0) and side (1 to 6) of each facet (k, 4); ValueError when one belongs to no element."""
    sides = np.sort(cells[:, _SIDES], axis=2)
    found = {tuple(nodes): (i, j + 1) for i, element in enumerate(sides.tolist()) for j, nodes in enumerate(element)}
    wanted = [tuple(nodes) for nodes in np.sort(facets, axis=1).tolist()]
    if missing := [nodes for nodes in wanted if nodes not in found]:
        raise ValueError(f"the facet of nodes {missing[0]} is a side of no element")
    return [found[nodes] for nodes in wanted]


def holder_node(lower: BodyMesh, upper: BodyMesh) -> int:
    """Number of the node that stands for the upper wire's holder."""
    return len(lower.mesh.points) + 1 + int(upper.mesh.surface_nodes("grip")[0])


def deck(lower: BodyMesh, upper: BodyMesh, test: CalculixTest) -> str:
    """The whole input file."""
    return "\n".join([*_model(lower, upper, test), *_steps(test)]) + "\n"


def _model(lower: BodyMesh, upper: BodyMesh, test: CalculixTest) -> Iterator[str]:
    first_node, first_cell = len(lower.mesh.points), len(lower.mesh.cells)
    points = np.vstack([lower.mesh.points, upper_points(upper.mesh.points)])
    cells = np.vstack([lower.mesh.cells, upper.mesh.cells + first_node])
    yield "*NODE, NSET=ALL"
    yield from (f"{i},{x:.12g},{y:.12g},{z:.12g}" for i, (x, y, z) in enumerate(points.tolist(), 1))
    yield "*ELEMENT, TYPE=C3D8, ELSET=WIRES"
    yield from (",".join(map(str, [i, *nodes])) for i, nodes in enumerate((cells + 1).tolist(), 1))
    grip = upper.mesh.surface_nodes("grip") + first_node + 1
    holder = holder_node(lower, upper)
    yield from _set("NSET", "LOWERGRIP", lower.mesh.surface_nodes("grip") + 1)
    yield from _set("NSET", "UPPERGRIP", grip)
    yield from _set("NSET", "HOLDER", [holder])
    yield from _set("NSET", "UPPERPATCH", upper.patch.nodes.ravel() + first_node + 1)
    for name, wire, before in (("LOWERFACE", lower, 0), ("UPPERFACE", upper, first_cell)):
        yield f"*SURFACE, NAME={name}, TYPE=ELEMENT"
        sides = element_sides(wire.mesh.cells, wire.mesh.surfaces["contact"])
        yield from (f"{before + element + 1},S{side}" for element, side in sides)
    yield from ("*MATERIAL, NAME=STEEL", "*ELASTIC", f"{test.youngs_modulus_MPa:.10g},{test.poissons_ratio:.10g}")
    yield "*SOLID SECTION, ELSET=WIRES, MATERIAL=STEEL"
    for node in grip[grip != holder].tolist():
        for direction in (1, 3):
            yield from ("*EQUATION", "2", f"{node},{direction},1.,{holder},{direction},-1.")
    if test.rig_stiffness_N_per_mm != "rigid":
        yield from ("*ELEMENT, TYPE=SPRING1, ELSET=RIG", f"{len(cells) + 1},{holder}")
        # CalculiX wants both numbers here, with their decimal points.
        yield from ("*SPRING, ELSET=RIG", "1", f"{_real(test.rig_stiffness_N_per_mm)},0.")
    kind, stiffness, stick_slope = CONTACT[test.method]
    yield "*SURFACE INTERACTION, NAME=STEELONSTEEL"
    yield from ("*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{stiffness:g}")
    yield from ("*FRICTION", f"{test.friction:g},{stick_slope:g}")
    yield from (f"*CONTACT PAIR, INTERACTION=STEELONSTEEL, TYPE={kind}", "UPPERFACE,LOWERFACE")
    yield from ("*BOUNDARY", "LOWERGRIP,1,3,0.", "UPPERGRIP,2,2,0.")
    if test.rig_stiffness_N_per_mm == "rigid":
        yield "HOLDER,1,1,0."


def _steps(test: CalculixTest) -> Iterator[str]:
    amplitude = f"{test.amplitude_mm:.10g}"
    rigid = test.rig_stiffness_N_per_mm == "rigid"
    held = ["*BOUNDARY, OP=NEW", "LOWERGRIP,2,3,0.", "UPPERGRIP,2,2,0.", *(["HOLDER,1,1,0."] if rigid else [])]
    load = ["*CLOAD", f"HOLDER,3,{-test.normal_load_N:.10g}"]
    yield from _step(1, ["*BOUNDARY", f"HOLDER,3,3,{-test.approach_mm:.10g}"])
    yield from _step(1, [*held, "LOWERGRIP,1,1,0.", *load])
    for increments, drive in ((test.out, amplitude), (test.back, f"-{amplitude}")):
        if increments:
            yield from _step(increments, ["*BOUNDARY", f"LOWERGRIP,1,1,{drive}"])


def _step(increments: int, conditions: Iterable[str]) -> Iterator[str]:
    size = f"{1.0 / increments:.10f}"
    yield from ("*STEP, NLGEOM, INC=200", "*STATIC", f"{size},1.,1e-5,{size}", *conditions)
    yield from ("*NODE PRINT, NSET=HOLDER", "U", "*NODE PRINT, NSET=LOWERGRIP, TOTALS=ONLY", "RF")
    yield from ("*CONTACT FILE", "CDIS,CSTR", "*END STEP")


def _real(value: float) -> str:
    """A number with its decimal point, as the first field of a data line must have."""
    text = f"{value:.10g}"
    return text if {".", "e"} & set(text) else f"{text}."


def _set(kind: str, name: str, numbers: IntArray | list[int]) -> Iterator[str]:
    yield f"*{kind}, {kind}={name}"
    values = np.asarray(numbers).tolist()
    yield from (",".join(map(str, values[i : i + 12])) for i in range(0, len(values), 12))
