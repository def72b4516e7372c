"""Making a blind batch: the records, the seal, cases that cannot be made; what is still to be done of whole batches."""

import ast
import json
import stat
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from packaging.requirements import Requirement

from studies.blind import make_batch
from studies.blind.errors import BlindError
from studies.blind.generators.cases import Case, exact_class, planned_cases
from studies.blind.generators.generator import LIBRARY_EFFECTS, MadeRecord
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.owners import OwnersWhoKnow
from studies.blind.sealing import fingerprint
from tests.exam.blind_batches import PlainModel, contents, truth_in
from tests.house.project import PROJECT, ROOT, imported_modules
from wirewear import read_record
from wirewear.base.errors import RunError

OUTSIDE = PlainModel().outside


class StopError(Exception):
    pass


class InterruptedModel(PlainModel):
    """Stops at the fourth record."""

    made = 0

    def make(self, case: Case) -> MadeRecord:
        InterruptedModel.made += 1
        if InterruptedModel.made == 4:
            raise StopError
        return super().make(case)


@pytest.mark.seconds
def test_an_interrupted_batch_goes_on_and_ends_as_an_unbroken_one(tmp_path: Path) -> None:
    with pytest.raises(StopError):
        make_batch(tmp_path / "broken", cases=7, seed=2, generator=InterruptedModel())
    assert not (tmp_path / "broken" / "manifest.json").exists()
    make_batch(tmp_path / "broken", cases=7, seed=2, generator=InterruptedModel())
    assert InterruptedModel.made == 8
    make_batch(tmp_path / "whole", cases=7, seed=2, generator=PlainModel())
    assert contents(tmp_path / "broken") == contents(tmp_path / "whole")
    assert truth_in(tmp_path / "broken")["truths"] == truth_in(tmp_path / "whole")["truths"]
    assert not list((tmp_path / "broken").glob(".*"))


def test_without_the_package_that_seals_keys_the_exam_says_in_a_sentence_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "cryptography", None)
    with pytest.raises(BlindError, match=r"cryptography.*not installed.*wirewear\[exam\]"):
        make_batch(tmp_path / "batch", cases=1, seed=2, generator=PlainModel())
    assert "cryptography" not in {Requirement(one).name for one in PROJECT["dependencies"]}


def test_a_record_damaged_between_its_making_and_the_seal_is_not_sealed(tmp_path: Path) -> None:
    folder = tmp_path / "batch"

    def damage(done: int, of: int) -> None:
        if done == of:
            with (folder / "case_001" / "loops.csv").open("a") as file:
                file.write("9\n")

    with pytest.raises(BlindError, match=r"case_001 is not as it was made: .* the same command makes it again\.$"):
        make_batch(folder, cases=2, seed=2, generator=PlainModel(), progress=damage)
    assert not (folder / "manifest.json").exists()
    assert make_batch(folder, cases=2, seed=2, generator=PlainModel()).exists()


@pytest.fixture(scope="module")
def batch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("blind") / "batch"
    make_batch(folder, cases=30, seed=5, generator=PlainModel())
    return folder


@pytest.mark.seconds
def test_records_are_read_without_a_remark(batch: Path) -> None:
    for folder in sorted(batch.glob("case_*"))[:20]:
        record = read_record(folder)
        assert record.notes == ()
        assert record.name == folder.name


def test_nothing_readable_names_effect_or_seed_and_the_manifest_binds_key_and_records(batch: Path) -> None:
    for path in batch.rglob("*"):
        if path.is_file() and path.name != "manifest.json":
            text = path.read_bytes()
            assert not [e for e in (*LIBRARY_EFFECTS, *OUTSIDE) if e.encode() in text], path
    manifest = json.loads((batch / "manifest.json").read_text())
    assert set(manifest) == {"format", "tier", "model", "wirewear", "key_sha256", "cases"}
    assert {frozenset(case) for case in manifest["cases"].values()} == {frozenset({"left_out", "sha256"})}
    manifest, truth = json.loads((batch / "manifest.json").read_text()), truth_in(batch)
    assert fingerprint(truth) == manifest["key_sha256"]
    assert fingerprint({**truth, "seed": 6}) != manifest["key_sha256"]
    assert {name: case["sha256"] for name, case in manifest["cases"].items()} == contents(batch)


def test_the_hash_reveals_no_seed_and_the_key_file_is_its_owners_alone(tmp_path: Path) -> None:
    for name in ("one", "two"):
        make_batch(tmp_path / name, cases=4, seed=9, generator=PlainModel())
    assert contents(tmp_path / "one") == contents(tmp_path / "two")
    hashes = [json.loads((tmp_path / name / "manifest.json").read_text())["key_sha256"] for name in ("one", "two")]
    assert hashes[0] != hashes[1]
    make_batch(tmp_path / "b", cases=2, seed=1, generator=PlainModel())
    assert stat.S_IMODE((tmp_path / "b.key").stat().st_mode) == 0o600
    with pytest.raises(BlindError, match="among the records"):
        make_batch(tmp_path / "c", cases=2, seed=1, generator=PlainModel(), key_path=tmp_path / "c" / "key")


class StuckModel(PlainModel):
    """Refuses the sizes that were drawn first."""

    def make(self, case: Case) -> MadeRecord:
        first = {c.name: c for c in planned_cases(6, 2, self.library, self.outside)}
        if case.effects and case.effects == first[case.name].effects:
            raise RunError("does not slip")
        return super().make(case)


def test_a_case_that_does_not_slip_is_drawn_again_with_the_same_effects(tmp_path: Path) -> None:
    make_batch(tmp_path / "b", cases=6, seed=2, generator=StuckModel())
    planned = planned_cases(6, 2, LIBRARY_EFFECTS, OUTSIDE)
    for case, truth in zip(planned, truth_in(tmp_path / "b")["truths"], strict=True):
        assert truth["redrawn"] == bool(case.effects)
        assert [e.effect for e in case.effects] == [e["effect"] for e in truth["effects"]]
        for effect, made in zip(case.effects, truth["effects"], strict=True):
            assert effect.parameters != made["parameters"]


@pytest.mark.slow
def test_the_independent_model_makes_a_batch_of_every_kind_that_the_program_reads(tmp_path: Path) -> None:
    make_batch(tmp_path / "b", cases=8, seed=1, generator=IndependentModel(points=6))
    truths = truth_in(tmp_path / "b")["truths"]
    assert {truth["kind"] for truth in truths} == {"none", "single", "pair", "outside", "left_out"}
    assert all((truth["gap_in_scatter"] > 0.0) == (truth["kind"] != "none") for truth in truths)
    for truth in truths:
        record = read_record(tmp_path / "b" / truth["case"])
        assert record.notes == ()
        asked = record.tables.conditions.displacement_amplitude_um
        for loop in record.loops:
            assert loop.figures(
                record.tables.conditions.normal_load_N
            ).displacement_amplitude_um.value == pytest.approx(asked, rel=0.25)


OUTSIDE_KINDS = PlainModel().outside
MODEL = IndependentModel(points=8)
GENERATORS = ROOT / "studies" / "blind" / "generators"
#: The seam to the finite elements (tiers T0 and T1, and L1) is the only part that may know the simulation.
FINITE_ELEMENT_SEAM = GENERATORS / "finite_element"
SEAMS = (FINITE_ELEMENT_SEAM, GENERATORS / "lines")
INDEPENDENT = GENERATORS / "independent"


def test_a_plan_holds_every_kind_in_its_share_and_every_effect_about_as_often() -> None:
    cases = planned_cases(400, 1, LIBRARY_EFFECTS, OUTSIDE_KINDS)
    kinds = Counter(case.kind for case in cases)
    assert kinds["none"] == 80
    assert set(kinds) == {"none", "single", "pair", "outside", "left_out"}
    singles = Counter(case.effects[0].effect for case in cases if case.kind == "single")
    assert set(singles) == set(LIBRARY_EFFECTS)
    assert max(singles.values()) - min(singles.values()) <= 1
    assert all(len(case.effects) == (2 if case.kind == "pair" else case.kind != "none") for case in cases)


def test_cases_without_their_effect_hide_among_those_without_an_absent_one() -> None:
    cases = planned_cases(400, 1, LIBRARY_EFFECTS, OUTSIDE_KINDS)
    without_one = [case for case in cases if case.left_out]
    true = [case for case in without_one if case.kind == "left_out"]
    assert all(set(case.left_out) == exact_class(case.effects[0].effect) for case in true)
    assert 0.2 < len(true) / len(without_one) < 0.5
    for case in without_one:
        if case.kind != "left_out":
            assert not {effect.effect for effect in case.effects} & set(case.left_out)


def test_what_a_record_looks_like_depends_on_seed_and_place_not_on_its_effect() -> None:
    planned = planned_cases(60, 4, LIBRARY_EFFECTS, OUTSIDE_KINDS)
    others = planned_cases(60, 4, LIBRARY_EFFECTS[:9], ())
    assert [case.effects for case in planned] != [case.effects for case in others]
    for case, other in zip(planned, others, strict=True):
        assert (case.name, case.nominal, case.nuisances, case.seed) == (
            other.name, other.nominal, other.nuisances, other.seed,
        )  # fmt: skip


def cases() -> list[Case]:
    return list(planned_cases(12, 5, MODEL.library, MODEL.outside, 2, MODEL.nominals))


@pytest.mark.slow
def test_the_stated_share_of_records_states_all_scatter_others_are_unchanged() -> None:
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
    causes = GENERATORS.with_name("causes")
    return sorted(
        (*GENERATORS.rglob("*.py"), *causes.glob("*.py"), *scoring.glob("*.py"), GENERATORS.with_name("make.py"))
    )


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
        "solvers", "geometry", "wirewear.effects", "wirewear.simulation", "wirewear.test", "wirewear.reference",
    )  # fmt: skip
    assert reaches(imports_of(file), *forbidden) == []


@pytest.mark.parametrize(
    "file",
    sorted((*INDEPENDENT.glob("*.py"), *GENERATORS.with_name("causes").glob("*.py"))),
    ids=lambda file: file.name,
)
def test_the_independent_model_takes_nothing_but_records_and_the_case_from_the_program(file: Path) -> None:
    allowed = (
        "studies.blind.causes", "studies.blind.generators", "studies.blind.errors", "wirewear.records",
        "wirewear.base.course", "wirewear.base.errors",
    )  # fmt: skip
    own = reaches(imports_of(file), "wirewear", "studies")
    assert [name for name in own if not reaches({name}, *allowed)] == []
