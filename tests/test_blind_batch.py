"""Making a blind batch: the records, the seal, and cases that cannot be made."""

import json
import stat
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from studies.blind import generator_of, make_batch, score_batch
from studies.blind.errors import BlindError
from studies.blind.generators.cases import Case, planned_cases
from studies.blind.generators.generator import LIBRARY_EFFECTS, MadeRecord
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.independent.sensing import read
from studies.blind.generators.sampling import despiked, loop_figures
from studies.blind.make import default_key_path
from studies.blind.sealing import fingerprint
from tests.blind_batches import PlainModel, contents, truth_in
from tests.test_blind_model import RIGID, at
from wirewear import read_record
from wirewear.base.errors import RunError
from wirewear.records import ExperimentRecord

OUTSIDE = PlainModel().outside


@pytest.mark.parametrize("offset_N", [0.0, 0.07])
def test_noise_on_the_shelf_of_a_free_play_does_not_decide_the_logged_slip_amplitude(offset_N: float) -> None:
    world = replace(RIGID, rig=replace(RIGID.rig, play_mm=5e-3))
    [snapshot] = at(world, 300, points=12)
    seen = read(world, snapshot.loop, 300)
    displacement, force = 1e3 * seen.displacement_mm[::4], seen.tangential_force_N[::4] + offset_N
    random = np.random.default_rng(0)
    noisy = [force + 0.008 * random.standard_normal(force.size) for _ in range(20)]
    widths = [loop_figures(displacement, one)["slip_amplitude_um"] for one in noisy]
    # The play takes half of itself from each side: slip is what is left of the stroke.
    assert np.mean(widths) == pytest.approx(59.5 - 2.5, abs=0.3)
    assert np.std(widths) < 0.1


def test_a_loop_whose_force_does_not_reverse_has_no_slip_amplitude() -> None:
    phase = 2.0 * np.pi * np.arange(200) / 200
    assert loop_figures(60.0 * np.sin(phase), 2.0 + np.cos(phase))["slip_amplitude_um"] == 0.0


def test_the_tips_of_a_coarse_loop_are_no_spikes() -> None:
    place = 60.0 * np.sin(2.0 * np.pi * np.arange(40) / 40)
    assert despiked(place) == pytest.approx(place)
    spiked = place.copy()
    spiked[3] += 30.0
    assert despiked(spiked)[3] == pytest.approx(place[3], abs=15.0)


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


def test_a_finished_batch_is_left_as_it_is(tmp_path: Path) -> None:
    manifest = make_batch(tmp_path / "b", cases=3, seed=2, generator=PlainModel())
    before = manifest.read_bytes()
    assert make_batch(tmp_path / "b", cases=3, seed=2, generator=PlainModel()) == manifest
    assert manifest.read_bytes() == before


@pytest.mark.parametrize(("seed", "cases", "word"), [(3, 3, "seed"), (2, 4, "cases")])
def test_another_batch_is_not_mixed_into_a_folder(tmp_path: Path, seed: int, cases: int, word: str) -> None:
    make_batch(tmp_path / "b", cases=3, seed=2, generator=PlainModel())
    with pytest.raises(BlindError, match=f"other arguments \\({word}\\)"):
        make_batch(tmp_path / "b", cases=cases, seed=seed, generator=PlainModel())


def test_a_folder_with_something_else_in_it_is_refused(tmp_path: Path) -> None:
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "notes.txt").write_text("mine")
    with pytest.raises(BlindError, match="not empty"):
        make_batch(tmp_path / "b", cases=3, seed=2, generator=PlainModel())


def test_a_batch_is_gone_on_with_by_the_code_that_began_it_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(_done: int, _of: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_batch(tmp_path / "batch", cases=3, seed=5, generator=PlainModel(), progress=stopped)
    with monkeypatch.context() as changed:
        changed.setattr("studies.blind.make.code_hash", lambda _: "other code")
        with pytest.raises(BlindError, match="was begun by another version of the program: name a new folder"):
            make_batch(tmp_path / "batch", cases=3, seed=5, generator=PlainModel())
    assert make_batch(tmp_path / "batch", cases=3, seed=5, generator=PlainModel()).exists()


def test_two_makers_of_one_batch_are_refused_by_name(tmp_path: Path) -> None:
    def again(_done: int, _of: int) -> None:
        with pytest.raises(RunError, match=r"another command is writing to .* \(blind make, process"):
            make_batch(tmp_path / "batch", cases=2, seed=5, generator=PlainModel())

    make_batch(tmp_path / "batch", cases=2, seed=5, generator=PlainModel(), progress=again)


def test_a_batch_that_ends_before_its_key_is_written_goes_on(tmp_path: Path) -> None:
    (tmp_path / "batch" / ".sealed").mkdir(parents=True)
    assert make_batch(tmp_path / "batch", cases=1, seed=5, generator=PlainModel()).exists()


class StoppedModel(PlainModel):
    """Ends the making of a batch with its fourth record, once."""

    stopped = False

    def make(self, case: Case) -> MadeRecord:
        if case.name.endswith("4") and not StoppedModel.stopped:
            StoppedModel.stopped = True
            raise StopError
        return super().make(case)


@pytest.mark.parametrize("place", ["case_002/loops.csv", ".sealed/case_002"])
def test_what_was_damaged_before_it_was_sealed_is_made_anew(tmp_path: Path, place: str) -> None:
    StoppedModel.stopped = False
    with pytest.raises(StopError):
        make_batch(tmp_path / "broken", cases=5, seed=2, generator=StoppedModel())
    data = (tmp_path / "broken" / place).read_bytes()
    (tmp_path / "broken" / place).write_bytes(data[:300] + bytes([data[300] ^ 1]) + data[301:])
    make_batch(tmp_path / "broken", cases=5, seed=2, generator=StoppedModel())
    make_batch(tmp_path / "whole", cases=5, seed=2, generator=PlainModel())
    assert contents(tmp_path / "broken") == contents(tmp_path / "whole")
    assert truth_in(tmp_path / "broken")["records"] == truth_in(tmp_path / "whole")["records"]


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


def test_records_are_read_without_a_remark(batch: Path) -> None:
    for folder in sorted(batch.glob("case_*"))[:20]:
        record = read_record(folder)
        assert record.notes == ()
        assert record.name == folder.name


def test_numbers_come_back_as_they_were_written(tmp_path: Path) -> None:
    model = PlainModel()
    case = planned_cases(5, 3, model.library, model.outside)[0]
    make_batch(tmp_path / "b", cases=5, seed=3, generator=model)
    made, read = model.make(case).record, read_record(tmp_path / "b" / case.name)
    assert np.abs(read.loops[0].displacement_um - made.loops[0].displacement_um).max() <= 0.00051
    assert np.abs(read.loops[0].tangential_force_N - made.loops[0].tangential_force_N).max() <= 0.000051
    assert isinstance(made, ExperimentRecord)
    assert [len(read.scars), len(read.evolution)] == [len(made.scars), len(made.evolution)]


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


def test_a_file_in_place_of_the_folder_is_refused_before_a_key_is_made(tmp_path: Path) -> None:
    (tmp_path / "b").write_text("not a folder")
    with pytest.raises(BlindError, match="b is a file"):
        make_batch(tmp_path / "b", cases=1, seed=1, generator=PlainModel())
    assert [path.name for path in tmp_path.iterdir()] == ["b"]


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


@dataclass(frozen=True)
class HalfModel(PlainModel):
    """Makes no case with an effect whose name begins with one of these letters."""

    refused: str = "abcdefghijklm"

    def make(self, case: Case) -> MadeRecord:
        if any(effect.effect[0] in self.refused for effect in case.effects):
            raise RunError(f"{case.name} does not converge")
        return super().make(case)


@pytest.mark.slow
def test_a_case_that_no_draw_can_make_stops_no_batch_and_is_told_of_in_key_and_score(tmp_path: Path) -> None:
    model, folder = HalfModel(), tmp_path / "b"
    make_batch(folder, cases=12, seed=2, generator=model, jobs=2)
    refused = [c for c in planned_cases(12, 2, model.library, model.outside) if any(e.effect < "n" for e in c.effects)]
    assert 0 < len(refused) < 12
    truth = truth_in(folder)
    assert [case["case"] for case in truth["unmade"]] == [case.name for case in refused]
    assert truth["unmade"][0]["reason"] == f"{refused[0].name} does not converge"
    assert {path.name for path in folder.glob("case_*")} == {case["case"] for case in truth["truths"]}
    assert len(truth["truths"]) + len(refused) == 12
    answered = tmp_path / truth["truths"][0]["case"]
    answered.mkdir()
    (answered / "diagnosis.json").write_text('{"format": 1, "verdict": "no_gap", "causes": []}', encoding="utf-8")
    score = score_batch(folder, tmp_path, key_path=default_key_path(folder))
    assert [case["effects"] for case in score.report["unmade"]] == [[e.effect for e in c.effects] for c in refused]
    assert f"{len(refused)} of the planned cases could not be made" in (tmp_path / "score.html").read_text()


def test_a_batch_of_which_nothing_can_be_made_is_refused_with_the_reason(tmp_path: Path) -> None:
    with pytest.raises(BlindError, match="no case can be made in 8 draws each; case_001: case_001 does not converge"):
        make_batch(tmp_path / "b", cases=1, seed=4, generator=HalfModel(refused="abcdefghijklmnopqrstuvwxyz"))


def test_an_unknown_tier_or_law_is_refused_in_a_sentence() -> None:
    with pytest.raises(BlindError, match="choose one of dahl"):
        generator_of("T2", law="coulomb")
    with pytest.raises(BlindError, match="no generator for the tier 'T3'"):
        generator_of("T3")
    with pytest.raises(BlindError, match="T1 slides by Coulomb's law"):
        generator_of("T1", law="iwan")


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
