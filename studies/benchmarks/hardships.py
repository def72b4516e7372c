"""Commands killed at random moments, on disks that fill up, and on files with flipped bits: is anything lost or wrong?

Usage: python -m studies.benchmarks.hardships [--kills 200] [--full 50] [--flips 300] [--seed 1] [--only run,diagnose]

Each command is run once undisturbed. Then it is killed at a random moment, some of the time on an empty cache, and
given again: the end must be that of the undisturbed one, bit by bit, and nothing may be left beside it. On disks that
fill up, a command must end by itself in one sentence and leave what was there before. Results with a flipped bit must
be refused in one sentence. Prints what failed, and exits with 1 if anything did.

A disk is full at a random size of file (RLIMIT_FSIZE), so that no rights are needed.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

import numpy as np

from wirewear import read_result

STUDY = """
format = 1
name = "two coarse wires"
kind = "crossed-wires"
[wires]
diameter_mm = 0.45
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = 60.0
frequency_Hz = 3.0
cycles = 30
[contact]
friction = 0.62
[wear]
energy_wear_coefficient_mm3_per_J = 3.0e-5
[holder]
tangential_stiffness_N_per_mm = 167.0
[log]
loop_cycles = [1, 3, 10, 30]
[fidelity.quick]
contact_mesh_um = 28.0
increments_per_cycle = 16
"""

MAPPING = """
format = 1
name = "as exported"
[wires]
diameter_mm = 0.45
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = 60.0
frequency_Hz = 3.0
cycles = 30
[loops]
files = "record/loops.csv"
[loops.columns]
time_s = "time_s"
displacement_um = "displacement_um"
tangential_force_N = "tangential_force_N"
cycle = "cycle"
"""

MOST_s = 600.0


@dataclass(frozen=True)
class Command:
    """Arguments of wirewear in a folder, what repeats it, and the files that must come out alike."""

    name: str
    first: tuple[str, ...]
    again: tuple[str, ...]
    outcome: Callable[[Path], dict[str, str]]
    output: str


@dataclass(frozen=True)
class Ended:
    """How a command ended."""

    status: int
    errors: str
    seconds: float

    @property
    def sentence(self) -> bool:
        """Whether it ended by itself in a sentence, and not in a traceback or by a signal."""
        told = [line for line in self.errors.splitlines() if line.startswith("wirewear: ")]
        return self.status == 2 and bool(told) and "Traceback" not in self.errors


def result_numbers(folder: Path) -> dict[str, str]:
    """Digests of all that a run has computed."""
    result = read_result(folder / "out" / "result.h5")
    arrays = {f"evolution {name}": column for name, column in result.evolution.items()}
    arrays |= {f"loop {loop.cycle}": loop.tangential_force_N for loop in result.loops}
    arrays |= {f"scar {scar.cycle} {scar.wire}": scar.depth_um for scar in result.scars}
    return {name: hashlib.sha256(np.ascontiguousarray(array).tobytes()).hexdigest() for name, array in arrays.items()}


def files_of(name: str, *left_out: str) -> Callable[[Path], dict[str, str]]:
    """Digests of the files of a folder."""

    def outcome(folder: Path) -> dict[str, str]:
        files = sorted(path for path in (folder / name).rglob("*") if path.is_file() and path.name not in left_out)
        return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}

    return outcome


COMMANDS = (
    Command(
        "run",
        ("run", "study.toml", "--fidelity", "quick", "--output", "out"),
        ("run", "study.toml", "--fidelity", "quick", "--output", "out", "--resume"),
        result_numbers,
        "out",
    ),
    Command("export", *2 * (("export", "given", "--as-record", "rec", "--repeats", "20", "--samples", "2000"),),
            files_of("rec"), "rec"),
    Command("import", *2 * (("import", "mapping.toml", "--output", "rec"),), files_of("rec"), "rec"),
    Command("blind", *2 * (("blind", "make", "batch", "--cases", "4", "--seed", "3", "--jobs", "1"),),
            # The key and its salt are drawn anew.
            files_of("batch", "key.json.enc", "manifest.json"), "batch"),
    Command("diagnose", *2 * (("diagnose", "record", "--output", "answer", "--model", "study.toml", "--jobs", "1"),),
            files_of("answer"), "answer"),
)  # fmt: skip


def wirewear(
    folder: Path,
    arguments: Sequence[str],
    cache: Path,
    kill_after_s: float | None = None,
    most_bytes: int | None = None,
) -> Ended:
    """Run a command in a folder; kill it and all that it started after some seconds, or let no file grow larger."""
    variables = os.environ | {"WIREWEAR_CACHE": str(cache), "OPENBLAS_NUM_THREADS": "1", "PYTHONUNBUFFERED": "1"}
    limit = "" if most_bytes is None else f"resource.setrlimit(resource.RLIMIT_FSIZE, ({most_bytes},) * 2);"
    command = [sys.executable, "-c", f"import resource; {limit} from wirewear.cli import main; main()", *arguments]
    started = time.perf_counter()
    with subprocess.Popen(
        command, cwd=folder, env=variables, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    ) as process:  # fmt: skip
        try:
            _, errors = process.communicate(timeout=MOST_s if kill_after_s is None else kill_after_s)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            _, errors = process.communicate()
    return Ended(process.returncode, errors, time.perf_counter() - started)


def prepared(folder: Path, given: Path) -> Path:
    """A new folder with what commands read."""
    folder.mkdir(parents=True)
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    (folder / "mapping.toml").write_text(MAPPING, encoding="utf-8")
    for name in ("given", "record"):
        if (given / name).exists():
            shutil.copytree(given / name, folder / name)
    return folder


def make_given(given: Path, cache: Path) -> None:
    """A result and a record for the other commands to read."""
    given.mkdir(parents=True)
    (given / "study.toml").write_text(STUDY, encoding="utf-8")
    for arguments in (
        ("run", "study.toml", "--fidelity", "quick", "--output", "given"),
        ("export", "given", "--as-record", "record", "--repeats", "3", "--samples", "200", "--noise",
         "displacement_um=0.05,tangential_force_N=0.004"),
    ):  # fmt: skip
        ended = wirewear(given, arguments, cache)
        if ended.status != 0:
            raise RuntimeError(f"{arguments[0]} cannot be run: {ended.errors}")


def remains(folder: Path) -> list[str]:
    """What killed writers have left and nobody has cleared away."""
    return [path.name for path in folder.rglob(".*") if ".partial" in path.name]


def killed(command: Command, base: Path, trials: int, random: Random) -> Iterator[str]:
    """Complaints about a command that is killed at random moments and given again."""
    cache = base / "cache"
    whole = prepared(base / command.name / "whole", base / "given")
    undisturbed = wirewear(whole, command.first, cache)
    if undisturbed.status != 0:
        yield f"{command.name} ended with {undisturbed.status}: {undisturbed.errors[-300:]}"
        return
    expected = command.outcome(whole)
    for trial in range(trials):
        folder = prepared(base / command.name / str(trial), base / "given")
        own = folder / "cache" if random.random() < 0.3 else cache
        moments = []
        for _ in range(random.choice((1, 1, 2))):
            moments.append(random.uniform(0.0, 1.1 * undisturbed.seconds))
            wirewear(folder, command.again if len(moments) > 1 else command.first, own, kill_after_s=moments[-1])
        ended = wirewear(folder, command.again, own)
        where = f"{command.name}, killed after {', '.join(f'{moment:.3f}' for moment in moments)} s"
        if ended.status != 0:
            yield f"{where}: ended with {ended.status}: {ended.errors[-300:]}"
        elif command.outcome(folder) != expected:
            yield f"{where}: another outcome"
        elif left := remains(folder / command.output):
            yield f"{where}: {', '.join(left)} left behind"
        else:
            shutil.rmtree(folder)


def on_full_disks(command: Command, base: Path, trials: int, random: Random) -> Iterator[str]:
    """Complaints about a command on disks that take no file above a random size; what it wrote before is there."""
    cache = base / "cache"
    largest = max(path.stat().st_size for path in (base / command.name / "whole").rglob("*") if path.is_file())
    for trial in range(trials):
        folder = prepared(base / command.name / f"full{trial}", base / "given")
        before = folder / command.output / "before.txt"
        before.parent.mkdir(exist_ok=True)
        if command.name != "blind":
            before.write_text("there before")
        most = int(10.0 ** random.uniform(0.0, np.log10(largest)))
        ended = wirewear(folder, command.first, cache, most_bytes=most)
        where = f"{command.name}, files of at most {most} bytes"
        if ended.status != 0 and not ended.sentence:
            yield f"{where}: ended with {ended.status}: {ended.errors[-300:]}"
        elif command.name != "blind" and before.read_text() != "there before":
            yield f"{where}: a file from before is lost"
        else:
            shutil.rmtree(folder)


def with_flipped_bits(base: Path, trials: int, random: Random) -> Iterator[str]:
    """Complaints about a result and what the cache keeps, read with one bit flipped."""
    given = base / "given" / "given" / "result.h5"
    data = given.read_bytes()
    for _ in range(trials):
        place = random.randrange(len(data))
        changed = base / "flipped.h5"
        changed.write_bytes(data[:place] + bytes([data[place] ^ (1 << random.randrange(8))]) + data[place + 1 :])
        try:
            read_result(changed)
        except Exception as refused:  # noqa: BLE001 - what is looked for is whatever is raised
            if type(refused).__name__ == "ResultError":
                continue
            yield f"result.h5, byte {place}: {type(refused).__name__}"
        else:
            yield f"result.h5, byte {place}: taken for whole"


def main() -> int:
    """Do all of it and say what failed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--kills", type=int, default=200, help="of all commands together")
    parser.add_argument("--full", type=int, default=50, help="full disks, of all commands together")
    parser.add_argument("--flips", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default=",".join(command.name for command in COMMANDS))
    arguments = parser.parse_args()
    chosen = [command for command in COMMANDS if command.name in arguments.only.split(",")]
    random, complaints = Random(arguments.seed), []
    with TemporaryDirectory(prefix="hardships-") as name:
        base = Path(name)
        make_given(base / "given", base / "cache")
        for command in chosen:
            for what, trials, found in (
                ("kills", arguments.kills // len(chosen), killed),
                ("full disks", arguments.full // len(chosen), on_full_disks),
            ):
                own = list(found(command, base, trials, random))
                complaints += own
                print(f"{command.name}: {trials} {what}, {len(own)} complaints", flush=True)
                print("".join(f"  {complaint}\n" for complaint in own), end="", flush=True)
        flips = list(with_flipped_bits(base, arguments.flips, random))
        complaints += flips
        print(f"{arguments.flips} flipped bits, {len(flips)} complaints")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
