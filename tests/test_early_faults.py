"""Faults of version 8318817 repeated through the commands alone, so that this file can be run on that version as well.

docs/promises.md says which other tests guard against the faults that are not here.
"""

import ast
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from random import Random

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

from wirewear import ResultError, read_result
from wirewear.cli import cli

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = (sys.executable, "-c", "from wirewear.cli import main; main()")

WIRES = """
format = 1
name = "two coarse wires"
[wires]
diameter_mm = 0.45
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = 60.0
frequency_Hz = 3.0
cycles = 3
"""

OF_WIRES = """
[contact]
friction = 0.62
[wear]
energy_wear_coefficient_mm3_per_J = 3.0e-5
[holder]
tangential_stiffness_N_per_mm = 167.0
[log]
loop_cycles = [1, 3]
[fidelity.quick]
contact_mesh_um = 28.0
increments_per_cycle = 16
"""

STUDY = f'kind = "crossed-wires"{WIRES}{OF_WIRES}'

LOOPS = """
[loops]
files = "cycle_1.csv"
encoding = "utf-8"
[loops.columns]
time_s = "t"
displacement_um = "x"
tangential_force_N = "q"
cycle = "n"
"""

GB = 10**9


def limited(to: int, what: int = resource.RLIMIT_AS) -> Callable[[], None]:
    return lambda: resource.setrlimit(what, (to, to))


def command(
    folder: Path, *arguments: str, before: Callable[[], None] | None = None, variables: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """A command as users give it; what goes on for a minute is ended."""
    return subprocess.run(
        [*PROGRAM, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
        preexec_fn=before,
        env={**os.environ, **(variables or {})},
    )


def run(folder: Path, *more: str, before: Callable[[], None] | None = None) -> subprocess.CompletedProcess[str]:
    """The study of a folder, run into its folder o."""
    return command(folder, "run", "study.toml", "--fidelity", "quick", "--output", "o", *more, before=before)


def refused(ended: subprocess.CompletedProcess[str]) -> str:
    """The one sentence of a command that refuses."""
    assert ended.returncode == 2, ended.stderr
    told = [line for line in ended.stderr.splitlines() if line.startswith("wirewear: ")]
    assert len(told) == 1, ended.stderr
    assert "Traceback" not in ended.stderr
    return told[0]


def refused_at_once(*arguments: str | Path) -> str:
    """The one sentence of a command in this process."""
    ended = CliRunner().invoke(cli, [str(argument) for argument in arguments])
    assert ended.exit_code == 2, ended.output or ended.exception
    assert ended.stderr.startswith("wirewear: ")
    assert ended.stderr.count("\n") == 1
    return ended.stderr


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a coarse study of three cycles and a mapping with one closed loop."""
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "mapping.toml").write_text(WIRES + LOOPS)
    corners = ((0, 0), (60, 1), (60, 1.2), (0, 1.2), (-60, -1.2), (-60, -1), (0, -1.2), (30, -0.5))
    rows = (f"{0.04 * at},{x},{q},1" for at, (x, q) in enumerate(corners))
    (tmp_path / "cycle_1.csv").write_text("\n".join(("t,x,q,n", *rows, "")))
    return tmp_path


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the study and its result in o."""
    made = tmp_path_factory.mktemp("ran")
    (made / "study.toml").write_text(STUDY)
    ended = run(made)
    assert ended.returncode == 0, ended.stderr
    return made


@pytest.fixture
def result(ran: Path, tmp_path: Path) -> Path:
    """A copy of that result."""
    return Path(shutil.copy(ran / "o" / "result.h5", tmp_path / "result.h5"))


def changed(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


# A. Wrong or old answers


@pytest.mark.slow
def test_a_complete_run_is_not_handed_out_by_other_code(folder: Path, ran: Path) -> None:
    shutil.copytree(ran / "o", folder / "o")
    for package in ("geometry", "solvers", "wirewear"):
        shutil.copytree(ROOT / package, folder / package)
    with (folder / "solvers" / "jumps.py").open("a") as file:
        file.write("\n# changed\n")
    code = f"import sys; sys.path.insert(0, {str(folder)!r}); from wirewear.cli import main; main()"
    ended = subprocess.run(
        [sys.executable, "-P", "-c", code, "run", "study.toml", "--fidelity", "quick", "--output", "o", "--resume"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "another version of the program" in ended.stdout + ended.stderr
    assert read_result(folder / "o" / "result.h5").status == "complete"


@pytest.mark.slow
def test_no_changed_byte_of_a_result_goes_unseen(result: Path) -> None:
    data, random = result.read_bytes(), Random(1)
    for _ in range(50):
        at = random.randrange(len(data))
        result.write_bytes(data[:at] + bytes([data[at] ^ random.randrange(1, 256)]) + data[at + 1 :])
        with pytest.raises(ResultError):
            read_result(result)


@pytest.mark.slow
def test_of_two_runs_into_one_folder_at_once_the_second_is_refused(folder: Path) -> None:
    changed(folder / "study.toml", "cycles = 3\n", "cycles = 3000\n")
    arguments = (*PROGRAM, "run", "study.toml", "--fidelity", "quick", "--output", "o")
    with subprocess.Popen(arguments, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as first:
        appears(folder / "o" / "result.h5")
        (folder / "other").mkdir()
        (folder / "other" / "study.toml").write_text(STUDY)
        second = command(folder, "run", "other/study.toml", "--fidelity", "quick", "--output", "o")
        assert first.poll() is None
        first.kill()
    assert refused(second)


@pytest.mark.slow
def test_nothing_of_an_older_time_series_stays_beside_a_new_one(folder: Path, ran: Path) -> None:
    shutil.copytree(ran / "o", folder / "o")
    (folder / "o" / "result.h5").unlink()
    changed(folder / "study.toml", "cycles = 3\n", "cycles = 1\n")
    changed(folder / "study.toml", "[1, 3]", "[1]")
    assert run(folder).returncode == 0
    series = {path.name for path in (folder / "o" / "vtk").glob("*.vtu")}
    assert series < {path.name for path in (ran / "o" / "vtk").glob("*.vtu")}


# B. Crashes and lost runs


def appears(path: Path) -> None:
    until = time.monotonic() + 120.0
    while not path.exists():
        assert time.monotonic() < until, f"{path} does not appear"
        time.sleep(0.02)


SMALL_DISK = ("unshare", "-rm", "sh", "-c", 'mount -t tmpfs -o size=64k none "$1" && shift && "$@"', "sh")


@pytest.mark.slow
def test_a_disk_that_is_full_at_a_checkpoint_is_one_sentence_and_no_crash(folder: Path) -> None:
    (folder / "o").mkdir()
    if (
        shutil.which("unshare") is None
        or subprocess.run([*SMALL_DISK, "o", "true"], cwd=folder, check=False).returncode
    ):
        pytest.skip("this user cannot mount a small disk")
    changed(folder / "study.toml", "cycles = 3\n", "cycles = 30\n")
    arguments = (*PROGRAM, "run", "study.toml", "--fidelity", "quick", "--output", "o/o")
    ended = subprocess.run([*SMALL_DISK, "o", *arguments], cwd=folder, capture_output=True, text=True, check=False)
    sentence = refused(ended)
    assert "cannot write the checkpoint" in sentence
    assert "--resume goes on" in sentence


@pytest.mark.slow
def test_a_run_that_was_killed_before_its_first_result_can_be_resumed(folder: Path) -> None:
    arguments = (*PROGRAM, "run", "study.toml", "--fidelity", "quick", "--output", "o")
    changed(folder / "study.toml", "cycles = 3\n", "cycles = 30\n")
    with subprocess.Popen(arguments, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        appears(folder / "o" / "checkpoint.h5")
        process.send_signal(signal.SIGKILL)
    (folder / "o" / "result.h5").unlink(missing_ok=True)
    ended = run(folder, "--resume")
    assert ended.returncode == 0, ended.stderr
    assert read_result(folder / "o" / "result.h5").status == "complete"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"contact_mesh_um = 28.0": "contact_mesh_um = 0.1"}, "give contact_mesh_um = "),
        (
            {
                "cycles = 3\n": "cycles = 1000000000\n",
                "[wear]\n": '[wear]\nupdate = "explicit"\nexplicit_jump_cycles = 0.01\n',
                "3.0e-5": "1e-10",
            },
            "cycle jumps",
        ),
    ],
)
def test_a_study_that_no_machine_holds_is_not_begun(folder: Path, changes: dict[str, str], words: str) -> None:
    for old, new in changes.items():
        changed(folder / "study.toml", old, new)
    assert words in refused(run(folder, before=limited(4 * GB)))


@pytest.mark.slow
def test_an_export_and_a_batch_that_no_machine_holds_are_not_begun(result: Path, tmp_path: Path) -> None:
    samples = ("--repeats", "1000", "--samples", "100000")
    export = command(tmp_path, "export", result.name, "--as-record", "r", *samples, before=limited(4 * GB))
    assert "samples, which take" in refused(export)
    batch = command(tmp_path, "blind", "make", "b", "--cases", "1000000000", "--seed", "1", before=limited(4 * GB))
    assert "of disk" in refused(batch)


@pytest.mark.parametrize("old", ["friction = 0.62", "normal_load_N = 2.0"])
def test_a_number_of_hundreds_of_digits_is_refused(folder: Path, old: str) -> None:
    changed(folder / "study.toml", old, f"{old.partition(' ')[0]} = {'9' * 309}")
    assert len(refused_at_once("run", folder / "study.toml", "--output", folder / "o")) < 400


@pytest.mark.parametrize("encoding", ["zlib", "hex", "rot13", "base64"])
def test_an_encoding_that_is_none_of_text_is_refused(folder: Path, encoding: str) -> None:
    changed(folder / "mapping.toml", '"utf-8"', f'"{encoding}"')
    assert "encoding" in refused_at_once("import", folder / "mapping.toml", "--output", folder / "r")


SCARS = '[scars.moving]\nfiles = "more.csv"\ncolumns = { x_um = "x", y_um = "y", depth_um = "d", repeat = "n" }\n'
EVOLUTION = '[evolution]\nfiles = "more.csv"\ncolumns = { cycle = "cycle", repeat = "n" }\n'


@pytest.mark.parametrize(
    ("table", "rows"),
    [
        (SCARS, "x,y,d,n\n0,0,1,nan\n"),
        (EVOLUTION, "cycle,n\n1,inf\n"),
        (EVOLUTION, "cycle,n\n1,1e300\n"),
        (EVOLUTION, f"cycle,n\n{'9' * 200},1\n"),
    ],
)
def test_a_repeat_or_cycle_that_is_no_number_is_refused(folder: Path, table: str, rows: str) -> None:
    changed(folder / "mapping.toml", "[loops]", f"{table}[loops]")
    (folder / "more.csv").write_text(rows)
    assert "whole number" in refused_at_once("import", folder / "mapping.toml", "--output", folder / "r")


@pytest.mark.slow
def test_sixty_thousand_points_at_random_are_refused(folder: Path) -> None:
    changed(folder / "mapping.toml", "[loops]", f"{SCARS}[loops]")
    random = Random(1)
    rows = (f"{random.random()},{random.random()},1,1" for _ in range(60_000))
    (folder / "more.csv").write_text("\n".join(("x,y,d,n", *rows, "")))
    ended = command(folder, "import", "mapping.toml", "--output", "r", before=limited(4 * GB))
    assert "which is no grid" in refused(ended)


@pytest.mark.slow
def test_a_pattern_that_would_need_for_ever_ends(folder: Path) -> None:
    name = f"cycle_{'1' * 60}.csv"
    (folder / "cycle_1.csv").rename(folder / name)
    pattern = r"name_pattern = '(cycle)_(?P<cycle>(\d+)+)x'"
    changed(folder / "mapping.toml", 'files = "cycle_1.csv"', f'files = "cycle_*.csv"\n{pattern}')
    changed(folder / "mapping.toml", 'cycle = "n"\n', "")
    assert "takes too long" in refused(command(folder, "import", "mapping.toml", "--output", "r"))


@pytest.mark.slow
def test_a_study_may_have_a_name_like_markup(folder: Path) -> None:
    changed(folder / "study.toml", "two coarse wires", "wires [/] [b]")
    ended = run(folder)
    assert ended.returncode == 0, ended.stderr


@pytest.mark.slow
def test_a_package_whose_effect_cannot_be_loaded_is_named(folder: Path) -> None:
    (folder / "gremlin.py").write_text("1 / 0\n")
    facts = folder / "gremlin-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: gremlin\nVersion: 1.0\n")
    (facts / "entry_points.txt").write_text("[wirewear.effects]\ngremlin = gremlin:Gremlin\n")
    assert "gremlin" in refused(command(folder, "effects"))


# C. What reaches beyond its folder


@pytest.mark.slow
def test_a_link_out_of_a_result_is_not_followed(result: Path, tmp_path: Path) -> None:
    moved = result.rename(tmp_path / "moved.h5")
    with h5py.File(moved) as source, h5py.File(result, "w") as file:
        file.attrs.update(source.attrs)
        for name in source:
            file[name] = h5py.ExternalLink(str(moved), f"/{name}")
    with pytest.raises(ResultError):
        read_result(result)


def test_a_mapping_quotes_no_file_of_the_system(folder: Path) -> None:
    changed(folder / "mapping.toml", '"cycle_1.csv"', '"/etc/passwd"')
    assert "root:" not in refused_at_once("import", folder / "mapping.toml", "--output", folder / "r")


# D. What held


@pytest.mark.slow
def test_the_same_numbers_come_out_in_another_folder_and_locale_and_with_two_threads(ran: Path, folder: Path) -> None:
    elsewhere = {"LC_ALL": "C", "PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo"}
    threads = {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2"}
    for variables, to in ((elsewhere, 0.0), (threads, 1e-12)):
        ended = command(folder, "run", "study.toml", "--fidelity", "quick", "--output", str(to), variables=variables)
        assert ended.returncode == 0, ended.stderr
        one, other = (read_result(path / "result.h5").evolution for path in (ran / "o", folder / str(to)))
        for name in one:
            np.testing.assert_allclose(other[name], one[name], rtol=to, err_msg=name)


def test_no_code_comes_from_data() -> None:
    found = []
    for package in ("geometry", "solvers", "wirewear"):
        for file in (ROOT / package).rglob("*.py"):
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                names = {alias.name for alias in node.names} if isinstance(node, ast.Import) else set()
                names |= {str(node.module)} if isinstance(node, ast.ImportFrom) else set()
                names |= {node.func.id} if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else set()
                names |= {str(node.arg)} if isinstance(node, ast.keyword) else set()
                found += [
                    f"{file}: {name}"
                    for name in names & {"pickle", "marshal", "shelve", "eval", "exec", "allow_pickle"}
                ]
    assert found == []


# E. Messages


@pytest.mark.slow
def test_a_result_that_is_cut_off_says_how_much_is_left(ran: Path, folder: Path) -> None:
    shutil.copytree(ran / "o", folder / "o")
    result = folder / "o" / "result.h5"
    result.write_bytes(result.read_bytes()[:20_000])
    sentence = refused(command(folder, "show", "o"))
    assert "is cut off: 20\u2009000 of" in sentence
    assert "base_addr" not in sentence


def test_a_file_that_may_not_be_read_is_told_as_all_else(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("click.types.os.access", lambda *_: False)
    assert refused_at_once("check", folder).endswith(f"'{folder}' is not readable.\n")
