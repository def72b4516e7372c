"""One bit flipped in each kind of file that wirewear reads back: the answer is never another one without a word.

A file with a flipped bit is refused in one sentence, left out, noted, or gives what it gave before.
"""

import json
import shutil
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from studies.blind import generator_of, make_batch
from studies.blind.scoring.answers import read_answer
from studies.blind.scoring.history import LOG
from studies.blind.scoring.score import verified
from tests.robustness.commands import STUDY
from tests.robustness.made_files import ANSWER, made_runs, scored
from wirewear import WirewearError, parse_study, read_record, read_result
from wirewear.base.cache import Identity, cache_directory
from wirewear.base.files import with_checksum
from wirewear.base.locks import LOCK_FILE_NAME, occupied
from wirewear.results import read_results as read_runs
from wirewear.simulation import discretise
from wirewear.simulation.problem import _load
from wirewear.simulation.store import read_checkpoint
from wirewear.sweeps.running import JOURNAL, Journal
from wirewear.sweeps.sweep import SweepRow


@dataclass(frozen=True)
class Kind:
    """A file in a folder, what reads it there, and what speaks of a change (empty: nothing does)."""

    file: str
    read: Callable[[Path], object]
    notices: Callable[[Any], object] = lambda _: ()


def spelled(value: object) -> str:
    """A digest of all that a value holds, arrays and tables in it too; what only says where it came from left out."""
    hashed = sha256()

    def add(item: object) -> None:
        match item:
            case np.ndarray():
                hashed.update(str(item.dtype).encode() + str(item.shape).encode() + item.tobytes())
            case Mapping():
                for key in sorted(item, key=str):
                    add(key)
                    add(item[key])
            case tuple() | list():
                hashed.update(f"({len(item)}".encode())
                for one in item:
                    add(one)
            case _ if is_dataclass(item) and not isinstance(item, type):
                for field in fields(item):
                    if field.name not in ("path", "notes"):
                        add(getattr(item, field.name))
            case _:
                hashed.update(repr(item).encode())

    add(value)
    return hashed.hexdigest()


def _made_batch(base: Path) -> None:
    """A batch of blind records with an answer, which has been scored once."""
    make_batch(base / "batch", cases=1, seed=4, tests=1, generator=generator_of("T2"))
    (base / "diagnoses" / "case_001").mkdir(parents=True)
    answer = base / "diagnoses" / "case_001" / "diagnosis.json"
    answer.write_text(json.dumps(with_checksum(ANSWER), indent=1), encoding="utf-8")
    scored(base)


def _sweep() -> Identity:
    return Identity("asked", "made")


def _made_rows(folder: Path) -> None:
    """The rows of a sweep."""
    folder.mkdir()
    journal = Journal(folder, _sweep())
    journal.rows_so_far()
    with journal.open() as file:
        for number in (1, 2, 3):
            journal.add(file, SweepRow(number, {"max_pressure_MPa": 100.0 * number}, cpu_s=1.0, peak_bytes=10**8))


def _rows(folder: Path) -> object:
    """The rows of a sweep; None where one is left out, which is then made again."""
    rows, _ = Journal(folder / "sweep", _sweep()).rows_so_far()
    return rows if len(rows) == 3 else None


def _held(folder: Path) -> object:
    with occupied(folder, "another") as before:
        return before.get("asked")


def _kinds(base: Path) -> dict[str, Kind]:
    """Every kind of file that is read back, made again in a folder."""
    made_runs(base)
    _made_batch(base)
    _made_rows(base / "sweep")
    (wire, *_), (batch_key,) = sorted(cache_folder().glob("body-*.npz")), [base / "batch.key"]
    shutil.copy(wire, base / wire.name)
    with suppress(ZeroDivisionError), occupied(base / "held", "a run", asked="this"):
        raise ZeroDivisionError
    noted = {"read": lambda at: read_record(at / "record"), "notices": lambda record: record.notes}
    line = {"read": lambda at: read_record(at / "line_record"), "notices": lambda record: record.notes}
    tables, line_tables = (
        sorted(path.relative_to(base).as_posix() for path in (base / name).iterdir() if path.is_file())
        for name in ("record", "line_record")
    )
    sealed = ("batch/manifest.json", "batch/key.json.enc", batch_key.name, "batch/case_001/loops.csv",
              "batch/case_001/experiment.toml")  # fmt: skip
    round_wire = discretise(parse_study(STUDY, "study.toml"), "quick").fixed.profile
    return {
        "result": Kind("result/result.h5", lambda at: read_result(at / "result")),
        "checkpoint": Kind("stopped/checkpoint.h5", lambda at: read_checkpoint(at / "stopped")),
        "planar result": Kind("planar/result.h5", lambda at: read_runs(at / "planar")),
        "condensed wire": Kind(wire.name, lambda at: _load(at / wire.name, round_wire)),
        **{f"record: {Path(name).name}": Kind(name, **noted) for name in tables},
        **{f"line record: {Path(name).name}": Kind(name, **line) for name in line_tables},
        "rows of a sweep": Kind(f"sweep/{JOURNAL}", _rows),
        "diagnosis": Kind("diagnoses/case_001/diagnosis.json",
                          lambda at: read_answer(at / "diagnoses" / "case_001" / "diagnosis.json")),
        **{f"blind: {name}": Kind(name, lambda at: verified(at / "batch", at / "batch.key")) for name in sealed},
        "log of scored runs": Kind(f"batch/{LOG}", scored),
        "copy of the log": Kind("batch.key.scored", scored),
        "lock": Kind(f"held/{LOCK_FILE_NAME}", lambda at: _held(at / "held")),
    }  # fmt: skip


def cache_folder() -> Path:
    """The folder of what is kept. Raises RuntimeError if there is none."""
    folder = cache_directory()
    if folder is None:
        raise RuntimeError("there is no folder for the cache")
    return folder


def how_it_ended(kind: Kind, whole: str, folder: Path, data: bytes) -> str:
    """How reading a changed file ended; in capitals what may not be."""
    path = folder / kind.file
    path.write_bytes(data)
    try:
        found = kind.read(folder)
    except WirewearError as refused:
        return "refused" if str(refused) and "\n" not in str(refused) else "NO SENTENCE"
    except Exception as problem:  # noqa: BLE001 - what is looked for is whatever is raised
        return f"TRACEBACK {type(problem).__name__}"
    if found is None:
        return "left out"
    if kind.notices(found):
        return "noted"
    return "the same" if spelled(found) == whole else "ANOTHER ANSWER"


def flip(kind: Kind, base: Path) -> None:
    """See how reading ends with one bit of a file flipped, for some of its bits."""
    data = (base / kind.file).read_bytes()
    keeps = {path: path.read_bytes() for path in (base / "batch" / LOG, base / "batch.key.scored")}
    before = spelled(kind.read(base))

    @settings(max_examples=max(settings().max_examples // 5, 1))
    @given(st.integers(0, 8 * len(data) - 1))
    def flipped(bit: int) -> None:
        for path, content in keeps.items():
            path.write_bytes(content)
        changed = data[: bit // 8] + bytes([data[bit // 8] ^ (1 << bit % 8)]) + data[bit // 8 + 1 :]
        assert how_it_ended(kind, before, base, changed) in ("refused", "left out", "noted", "the same")

    try:
        flipped()
    finally:
        for path, content in {**keeps, base / kind.file: data}.items():
            path.write_bytes(content)


@pytest.mark.slow
def test_no_flipped_bit_of_any_kind_of_file_changes_an_answer_without_a_word(
    tmp_path: Path, subtests: pytest.Subtests
) -> None:
    kinds = _kinds(tmp_path)
    assert len(kinds) == 24
    for name, kind in kinds.items():
        with subtests.test(name):
            flip(kind, tmp_path)
