"""Mutated inputs of every reader: each must be read or refused in one sentence, soon, in little memory.

Usage: python -m studies.benchmarks.fuzz_inputs [--count 20000] [--seed 1] [--only NAME] [--index N]

Bytes, words, numbers and lines of studies, mappings, logger files, records, loops, tribometers, diagnoses, batches,
logs and results are changed, cut, doubled and moved. Every mutant is drawn from the seed and its index, so that a
failing one can be repeated alone. Exit code 1 if any ends in a traceback, takes more than ten seconds, or asks for more
than four gigabytes.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import re
import resource
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random

from wirewear import WirewearError, check_record, parse_study, read_record, read_results
from wirewear.blind.scoring.answers import read_answer
from wirewear.blind.scoring.history import LOG, logged_run
from wirewear.blind.scoring.score import verified
from wirewear.cli.study_kinds import load_any_study
from wirewear.loops.loop_report import analyse_loops, read_loops
from wirewear.records.importing import import_record
from wirewear.simulation import discretise
from wirewear.tribometers.rows import read_rows

from .hardships import MAPPING, STUDY
from .record_mutations import small_record

LONGEST_s, MOST_BYTES = 10.0, 4_000_000_000

STUDIES = Path(__file__).parent.parent
REFUSALS = {"LoopError", "GeometryError", "SolverError", "PatchLeftError"}

#: What stands where something else is expected.
ODD = (
    *("nan", "inf", "-inf", "-1", "0", "1e400", "-1e-400", "9" * 400, "9" * 5000, "1_000", "1e5", "0x10", "true"),
    *("", '""', '"[/]"', "[]", "[[]]", "{}", "{a=1}", "[" * 3000, "{" * 3000, "'", '"', "\\", "\0", "\x7f", "\u202e"),
    *("µ", "１", "../..", "/etc/passwd", "<script>", "%n%s", "1979-05-27", "07:32:00", ",", ";", "\t", "\n", "\r"),
    *("#", "=", "x" * 20_000),
)

ANSWER = {
    "format": 1,
    "verdict": "explained",
    "gap": {"shrink": 0.9, "confirmed": {"shrink": 0.8}},
    "causes": [
        {
            "effect": "free_play",
            "probability": 0.9,
            "parameters": {"gap_um": {"value": 3.0, "interval95": [2.0, 4.0]}},
        }
    ],
    "equivalent": [["free_play", "none"]],
    "undetectable": [],
}


@dataclass(frozen=True)
class Reader:
    """Files as they should be, which of them are mutated, and what reads them in a folder."""

    files: Mapping[str, bytes]
    mutated: Sequence[str]
    read: Callable[[Path], object]


def flipped(data: bytes, random: Random) -> bytes:
    """One bit changed."""
    if not data:
        return data
    place = random.randrange(len(data))
    return data[:place] + bytes([data[place] ^ (1 << random.randrange(8))]) + data[place + 1 :]


def cut(data: bytes, random: Random) -> bytes:
    """Cut off, or with a part missing."""
    first, second = sorted(random.randrange(len(data) + 1) for _ in range(2))
    return data[:first] if random.random() < 0.3 else data[:first] + data[second:]


def doubled(data: bytes, random: Random) -> bytes:
    """A part put in once more, somewhere."""
    first, second = sorted(random.randrange(len(data) + 1) for _ in range(2))
    place = random.randrange(len(data) + 1)
    return data[:place] + data[first : min(second, first + 50_000)] + data[place:]


def reworded(data: bytes, random: Random) -> bytes:
    """A word or number replaced by something odd, or by another word of the file."""
    words = list(re.finditer(rb"[\w.+-]+", data))
    if not words:
        return data
    found = random.choice(words)
    new = random.choice(ODD).encode() if random.random() < 0.7 else random.choice(words)[0]
    return data[: found.start()] + new + data[found.end() :]


def inserted(data: bytes, random: Random) -> bytes:
    """Something odd put in."""
    place = random.randrange(len(data) + 1)
    return data[:place] + random.choice(ODD).encode() + data[place:]


def reordered(data: bytes, random: Random) -> bytes:
    """Lines exchanged, left out or doubled."""
    lines = data.split(b"\n")
    first, second = random.randrange(len(lines)), random.randrange(len(lines))
    match random.randrange(3):
        case 0:
            lines[first], lines[second] = lines[second], lines[first]
        case 1:
            del lines[first]
        case _:
            lines.insert(second, lines[first])
    return b"\n".join(lines)


def recoded(data: bytes, random: Random) -> bytes:
    """In another encoding, or with other ends of lines."""
    text = data.decode("latin-1")
    return random.choice(
        [
            text.encode("utf-16"),
            text.encode("utf-8-sig"),
            data.replace(b"\n", b"\r"),
            data.replace(b"\n", b"\r\n"),
            data.replace(b",", b";"),
            data.replace(b".", b","),
        ]
    )


MUTATIONS = (flipped, cut, doubled, reworded, reworded, reworded, inserted, reordered, recoded)


def studied(folder: Path) -> object:
    """A study of wires, as far as its mesh's sizes."""
    study = parse_study((folder / "study.toml").read_text(encoding="utf-8", errors="surrogateescape"), "study.toml")
    variants = [study.variant(name) for name in study.variant_names] or [study]
    return [discretise(one, "quick") for one in variants]


def made_batch(folder: Path) -> dict[str, bytes]:
    """A small batch of blind records, flat: its files by their place."""
    from wirewear.blind import generator_of, make_batch

    make_batch(folder / "batch", cases=2, seed=4, generator=generator_of("T2"))
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def made_result(folder: Path) -> bytes:
    """A short run's result."""
    from wirewear import run_study

    run_study(parse_study(STUDY, "study.toml").changed({"conditions": {"cycles": 1}, "log": {"loop_cycles": (1,)}}),
              fidelity="quick", output=folder)  # fmt: skip
    return (folder / "result.h5").read_bytes()


def scored(folder: Path) -> object:
    """The log of scored runs, appended to."""
    return logged_run(folder / "batch", folder / "diagnoses", {}, folder / "batch.key")


def readers(base: Path) -> dict[str, Reader]:
    """Every reader, by name."""
    record = small_record()
    loops = record["loops.csv"]
    answer = json.dumps(ANSWER).encode()
    batch = made_batch(base / "made")
    (base / "made" / "diagnoses").mkdir()
    scored(base / "made")
    log = (base / "made" / "batch" / LOG).read_bytes()
    key = base / "made" / "batch.key"
    planar = (STUDIES / "cylinder_on_flat" / "study.toml").read_bytes()
    rig = (STUDIES / "rig_stiffness_2d" / "study.toml").read_bytes()
    steel = (STUDIES / "steel_wires" / "study.toml").read_bytes()
    tribometers = (STUDIES / "tribometers" / "tribometers.csv").read_bytes()
    mapping = {"mapping.toml": MAPPING.encode(), "record/loops.csv": loops}
    logged = {f"batch/{LOG}": log, "batch.key": key.read_bytes(), "diagnoses/case_001/diagnosis.json": answer}
    return {
        "study": Reader({"study.toml": steel}, ("study.toml",), studied),
        "planar": Reader({"s.toml": planar}, ("s.toml",), lambda at: load_any_study(at / "s.toml")),
        "rig": Reader({"s.toml": rig}, ("s.toml",), lambda at: load_any_study(at / "s.toml")),
        "record": Reader(record, tuple(record), lambda at: check_record(read_record(at)).to_json()),
        "mapping": Reader(mapping, tuple(mapping), lambda at: import_record(at / "mapping.toml")),
        "loops": Reader({"l.csv": loops}, ("l.csv",), lambda at: analyse_loops(read_loops(at / "l.csv")[:3])),
        "tribometers": Reader({"t.csv": tribometers}, ("t.csv",), lambda at: read_rows(at / "t.csv")),
        "answer": Reader({"d.json": answer}, ("d.json",), lambda at: read_answer(at / "d.json")),
        "batch": Reader(
            batch,
            ("batch/manifest.json", "batch/key.json.enc", "batch.key", "batch/case_001/loops.csv"),
            lambda at: verified(at / "batch", at / "batch.key"),
        ),
        "log": Reader(logged, (f"batch/{LOG}",), scored),
        "result": Reader({"result.h5": made_result(base / "run")}, ("result.h5",), read_results),
    }


def mutant(reader: Reader, seed: int, index: int) -> dict[str, bytes]:
    """Files of which one to three mutations were made."""
    random = Random(f"{seed} {index}")
    files = dict(reader.files)
    for _ in range(random.choice((1, 1, 2, 3))):
        name = random.choice(list(reader.mutated))
        files[name] = random.choice(MUTATIONS)(files[name], random)
    return files


def complaint(reader: Reader, files: Mapping[str, bytes], folder: Path) -> tuple[str, str | None]:
    """How a mutant ended, and what is wrong with that."""
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    started = time.perf_counter()
    ended, wrong = "read", None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            reader.read(folder)
    except BaseException as error:  # noqa: BLE001 - any end but a refusal is what is looked for
        if isinstance(error, WirewearError) or type(error).__name__ in REFUSALS:
            ended = "refused"
            if "\n" in str(error) or not str(error):
                wrong = f"no sentence: {str(error)[:200]!r}"
        else:
            ended, wrong = "traceback", f"{type(error).__name__}: {str(error)[:200]}"
    if (took := time.perf_counter() - started) > LONGEST_s:
        wrong = f"{took:.1f} s"
    return ended, wrong


def run(
    seed: int, count: int, only: Sequence[str] = (), index: int | None = None
) -> tuple[Counter[tuple[str, str]], list[str]]:
    """How so many mutants of all readers ended, and what went wrong."""
    counts: Counter[tuple[str, str]] = Counter()
    wrongs = []
    with tempfile.TemporaryDirectory() as base:
        chosen = {name: reader for name, reader in readers(Path(base)).items() if not only or name in only}
        for name, reader in chosen.items():
            for number in range(count // len(chosen)) if index is None else (index,):
                with tempfile.TemporaryDirectory() as folder:
                    ended, wrong = complaint(reader, mutant(reader, seed, number), Path(folder))
                counts[name, ended] += 1
                if wrong is not None:
                    wrongs.append(f"{name} {number}: {wrong}")
    return counts, wrongs


def main() -> int:
    """Read all mutants and print how they ended."""
    parser = argparse.ArgumentParser(description="mutated inputs of every reader")
    parser.add_argument("--count", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--index", type=int)
    asked = parser.parse_args()
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, MOST_BYTES))
    counts, wrongs = run(asked.seed, asked.count, [name for name in asked.only.split(",") if name], asked.index)
    for name in dict.fromkeys(name for name, _ in counts):
        print(f"{name:12} {', '.join(f'{ended} {n}' for (own, ended), n in sorted(counts.items()) if own == name)}")
    for wrong in wrongs:
        print(wrong)
    print(f"{sum(counts.values()) - len(wrongs)} of {sum(counts.values())} as required")
    return 1 if wrongs else 0


if __name__ == "__main__":
    sys.exit(main())
