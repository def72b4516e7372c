"""Imports run only studies → wirewear → solvers → geometry."""

import ast
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
LAYERS = ("geometry", "solvers", "wirewear", "studies")
MAY_IMPORT = {
    "geometry": {"geometry"},
    "solvers": {"geometry", "solvers"},
    "wirewear": {"geometry", "solvers", "wirewear"},
    "studies": {"studies", "wirewear"},
}
#: Those that write effects of their own, as other packages do (docs/extending.md), name what the solver takes.
EFFECTS_OF_STUDIES = ("studies/blind/generators/",)


def imported_modules(nodes: Iterable[ast.AST]) -> Iterator[tuple[int, str]]:
    """Line and dotted name of every absolute import, also those spelled importlib.import_module("name")."""
    for node in nodes:
        match node:
            case ast.Import(names=names):
                yield from ((node.lineno, alias.name) for alias in names)
            case ast.ImportFrom(module=str(module), level=0):
                yield node.lineno, module
            case ast.Call(
                func=ast.Name(id="import_module" | "__import__") | ast.Attribute(attr="import_module"),
                args=[ast.Constant(value=str(name)), *_],
            ):
                yield node.lineno, name


def climbs_out(node: ast.AST, depth: int) -> bool:
    """A relative import with more dots than the file has packages above it leaves its layer."""
    return isinstance(node, ast.ImportFrom) and node.level > depth


def violations(root: Path) -> list[str]:
    """Every import in the code folders under root that runs the wrong way, as "file:line imports name"."""
    found = []
    for layer in LAYERS:
        for file in sorted((root / layer).rglob("*.py")):
            nodes = list(ast.walk(ast.parse(file.read_text(encoding="utf-8"), filename=str(file))))
            where = file.relative_to(root)
            may_import = MAY_IMPORT[layer] | ({"solvers"} if where.as_posix().startswith(EFFECTS_OF_STUDIES) else set())
            found += [
                f"{where}:{line} imports {name}"
                for line, name in imported_modules(nodes)
                if (top := name.partition(".")[0]) in LAYERS and top not in may_import
            ]
            found += [
                f"{where}:{node.lineno} imports from above {layer}"
                for node in nodes
                if isinstance(node, ast.ImportFrom) and climbs_out(node, len(where.parts) - 1)
            ]
    return found


def test_no_import_runs_against_the_layers() -> None:
    assert violations(ROOT) == []


@pytest.mark.parametrize("layer", ["geometry", "solvers", "wirewear"])
def test_the_checker_sees_the_code_of_every_package(layer: str) -> None:
    assert list((ROOT / layer).rglob("*.py")), f"no Python files in {layer}: the check above would pass idly"


@pytest.mark.parametrize(
    ("layer", "line"),
    [
        ("geometry", "import solvers"),
        ("geometry", "from wirewear.study import Study"),
        ("solvers", "from wirewear import errors"),
        ("solvers", "import numpy, studies.steel_wires.compare"),
        ("wirewear", "def late():\n    from studies import blind"),
        ("wirewear", "import importlib\nimportlib.import_module('studies.blind')"),
        ("wirewear", "from ..solvers import contact"),
        ("studies", "from solvers.contact import solve"),
        ("studies", "import geometry"),
    ],
)
def test_an_import_against_the_layers_is_detected(tmp_path: Path, layer: str, line: str) -> None:
    (tmp_path / layer).mkdir()
    (tmp_path / layer / "module.py").write_text(line, encoding="utf-8")
    assert len(violations(tmp_path)) == 1


def test_imports_along_the_layers_are_accepted(tmp_path: Path) -> None:
    lines = {
        "geometry": "import gmsh\nfrom . import mesh",
        "solvers": "from geometry import mesh\nfrom .law import friction",
        "wirewear": "import solvers.contact\nimport geometry",
        "studies": "import wirewear\nimport matplotlib\nfrom studies.blind import make",
    }
    for layer, line in lines.items():
        (tmp_path / layer).mkdir()
        (tmp_path / layer / "module.py").write_text(line, encoding="utf-8")
    assert violations(tmp_path) == []
