"""What a study says of a body from a file that cannot be taken: one sentence each, with what would be right."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from wirewear import StudyError
from wirewear.kinds import load_any_study

STUDY = """
format = 1
name = "own"
kind = "point-contact"
[contact]
friction = 0.6
[conditions]
normal_load_N = 20.0
displacement_amplitude_um = 5.0
frequency_Hz = 10.0
cycles = 2
[bodies.lower]
shape = "flat"
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[bodies.upper]
shape = "mesh"
file = "{file}"
unit = "{unit}"
contact = "{contact}"
held = "{held}"
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
{more}
"""
N = 6  #: Elements along each edge of the block.
Lines = tuple[list[list[float]], list[list[int]]]


def block(height: Callable[[np.ndarray, np.ndarray], np.ndarray], wide: float = 4.0) -> Lines:
    """Nodes and hexahedra of a block on z = 0 with a face of that height."""
    steps = np.linspace(-0.5 * wide, 0.5 * wide, N + 1)
    x, y, share = np.meshgrid(steps, steps, np.linspace(0.0, 1.0, N + 1), indexing="ij")
    number = np.arange((N + 1) ** 3).reshape(x.shape) + 1
    n = number
    corners = [n[:-1, :-1, :-1], n[1:, :-1, :-1], n[1:, 1:, :-1], n[:-1, 1:, :-1]]
    corners += [n[:-1, :-1, 1:], n[1:, :-1, 1:], n[1:, 1:, 1:], n[:-1, 1:, 1:]]
    points = np.stack([x, y, share * height(x, y)], axis=-1).reshape(-1, 3)
    return points.tolist(), np.stack(corners, axis=-1).reshape(-1, 8).tolist()


def ball(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt(100.0 - x**2 - y**2) - 7.0)


def written(folder: Path, lines: Lines, kind: str = "C3D8") -> Path:
    points, cells = lines
    top = [k for k in range(1, len(points) + 1) if k % (N + 1) == 0]
    bottom = [k for k in range(1, len(points) + 1) if k % (N + 1) == 1]
    text = ["*NODE", *(", ".join(map(repr, (k, *point))) for k, point in enumerate(points, 1))]
    for number, nodes in enumerate(cells, 1):
        text += [f"*ELEMENT, TYPE={kind if len(nodes) == 8 else 'C3D6'}, ELSET=body", f"{number}, {str(nodes)[1:-1]}"]
    text += ["*NSET, NSET=face", ", ".join(map(str, top)), "*NSET, NSET=back", ", ".join(map(str, bottom))]
    (file := folder / "own.inp").write_text("\n".join(text), encoding="utf-8")
    return file


def study(folder: Path, file: Path, **stated: str) -> Any:
    named = {"unit": "mm", "contact": "face", "held": "back", "more": ""} | stated
    (path := folder / "study.toml").write_text(STUDY.format(file=file.name, **named), encoding="utf-8")
    return load_any_study(path)


@pytest.mark.parametrize("wide", [4.0, 12.4])
def test_a_ball_of_hexahedra_is_known_by_its_radius(tmp_path: Path, wide: float) -> None:
    _, upper = study(tmp_path, written(tmp_path, block(lambda x, y: 5.0 + ball(x, y), wide))).bodies
    np.testing.assert_allclose(upper.curvatures_per_mm, 0.1, rtol=1e-6)


def test_a_face_that_is_no_barrel_passes_through_the_files_nodes(tmp_path: Path) -> None:
    waved = block(lambda x, y: ball(x, y) + 2e-4 * np.cos(3.0 * x) * np.cos(2.0 * y))
    _, upper = study(tmp_path, written(tmp_path, waved)).bodies
    own = upper.own
    places = own.solid.points[own.nodes]
    np.testing.assert_allclose(own.face.height(places[:, :2]), places[:, 2], atol=1e-9)


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ({"contact": "top"}, "it has no set 'top' of the contact surface, but 'face', 'back'"),
        ({"held": "rear"}, "it has no set 'rear' of the held surface"),
        ({"unit": "m"}, r"unit.*is 'm', by which the body measures 4000 × 4000 × 3000 mm, but its largest extent must"),
        ({"unit": "furlong"}, "unit.*must be"),
        ({"more": "half_width_mm = 3.0"}, "half_width_mm"),
        ({"more": "outward = [0, 0, 0]"}, r"outward.*must be a direction"),
        ({"more": "[bodies.upper.parts.core]\nmaterial = 'steel'"}, "core"),
        ({"held": "face"}, "'face' is in the held set 'face', too"),
        ({"more": "outward = [1, 0, 0]"}, "no face of its set 'face' looks along outward"),
        ({"more": "at_mm = [0, 0, 9]"}, "at_mm lies 6 mm from the nearest node"),
        ({"more": "outward = [0.3, 0, 1]\nat_mm = [0, 0, 3]"}, r"tilted by 1[67].*° .*outward = \["),
        ({"more": "at_mm = [0.5, 0.0, 2.9875]"}, r"tilted by 2.9.*° .*outward = \[0.051, 0, 0.999\]"),
    ],
    ids=[
        "no contact",
        "not held",
        "metres",
        "unknown unit",
        "of a block",
        "no direction",
        "no such part",
        "held",
        "aside",
        "off",
        "tilted",
        "beside the top",
    ],
)
def test_what_does_not_fit_the_file_is_said(tmp_path: Path, stated: dict[str, str], said: str) -> None:
    with pytest.raises(StudyError, match=said) as refused:
        study(tmp_path, written(tmp_path, block(ball)), **stated)
    assert "\n" not in str(refused.value)


def turned(lines: Lines) -> Lines:
    points, cells = lines
    return points, [[*cell[4:], *cell[:4]] for cell in cells]


def flattened(lines: Lines) -> Lines:
    points, cells = lines
    points[cells[0][6] - 1] = points[cells[0][0] - 1]
    return points, cells


def torn(lines: Lines) -> Lines:
    points, cells = lines
    first = len(points)
    points += [[x + 50.0, y, z] for x, y, z in (points[k - 1] for k in cells[0])]
    return points, [*cells, list(range(first + 1, first + 9))]


def slit(lines: Lines) -> Lines:
    points, cells = lines
    points.append(list(points[cells[0][6] - 1]))
    cells[0][6] = len(points)
    return points, cells


def refined(lines: Lines) -> Lines:
    """Cut the first element in two, so that its new nodes hang on its neighbours' edges."""
    points, cells = lines
    low, high = cells[0][:4], cells[0][4:]
    new = [len(points) + k for k in range(1, 5)]
    points += [
        [0.5 * (a + b) for a, b in zip(points[i - 1], points[k - 1], strict=True)]
        for i, k in zip(low, high, strict=True)
    ]
    return points, [[*low, *new], [*new, *high], *cells[1:]]


def split(lines: Lines) -> Lines:
    """Cut the first element in two prisms, which the one above meets in a quadrilateral."""
    points, ((a, b, c, d, e, f, g, h), *cells) = lines
    return points, [[a, b, c, e, f, g], [a, c, d, e, g, h], *cells]


@pytest.mark.parametrize(
    ("spoiled", "said"),
    [
        (split(block(ball)), "1 in all, the first at .*, have two triangles on their other side"),
        (
            refined(block(ball)),
            r"[23] of its nodes lie in or on the faces of elements that do not have them, the first at",
        ),
        (turned(block(ball)), "turned inside out"),
        (flattened(block(ball)), "inside out|without volume"),
        (torn(block(ball)), "consists of 2 parts that share no nodes"),
        (block(lambda x, y: 5.0 + 0.02 * (x**2 + y**2)), "hollow"),
        (block(lambda x, y: np.exp(-0.5 * (x**2 + y**2)) + 1.0), "is too coarse under the contact"),
        (([[0.0, 0.0, 0.0]] * 7, []), "no solid elements"),
        (slit(block(ball)), "2 of its nodes coincide in pairs, the first at"),
        ((block(ball)[0], 2 * block(ball)[1]), "belong to three elements or more"),
        (block(lambda x, _: 3.0 - 0.8 * np.abs(x)), "none on an edge"),
        (([[0.0, 0.0]], []), "node 1 has 2 coordinates"),
    ],
    ids=[
        "split face",
        "hanging nodes",
        "inverted",
        "degenerate",
        "two parts",
        "hollow",
        "too coarse",
        "no elements",
        "slit",
        "twice",
        "edge",
        "cut short",
    ],
)
def test_a_bad_mesh_is_refused_in_one_sentence(tmp_path: Path, spoiled: Lines, said: str) -> None:
    with pytest.raises(StudyError, match=said) as refused:
        study(tmp_path, written(tmp_path, spoiled))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("replaced", "by"),
    [
        ("*NODE", "*Part, name=Ball\n*Node"),
        ("*NSET, NSET=face\n", "*NSET, NSET=face, INSTANCE=Ball-1\nBall-1."),
        ("NSET=face", 'NSET="face"'),
        ("-2.0, -2.0, 0.0", "-2.0D0, -0.2d+01, 0.0"),
    ],
    ids=["part", "instance", "quoted", "Fortran"],
)
def test_dialects_of_abaqus_files_are_read(tmp_path: Path, replaced: str, by: str) -> None:
    file = written(tmp_path, block(lambda x, y: 5.0 + ball(x, y)))
    assert replaced in file.read_text()
    other = file.with_name("other.INP")
    other.write_text(file.read_text().replace(replaced, by))
    _, upper = study(tmp_path, other).bodies
    np.testing.assert_allclose(upper.curvatures_per_mm, 0.1, rtol=1e-6)


@pytest.mark.parametrize(
    ("added", "said"),
    [
        ("*NODE\n1, 0., 0., 9.", "two different nodes 1, as where a file holds several parts"),
        ("*ELEMENT, TYPE=C3D8\n1, 8, 7, 6, 5, 4, 3, 2, 1", "two different elements 1"),
        ("*INCLUDE, INPUT=rest.inp", "from the file rest.inp"),
        ("*NSET\n1, 2, 3", "has no name: give it after NSET="),
        ("*NSET, NSET=more, INPUT=set.txt", "from the file set.txt"),
    ],
)
def test_abaqus_files_of_several_parts_or_files_or_without_names_are_refused(
    tmp_path: Path, added: str, said: str
) -> None:
    file = written(tmp_path, block(ball))
    file.write_text(f"{file.read_text()}\n{added}\n")
    with pytest.raises(StudyError, match=said):
        study(tmp_path, file)


def test_a_file_that_is_no_mesh_is_refused(tmp_path: Path) -> None:
    (file := tmp_path / "own.stl").write_text("solid", encoding="utf-8")
    with pytest.raises(StudyError, match=r"must be gmsh's \.msh or Abaqus' \.inp"):
        study(tmp_path, file)
    with pytest.raises(StudyError, match=re.escape("cannot be read (No such file or directory)")):
        study(tmp_path, tmp_path / "none.msh")
