"""Mutated inputs of every reader: each must be read or refused in one sentence, soon, in little memory.

Usage: python -m studies.benchmarks.fuzz_inputs [--count 20000] [--seed 1] [--only NAME] [--index N]

Bytes, words, numbers and lines of studies, mappings, logger files, records, loops, tribometers, diagnoses, batches,
logs, results and checkpoints are changed, cut, doubled and moved, and given to readers and commands. Every mutant is
drawn from the seed and its index, so that a failing one can be repeated alone. Exit code 1 if any ends in a traceback,
takes more than ten seconds, asks for more than four gigabytes, writes outside of its output folder, or starts, loads or
calls what it was not asked to.
"""

from __future__ import annotations

import argparse
import contextlib
import faulthandler
import math
import os
import re
import resource
import signal
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

from wirewear import WirewearError

from .flipped_bits import flipped
from .fuzz_readers import Reader, readers

LONGEST_s, MOST_BYTES = 10.0, 4_000_000_000

#: What changes files, and what data may never bring about, by the names of the interpreter's audit events.
CHANGING = ("os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.symlink", "os.link", "os.chmod", "os.truncate")
FORBIDDEN = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "socket.connect",
             "pickle.find_class", "ctypes.dlopen")  # fmt: skip

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


@dataclass
class Watch:
    """Where files may be written while a reader is at work; what else it did that data may not bring about."""

    allowed: tuple[str, ...] = ()
    found: list[str] = field(default_factory=list)
    active: bool = False

    def __call__(self, event: str, arguments: tuple[object, ...]) -> None:
        """Look at what the interpreter is about to do (PEP 578)."""
        if not self.active:
            return
        if event in FORBIDDEN:
            self.found.append(f"{event} {str(arguments)[:100]}")
        elif event in CHANGING or (event == "open" and _writes(arguments)):
            for given in arguments[: 2 if event in ("os.rename", "os.link") else 1]:
                self._changed(event, given)

    def _changed(self, event: str, given: object) -> None:
        # What is opened by its number was opened before.
        if isinstance(given, str | bytes | Path):
            where = Path(os.fsdecode(given)).resolve()
            if not any(where.is_relative_to(one) for one in self.allowed):
                self.found.append(f"{event} {where}")


def _writes(arguments: tuple[object, ...]) -> bool:
    flags = arguments[2]
    return isinstance(flags, int) and bool(flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT))


WATCH = Watch()


class HangError(BaseException):
    """A reader takes too long."""


def _too_long(_signal: int, _frame: object) -> None:
    raise HangError


@contextlib.contextmanager
def watched(allowed: Sequence[Path]) -> Iterator[list[str]]:
    """Watch what is done within; yields what may not be."""
    if not WATCH.allowed:
        sys.addaudithook(WATCH)
    always = ("/dev/null", os.environ.get("WIREWEAR_CACHE", "/nowhere"))
    WATCH.allowed, WATCH.found, WATCH.active = (*always, *(str(path.resolve()) for path in allowed)), [], True
    before = signal.signal(signal.SIGALRM, _too_long)
    signal.setitimer(signal.ITIMER_REAL, LONGEST_s)
    # What no signal interrupts ends the program, and says where it was.
    faulthandler.dump_traceback_later(12.0 * LONGEST_s, exit=True)
    try:
        yield WATCH.found
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        faulthandler.cancel_dump_traceback_later()
        signal.signal(signal.SIGALRM, before)
        WATCH.active = False


def mutant(reader: Reader, seed: int, index: int) -> dict[str, bytes]:
    """Files of which one to three mutations were made."""
    random = Random(f"{seed} {index}")
    files = dict(reader.files)
    for _ in range(random.choice((1, 1, 2, 3))):
        name = random.choice(list(reader.mutated))
        files[name] = random.choice(MUTATIONS)(files[name], random)
    finish = reader.finish
    return files if finish is None else {name: finish(data) for name, data in files.items()}


def complaint(reader: Reader, files: Mapping[str, bytes], folder: Path) -> tuple[str, str | None]:
    """How a mutant ended, and what is wrong with that."""
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    started = time.perf_counter()
    ended, wrong = "read", None
    with watched([folder / name for name in reader.writes]) as done:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                reader.read(folder)
        except KeyboardInterrupt:
            raise
        except HangError:
            ended = "hang"
        except BaseException as error:  # noqa: BLE001 - any end but a refusal is what is looked for
            if isinstance(error, WirewearError) or type(error).__name__ in REFUSALS:
                ended = "refused"
                if "\n" in str(error) or not str(error):
                    wrong = f"no sentence: {str(error)[:200]!r}"
            else:
                ended, wrong = "traceback", f"{type(error).__name__}: {str(error)[:200]}"
    if (took := time.perf_counter() - started) > LONGEST_s:
        wrong = f"{took:.1f} s"
    if done:
        wrong = f"not asked for: {done[0]}"
    return ended, wrong


@contextlib.contextmanager
def _prepared(only: Sequence[str]) -> Iterator[dict[str, Reader]]:
    """The readers, each of which has read its files once as they are, so that all is loaded that it needs."""
    with tempfile.TemporaryDirectory() as base:
        chosen = {name: reader for name, reader in readers(Path(base)).items() if not only or name in only}
        for name, reader in chosen.items():
            with tempfile.TemporaryDirectory() as folder:
                for file, data in reader.files.items():
                    (Path(folder) / file).parent.mkdir(parents=True, exist_ok=True)
                    (Path(folder) / file).write_bytes(data)
                try:
                    reader.read(Path(folder))
                except WirewearError as error:
                    raise RuntimeError(f"{name} refuses what it should read: {error}") from error
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
            for number in range(trials) if index is None else (index,):
                with tempfile.TemporaryDirectory() as folder:
                    ended, wrong = complaint(reader, mutant(reader, seed, number), Path(folder))
                counts[name, ended] += 1
                if wrong is not None:
                    wrongs.append(f"{name} {number}: {wrong}")
                    tell(wrongs[-1])
            endings = ", ".join(f"{ended} {n}" for (own, ended), n in sorted(counts.items()) if own == name)
            tell(f"{name:22} {endings}")
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
    only = [name for name in asked.only.split(",") if name]
    counts, wrongs = run(asked.seed, asked.count, only, asked.index, lambda text: print(text, flush=True))
    print(f"{sum(counts.values()) - len(wrongs)} of {sum(counts.values())} as required")
    return 1 if wrongs else 0


if __name__ == "__main__":
    sys.exit(main())
