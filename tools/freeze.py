"""Reference answers of the program, to show that a change which should alter nothing alters nothing.

    python -m tools.freeze make FOLDER       compute the answers with the present code and keep them
    python -m tools.freeze compare FOLDER    compute them again and name every difference; exit code 1 if there is any

It runs the command line only, so it works before and after modules move. Answers of another machine or other versions
of numpy and scipy may differ by more than round-off: freeze and compare in one place. What is kept is

    FOLDER/frozen.json             what froze each group, and the CPU time that it took
    FOLDER/inputs/                 studies, records and loops, copied by `make`: `compare` reads these again
    FOLDER/answers/<group>/        results (HDF5), JSON, records

Numbers agree where they differ by at most the tolerance times the largest number of their array. Times, versions,
hashes and the salt of a key are not compared. One thread computes, so that sums are taken in one order.
"""

import json
import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import click
import numpy as np

from tools.differences import TOLERANCE, tree_differences

ROOT = Path(__file__).resolve().parent.parent
STUDIES = ROOT / "studies"
EXAMPLES = ("no_gap", "free_play_rig", "rigid_stated_compliant_rig")

#: Arguments of `python -m studies.blind make`: a few cases of spent batches' seeds, all of the article's nominal test.
BATCHES = {
    "T0": ("--cases", "2", "--seed", "118823"),
    "T1": ("--cases", "2", "--seed", "905112"),
    "T2": ("--cases", "3", "--seed", "733201", "--law", "weakening"),
}
DIAGNOSED_BATCH = "T2"


# Inputs


def gather_inputs(folder: Path) -> None:
    """Copy studies and example records, and make a small T2 batch and loops, each unless it is there."""
    for name in ("steel_wires", "cylinder_on_flat"):
        _once(folder / "studies" / f"{name}.toml", partial(shutil.copyfile, STUDIES / name / "study.toml"))
    for name in EXAMPLES:
        example = STUDIES / "steel_wires" / "example_records" / name
        _once(folder / "records" / name, partial(shutil.copytree, example))
    _once(folder / "records" / "case_001", lambda to: _made_records(DIAGNOSED_BATCH, to.parent))
    for name, loop in LOOPS.items():
        _once(folder / "loops" / f"{name}.csv", partial(_write_loop, loop))


def _once(path: Path, make: Callable[[Path], object]) -> None:
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        make(path)


def _made_records(tier: str, to: Path) -> None:
    with TemporaryDirectory() as folder:
        for record in _batch(tier, Path(folder)):
            shutil.copytree(record, to / record.name)


@dataclass(frozen=True)
class Loop:
    """A spring and a slider in series; hook at the ends of the stroke, noise and outliers as shares of the friction."""

    friction: float
    stiffness_N_per_um: float
    hook: float = 0.0
    noise: float = 0.0
    outliers: float = 0.0
    has_normal_force: bool = True


LOOPS = {
    "plain": Loop(0.62, 0.16),
    "hooked": Loop(0.62, 0.16, hook=0.4, noise=0.005),
    "noisy": Loop(0.45, 0.4, hook=0.1, noise=0.02, outliers=0.01, has_normal_force=False),
    "partial_slip": Loop(0.9, 0.028, noise=0.002),
}


def _write_loop(loop: Loop, path: Path) -> None:
    load_N, amplitude_um, samples = 2.0, 60.0, 256
    random = np.random.default_rng(len(path.stem))
    stroke = amplitude_um * np.sin(2.0 * np.pi * np.arange(2 * samples) / samples)
    limit = loop.friction * load_N * (1.0 + loop.hook * (stroke / amplitude_um) ** 8)
    force = np.zeros(stroke.size)
    for i in range(1, stroke.size):
        tried = force[i - 1] + loop.stiffness_N_per_um * (stroke[i] - stroke[i - 1])
        force[i] = min(max(tried, -limit[i]), limit[i])
    disturbance = loop.noise * random.standard_normal(force.size) + (random.random(force.size) < loop.outliers)
    columns = {
        "time_s": np.arange(force.size) / (3.0 * samples),
        "displacement_um": stroke,
        "tangential_force_N": force + loop.friction * load_N * disturbance,
    }
    if loop.has_normal_force:
        columns["normal_force_N"] = load_N + loop.noise * random.standard_normal(force.size)
    rows = zip(*(column[samples:].tolist() for column in columns.values()), strict=True)
    lines = [",".join(columns), *(",".join(f"{value:.6f}" for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


# Answers


def wirewear(*arguments: str | Path, may_fail: bool = False, module: str = "wirewear.app.cli") -> str:
    """Run the command line of the present code on one thread; returns what it prints."""
    threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    done = subprocess.run(
        [sys.executable, "-c", f"from {module} import main; main()", *map(str, arguments)],
        env={**os.environ, **threads, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0 and not may_fail:
        raise click.ClickException(f"{module} {' '.join(map(str, arguments))} failed:\n{done.stderr.strip()}")
    return done.stdout


def _simulated(study: str, inputs: Path, answers: Path, *options: str) -> None:
    with TemporaryDirectory() as folder:
        output = Path(folder)
        wirewear("run", inputs / "studies" / f"{study}.toml", "--fidelity", "quick", "--output", output, *options)
        for path in output.rglob("*.h5"):
            kept = answers / path.relative_to(output)
            kept.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, kept)


def _verified(answers: Path) -> None:
    # A failed check is an answer, too.
    wirewear("verify", "--quick", "--json", answers / "verify.json", may_fail=True)


def _loops_analysed(inputs: Path, answers: Path) -> None:
    paths = [*sorted((inputs / "records").iterdir()), *sorted((inputs / "loops").iterdir())]
    for path in paths:
        options = ("--normal-load", "2.0") if path.stem == "noisy" else ()
        (answers / f"{path.stem}.json").write_text(wirewear("loops", path, "--json", *options), encoding="utf-8")


def _diagnosed(inputs: Path, answers: Path) -> None:
    for record in sorted((inputs / "records").iterdir()):
        with TemporaryDirectory() as folder:
            wirewear("diagnose", record, "--output", folder, "--jobs", "1")
            shutil.copyfile(Path(folder) / "diagnosis.json", answers / f"{record.name}.json")


def _batch(tier: str, folder: Path) -> list[Path]:
    """Make a small batch in a folder; its records, the key beside them."""
    options: tuple[str | Path, ...] = (
        "--tier",
        tier,
        *BATCHES[tier],
        "--tests",
        "1",
        "--jobs",
        "1",
        "--key",
        folder / "records.key",
    )
    wirewear("make", folder / "records", *options, module="studies.blind.commands")
    return sorted(path for path in (folder / "records").iterdir() if path.is_dir())


def _batch_made(tier: str, answers: Path) -> None:
    from cryptography.fernet import Fernet

    with TemporaryDirectory() as name:
        folder = Path(name)
        for record in _batch(tier, folder):
            shutil.copytree(record, answers / record.name)
        opener = Fernet((folder / "records.key").read_bytes().strip())
        (answers / "key.json").write_bytes(opener.decrypt((folder / "records" / "key.json.enc").read_bytes()))


GROUPS: dict[str, Callable[[Path, Path], None]] = {
    "runs": lambda inputs, answers: _simulated("steel_wires", inputs, answers, "--jobs", "1"),
    "planar": lambda inputs, answers: _simulated("cylinder_on_flat", inputs, answers),
    "verify": lambda _, answers: _verified(answers),
    "loops": _loops_analysed,
    "diagnoses": _diagnosed,
    "blind_T0": lambda _, answers: _batch_made("T0", answers),
    "blind_T1": lambda _, answers: _batch_made("T1", answers),
    "blind_T2": lambda _, answers: _batch_made("T2", answers),
}


def compute(group: str, inputs: Path, answers: Path) -> float:
    """Compute a group's answers into a new folder; returns the CPU time in seconds."""
    shutil.rmtree(answers, ignore_errors=True)
    answers.mkdir(parents=True)
    before = _cpu_s()
    GROUPS[group](inputs, answers)
    return _cpu_s() - before


def _cpu_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


# Commands


def _chosen(_: click.Context, __: click.Parameter, text: str | None) -> list[str]:
    names = list(GROUPS) if text is None else text.split(",")
    if unknown := [name for name in names if name not in GROUPS]:
        raise click.BadParameter(f"{', '.join(unknown)}: choose from {','.join(GROUPS)}")
    return names


ONLY = click.option("--only", metavar="GROUP,...", callback=_chosen, help="These groups.  [default: all]")


#: CPU seconds are those of one core, the cache of wires empty at the start.
COSTS = """\b
group          answers                                            CPU s
runs           quick steel wires, both rigs                          50
planar         quick cylinder on flat                                 8
verify         verify --quick                                        70
loops          loops of six records and four files                   15
diagnoses      three example records, three of a small T2 batch     100
blind_T0       records and key of a small batch                      40
blind_T1       the same; its wires have a mesh of their own         100
blind_T2       the same                                               6
"""


@click.group(epilog=COSTS)
def main() -> None:
    """Reference answers: make them, and compare with them later."""


@main.command()
@click.argument("folder", type=click.Path(path_type=Path))
@ONLY
def make(folder: Path, only: list[str]) -> None:
    """Compute the reference answers with the present code."""
    gather_inputs(folder / "inputs")
    notes = folder / "frozen.json"
    known = json.loads(notes.read_text(encoding="utf-8")) if notes.exists() else {}
    for group in only:
        cpu_s = compute(group, folder / "inputs", folder / "answers" / group)
        known[group] = {"commit": _commit(), "numpy": np.__version__, "cpu_s": round(cpu_s, 1)}
        notes.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
        click.echo(f"{group}: frozen ({cpu_s:.0f} s of CPU)")


def _commit() -> str:
    asked = ["git", "-C", str(ROOT), "describe", "--always", "--dirty", "--abbrev=10"]
    return subprocess.run(asked, capture_output=True, text=True, check=False).stdout.strip()


@main.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@ONLY
@click.option("--tolerance", type=click.FloatRange(min=0.0), default=TOLERANCE, show_default=True)
@click.option("--most", type=click.IntRange(0), default=20, show_default=True, help="Differences named in each group.")
@click.option("--keep", type=click.Path(path_type=Path), help="Leave the present answers in this folder.")
def compare(folder: Path, only: list[str], tolerance: float, most: int, keep: Path | None) -> None:
    """Compute the answers again and name every difference; exit code 1 if there is any."""
    differ = False
    with TemporaryDirectory() as temporary:
        for group in only:
            frozen, present = folder / "answers" / group, (keep or Path(temporary)) / group
            if not frozen.is_dir():
                raise click.ClickException(
                    f"{folder} holds no answers of {group}: make them with `make --only {group}`."
                )
            cpu_s = compute(group, folder / "inputs", present)
            found = tree_differences(frozen, present, tolerance)
            click.echo(f"{group}: {len(found) or 'no'} differences ({cpu_s:.0f} s of CPU)")
            for one in found[:most]:
                click.echo(f"  {group}/{one}")
            if len(found) > most:
                click.echo(f"  and {len(found) - most} smaller ones")
            differ = differ or bool(found)
    sys.exit(int(differ))


if __name__ == "__main__":
    main()
