"""The generator of blind records and the diagnosis know nothing of each other."""

import ast
from pathlib import Path

import pytest

from tests.test_import_direction import ROOT, imported_modules

GENERATORS = ROOT / "studies" / "blind" / "generators"

#: The seam to the finite elements (tiers T0 and T1, and L1) is the only part that may know the simulation.
FINITE_ELEMENT_SEAM = GENERATORS / "finite_element"
SEAMS = (FINITE_ELEMENT_SEAM, GENERATORS / "lines")
INDEPENDENT = GENERATORS / "independent"


def imports_of(file: Path) -> set[str]:
    """Dotted names that a file imports, with the names taken from packages."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    found = {name for _, name in imported_modules(ast.walk(tree))}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def reaches(names: set[str], *packages: str) -> list[str]:
    return sorted(name for name in names if any(name == p or name.startswith(f"{p}.") for p in packages))


def blind_files() -> list[Path]:
    scoring = GENERATORS.with_name("scoring")
    return sorted((*GENERATORS.rglob("*.py"), *scoring.glob("*.py"), GENERATORS.with_name("make.py")))


def test_the_independent_model_and_the_seam_have_files_to_check() -> None:
    assert len(list(INDEPENDENT.glob("*.py"))) > 5
    assert any(reaches(imports_of(file), "solvers") for file in FINITE_ELEMENT_SEAM.glob("*.py"))


@pytest.mark.parametrize("file", blind_files(), ids=lambda file: file.name)
def test_nothing_of_the_blind_check_imports_the_diagnosis(file: Path) -> None:
    assert reaches(imports_of(file), "wirewear.diagnosis") == []


@pytest.mark.parametrize(
    "file", [file for file in blind_files() if file.parent not in SEAMS], ids=lambda file: file.name
)
def test_only_the_seam_to_the_finite_elements_knows_solvers_and_effects(file: Path) -> None:
    forbidden = (
        "solvers",
        "geometry",
        "wirewear.effects",
        "wirewear.simulation",
        "wirewear.study",
        "wirewear.reference",
    )
    assert reaches(imports_of(file), *forbidden) == []


@pytest.mark.parametrize("file", sorted(INDEPENDENT.glob("*.py")), ids=lambda file: file.name)
def test_the_independent_model_takes_nothing_but_records_and_the_case_from_the_program(file: Path) -> None:
    allowed = (
        "studies.blind.generators",
        "studies.blind.errors",
        "wirewear.records",
        "wirewear.base.course",
        "wirewear.base.errors",
    )
    own = reaches(imports_of(file), "wirewear", "studies")
    assert [name for name in own if not reaches({name}, *allowed)] == []
