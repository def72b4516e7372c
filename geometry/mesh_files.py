"""Meshes of solid bodies read from files: gmsh's .msh, read by gmsh, and Abaqus' .inp."""

import re
from collections.abc import Iterable, Iterator
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from geometry.body import gmsh_session
from geometry.elements import ELEMENT_KINDS
from geometry.errors import GeometryError
from geometry.solid import SolidMesh

FORMATS = (".msh", ".inp")
MATRICES = (".npz", ".mtx")  #: Of condensed stiffnesses, see `stiffness_files`.
#: Solid elements of Abaqus by their names' beginnings; what follows (R, I, H, T …) is how they are integrated.
_ABAQUS = {"C3D20": 20, "C3D15": 15, "C3D10": 10, "C3D8": 8, "C3D6": 6, "C3D4": 4, "C3D27": 27}
_PYRAMIDS = "pyramids are not among hexahedra, tetrahedra and prisms"
#: Faces that Abaqus numbers from 1, as those of `ElementKind.faces`.
_ABAQUS_FACES = {8: (0, 1, 2, 3, 4, 5), 4: (0, 1, 2, 3), 6: (0, 1, 2, 3, 4)}
_READ = ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE")  #: Keywords of Abaqus that are read.
_MOST_BYTES = 500_000_000


@lru_cache(maxsize=4)
def read_solid(path: str, digest: str, mm_per_unit: float) -> SolidMesh:
    """The mesh in a .msh or .inp file, checked; coordinates are multiplied by mm_per_unit. The last four are kept.

    digest: SHA-256 that the file's contents must have. Raises GeometryError, in one sentence, if the file holds no
    mesh, the mesh is not sound, or the contents have changed.
    """
    file = Path(path)
    found = digest_of(path)
    if found != digest:
        raise GeometryError(f"the mesh {file.name} is not the file that it was: put the one back that was read before")
    try:
        mesh = _of_gmsh(file, mm_per_unit) if file.suffix.lower() == ".msh" else _of_abaqus(file, mm_per_unit)
        mesh.require_sound()
    except GeometryError as problem:
        raise GeometryError(f"the mesh {file.name} cannot be taken: {problem}") from None
    return mesh


def digest_of(path: str) -> str:
    """SHA-256 of a file's contents, of a .mtx with its .csv. Raises GeometryError if it cannot be read, is larger than
    500 MB, or has no known ending.
    """
    file = Path(path)
    if file.suffix.lower() not in (*FORMATS, *MATRICES):
        raise GeometryError(f"{file.name} must be gmsh's .msh or Abaqus' .inp, or of a stiffness .npz or .mtx")
    try:
        if file.stat().st_size > _MOST_BYTES:
            raise GeometryError(
                f"{file.name} is larger than {_MOST_BYTES // 1_000_000} MB: mesh the body more coarsely"
            )
        table = file.with_suffix(".csv").read_bytes() if file.suffix.lower() == ".mtx" else b""
        return sha256(file.read_bytes() + table).hexdigest()
    except OSError as problem:
        reason = problem.strerror or type(problem).__name__
        raise GeometryError(
            f"the mesh {file} cannot be read ({reason}): give the name of a file that is there"
        ) from None


def _assembled(
    points: Array, cells: dict[int, IntArray], sets: dict[str, IntArray], parts: dict[str, dict[int, BoolArray]]
) -> SolidMesh:
    """The mesh without nodes that belong to no cell. Raises GeometryError if there is no cell, or a node is missing."""
    if not cells:
        raise GeometryError("it holds no solid elements: fill its surface with hexahedra, tetrahedra or prisms")
    if not np.isfinite(points).all():
        raise GeometryError("a coordinate of its nodes is not finite")
    used = np.unique(np.concatenate([each.ravel() for each in cells.values()]))
    if used[0] < 0 or used[-1] >= len(points):
        raise GeometryError("an element has a node that the file does not list")
    number = np.full(len(points), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    kept = {name: np.unique(number[nodes][number[nodes] >= 0]) for name, nodes in sets.items()}
    return SolidMesh(points[used], {count: number[each] for count, each in cells.items()}, kept, parts)


def _of_gmsh(file: Path, mm_per_unit: float) -> SolidMesh:
    with gmsh_session() as gmsh:
        try:
            gmsh.merge(str(file))
        except Exception as problem:  # noqa: BLE001 - gmsh raises no other
            raise GeometryError(f"gmsh does not read it ({str(problem).splitlines()[0]})") from None
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        if not len(tags):
            raise GeometryError("it holds no nodes: save the mesh, and not the geometry alone")
        row = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
        row[tags.astype(np.int64)] = np.arange(len(tags))
        cells: dict[int, list[IntArray]] = {}
        where: dict[int, list[tuple[int, slice]]] = {}  # Of each volume: kinds, and which of their cells.
        for _, volume in gmsh.model.getEntities(3):
            types, _, nodes = gmsh.model.mesh.getElements(3, volume)
            for kind, of_kind in zip(types, nodes, strict=True):
                order = _order(gmsh, int(kind))
                one = row[of_kind.astype(np.int64)].reshape(-1, len(order))[:, order]
                blocks = cells.setdefault(len(order), [])
                before = sum(map(len, blocks))
                blocks.append(one)
                where.setdefault(volume, []).append((len(order), slice(before, before + len(one))))
        joined = {count: np.vstack(each) for count, each in cells.items()}
        sets: dict[str, IntArray] = {}
        parts: dict[str, dict[int, BoolArray]] = {}
        for dimension, tag in gmsh.model.getPhysicalGroups():
            name = gmsh.model.getPhysicalName(dimension, tag) or str(tag)
            nodes, _ = gmsh.model.mesh.getNodesForPhysicalGroup(dimension, tag)
            sets[name] = np.union1d(sets.get(name, np.zeros(0, dtype=np.int64)), row[nodes.astype(np.int64)])
            if dimension == 3:
                parts[name] = {count: np.zeros(len(each), dtype=bool) for count, each in joined.items()}
                for volume in gmsh.model.getEntitiesForPhysicalGroup(3, tag):
                    for count, which in where.get(int(volume), []):
                        parts[name][count][which] = True
    return _assembled(mm_per_unit * coordinates.reshape(-1, 3), joined, sets, parts)


def _order(gmsh: Any, kind: int) -> IntArray:
    """For each node of this program's element kind, its index among gmsh's nodes. GeometryError for an unsupported
    kind.
    """
    name, _, _, count, local, _ = gmsh.model.mesh.getElementProperties(kind)
    ours = ELEMENT_KINDS.get(count)
    if ours is None or "Pyramid" in name:
        raise GeometryError(f"it holds elements of the kind {name}: mesh with hexahedra, tetrahedra or prisms")
    away = np.linalg.norm(local.reshape(-1, 3)[None] - ours.nodes[:, None], axis=2)
    return np.asarray(away.argmin(axis=1))


def _of_abaqus(file: Path, mm_per_unit: float) -> SolidMesh:
    reader = _Abaqus()
    try:
        text = file.read_text(encoding="utf-8", errors="replace")
        for keyword, options, lines in _blocks(text):
            reader.take(keyword, options, lines)
    except KeyError as problem:
        raise GeometryError(f"one of its sets or surfaces has no name: give it after {problem.args[0]}=") from None
    except (ValueError, IndexError) as problem:
        raise GeometryError(f"it is not written as Abaqus' input files are ({problem})") from None
    return reader.mesh(mm_per_unit)


def _blocks(text: str) -> Iterator[tuple[str, dict[str, str], list[list[str]]]]:
    """Keywords of an Abaqus file in capitals, each with its options and lines of data; continued lines are joined."""
    lines = [line.strip() for line in text.splitlines()]
    lines = [line for line in lines if line and not line.startswith("**")]
    starts = [k for k, line in enumerate(lines) if line.startswith("*")]
    if not starts:
        raise ValueError("no line begins with a keyword such as *NODE")
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        keyword, *options = [part.strip() for part in lines[start][1:].split(",")]
        pairs = [option.partition("=") for option in options if option]
        data = "\n".join(lines[start + 1 : end])
        data = re.sub(r",\s*\n", ",", data) if keyword.upper() == "ELEMENT" else data
        values = [[value.strip(' \t"') for value in line.split(",") if value.strip()] for line in data.splitlines()]
        yield keyword.upper(), {key.strip().upper(): value.strip(' "') for key, _, value in pairs}, values


class _Abaqus:
    """The contents of an Abaqus input file of one part, as far as it has been read."""

    def __init__(self) -> None:
        self.nodes: dict[int, int] = {}
        self.places: list[list[float]] = []
        self.elements: dict[int, tuple[int, list[int]]] = {}  # Number of nodes and the nodes, solids only.
        self.facets: dict[int, list[int]] = {}  # Of shells, which stand for parts of a surface.
        self.node_sets: dict[str, set[int]] = {}
        self.cell_sets: dict[str, set[int]] = {}
        self.faces: dict[str, list[tuple[str, str]]] = {}

    def take(self, keyword: str, options: dict[str, str], lines: list[list[str]]) -> None:
        """Store nodes, elements, sets or surfaces of a keyword with its options and data; ignore other keywords."""
        if keyword == "INCLUDE" or (keyword in _READ and "INPUT" in options):
            raise GeometryError(f"it takes a part of itself from the file {options.get('INPUT')}: write all into one")
        if keyword == "NODE":
            for line in lines:
                if len(line) < 4:
                    raise ValueError(f"node {line[0]} has {len(line) - 1} coordinates")
                place = [float(value.upper().replace("D", "E")) for value in line[1:4]]
                self._require_one("node", self.nodes.get(int(line[0])), line[0], place, self.places)
                self.nodes[int(line[0])] = len(self.places)
                self.places.append(place)
            if "NSET" in options:
                self.node_sets.setdefault(options["NSET"], set()).update(int(line[0]) for line in lines)
        elif keyword == "ELEMENT":
            self._take_elements(options, lines)
        elif keyword in ("NSET", "ELSET"):
            sets = self.node_sets if keyword == "NSET" else self.cell_sets
            sets.setdefault(options[keyword], set()).update(self._members(sets, lines, generate="GENERATE" in options))
        elif keyword == "SURFACE":
            self.faces.setdefault(options["NAME"], []).extend((line[0], line[1] if line[1:] else "") for line in lines)

    def _take_elements(self, options: dict[str, str], lines: list[list[str]]) -> None:
        kind = options.get("TYPE", "").upper()
        count = next((count for name, count in _ABAQUS.items() if kind.startswith(name)), None)
        if count is None and kind.startswith(("C3D5", "C3D13")):
            raise GeometryError(f"it holds elements of the type {kind}: {_PYRAMIDS}")
        for line in lines:
            number, *nodes = map(int, line)
            if count is None:
                self.facets[number] = nodes
            elif len(nodes) < count:
                raise ValueError(f"element {number} of the type {kind} has {len(nodes)} nodes")
            else:
                known = number if number in self.elements else None
                self._require_one("element", known, str(number), (count, nodes[:count]), self.elements)
                self.elements[number] = count, nodes[:count]
        if "ELSET" in options:
            self.cell_sets.setdefault(options["ELSET"], set()).update(int(line[0]) for line in lines)

    @staticmethod
    def _require_one(what: str, known: int | None, number: str, new: object, held: Any) -> None:
        if known is not None and held[known] != new:
            raise GeometryError(
                f"it has two different {what}s {number}, as where a file holds several parts: write one of them alone"
            )

    def _members(self, sets: dict[str, set[int]], lines: list[list[str]], *, generate: bool) -> Iterable[int]:
        for line in lines:
            if generate:
                first, last, *step = map(int, line)
                yield from range(first, last + 1, step[0] if step else 1)
                continue
            for value in line:
                # In an assembly, what belongs to the body is named after it and a point.
                own = value if value in sets else value.rpartition(".")[2]
                if own.lstrip("-").isdigit():
                    yield int(own)
                else:
                    yield from tuple(sets.get(own, ()))

    def mesh(self, mm_per_unit: float) -> SolidMesh:
        """The stored contents as a mesh, with coordinates multiplied by mm_per_unit."""
        order: dict[int, list[int]] = {}
        for number, (count, _) in self.elements.items():
            order.setdefault(count, []).append(number)
        cells = {count: self._rows([self.elements[n][1] for n in numbers]) for count, numbers in order.items()}
        sets = {name: self._rows([sorted(numbers)])[0] for name, numbers in self.node_sets.items()}
        parts: dict[str, dict[int, BoolArray]] = {}
        for name, numbers in self.cell_sets.items():
            nodes = [
                node
                for n in numbers
                for node in (self.elements[n][1] if n in self.elements else self.facets.get(n, []))
            ]
            sets.setdefault(name, np.unique(self._rows([nodes])[0]))
            if any(n in self.elements for n in numbers):
                parts[name] = {count: np.array([n in numbers for n in own]) for count, own in order.items()}
        for name, faces in self.faces.items():
            sets.setdefault(name, np.unique(self._rows([self._on_faces(faces)])[0]))
        points = mm_per_unit * np.array(self.places, dtype=np.float64).reshape(-1, 3)
        return _assembled(points, cells, sets, parts)

    def _on_faces(self, faces: list[tuple[str, str]]) -> list[int]:
        """Numbers of the nodes on a surface, given as faces of element sets or of single elements, or as node sets."""
        found: list[int] = []
        for where, side in faces:
            if not re.fullmatch(r"[Ss]\d", side):
                numbers = [int(where)] if where.isdigit() else sorted(self.node_sets.get(where, ()))
                found += [n for n in numbers if n in self.nodes]
                continue
            for n in [int(where)] if where.isdigit() else sorted(self.cell_sets.get(where, ())):
                if n in self.elements:
                    count, nodes = self.elements[n]
                    kind = ELEMENT_KINDS[count]
                    found += [nodes[k] for k in kind.face_nodes[_ABAQUS_FACES[kind.corners][int(side[1]) - 1]]]
        return found

    def _rows(self, lists: list[list[int]]) -> IntArray:
        try:
            return np.array([[self.nodes[n] for n in each] for each in lists], dtype=np.int64)
        except KeyError as problem:
            raise GeometryError(
                f"an element or a set names node {problem.args[0]}, which the file does not list"
            ) from None
