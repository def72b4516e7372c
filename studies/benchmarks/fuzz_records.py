"""Mutated experiment records: each must be read correctly or refused in one sentence that names file, line and column.

Usage: fuzz_records.py [--count 5000] [--seed 1] [--only N]

Every mutation is drawn from the seed, so that a failing one can be repeated alone: `--only 17`. Some mutations keep the
meaning (columns or rows in another order, other line ends, blank lines, a byte order mark): these must be read as the
same record. Some destroy it (text for a number, a duplicated cycle, a missing column): these must be refused. The
others may end either way. Exit code 1 if any mutation ends otherwise, in a traceback, or after more than five seconds.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np

from wirewear import ExperimentRecord, RecordError, check_record, read_record

RECORD = Path(__file__).parent.parent / "steel_wires" / "example_records" / "no_gap"

#: A mutation that takes longer counts as hanging.
LONGEST_s = 5.0

Files = dict[str, bytes]
Random = np.random.Generator
Expected = Literal["same", "refused", "either"]


def small_record() -> Files:
    """Two repeats and two cycles of an example record, every second sample, and a coarse scar map."""
    files = {path.name: path.read_bytes() for path in sorted(RECORD.iterdir())}
    keeps: dict[str, Callable[[list[str]], bool]] = {
        "loops.csv": lambda f: f[1] in ("100", "100000") and int(f[2]) % 4 == 0,
        "evolution.csv": lambda _: True,
        "scar_moving.csv": lambda f: float(f[1]) % 40 == 20 and float(f[2]) % 30 == 0,
        "scar_fixed.csv": lambda f: float(f[1]) % 30 == 20 and float(f[2]) % 30 == 0,
    }
    for name, keep in keeps.items():
        header, *lines = files[name].decode().splitlines()
        kept = [line for line in lines if line[0] != "3" and keep(line.split(","))]
        files[name] = "\n".join([header, *kept, ""]).encode()
    return files


def _csv(files: Files, random: Random) -> str:
    return str(random.choice([name for name in files if name.endswith(".csv")]))


def _cells(data: bytes) -> list[list[str]]:
    return [line.split(",") for line in data.decode().splitlines()]


def _joined(cells: list[list[str]]) -> bytes:
    return "\n".join([*(",".join(row) for row in cells), ""]).encode()


def _required_places(name: str, cells: list[list[str]]) -> list[int]:
    """Columns that the format requires."""
    return [place for place, column in enumerate(cells[0]) if column != "normal_force_N" or name != "loops.csv"]


def _set_cell(files: Files, random: Random, text: str) -> None:
    name = _csv(files, random)
    cells = _cells(files[name])
    cells[random.integers(1, len(cells))][random.integers(len(cells[0]))] = text
    files[name] = _joined(cells)


def text_for_number(files: Files, random: Random) -> Expected:
    """A word where a number should stand."""
    _set_cell(
        files, random, str(random.choice(["abc", "1.2.3", "1;2", "--", "#N/A", "0x1F", "1_000", "µ", "True", "1e"]))
    )
    return "refused"


def missing_value(files: Files, random: Random) -> Expected:
    """An empty field or a NaN."""
    _set_cell(files, random, str(random.choice(["", "NaN", "nan", " "])))
    return "either"


def huge_number(files: Files, random: Random) -> Expected:
    """A number that no sensor gives."""
    _set_cell(files, random, str(random.choice(["1e30", "-1e300", "1e999", "inf", "-inf", "9" * 400])))
    return "refused"


def odd_number(files: Files, random: Random) -> Expected:
    """A number that may or may not make sense."""
    _set_cell(files, random, str(random.choice(["-1", "0.5", "1e4", "-99999", "0", "1e-300", "+3", ".5", "007"])))
    return "either"


def missing_column(files: Files, random: Random) -> Expected:
    """A required column is gone."""
    name = _csv(files, random)
    cells = _cells(files[name])
    place = int(random.choice(_required_places(name, cells)))
    files[name] = _joined([row[:place] + row[place + 1 :] for row in cells])
    return "refused"


def misnamed_column(files: Files, random: Random) -> Expected:
    """A required column has another name."""
    name = _csv(files, random)
    cells = _cells(files[name])
    place = int(random.choice(_required_places(name, cells)))
    cells[0][place] = str(
        random.choice(["", "x", cells[0][place].upper() + "!", cells[0][place - 1], "displacement_mm"])
    )
    files[name] = _joined(cells)
    return "refused"


def reordered_columns(files: Files, random: Random) -> Expected:
    """Columns in another order, and one more."""
    name = _csv(files, random)
    cells = _cells(files[name])
    order = random.permutation(len(cells[0]))
    extra = ["remark", *["text"] * (len(cells) - 1)]
    files[name] = _joined([[row[i] for i in order] + [more] for row, more in zip(cells, extra, strict=True)])
    return "same"


def reordered_rows(files: Files, random: Random) -> Expected:
    """Rows in another order."""
    name = _csv(files, random)
    header, *rows = _cells(files[name])
    files[name] = _joined([header, *(rows[i] for i in random.permutation(len(rows)))])
    return "same"


def other_spelling(files: Files, random: Random) -> Expected:
    """Other line ends, blank lines, a byte order mark, quotes, spaces."""
    name = _csv(files, random)
    data = files[name]
    match random.integers(5):
        case 0:
            data = data.replace(b"\n", b"\r\n")
        case 1:
            data = data.replace(b"\n", b"\n\n")
        case 2:
            data = b"\xef\xbb\xbf" + data
        case 3:
            data = data.replace(b",", b'","').replace(b"\n", b'"\n"')[:-1]
            data = b'"' + data
        case _:
            data = data.replace(b",", b", ").rstrip(b"\n")
    files[name] = data
    return "same"


def ragged_line(files: Files, random: Random) -> Expected:
    """A line with a field too many or too few."""
    name = _csv(files, random)
    cells = _cells(files[name])
    row = cells[random.integers(1, len(cells))]
    if random.random() < 0.5:
        row.append("1")
    else:
        del row[random.integers(len(row))]
    files[name] = _joined(cells)
    return "refused"


def duplicated_cycle(files: Files, random: Random) -> Expected:
    """The rows of one group stand there twice."""
    name = _csv(files, random)
    header, *rows = _cells(files[name])
    group = rows[random.integers(len(rows))][:2]
    again = [row for row in rows if row[:2] == group]
    place = int(random.integers(len(rows)))
    files[name] = _joined([header, *rows[:place], *again, *rows[place:]])
    return "refused"


def missing_rows(files: Files, random: Random) -> Expected:
    """Some rows are gone."""
    name = _csv(files, random)
    header, *rows = _cells(files[name])
    start, stop = sorted(random.integers(0, len(rows) + 1, 2))
    files[name] = _joined([header, *rows[:start], *rows[stop:]])
    return "either"


def truncated(files: Files, random: Random) -> Expected:
    """A file ends early, at any byte."""
    name = str(random.choice(list(files)))
    files[name] = files[name][: random.integers(len(files[name]))]
    return "either"


def empty_file(files: Files, random: Random) -> Expected:
    """A file holds nothing, or blanks, or its first line only."""
    name = str(random.choice(list(files)))
    first = files[name].split(b"\n")[0]
    files[name] = [b"", b"\n\n", b"  ", first, first + b"\n"][random.integers(5)]
    return "refused"


def missing_file(files: Files, random: Random) -> Expected:
    """A file that the record names is not there."""
    del files[str(random.choice(list(files)))]
    return "refused"


def binary_junk(files: Files, random: Random) -> Expected:
    """Random bytes for a file, or in its midst."""
    name = str(random.choice(list(files)))
    data, junk = files[name], random.bytes(int(random.integers(1, 200)))
    place = int(random.integers(len(data)))
    files[name] = junk if random.random() < 0.3 else data[:place] + junk + data[place:]
    return "either"


def flipped_bytes(files: Files, random: Random) -> Expected:
    """A few bytes are others."""
    name = str(random.choice(list(files)))
    data = bytearray(files[name])
    for place in random.integers(len(data), size=random.integers(1, 8)):
        data[place] = random.integers(256)
    files[name] = bytes(data)
    return "either"


def missing_key(files: Files, random: Random) -> Expected:
    """A line of experiment.toml is gone."""
    lines = files["experiment.toml"].splitlines(keepends=True)
    del lines[random.integers(len(lines))]
    files["experiment.toml"] = b"".join(lines)
    return "either"


def odd_value(files: Files, random: Random) -> Expected:
    """A value of experiment.toml is something else."""
    lines = files["experiment.toml"].decode().splitlines()
    places = [place for place, line in enumerate(lines) if "=" in line]
    place = int(random.choice(places))
    odd = [
        "nan",
        "inf",
        "-1",
        '"text"',
        "true",
        "[1]",
        "{}",
        "1e400",
        "9" * 5000,
        "2024-01-01",
        '"../x"',
        "",
        "'a",
        '"\\u0000"',
    ]
    lines[place] = lines[place].split("=")[0] + "= " + odd[random.integers(len(odd))]
    files["experiment.toml"] = "\n".join(lines).encode()
    return "either"


def odd_key(files: Files, random: Random) -> Expected:
    """A key of experiment.toml is misspelt, unknown, given twice, or its table renamed."""
    lines = files["experiment.toml"].decode().splitlines()
    place = int(random.integers(len(lines)))
    line = lines[place]
    lines[place] = [
        line.replace("_", "-", 1),
        f"x{line}",
        f"{line}\n{line}",
        "unknown = 1",
        f"{line[:-1]}",
        "[[wires]]",
    ][random.integers(6)]
    files["experiment.toml"] = "\n".join(lines).encode()
    return "either"


MUTATIONS: tuple[Callable[[Files, Random], Expected], ...] = (
    text_for_number,
    missing_value,
    huge_number,
    odd_number,
    missing_column,
    misnamed_column,
    reordered_columns,
    reordered_rows,
    other_spelling,
    ragged_line,
    duplicated_cycle,
    missing_rows,
    truncated,
    empty_file,
    missing_file,
    binary_junk,
    flipped_bytes,
    missing_key,
    odd_value,
    odd_key,
)


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
    values += [(scar.wire, scar.repeat, scar.x_um.tolist(), scar.depth_um.tolist()) for scar in record.scars]
    return values


def complaint(message: str) -> str | None:
    """What a refusal lacks, if anything: one sentence that names a file, and a line or a missing file."""
    if "\n" in message or not message.endswith((".", "?")) or ". " in message.replace("...", ""):
        return "the refusal is not one sentence"
    if not re.search(r"\.csv|\.toml", message):
        return "the refusal names no file"
    if not re.search(r"line \d+|there is no file|end of document|not valid TOML: a number", message):
        return "the refusal names no line"
    return None


def run_one(
    seed: int, index: int, original: Files, reference: list[object], check: bool
) -> tuple[str, str, str | None]:
    """Name of the mutation, how it ended, and what is wrong with that."""
    random = np.random.default_rng([seed, index])
    mutate = MUTATIONS[index % len(MUTATIONS)]
    files = dict(original)
    expected = mutate(files, random)
    started = time.perf_counter()
    wrong: str | None = None
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, data in files.items():
            (folder / file).write_bytes(data)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                record = read_record(folder)
                read = contents(record)
                if check:
                    check_record(record).to_json()
            ended = "read"
            if expected == "refused":
                wrong = "it should have been refused"
            elif expected == "same" and read != reference:
                wrong = "it was read as something else"
        except RecordError as error:
            ended = "refused"
            message = str(error)
            wrong = complaint(message) if expected != "same" else f"it should have been read, but: {message}"
            if wrong is not None:
                wrong += f": {message}"
        except Exception as error:  # noqa: BLE001 - any other end is what this script is there to find
            ended, wrong = "traceback", f"{type(error).__name__}: {error}"
    if time.perf_counter() - started > LONGEST_s:
        wrong = wrong or f"it took {time.perf_counter() - started:.1f} s"
    return mutate.__name__, ended, wrong


def run(seed: int, indices: range | list[int], check_every: int = 1) -> tuple[Counter[tuple[str, str]], list[str]]:
    """How many of each mutation ended how, and what went wrong; not all that can be read need be checked as well."""
    original = small_record()
    with tempfile.TemporaryDirectory() as name:
        for file, data in original.items():
            (Path(name) / file).write_bytes(data)
        reference = contents(read_record(name))
    counts: Counter[tuple[str, str]] = Counter()
    wrongs = []
    for count, index in enumerate(indices):
        mutation, ended, wrong = run_one(seed, index, original, reference, count % check_every == 0)
        counts[mutation, ended] += 1
        if wrong is not None:
            wrongs.append(f"{index} {mutation}: {wrong}")
    return counts, wrongs


def main() -> None:
    """Run all mutations and print how they ended."""
    parser = argparse.ArgumentParser(description="mutated experiment records")
    parser.add_argument("--count", type=int, default=5000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int)
    asked = parser.parse_args()
    counts, wrongs = run(asked.seed, range(asked.count) if asked.only is None else [asked.only])
    for mutate in MUTATIONS:
        ends = ", ".join(f"{ended} {n}" for (name, ended), n in sorted(counts.items()) if name == mutate.__name__)
        if ends:
            print(f"{mutate.__name__:18} {ends}")
    for wrong in wrongs:
        print(wrong)
    print(f"{sum(counts.values()) - len(wrongs)} of {sum(counts.values())} as required")
    sys.exit(1 if wrongs else 0)


if __name__ == "__main__":
    main()
