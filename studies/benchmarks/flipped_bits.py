"""One bit flipped in each kind of file that wirewear reads back: is the answer ever another one without a word?

Usage: python -m studies.benchmarks.flipped_bits [--flips 300] [--seed 1] [--only result]

A file with a flipped bit must be refused in one sentence, left out, told, or give what it gave before, and
never anything else. Prints how each kind ended, and exits with 1 if any ended otherwise.
"""

import json
import shutil
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, fields, is_dataclass
from hashlib import sha256
from pathlib import Path
from random import Random
from typing import Any

import click
import numpy as np

from studies.blind import generator_of, make_batch
from studies.blind.scoring.answers import read_answer
from studies.blind.scoring.history import LOG, logged_run
from studies.blind.scoring.score import verified
from wirewear import WirewearError, parse_study, read_record, read_result, record_of_result, run_study, write_record
from wirewear.base.cache import Identity, cache_directory
from wirewear.base.errors import RunError
from wirewear.base.locks import LOCK_FILE_NAME, occupied
from wirewear.base.reading import with_checksum
from wirewear.faces.study_script import StudyScript
from wirewear.kinds import load_any_study
from wirewear.results import read_results as read_runs
from wirewear.simulation import Moment, Observer, discretise
from wirewear.simulation.folder import read_checkpoint
from wirewear.simulation.problem import _load
from wirewear.study import LineStudy
from wirewear.sweeps.running import JOURNAL, Journal
from wirewear.sweeps.sweep import SweepRow

from .hard_pressed import FLAT, STUDY

#: A diagnosis, as short as one can be.
ANSWER: Mapping[str, Any] = {
    "format": 1,
    "verdict": "explained",
    "gap": {"shrink": 0.9, "confirmed": {"shrink": 0.8}},
    "causes": [
        {"effect": "free_play", "probability": 0.9, "parameters": {"gap_um": {"value": 3.0, "interval95": [2.0, 4.0]}}}
    ],
    "equivalent": [["free_play", "none"]],
    "undetectable": [],
}


@dataclass(frozen=True)
class Kind:
    """A file in a folder, what reads it there, and what tells of a change (empty: nothing does)."""

    file: str
    read: Callable[[Path], object]
    told: Callable[[Any], object] = lambda _: ()


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


def made_runs(base: Path) -> None:
    """A result, a checkpoint of a run that was stopped, a planar result, and a record of each."""
    wires = parse_study(STUDY, "study.toml")

    class Stopping(Observer):
        def moved(self, _moment: Moment) -> None:
            if (base / "stopped" / "checkpoint.h5").exists():
                raise KeyboardInterrupt

    (result,) = run_study(wires, fidelity="quick", output=base / "result")
    with suppress(KeyboardInterrupt):
        run_study(wires, fidelity="quick", output=base / "stopped", observer_of=lambda _: nullcontext(Stopping()))
    flat = load_any_study(_written(base / "flat.toml", FLAT))
    if isinstance(flat, LineStudy):
        (line,) = run_study(flat, fidelity="quick", output=base / "planar")
        write_record(base / "line_record", record_of_result(line, 5.0, samples=100, repeats=2, seed=1))
    write_record(base / "record", record_of_result(result, samples=100, repeats=2, seed=1))


def _written(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def _made_batch(base: Path) -> None:
    """A batch of blind records with an answer, which has been scored once."""
    make_batch(base / "batch", cases=1, seed=4, tests=1, generator=generator_of("T2"))
    (base / "diagnoses" / "case_001").mkdir(parents=True)
    _written(base / "diagnoses" / "case_001" / "diagnosis.json", json.dumps(with_checksum(ANSWER), indent=1))
    scored(base)


def scored(folder: Path) -> object:
    """The log of scored runs, appended to."""
    entry = logged_run(folder / "batch", folder / "diagnoses", {}, folder / "batch.key")
    return entry["run"], entry["previous_sha256"], entry["different_diagnoses_before"]


def _sweep() -> Identity:
    return Identity("asked", "made")


def _made_rows(folder: Path) -> None:
    """The rows of a sweep."""
    folder.mkdir()
    journal = Journal(folder, _sweep())
    journal.begun()
    with journal.open() as file:
        for number in (1, 2, 3):
            journal.add(file, SweepRow(number, {"max_pressure_MPa": 100.0 * number}, cpu_s=1.0, peak_bytes=10**8))


def _rows(folder: Path) -> object:
    """The rows of a sweep; None where one is left out, which is then made anew."""
    rows, _ = Journal(folder / "sweep", _sweep()).begun()
    return rows if len(rows) == 3 else None


def _held(folder: Path) -> object:
    with occupied(folder, "another") as before:
        return before.get("asked")


def _kinds(base: Path) -> dict[str, Kind]:
    """Every kind of file that is read back, made anew in a folder."""
    made_runs(base)
    _made_batch(base)
    _made_rows(base / "sweep")
    (wire, *_), (batch_key,) = sorted(cache_folder().glob("body-*.npz")), [base / "batch.key"]
    shutil.copy(wire, base / wire.name)
    with suppress(ZeroDivisionError), occupied(base / "held", "a run", asked="this"):
        raise ZeroDivisionError
    noted = {"read": lambda at: read_record(at / "record"), "told": lambda record: record.notes}
    line = {"read": lambda at: read_record(at / "line_record"), "told": lambda record: record.notes}
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
    if kind.told(found):
        return "told"
    return "the same" if spelled(found) == whole else "ANOTHER ANSWER"


def flipped(data: bytes, random: Random) -> bytes:
    """One bit changed, if there is any."""
    if not data:
        return data
    place = random.randrange(len(data))
    return data[:place] + bytes([data[place] ^ (1 << random.randrange(8))]) + data[place + 1 :]


def run(flips: int, seed: int, only: Sequence[str] = ()) -> Counter[tuple[str, str]]:
    """How reading ended, by the kind of file, of so many flips in each."""
    counts: Counter[tuple[str, str]] = Counter()
    with tempfile.TemporaryDirectory() as name:
        base, random = Path(name), Random(seed)
        kinds = _kinds(base)
        if unknown := set(only) - set(kinds):
            raise RunError(f"there is no kind of file {min(unknown)!r}: there are {', '.join(kinds)}.")
        for kind, own in kinds.items():
            if only and kind not in only:
                continue
            data = (base / own.file).read_bytes()
            keeps = {path: path.read_bytes() for path in (base / "batch" / LOG, base / "batch.key.scored")}
            before = spelled(own.read(base))
            for _ in range(flips):
                for path, content in keeps.items():
                    path.write_bytes(content)
                counts[kind, how_it_ended(own, before, base, flipped(data, random))] += 1
            for path, content in {**keeps, base / own.file: data}.items():
                path.write_bytes(content)
    return counts


@click.command(cls=StudyScript)
@click.option("--flips", type=click.IntRange(1), default=300, show_default=True, help="In each kind of file.")
@click.option("--seed", type=int, default=1, show_default=True)
@click.option("--only", multiple=True, help="A kind of file; may be repeated.")
def main(flips: int, seed: int, only: tuple[str, ...]) -> None:
    """Flip bits of files and say how reading them ended."""
    counts = run(flips, seed, only)
    for kind in dict.fromkeys(kind for kind, _ in counts):
        click.echo(f"{kind:36} {', '.join(f'{how} {n}' for (own, how), n in sorted(counts.items()) if own == kind)}")
    if any(how[:2].isupper() for _, how in counts):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
