"""Whole batches: what is still to be done, what is kept, and the baseline that knows no mechanics."""

import ast
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from studies.blind import make_batch
from studies.blind.generators.cases import Case, exact_class, planned_cases
from studies.blind.generators.generator import LIBRARY_EFFECTS
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.owners import OwnersWhoKnow
from tests.blind_batches import PlainModel
from tests.test_house import ROOT, imported_modules

OUTSIDE = PlainModel().outside

MODEL = IndependentModel(points=8)

GENERATORS = ROOT / "studies" / "blind" / "generators"

#: The seam to the finite elements (tiers T0 and T1, and L1) is the only part that may know the simulation.
FINITE_ELEMENT_SEAM = GENERATORS / "finite_element"
SEAMS = (FINITE_ELEMENT_SEAM, GENERATORS / "lines")
INDEPENDENT = GENERATORS / "independent"


def test_a_plan_holds_every_kind_in_its_share_and_every_effect_about_as_often() -> None:
    cases = planned_cases(400, 1, LIBRARY_EFFECTS, OUTSIDE)
    kinds = Counter(case.kind for case in cases)
    assert kinds["none"] == 80
    assert set(kinds) == {"none", "single", "pair", "outside", "left_out"}
    singles = Counter(case.effects[0].effect for case in cases if case.kind == "single")
    assert set(singles) == set(LIBRARY_EFFECTS)
    assert max(singles.values()) - min(singles.values()) <= 1
    assert all(len(case.effects) == (2 if case.kind == "pair" else case.kind != "none") for case in cases)


def test_a_plan_depends_on_its_seed_alone() -> None:
    first, again = (planned_cases(30, 7, LIBRARY_EFFECTS, OUTSIDE) for _ in range(2))
    assert first == again
    assert planned_cases(30, 8, LIBRARY_EFFECTS, OUTSIDE) != first


def test_cases_that_leave_their_effect_out_hide_among_others_that_leave_out_one_that_is_not_there() -> None:
    cases = planned_cases(400, 1, LIBRARY_EFFECTS, OUTSIDE)
    told = [case for case in cases if case.left_out]
    true = [case for case in told if case.kind == "left_out"]
    assert all(set(case.left_out) == exact_class(case.effects[0].effect) for case in true)
    assert 0.2 < len(true) / len(told) < 0.5
    for case in told:
        if case.kind != "left_out":
            assert not {effect.effect for effect in case.effects} & set(case.left_out)


def test_what_a_record_looks_like_depends_on_seed_and_place_not_on_its_effect() -> None:
    planned = planned_cases(60, 4, LIBRARY_EFFECTS, OUTSIDE)
    others = planned_cases(60, 4, LIBRARY_EFFECTS[:9], ())
    assert [case.effects for case in planned] != [case.effects for case in others]
    for case, other in zip(planned, others, strict=True):
        assert (case.name, case.nominal, case.nuisances, case.seed) == (
            other.name,
            other.nominal,
            other.nuisances,
            other.seed,
        )


def cases() -> list[Case]:
    return list(planned_cases(12, 5, MODEL.library, MODEL.outside, 2, MODEL.nominals))


@pytest.mark.slow
def test_the_stated_share_of_records_states_all_of_the_scatter_and_the_others_are_as_they_were() -> None:
    own = OwnersWhoKnow(MODEL, 0.5)
    stating = 0
    for case in cases():
        plain, made = MODEL.make(case).record, own.make(case).record
        stated = made.tables.scatter.model_dump(exclude_none=True)
        stating += bool(stated)
        assert len(stated) in (0, 5)
        assert made.tables.model_copy(update={"scatter": plain.tables.scatter}) == plain.tables
        assert all(
            np.array_equal(a.displacement_um, b.displacement_um) for a, b in zip(made.loops, plain.loops, strict=True)
        )
    assert 2 <= stating <= 10


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


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("batches") / "records"
    make_batch(folder, cases=30, seed=12, generator=PlainModel())
    return folder
