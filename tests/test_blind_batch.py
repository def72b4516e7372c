"""Making a blind batch: the records, the seal, and cases that cannot be made."""

import json
import stat
from pathlib import Path

import pytest

from studies.blind import make_batch
from studies.blind.errors import BlindError
from studies.blind.generators.cases import Case, planned_cases
from studies.blind.generators.generator import LIBRARY_EFFECTS, MadeRecord
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.sealing import fingerprint
from tests.blind_batches import PlainModel, contents, truth_in
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


def test_a_record_damaged_between_its_making_and_the_seal_is_not_sealed(tmp_path: Path) -> None:
    folder = tmp_path / "batch"

    def damage(done: int, of: int) -> None:
        if done == of:
            with (folder / "case_001" / "loops.csv").open("a") as file:
                file.write("9\n")

    with pytest.raises(BlindError, match=r"case_001 is not as it was made: .* the same command makes it anew\.$"):
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


def test_nothing_readable_names_an_effect_or_the_seed(batch: Path) -> None:
    for path in batch.rglob("*"):
        if path.is_file() and path.name != "manifest.json":
            text = path.read_bytes()
            assert not [e for e in (*LIBRARY_EFFECTS, *OUTSIDE) if e.encode() in text], path
    manifest = json.loads((batch / "manifest.json").read_text())
    assert set(manifest) == {"format", "tier", "model", "wirewear", "key_sha256", "cases"}
    assert {frozenset(case) for case in manifest["cases"].values()} == {frozenset({"left_out", "sha256"})}


def test_the_manifest_binds_key_and_records(batch: Path) -> None:
    manifest, truth = json.loads((batch / "manifest.json").read_text()), truth_in(batch)
    assert fingerprint(truth) == manifest["key_sha256"]
    assert fingerprint({**truth, "seed": 6}) != manifest["key_sha256"]
    assert {name: case["sha256"] for name, case in manifest["cases"].items()} == contents(batch)


def test_the_hash_tells_nothing_to_somebody_who_guesses_the_seed(tmp_path: Path) -> None:
    for name in ("one", "two"):
        make_batch(tmp_path / name, cases=4, seed=9, generator=PlainModel())
    assert contents(tmp_path / "one") == contents(tmp_path / "two")
    hashes = [json.loads((tmp_path / name / "manifest.json").read_text())["key_sha256"] for name in ("one", "two")]
    assert hashes[0] != hashes[1]


def test_the_key_file_is_its_owners_alone_and_not_among_the_records(tmp_path: Path) -> None:
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


def test_a_case_that_does_not_slip_is_drawn_anew_with_the_same_effects(tmp_path: Path) -> None:
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
