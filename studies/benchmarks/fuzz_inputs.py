"""Mutated inputs of every reader: each must be read or refused in one sentence, soon, in little memory.

Usage: python -m studies.benchmarks.fuzz_inputs [--count 20000] [--seed 1] [--only NAME] [--index N]

Bytes, words, numbers and lines of studies, mappings, logger files, records, loops, diagnoses, batches,
logs, results and checkpoints are changed, cut, doubled and moved, and given to readers and commands. Every mutant is
drawn from the seed and its index, so that a failing one can be repeated alone. Exit code 1 if any ends in a traceback,
takes more than 20 s, asks for more than four gigabytes, writes outside of its output folder, or starts, loads or
calls what it was not asked to.
"""

import contextlib
import math
import multiprocessing
import os
import pkgutil
import re
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from random import Random

import click

from wirewear import WirewearError
from wirewear.base.budget import MOST_MEMORY_GB
from wirewear.base.errors import RunError
from wirewear.faces.study_script import StudyScript

from .flipped_bits import flipped
from .forked_commands import load_everything
from .fuzz_commands import commands
from .fuzz_readers import Made, Reader, make, readers
from .watched_child import FORBIDDEN, MOST_BYTES, Ending, ended_in_child

REFUSALS = {"LoopError", "GeometryError", "SolverError", "PatchLeftError"}

#: What stands where something else is expected.
ODD = (
    *("nan", "inf", "-inf", "-1", "0", "1e400", "-1e-400", "9" * 400, "9" * 5000, "1_000", "1e5", "0x10", "true"),
    *("", '""', '"[/]"', "[]", "[[]]", "{}", "{a=1}", "[" * 3000, "{" * 3000, "'", '"', "\\", "\0", "\x7f", "\u202e"),
    *("µ", "１", "../..", "/etc/passwd", "<script>", "%n%s", "1979-05-27", "07:32:00", ",", ";", "\t", "\n", "\r"),
    *("#", "=", "x" * 20_000),
)


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


def mutant(reader: Reader, seed: int, index: int) -> dict[str, bytes]:
    """Files of which one to three mutations were made."""
    random = Random(f"{seed} {index}")
    files = dict(reader.files)
    for _ in range(random.choice((1, 1, 2, 3))):
        name = random.choice(list(reader.mutated))
        files[name] = random.choice(MUTATIONS)(files[name], random)
    finish = reader.finish
    return {name: finish(data) if finish and name in reader.mutated else data for name, data in files.items()}


def put(files: Mapping[str, bytes], folder: Path) -> None:
    """Write files into a folder."""
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)


def ended(reader: Reader, files: Mapping[str, bytes], folder: Path) -> Ending:
    """How a mutant ended, and what is wrong with that."""
    put(files, folder)
    places = [folder / name for name in reader.writes]
    ending = ended_in_child(lambda: _outcome(reader, folder), folder, places)
    if (found := _changed(files, folder, places)) is not None:
        ending = replace(ending, deeds=(*ending.deeds, f"{found} is not as it was"))
    deeds = [one for one in ending.deeds if one not in reader.usual]
    return replace(ending, wrong=f"not asked for: {deeds[0]}") if deeds else ending


def _outcome(reader: Reader, folder: Path) -> tuple[str, str | None]:
    """In the child: how reading ended, and what is wrong with that."""
    os.environ[MOST_MEMORY_GB] = str(0.5e-9 * MOST_BYTES)
    try:
        with warnings.catch_warnings(), stood_in_for(reader):
            warnings.simplefilter("error")
            reader.read(folder)
    except BaseException as error:  # noqa: BLE001 - any end but a refusal is what is looked for
        if isinstance(error, WirewearError) or type(error).__name__ in REFUSALS:
            told = str(error)
            return "refused", f"no sentence: {told[:200]!r}" if "\n" in told or not told else None
        return "traceback", f"{type(error).__name__}: {str(error)[:200]} ({_where(error)})"
    return "read", None


@contextlib.contextmanager
def stood_in_for(reader: Reader) -> Iterator[None]:
    """Something else stands in for the parts of the program that would simulate."""
    before = []
    for name, stand_in in reader.stand_ins.items():
        place, _, attribute = name.partition(":")
        *parents, last = attribute.split(".")
        owner = pkgutil.resolve_name(f"{place}:{'.'.join(parents)}" if parents else place)
        before.append((owner, last, getattr(owner, last)))
        setattr(owner, last, stand_in)
    try:
        yield
    finally:
        for owner, last, own in before:
            setattr(owner, last, own)


def _where(error: BaseException) -> str:
    """The place that raised an error."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{Path(last.filename).name} line {last.lineno}"


def _changed(files: Mapping[str, bytes], folder: Path, places: Sequence[Path]) -> str | None:
    """A file that came, went or changed where nothing may be written, also by libraries that no hook sees."""
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    differs = [name for name in found & set(files) if (folder / name).read_bytes() != files[name]]
    for name in sorted({*(found ^ set(files)), *differs}):
        if not any((folder / name).is_relative_to(place) for place in places):
            return name
    return None


@contextlib.contextmanager
def _prepared(only: Sequence[str]) -> Iterator[dict[str, Reader]]:
    """Readers and commands that take their files as they are."""
    load_everything()
    with tempfile.TemporaryDirectory() as base:
        making = multiprocessing.get_context("fork").Process(target=make, args=(Path(base),))
        making.start()
        making.join()
        made = Made(Path(base))
        chosen = {**readers(made), **commands(made)}
        if unknown := set(only) - set(chosen):
            raise RunError(f"there is no reader or command {min(unknown)!r}: there are {', '.join(chosen)}.")
        chosen = {name: reader for name, reader in chosen.items() if not only or name in only}
        for name, reader in [*chosen.items()]:
            with tempfile.TemporaryDirectory() as folder:
                as_is = ended(reader, reader.files, Path(folder))
            if as_is.how != "read":
                raise RuntimeError(f"{name} does not take what it should: {as_is.how} {as_is.wrong or ''}")
            usual = frozenset(one for one in as_is.deeds if one.startswith(FORBIDDEN))
            chosen[name] = replace(reader, usual=usual)
            if usual >= set(as_is.deeds) and (usual or as_is.wrong is None):
                continue
            # What else it did, such as keeping compiled functions, it does once.
            with tempfile.TemporaryDirectory() as folder:
                as_is = ended(chosen[name], reader.files, Path(folder))
            if as_is.wrong is not None or as_is.how != "read":
                raise RuntimeError(f"{name} does not do the same again: {as_is.how} {as_is.wrong or ''}")
        yield chosen


def run(
    seed: int,
    count: int,
    only: Sequence[str] = (),
    index: int | None = None,
    tell: Callable[[str], object] = lambda _: None,
) -> tuple[Counter[tuple[str, str]], list[str]]:
    """How so many mutants of all readers ended, and what went wrong; `tell` is told of each reader and each wrong."""
    counts: Counter[tuple[str, str]] = Counter()
    wrongs = []
    with _prepared(only) as chosen:
        shares = sum(reader.share for reader in chosen.values())
        for name, reader in chosen.items():
            trials = math.ceil(count * reader.share / shares)
            cpu, peak = 0.0, 0
            for number in range(trials) if index is None else (index,):
                with tempfile.TemporaryDirectory() as folder:
                    ending = ended(reader, mutant(reader, seed, number), Path(folder))
                counts[name, ending.how] += 1
                cpu, peak = max(cpu, ending.cpu_s), max(peak, ending.peak_bytes)
                if ending.wrong is not None:
                    wrongs.append(f"{name} {number}: {ending.wrong}")
                    tell(wrongs[-1])
            endings = ", ".join(f"{how} {n}" for (own, how), n in sorted(counts.items()) if own == name)
            tell(f"{name:28} {endings}; at most {cpu:.1f} s, {1e-9 * peak:.1f} GB")
    return counts, wrongs


@click.command(cls=StudyScript)
@click.option("--count", type=click.IntRange(1), default=20_000, show_default=True)
@click.option("--seed", type=int, default=1, show_default=True)
@click.option("--only", multiple=True, help="A reader or command; may be repeated.")
@click.option("--index", type=click.IntRange(0), help="The mutant of this number alone.")
def main(count: int, seed: int, only: tuple[str, ...], index: int | None) -> None:
    """Give mutated inputs to every reader and command, and print how they ended."""
    counts, wrongs = run(seed, count, only, index, click.echo)
    click.echo(f"{sum(counts.values()) - len(wrongs)} of {sum(counts.values())} as required")
    if wrongs:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
