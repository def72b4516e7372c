"""Commands that are to withstand hardships: their arguments, what they read, and what must come out alike."""

import hashlib
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from tests.robustness.forked import Commands
from tests.studies import steel_wires, wires_in_test

STUDY = f"""{steel_wires("two coarse wires", amplitude_um=60.0, cycles=30)}[wear]
energy_wear_coefficient_mm3_per_J = 3.0e-5
[holder]
tangential_stiffness_N_per_mm = 167.0
[log]
loop_cycles = [1, 3, 10, 30]
[fidelity.quick]
contact_mesh_um = 28.0
increments_per_cycle = 16
"""

VARIANTS = """
[variants.compliant]
[variants.stiff]
holder.tangential_stiffness_N_per_mm = 900.0
"""

FLAT = """
format = 1
name = "a coarse cylinder on a flat"
kind = "cylinder-on-flat"
[pad]
radius_mm = 40.0
youngs_modulus_MPa = 116000.0
poissons_ratio = 0.3
[specimen]
youngs_modulus_MPa = 116000.0
poissons_ratio = 0.3
[conditions]
normal_load_N_per_mm = 390.0
displacement_amplitude_um = 35.0
motion = "sinusoidal"
frequency_Hz = 5.0
cycles = 20
[contact]
friction = 0.9
[wear]
pad_energy_mm3_per_J = 2.0e-5
specimen_energy_mm3_per_J = 4.0e-5
[log]
loop_cycles = [1, 5, 20]
[mesh]
contact_mesh_um = 60.0
increments_per_cycle = 16
"""

MAPPING = f"""{wires_in_test("as exported", cycles=30)}[loops]
files = "record/loops.csv"
[loops.columns]
time_s = "time_s"
displacement_um = "displacement_um"
tangential_force_N = "tangential_force_N"
cycle = "cycle"
"""

LINE_MAPPING = """
format = 1
name = "as exported"
[contact]
kind = "line-contact"
length_mm = 5.0
[pad]
radius_mm = 6.0
material = "steel"
[specimen]
material = "steel"
[conditions]
normal_load_N_per_mm = 20.0
displacement_amplitude_um = 30.0
frequency_Hz = 3.0
cycles = 30
[loops]
files = "record/loops.csv"
[loops.columns]
time_s = "time_s"
displacement_um = "displacement_um"
tangential_force_N = { column = "tangential_force_N", unit = "N/mm" }
cycle = "cycle"
repeat = "repeat"
[profiles.specimen]
files = "record/profile_specimen.csv"
[profiles.specimen.columns]
x_um = "x_um"
height_um = { column = "depth_um", factor = -1.0 }
repeat = "repeat"
"""

TEXTS = {"study.toml": STUDY, "variants.toml": STUDY + VARIANTS, "flat.toml": FLAT, "mapping.toml": MAPPING}

BEFORE = "before.txt"  #: A file that lies in an output folder before a command writes there.
_TIMES = ("timings_s",)  #: Arrays of a result that show how long it took.

Outcome = Callable[[Path], dict[str, str]]


@dataclass(frozen=True)
class Command:
    """Arguments of wirewear in a folder, what repeats it, the outcome that must come out alike, and where it goes.

    reads: files or folders.  share: of all trials.  takes_full_folders: whether other files may lie in its output.
    """

    name: str
    first: tuple[str, ...]
    again: tuple[str, ...]
    outcome: Outcome
    output: str
    reads: str
    share: float
    takes_full_folders: bool = True


def digest(data: bytes) -> str:
    """SHA-256."""
    return hashlib.sha256(data).hexdigest()


def all_results(folder: Path) -> dict[str, str]:
    """Digests of all that runs have left in out/: every array of every result, and other files."""
    # The page of a run shows how long it took.
    found = files_of("out", "result.h5", "report.html", BEFORE)(folder)

    def add(place: str, name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset) and not any(time in name for time in _TIMES):
            found[f"{place}: {name}"] = digest(np.asarray(item[()]).tobytes() if item.dtype.kind != "O" else item[()])

    for path in sorted((folder / "out").rglob("result.h5")):
        with h5py.File(path) as file:
            place = path.relative_to(folder).as_posix()
            file.visititems(lambda name, item, place=place: add(place, name, item))
            found[f"{place}: status"] = str(file.attrs.get("status"))
    return found


def files_of(name: str, *left_out: str) -> Outcome:
    """Digests of the files of a folder."""

    def outcome(folder: Path) -> dict[str, str]:
        files = sorted(path for path in (folder / name).rglob("*") if path.is_file() and path.name not in left_out)
        return {path.relative_to(folder).as_posix(): digest(path.read_bytes()) for path in files}

    return outcome


def _run(name: str, file: str, share: float, *options: str) -> Command:
    first = ("run", file, "--fidelity", "quick", "--output", "out", *options)
    return Command(name, first, (*first, "--resume"), all_results, "out", file, share)


def _repeated(name: str, arguments: str, outcome: Outcome, output: str, reads: str, share: float) -> Command:
    return Command(name, *2 * (tuple(arguments.split()),), outcome, output, reads, share, name != "blind")


COMMANDS = (
    _run("run", "study.toml", 0.25),
    _run("variants", "variants.toml", 0.05, "--jobs", "2"),
    _run("planar", "flat.toml", 0.1),
    _repeated("export", "export given --as-record rec --repeats 5 --samples 400", files_of("rec", BEFORE), "rec",
              "given/result.h5", 0.15),
    _repeated("import", "import mapping.toml --output rec", files_of("rec", BEFORE), "rec", "record/loops.csv", 0.15),
    _repeated("compare", "compare given record --output out", files_of("out", BEFORE), "out", "given/result.h5", 0.05),
    # The key and its salt are drawn again.
    _repeated("blind", "studies.blind make batch --cases 2 --tests 1 --seed 3 --jobs 1",
              files_of("batch", "key.json.enc", "manifest.json"), "batch", "study.toml", 0.125),
    _repeated("diagnose", "diagnose record --output answer --model study.toml --jobs 1", files_of("answer", BEFORE),
              "answer", "record/loops.csv", 0.125),
)  # fmt: skip


def prepared(folder: Path, given: Path) -> Path:
    """A new folder with what commands read."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in TEXTS.items():
        (folder / name).write_text(text, encoding="utf-8")
    for name in ("given", "record"):
        if (given / name).exists():
            shutil.copytree(given / name, folder / name)
    return folder


def make_given(commands: Commands, given: Path, cache: Path) -> None:
    """A result and a record for the other commands to read."""
    given.mkdir(parents=True)
    (given / "study.toml").write_text(STUDY, encoding="utf-8")
    for arguments in (
        ("run", "study.toml", "--fidelity", "quick", "--output", "given"),
        ("export", "given", "--as-record", "record", "--repeats", "3", "--samples", "200", "--noise",
         "displacement_um=0.05,tangential_force_N=0.004"),
    ):  # fmt: skip
        ended = commands.run(given, arguments, cache)
        if ended.status != 0:
            raise RuntimeError(f"{arguments[0]} cannot be run: {ended.last_words}")
