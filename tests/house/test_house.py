"""The house: no circle among files, no import upward between rooms, few modules at its root; what it needs besides."""

import ast
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, metadata, version
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from tests.house.project import ODD, PROJECT, ROOT, imported_modules
from tools.house import anys, branches_on_kinds, circles, imports_among, modules_of, nodes_of, rooms_among, weights
from wirewear.base.cache import CONDENSATION_CODE, RUN_CODE

pytestmark = pytest.mark.seconds
LAYERS = ("geometry", "solvers", "wirewear", "studies")
MAY_IMPORT = {
    "geometry": {"geometry"},
    "solvers": {"geometry", "solvers"},
    "wirewear": {"geometry", "solvers", "wirewear"},
    "studies": {"studies", "wirewear"},
}
#: Those that write effects of their own, as other packages do (docs/extending.md), name what the solver takes.
EFFECTS_OF_STUDIES = ("studies/blind/generators/",)
#: Rooms of wirewear, folders at its root, from the ground up: a file imports only from its own and from those named
#: before it.
ROOMS = (
    "base",
    "reference",
    "loops",
    "effects",
    "test",
    "results",
    "pictures",
    "simulation",
    "stress",
    "records",
    "verification",
    "kinds",
    "diagnosis",
    "comparison",
    "sweeps",
    "strand",
    "views",
    "",  # what `import wirewear` offers
    "app",
    "__main__",
)
APPLICATIONS = ("app",)
MOST_AT_THE_ROOT = 1


def climbs_out(node: ast.AST, depth: int) -> bool:
    """A relative import with more dots than the file has packages above it leaves its layer."""
    return isinstance(node, ast.ImportFrom) and node.level > depth


def violations(root: Path) -> list[str]:
    """Every import in the code folders under root that runs the wrong way, as "file:line imports name"."""
    found = []
    for layer in LAYERS:
        for file in sorted((root / layer).rglob("*.py")):
            nodes = nodes_of(file)
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
        ("geometry", "from wirewear.test import Study"),
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


def room_of(module: str) -> str:
    """The declared room of a module of wirewear, dotted; KeyError for one that has none."""
    name = module.removeprefix("wirewear").removeprefix(".")
    held = [room for room in ROOMS if room and (name == room or name.startswith(f"{room}."))]
    if name and not held:
        raise KeyError(f"{module} stands in no room of tests/house/test_house.py: give its room a place in ROOMS")
    return max(held, key=len, default="")


@cache
def imports_of(package: str = "wirewear") -> dict[str, set[str]]:
    """Who imports whom, read once."""
    return imports_among(modules_of(ROOT, package))


def upward(graph: Mapping[str, set[str]]) -> list[str]:
    """Every import from a room above; what a room offers in its `__init__` of the rooms in it is none."""
    floor = {room: height for height, room in enumerate(ROOMS)}
    return [
        f"{module} imports {target} from above"
        for module, targets in graph.items()
        for target in sorted(targets)
        if floor[room_of(target)] > floor[room_of(module)] and not target.startswith(f"{module}.")
    ]


def test_no_import_runs_upward_between_rooms() -> None:
    assert upward(imports_of()) == []


@pytest.mark.parametrize("package", ["geometry", "solvers", "wirewear"])
def test_no_files_import_one_another_in_a_circle(package: str) -> None:
    graph = imports_of(package)
    assert sum(map(len, graph.values())) > len(graph) / 2, "hardly any imports: the check would pass idly"
    assert circles(graph) == []


def test_no_rooms_import_one_another_in_a_circle() -> None:
    assert circles(rooms_among(modules_of(ROOT))) == []


def closure(graph: dict[str, set[str]], start: str) -> Iterator[str]:
    seen, ahead = {start}, [start]
    while ahead:
        module = ahead.pop()
        yield module
        ahead += sorted(graph[module] - seen)
        seen |= graph[module]


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize(
    ("start", "code", "left_out"),
    [
        ("wirewear.simulation.runs", RUN_CODE, ("wirewear.base",)),
        ("solvers.elasticity.condensation", CONDENSATION_CODE, ("solvers",)),
    ],
)
def test_the_code_of_an_identity_is_all_that_the_answer_comes_from(
    start: str, code: tuple[str, ...], left_out: tuple[str, ...]
) -> None:
    packages = [modules_of(ROOT, package) for package in ("geometry", "solvers", "wirewear")]
    modules = {name: file for package in packages for name, file in package.items()}
    graph = imports_among(modules)
    hashed = [ROOT / name for name in code]
    for module in closure(graph, start):
        file = modules[module]
        held = any(file == own or own in file.parents for own in hashed)
        neutral = any(module == name or (name != "solvers" and module.startswith(f"{name}.")) for name in left_out)
        assert held or neutral, f"{module} is missing from the code of {start}"


def test_pages_are_asked_for_by_the_applications_alone() -> None:
    asking = {
        room_of(name) for name, targets in imports_of().items() if any(room_of(one) == "views" for one in targets)
    }
    assert asking - {"views"} == set(APPLICATIONS)


@pytest.mark.slow
def test_any_room_can_be_entered_first() -> None:
    """A command begins at the room that it needs, with nothing of the others loaded."""
    rooms = [f"wirewear.{room}".rstrip(".") for room in ROOMS if room != "__main__"]
    entered = (
        "import sys, importlib\n"
        f"for room in {rooms}:\n"
        "    for name in [one for one in sys.modules if one.partition('.')[0] == 'wirewear']:\n"
        "        del sys.modules[name]\n"
        "    package = importlib.import_module(room)\n"
        "    for name in getattr(package, '__all__', ()):\n"
        "        getattr(package, name)\n"
    )
    required = subprocess.run([sys.executable, "-c", entered], cwd=ROOT, capture_output=True, text=True, check=False)
    assert required.returncode == 0, required.stderr


def test_a_simulation_is_asked_for_at_its_door() -> None:
    """Everybody else knows what `wirewear.simulation` offers."""
    within = ("wirewear.simulation",)
    graph = imports_of()
    outsiders = {name: targets for name, targets in graph.items() if not name.startswith(within)}
    assert any("wirewear.simulation" in targets for targets in outsiders.values())
    past_the_door = [
        f"{name} imports {target}"
        for name, targets in outsiders.items()
        for target in targets
        if target.startswith("wirewear.simulation.")
    ]
    assert past_the_door == []


def test_few_modules_stand_loose_and_named_files_exist() -> None:
    loose = [path.name for path in (ROOT / "wirewear").glob("*.py") if path.name != "__init__.py"]
    assert len(loose) <= MOST_AT_THE_ROOT, loose
    page = (ROOT / "docs" / "developers.md").read_text(encoding="utf-8")
    named = set(re.findall(r"`([\w./]+(?:\.py|/))`", page))
    assert len(named) > 20
    assert [path for path in named if not ((ROOT / path).exists() or (ROOT / "wirewear" / path).exists())] == []


def tree(root: Path, **texts: str) -> dict[str, set[str]]:
    """The imports of a package with these modules, each in a folder of its own."""
    for name, text in texts.items():
        (root / "wirewear" / name).mkdir(parents=True)
        (root / "wirewear" / name / "__init__.py").write_text("", encoding="utf-8")
        (root / "wirewear" / name / "part.py").write_text(text, encoding="utf-8")
    (root / "wirewear" / "__init__.py").write_text("", encoding="utf-8")
    return imports_among(modules_of(root))


@pytest.mark.parametrize(
    "line",
    [
        "from wirewear.test.part import Study",
        "from wirewear.test import part",
        "import wirewear.test.part",
        "def late():\n    from wirewear.test.part import Study",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from wirewear.test.part import Study",
        "from ..test import part",
        "from ..test.part import Study",
        "import importlib\nimportlib.import_module('wirewear.test.part')",
    ],
)
def test_an_import_from_above_and_the_circle_that_it_closes_are_found(tmp_path: Path, line: str) -> None:
    graph = tree(tmp_path, effects=line, test="from wirewear.effects.part import Effect")
    assert upward(graph) == ["wirewear.effects.part imports wirewear.test.part from above"]
    assert circles(graph) == [["wirewear.effects.part", "wirewear.test.part"]]


def test_a_room_without_a_place_is_named(tmp_path: Path) -> None:
    with pytest.raises(KeyError, match=r"wirewear\.attic\.part stands in no room"):
        upward(tree(tmp_path, attic="import wirewear", effects="from wirewear.attic.part import it"))


#: What the house may weigh (tools/house.py): its weight when a version is made, with 3 % of slack for the next one.
BUDGETS = {
    "lines of geometry, solvers and wirewear": 90_600,
    "lines of wirewear": 70_300,
    "lines of studies": 18_500,
    "lines of tests": 38_100,
    "files of geometry, solvers and wirewear": 450,
    "rooms of wirewear": 20,
    "arrows between rooms": 106,
    "questions for the kind of contact": 0,
    "Any in public signatures": 79,  # one in 1 000 lines
    "lines of wirewear that import, per cent": 7.1,
}


def test_the_house_weighs_no_more_than_its_budget() -> None:
    found = weights(ROOT)
    assert found.keys() == BUDGETS.keys()
    assert {name: value for name, value in found.items() if value > BUDGETS[name]} == {}


def test_questions_for_the_kind_of_contact_are_counted(tmp_path: Path) -> None:
    asking = tmp_path / "asking.py"
    asking.write_text(
        "def f(a):\n    if isinstance(a, Study | LineStudy) or a.kind == 'line-contact' or is_line_record(a):\n"
        "        return int\n"
        "    match a:\n        case LineRecord():\n            return isinstance(a, int)\n",
        encoding="utf-8",
    )
    assert branches_on_kinds([asking]) == 4


@pytest.mark.parametrize(
    "line",
    [
        "per = 1.0 / (record.tables.length_mm or 1.0)",
        "plane = mesh.points.shape[1] == 2",
        "what = 'wire' if result.bodies == WIRES else 'body'",
        "if chain.length_um == 0.0: pass",
        "unit = 'J/mm' if test.per_mm else 'J'",
        "if length_mm is not None: pass",
        "lines = record.contact_kind == kinds.LINE_CONTACT",
    ],
)
def test_a_question_for_the_kind_in_other_words_is_counted(tmp_path: Path, line: str) -> None:
    (asking := tmp_path / "asking.py").write_text(line, encoding="utf-8")
    assert branches_on_kinds([asking]) > 0


@pytest.mark.parametrize(
    ("signature", "count"),
    [
        ("def f(a: Any, *, b: dict[str, Any]) -> Any: ...", 3),
        ("Values = dict[str, Any]\nclass A:\n    def f(self) -> Values: ...", 1),
        ("def f(a: NDArray[Any]) -> object: ...", 0),
        ("def _f(a: Any) -> Any: ...", 0),
    ],
)
def test_any_in_public_signatures_is_counted_by_whatever_name(tmp_path: Path, signature: str, count: int) -> None:
    (file := tmp_path / "signature.py").write_text(signature, encoding="utf-8")
    assert len([*anys(file)]) == count


def test_docstrings_are_in_plain_english() -> None:
    odd = [
        f"{file}: {said}"
        for layer in LAYERS
        for file in (ROOT / layer).rglob("*.py")
        for node in nodes_of(file)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and (said := ast.get_docstring(node))
        if ODD.search(said)
    ]
    assert odd == []


def test_no_class_has_the_name_of_another() -> None:
    named = Counter(
        node.name
        for package in ("geometry", "solvers", "wirewear")
        for file in (ROOT / package).rglob("*.py")
        for node in ast.parse(file.read_text(encoding="utf-8")).body
        if isinstance(node, ast.ClassDef)
    )
    assert len(named) > 300
    assert [name for name, times in named.items() if times > 1] == []


CONSTRAINTS = ROOT / "constraints.txt"
OLDEST_PYTHON = PROJECT["requires-python"].removeprefix(">=")
DISTRIBUTION_OF = {"skfem": "scikit-fem"}  #: What some packages bring along that are called otherwise when imported.
#: Packages that others of the product bring along for certain: matplotlib, pydantic.
BROUGHT_ALONG = {"PIL", "pydantic_core", "typing_extensions"}


def pins() -> list[str]:
    return CONSTRAINTS.read_text(encoding="utf-8").split()


def is_installed(pin: str) -> bool:
    name, wanted = pin.split("==")
    with suppress(PackageNotFoundError):
        return version(name) == wanted
    return False


def test_every_pinned_package_takes_the_oldest_python_promised() -> None:
    required = {pin: metadata(pin.partition("=")[0]) for pin in pins() if is_installed(pin)}
    needs = {pin: one["Requires-Python"] for pin, one in required.items() if "Requires-Python" in one}
    assert len(needs) > 60
    assert {pin: need for pin, need in needs.items() if OLDEST_PYTHON not in SpecifierSet(need)} == {}


def test_what_is_imported_when_the_product_is_loaded_is_what_it_depends_on() -> None:
    needed = {Requirement(one).name.lower() for one in PROJECT["dependencies"]}
    known = {"geometry", "solvers", "wirewear", *sys.stdlib_module_names, *BROUGHT_ALONG}
    strange = []
    for layer in ("geometry", "solvers", "wirewear"):
        for file in sorted((ROOT / layer).rglob("*.py")):
            # What stands in functions, and under `if TYPE_CHECKING`, is not loaded with the module.
            body = [one for one in ast.parse(file.read_text(encoding="utf-8")).body if not isinstance(one, ast.If)]
            nodes = [node for one in body if isinstance(one, ast.Import | ast.ImportFrom) for node in ast.walk(one)]
            for line, name in imported_modules(nodes):
                top = name.partition(".")[0]
                if top not in known and DISTRIBUTION_OF.get(top, top).lower() not in needed:
                    strange.append(f"{file.relative_to(ROOT)}:{line} imports {name}")
    assert strange == []
