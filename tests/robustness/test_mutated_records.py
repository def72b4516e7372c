"""Mutated experiment records: each is read correctly or refused in one sentence that names file, line and column.

Some mutations keep the meaning (columns or rows in another order, other line ends, blank lines, a byte order mark):
these are read as the same record. Some destroy it (text for a number, a duplicated cycle, a missing column): these are
refused. Other changes may end either way. None ends in a traceback, or after more than five seconds of CPU.
"""

import re
import tempfile
import time
import warnings
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.robustness.changes import changed
from tests.robustness.record_mutations import MUTATIONS, Files, Mutation, small_record
from wirewear import ExperimentRecord, RecordError, check_record, read_record

LONGEST_s = 5.0  #: A mutation that takes more CPU time counts as hanging.


def contents(record: ExperimentRecord) -> list[object]:
    """The numbers of a record, to be compared with others."""
    values: list[object] = [record.tables]
    for loop in record.loops:
        normal = [] if loop.normal_force_N is None else loop.normal_force_N.tolist()
        channels = [loop.time_s, loop.displacement_um, loop.tangential_force_N]
        values.append((loop.name, *(channel.tolist() for channel in channels), normal))
    values += [
        (part.repeat, {name: column.tolist() for name, column in part.columns.items()}) for part in record.evolution
    ]
    values += [(scar.body, scar.repeat, scar.x_um.tolist(), scar.depth_um.tolist()) for scar in record.scars]
    return values


def complaint(message: str) -> str | None:
    """What a refusal lacks, if anything: one sentence that names a file, and a line or a missing file."""
    if "\n" in message or not message.endswith((".", "?")) or ". " in message.replace("...", ""):
        return "the refusal is not one sentence"
    if not re.search(r"\.csv|\.toml", message):
        return "the refusal names no file"
    if not re.search(r"line \d+|there is no (TOML )?file|end of document|not valid TOML: a number", message):
        return "the refusal names no line"
    return None


def read(files: Files) -> ExperimentRecord:
    """The record of files in a folder."""
    with tempfile.TemporaryDirectory() as name:
        for file, data in files.items():
            (Path(name) / file).write_bytes(data)
        return read_record(name)


ORIGINAL = small_record()


@pytest.fixture(scope="module")
def reference() -> list[object]:
    """What the record holds before it is mutated."""
    return contents(read(ORIGINAL))


def outcome(files: Files, *, checked: bool) -> tuple[list[object], str | None]:
    """What is read of files, or the sentence that refuses them, in which nothing is missing; soon."""
    started = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            record = read(files)
            found, refusal = contents(record), None
            if checked:
                check_record(record).to_json()
    except RecordError as refused:
        found, refusal = [], str(refused)
    assert refusal is None or complaint(refusal) is None, refusal
    assert time.process_time() - started < LONGEST_s
    return found, refusal


#: Checking takes longer than reading.
one_in_seven = st.integers(0, 6).map(lambda number: number == 0)


@pytest.mark.seconds
@pytest.mark.parametrize("mutate", MUTATIONS, ids=lambda mutate: mutate.__name__)
def test_a_record_of_the_same_meaning_is_read_and_one_of_none_refused(
    mutate: Mutation, reference: list[object]
) -> None:
    @settings(max_examples=max(settings().max_examples // 16, 1))
    @given(st.randoms(use_true_random=False), one_in_seven)
    def ends_as_expected(random: Random, checked: bool) -> None:
        files = dict(ORIGINAL)
        expected = mutate(files, random)
        found, refusal = outcome(files, checked=checked)
        assert (expected == "refused") == (refusal is not None), refusal
        assert expected == "refused" or found == reference

    ends_as_expected()


@pytest.mark.slow
@given(st.data(), one_in_seven)
def test_a_changed_record_is_read_or_refused_in_one_sentence(data: st.DataObject, checked: bool) -> None:
    name = data.draw(st.sampled_from(sorted(ORIGINAL)))
    outcome({**ORIGINAL, name: data.draw(changed(ORIGINAL[name]))}, checked=checked)
