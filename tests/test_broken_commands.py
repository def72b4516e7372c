"""Commands killed at random moments and on full disks, and mutated inputs of every reader: a few of each."""

from pathlib import Path
from random import Random

import pytest

from studies.benchmarks import fuzz_inputs, hardships
from studies.benchmarks.hardships import COMMANDS, killed, make_given, on_full_disks, with_flipped_bits


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what the commands read, and a cache."""
    folder = tmp_path_factory.mktemp("hardships")
    make_given(folder / "given", folder / "cache")
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("command", [one for one in COMMANDS if one.name in ("run", "import")], ids=["run", "import"])
def test_nothing_is_lost_or_wrong_after_kills_and_full_disks(base: Path, command: hardships.Command) -> None:
    random = Random(5)
    assert list(killed(command, base, 2, random)) == []
    assert list(on_full_disks(command, base, 2, random)) == []


@pytest.mark.slow
def test_no_flipped_bit_of_a_real_result_goes_unseen(base: Path) -> None:
    assert list(with_flipped_bits(base, 100, Random(6))) == []


@pytest.mark.slow
def test_mutants_of_every_input_are_read_or_refused_in_a_sentence() -> None:
    counts, wrongs = fuzz_inputs.run(seed=3, count=2200)
    assert wrongs == []
    assert sum(count for (_, ended), count in counts.items() if ended == "read") > 200
    assert {name for name, _ in counts} == {
        *("study", "planar", "rig", "record", "mapping", "loops", "tribometers", "answer", "batch", "log", "result"),
    }  # fmt: skip


def test_a_reader_that_fails_otherwise_is_found_out(tmp_path: Path) -> None:
    def wrong(_folder: Path) -> object:
        raise ZeroDivisionError("division by zero")

    reader = fuzz_inputs.Reader({"a.txt": b"some words"}, ("a.txt",), wrong)
    assert fuzz_inputs.complaint(reader, {"a.txt": b""}, tmp_path) == (
        "traceback",
        "ZeroDivisionError: division by zero",
    )
    first, again = (fuzz_inputs.mutant(reader, 1, 7) for _ in range(2))
    assert first == again
    assert len({fuzz_inputs.mutant(reader, 1, index)["a.txt"] for index in range(50)}) > 30
