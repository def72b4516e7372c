"""Making a blind batch: the plan, the records without a trace, the seal, and going on after an interruption."""

import json
import stat
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.blind_batches import PlainModel
from wirewear import read_record
from wirewear.blind import generator_of, make_batch, score_batch
from wirewear.blind.cases import Case, TrueEffect, exact_class, planned_cases
from wirewear.blind.files import record_hash, write_traceless
from wirewear.blind.generator import LIBRARY_EFFECTS, Generator, MadeRecord
from wirewear.blind.independent.model import IndependentModel
from wirewear.blind.make import default_key_path
from wirewear.blind.nominal import MOST_LOST, WIDEST_SCAR, drawn_nominals
from wirewear.blind.sealing import fingerprint, opened, read_key_file
from wirewear.errors import BlindError, RunError
from wirewear.records import ExperimentRecord

OUTSIDE = PlainModel().outside


def truth_in(folder: Path) -> dict:  # type: ignore[type-arg]
    key = read_key_file(folder.with_name(f"{folder.name}.key"))
    return opened((folder / "key.json.enc").read_bytes(), key, "the key")


def contents(folder: Path) -> dict[str, str]:
    return {path.name: record_hash(path) for path in sorted(folder.iterdir()) if path.is_dir()}


@pytest.fixture(scope="module")
def batch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("blind") / "batch"
    make_batch(folder, cases=30, seed=5, generator=PlainModel())
    return folder


@pytest.fixture(scope="module")
def large_batch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Enough records for a forest to learn from."""
    folder = tmp_path_factory.mktemp("blind") / "large"
    make_batch(folder, cases=150, seed=5, generator=PlainModel())
    return folder


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


def test_nominal_tests_slip_and_keep_their_scars_inside_the_wire() -> None:
    for nominal in drawn_nominals(50, np.random.default_rng(0)):
        assert nominal.expected_scar_mm < WIDEST_SCAR * nominal.diameter_mm / 2
        if nominal.stiffness_N_per_mm is not None:
            lost_um = 1e3 * nominal.friction * nominal.load_N / nominal.stiffness_N_per_mm
            assert lost_um < MOST_LOST * nominal.amplitude_um


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


def metadata(folder: Path) -> list[float]:
    """All that can be seen of a record without looking at what was measured."""
    features: list[float] = [len(folder.name), int(folder.name.split("_")[1]), folder.stat().st_mtime]
    for name in ("experiment.toml", "loops.csv", "evolution.csv", "scar_moving.csv", "scar_fixed.csv"):
        path = folder / name
        if not path.exists():
            features += [0.0] * 7
            continue
        lines = path.read_text(encoding="utf-8").splitlines()
        fields = [field for line in lines[1:200] for field in line.split(",")]
        decimals = [len(field.partition(".")[2]) for field in fields]
        last_digits = [int(field[-1]) for field in fields if field[-1:].isdigit()]
        size, times = path.stat().st_size, path.stat().st_mtime
        features += [size, size / len(lines), times, len(lines), float(np.mean(decimals)), max(map(len, lines))]
        features.append(float(np.mean(np.array(last_digits) % 5 == 0)))
    return features


LAST_DIGITS = slice(9, None, 7)


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


@pytest.mark.parametrize(
    "model",
    [PlainModel(), pytest.param(IndependentModel(points=6), marks=pytest.mark.slow)],
    ids=["plain", "independent"],
)
def test_files_have_the_same_sizes_names_times_and_widths_with_a_strong_effect_as_without_one(
    model: Generator, tmp_path: Path
) -> None:
    case = planned_cases(4, 1, model.library, model.outside)[0]
    strong = (TrueEffect("friction_offset", {"friction": 1.5 * case.nominal.friction}),)
    for name, effects in (("without", ()), ("with", strong)):
        write_traceless(tmp_path / name / case.name, model.make(replace(case, effects=effects)).record)
    without, with_effect = (np.array(metadata(tmp_path / name / case.name)) for name in ("without", "with"))
    assert record_hash(tmp_path / "without" / case.name) != record_hash(tmp_path / "with" / case.name)
    without[LAST_DIGITS] = with_effect[LAST_DIGITS] = 0.0
    assert without.tolist() == with_effect.tolist()


def deviations_from_chance(seen: "np.ndarray[Any, Any]", label: "np.ndarray[Any, Any]") -> float:
    """How far a random forest's area under the ROC lies above that for shuffled labels, over their scatter."""
    from sklearn.ensemble import RandomForestClassifier
    from sklearn.metrics import roc_auc_score

    random = np.random.default_rng(0)
    areas = []
    for labels in (label, *(random.permutation(label) for _ in range(20))):
        forest = RandomForestClassifier(60, random_state=0, min_samples_leaf=3, oob_score=True).fit(seen, labels)
        areas.append(roc_auc_score(labels, forest.oob_decision_function_[:, 1]))
    return float((areas[0] - np.mean(areas[1:])) / np.std(areas[1:], ddof=1))


#: By chance a batch lies above this once in some thousands (Student's distribution, 19 degrees of freedom).
CHANCE = 4.0


@pytest.mark.slow
def test_a_random_forest_learns_nothing_from_sizes_names_times_and_rounding(large_batch: Path) -> None:
    truths = truth_in(large_batch)["truths"]
    seen = np.array([metadata(large_batch / truth["case"]) for truth in truths])
    labels = {
        "whether there is an effect": np.array([bool(truth["effects"]) for truth in truths]),
        "whether it is easy": np.array([truth["ease"] == "easy" for truth in truths]),
        "whether it is in the sensors": np.array(
            [any("displacement" in e["effect"] or "force" in e["effect"] for e in t["effects"]) for t in truths]
        ),
    }
    for what, label in labels.items():
        assert deviations_from_chance(seen, label) < CHANCE, what


@pytest.mark.slow
def test_the_same_forest_sees_a_trace_where_there_is_one(large_batch: Path) -> None:
    truths = truth_in(large_batch)["truths"]
    label = np.array([bool(truth["effects"]) for truth in truths])
    seen = np.array([metadata(large_batch / truth["case"]) for truth in truths])
    # As if one number in fifty of the loops had one digit more in records with an effect.
    decimals = 3 + 7 + 4
    seen[:, decimals] += 0.02 * label
    assert deviations_from_chance(seen, label) > CHANCE


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


def test_a_batch_is_gone_on_with_by_the_code_that_began_it_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(_done: int, _of: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        make_batch(tmp_path / "batch", cases=3, seed=5, generator=PlainModel(), progress=stopped)
    with monkeypatch.context() as changed:
        changed.setattr("wirewear.blind.make.code_hash", lambda _: "other code")
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
