"""A blind batch that is interrupted, damaged, finished or another's."""

from pathlib import Path

import pytest

from studies.blind import make_batch
from studies.blind.errors import BlindError
from studies.blind.generators.cases import Case
from studies.blind.generators.generator import MadeRecord
from tests.blind_batches import PlainModel, contents, truth_in
from wirewear.base.errors import RunError


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
