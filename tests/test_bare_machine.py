"""What a bare machine with the oldest promised Python can install, and what runs there without developers' packages."""

import ast
import sys
import tomllib
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, metadata, version
from pathlib import Path

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from tests.test_house import imported_modules

ROOT = Path(__file__).resolve().parent.parent


CONSTRAINTS = ROOT / "constraints.txt"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


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
    told = {pin: metadata(pin.partition("=")[0]) for pin in pins() if is_installed(pin)}
    needs = {pin: one["Requires-Python"] for pin, one in told.items() if "Requires-Python" in one}
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
