"""A run as another program's input: the bodies that were worn, in touch, held and moved as in the test."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from geometry import HexMesh
from tests.simulation.test_yielding_runs import wires
from tests.stress.interior_runs import CYCLE, LOAD_N, DEPTH_um, run_with_forces
from wirewear.base.errors import ResultError
from wirewear.stress.bodies import meshed_body
from wirewear.stress.deck import write_deck

pytestmark = pytest.mark.seconds


def blocks(path: Path) -> dict[str, list[list[str]]]:
    """Data lines of a deck by their keyword line; of those that come twice, one after the other."""
    found: dict[str, list[list[str]]] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            latest = found.setdefault(line, [])
        else:
            latest.append([word.strip() for word in line.split(",")])
    return found


@pytest.mark.parametrize("dialect", ["abaqus", "calculix"])
def test_a_deck_holds_both_worn_bodies_in_touch_and_moves_them_as_the_test_does(tmp_path: Path, dialect: str) -> None:
    run = replace(run_with_forces(), study=wires().resolved())
    deck = blocks(write_deck(run, tmp_path / "worn.inp", CYCLE, dialect))
    points = np.array(deck["*NODE, NSET=ALL"], dtype=float)
    assert np.array_equal(points[:, 0], 1 + np.arange(len(points)))
    fixed, moving = (meshed_body(run, run.forces(CYCLE, name)).mesh for name in ("fixed", "moving"))
    assert len(points) == len(fixed.points) + len(moving.points) + 2
    upper = np.array(deck["*ELEMENT, TYPE=C3D8, ELSET=MOVING"], dtype=int)
    mesh = HexMesh(points[:, 1:], upper[:, 1:] - 1, {})
    assert mesh.scaled_jacobians().min() == pytest.approx(moving.scaled_jacobians().min(), abs=1e-6)
    heights = {}
    for name, body, facing in (("MOVING", moving, 1.0), ("FIXED", fixed, -1.0)):
        cells = {int(number): corners for number, *corners in deck[f"*ELEMENT, TYPE=C3D8, ELSET={name}"]}
        sides = deck[f"*SURFACE, NAME=CONTACT_{name}, TYPE=ELEMENT"]
        assert len(sides) == len(body.surfaces["contact"])
        for number, side in sides:
            corners = points[np.array(cells[int(number)], dtype=int) - 1, 1:][HexMesh.SIDES[int(side[1]) - 1]]
            assert facing * np.cross(corners[2] - corners[0], corners[3] - corners[1])[2] > 0.0
        worn = points[[int(number) - 1 for number, _ in deck[f"*NSET, NSET=WORN_{name}"]], 1:]
        heights[name] = worn[np.hypot(*worn[:, :2].T) < 1e-9, 2].item()
    # Crossed wires that are worn most in the middle do not touch there.
    assert 0.0 < 1e3 * (heights["FIXED"] - heights["MOVING"]) <= 2.0 * DEPTH_um
    assert 1e3 * heights["MOVING"] == pytest.approx(-DEPTH_um, rel=0.02)
    (load,) = deck["*CLOAD"]
    assert float(load[2]) == pytest.approx(-LOAD_N)
    assert meshio.read(tmp_path / "worn.inp").points.shape[1] == 3


@pytest.mark.parametrize(
    ("words", "tables"),
    [
        ("a holder that turns", {"holder": {"rotational_stiffness_N_mm_per_rad": 1e4, "pivot_height_mm": 9.0}}),
        ("bulk stress", {"wires": {"moving": {"bulk": {"axial_stress_MPa": 100.0}}}}),
        (
            "coats of their own modulus",
            {
                "wires": {
                    "moving": {"layers": [{"thickness_um": 2.0, "youngs_modulus_MPa": 4e5, "poissons_ratio": 0.2}]}
                }
            },
        ),
        ("elastic grips", {"wires": {"grip_stiffness_N_per_mm3": 1e5}}),
        (
            "shear-limited friction",
            {"contact": {"friction_law": {"name": "shear-limited", "shear_strength_MPa": 900.0}}},
        ),
    ],
)
def test_what_a_deck_cannot_state_is_refused_in_a_sentence(tmp_path: Path, words: str, tables: dict[str, Any]) -> None:
    with pytest.raises(ResultError, match=f"a deck cannot state {words}: export"):
        write_deck(replace(run_with_forces(), study=wires(**tables).resolved()), tmp_path / "worn.inp", CYCLE, "abaqus")
    assert not list(tmp_path.iterdir())
