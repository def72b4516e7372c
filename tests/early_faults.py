"""Commands as users give them, a coarse study and a mapping: what tests of an early version's faults share.

They use commands alone, so that they can be run on version 8318817 as well.
"""

import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = (sys.executable, "-c", "from wirewear.faces import main; main()")
_FROM_HERE = f"import sys; sys.path.insert(0, {str(ROOT)!r})"
EXAM = (sys.executable, "-c", f"{_FROM_HERE}; from studies.blind.commands import main; main()")
RUN = ("run", "study.toml", "--fidelity", "quick", "--output", "o")

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
    folder: Path,
    *arguments: str,
    before: Callable[[], None] | None = None,
    variables: Mapping[str, str] | None = None,
    program: Sequence[str] = PROGRAM,
) -> subprocess.CompletedProcess[str]:
    """A command as users give it; what goes on without end is ended."""
    return subprocess.run(
        [*program, *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=1200,
        preexec_fn=before,
        env={**os.environ, **(variables or {})},
    )


def run(folder: Path, *more: str, before: Callable[[], None] | None = None) -> subprocess.CompletedProcess[str]:
    """The study of a folder, run into its folder o."""
    return command(folder, *RUN, *more, before=before)


def refused(ended: subprocess.CompletedProcess[str]) -> str:
    """The one sentence with which a command refuses, after what it had got to."""
    assert ended.returncode == 2, ended.stderr
    *progress, sentence = ended.stderr.splitlines()
    assert all(line.startswith("wirewear: ") and not line.endswith(".") for line in progress), ended.stderr
    assert sentence.startswith("wirewear: ")
    return sentence


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


@contextmanager
def held(folder: Path, *names: str) -> Iterator[subprocess.Popen[bytes]]:
    """The study of a folder on its way into its folder o, stopped before its end with these files there; killed then.

    A run that came to its end before it could be stopped is begun again: how fast it is differs from time to time.
    """
    for _ in range(20):
        with subprocess.Popen(
            (*PROGRAM, *RUN), cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as process:
            while process.poll() is None and not all((folder / "o" / name).exists() for name in names):
                time.sleep(0.01)
            process.send_signal(signal.SIGSTOP)
            os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WEXITED | os.WNOWAIT)
            if process.poll() is None and all((folder / "o" / name).exists() for name in names):
                try:
                    yield process
                finally:
                    process.kill()
                return
        assert process.returncode == 0
        shutil.rmtree(folder / "o")
    pytest.fail(f"the run of {folder} ends before it can be stopped")
