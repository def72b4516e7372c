"""Mutated experiment records: each must be read correctly or refused in one sentence that names file, line and column.

Usage: python -m studies.benchmarks.fuzz_records [--count 5000] [--seed 1] [--only N]

Every mutation is drawn from the seed, so that a failing one can be repeated alone: `--only 17`. Some mutations keep the
meaning (columns or rows in another order, other line ends, blank lines, a byte order mark): these must be read as the
same record. Some destroy it (text for a number, a duplicated cycle, a missing column): these must be refused. The
others may end either way. Exit code 1 if any mutation ends otherwise, in a traceback, or after more than five seconds
of CPU.
"""

import re
import tempfile
import time
import warnings
from collections import Counter
from pathlib import Path

import click
import numpy as np

from wirewear import ExperimentRecord, RecordError, check_record, read_record
from wirewear.faces.study_script import StudyScript

from .record_mutations import MUTATIONS, Files, small_record

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
    started = time.process_time()
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
    if time.process_time() - started > LONGEST_s:
        wrong = wrong or f"it took {time.process_time() - started:.1f} s of CPU"
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


@click.command(cls=StudyScript)
@click.option("--count", type=click.IntRange(1), default=5000, show_default=True)
@click.option("--seed", type=int, default=1, show_default=True)
@click.option("--only", type=click.IntRange(0), help="The mutation of this number alone.")
def main(count: int, seed: int, only: int | None) -> None:
    """Read mutated experiment records and print how they ended."""
    counts, wrongs = run(seed, range(count) if only is None else [only])
    for mutate in MUTATIONS:
        ends = ", ".join(f"{ended} {n}" for (name, ended), n in sorted(counts.items()) if name == mutate.__name__)
        if ends:
            click.echo(f"{mutate.__name__:18} {ends}")
    for wrong in wrongs:
        click.echo(wrong)
    click.echo(f"{sum(counts.values()) - len(wrongs)} of {sum(counts.values())} as required")
    if wrongs:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
