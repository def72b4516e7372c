"""The deck that CalculiX is given."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from studies.benchmarks.calculix_deck import deck, element_sides, holder_node
from studies.benchmarks.crossed_wires import discretised, study
from tests.calculix_cases import sliding
from wirewear.simulation.workbench import (
    WireMesh,
    build_wire,
)


@cache
def wires() -> tuple[WireMesh, WireMesh]:
    meshes = discretised(study(25.0))
    return build_wire(meshes.moving), build_wire(meshes.fixed)


@cache
def text(rig: float | str = 167.0) -> list[str]:
    return deck(*wires(), sliding(rig)).splitlines()


def following(lines: list[str], keyword: str) -> list[str]:
    start = lines.index(keyword) + 1
    end = next(i for i in range(start, len(lines)) if lines[i].startswith("*"))
    return lines[start:end]


def test_the_deck_holds_every_node_and_hexahedron_once() -> None:
    lower, upper = wires()
    assert len(following(text(), "*NODE, NSET=ALL")) == len(lower.mesh.points) + len(upper.mesh.points)
    assert len(following(text(), "*ELEMENT, TYPE=C3D8, ELSET=WIRES")) == len(lower.mesh.cells) + len(upper.mesh.cells)


def test_upper_hexahedra_keep_their_orientation() -> None:
    rows = np.array([[float(x) for x in line.split(",")] for line in following(text(), "*NODE, NSET=ALL")])
    cells = np.array(
        [[int(x) for x in line.split(",")[1:]] for line in following(text(), "*ELEMENT, TYPE=C3D8, ELSET=WIRES")]
    )
    corner = rows[cells - 1, 1:]
    edges = corner[:, [1, 3, 4]] - corner[:, [0]]
    assert np.linalg.det(edges).min() > 0.0


def test_the_upper_grip_follows_the_holder_along_x_and_z() -> None:
    lower, upper = wires()
    holder = holder_node(lower, upper)
    grip = set((upper.mesh.surface_nodes("grip") + len(lower.mesh.points) + 1).tolist()) - {holder}
    equations = [text()[i + 2].split(",") for i, line in enumerate(text()) if line == "*EQUATION"]
    assert {(int(e[0]), int(e[1])) for e in equations} == {(node, axis) for node in grip for axis in (1, 3)}
    assert {int(e[3]) for e in equations} == {holder}


def test_a_compliant_rig_is_a_spring_and_a_rigid_one_a_support() -> None:
    assert following(text(), "*SPRING, ELSET=RIG") == ["1", "167.,0."]
    assert not any(line.startswith("*SPRING") for line in text("rigid"))
    assert text("rigid").count("HOLDER,1,1,0.") == 2


def test_contact_faces_are_those_of_the_patch() -> None:
    lower, _ = wires()
    assert len(following(text(), "*SURFACE, NAME=LOWERFACE, TYPE=ELEMENT")) == len(lower.mesh.surfaces["contact"])


def test_the_contact_pair_and_friction_are_those_asked_for() -> None:
    assert following(text(), "*CONTACT PAIR, INTERACTION=STEELONSTEEL, TYPE=LINMORTAR") == ["UPPERFACE,LOWERFACE"]
    assert following(text(), "*FRICTION") == ["0.62,1e+08"]
    penalty = deck(*wires(), replace(sliding(), method="penalty")).splitlines()
    kind = "*CONTACT PAIR, INTERACTION=STEELONSTEEL, TYPE=SURFACE TO SURFACE"
    assert following(penalty, kind) == ["UPPERFACE,LOWERFACE"]


def test_a_whole_number_of_stiffness_keeps_its_decimal_point() -> None:
    assert following(text(1e4), "*SPRING, ELSET=RIG") == ["1", "10000.,0."]
    assert following(text(2.5e12), "*SPRING, ELSET=RIG") == ["1", "2.5e+12,0."]


def test_a_step_without_increments_is_left_out() -> None:
    both, out_only = (deck(*wires(), replace(sliding(), back=back)) for back in (6, 0))
    assert both.count("*STEP") == 4
    assert out_only.count("*STEP") == 3
    assert "LOWERGRIP,1,1,-0.02" not in out_only


def test_a_facet_of_no_element_is_refused() -> None:
    with pytest.raises(ValueError, match="side of no element"):
        element_sides(np.arange(8)[None], np.array([[0, 1, 2, 6]]))
