"""The benchmarks of scaling, of condensation and of the half-space."""

import ast
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from solvers.kept_code import _written
from studies.benchmarks import bench_calculix
from studies.benchmarks.bench_condensation import splu_schur_complement
from studies.benchmarks.bench_half_space import periodic_correction
from studies.benchmarks.bench_scaling import PARTS, Increments, SizeClass, fitted_exponent, size_classes
from studies.benchmarks.bench_scaling import table as scaling_table
from studies.benchmarks.sampled_time import SampledTime
from tests.bodies import STEEL, brick, patch_on
from wirewear.simulation.workbench import (
    schur_complement,
    stiffness_matrix,
)

_INNER = """
from solvers.compiled import compiled

FACTOR = {factor}


@compiled
def shifted(x):
    return x + {shift}
"""
_OUTER = """
from solvers.compiled import compiled
from things.inner import (
    FACTOR,
    shifted,
)


@compiled
def twice_removed(x):
    return FACTOR * shifted(x)
"""
_LAST = """
from solvers.compiled import compiled
from things.outer import twice_removed


@compiled
def answer(x):
    return twice_removed(x)
"""


def _answer(folder: Path, **values: float) -> tuple[float, int]:
    """What the chain of modules answers in a process of its own, and how many functions that loaded from disk."""
    package = folder / "things"
    package.mkdir(exist_ok=True)
    sources = {"__init__": "", "inner": _INNER.format(**values), "outer": _OUTER, "last": _LAST}
    for name, text in sources.items():
        (package / f"{name}.py").write_text(text, encoding="utf-8")
    here = os.pathsep.join([str(folder), *sys.path])
    script = "from things.last import answer; print(answer(1.0), sum(answer.stats.cache_hits.values()))"
    told = subprocess.run(
        [sys.executable, "-B", "-c", script],
        env={**os.environ, "PYTHONPATH": here, "NUMBA_CACHE_DIR": str(folder / "kept")},
        capture_output=True,
        text=True,
        check=True,
    )
    value, loaded = told.stdout.split()
    return float(value), int(loaded)


@pytest.mark.slow
@pytest.mark.parametrize(("change", "expected"), [({"factor": 20.0}, 40.0), ({"shift": 2.0}, 30.0)])
def test_code_from_functions_and_numbers_of_other_files_is_compiled_anew_when_those_change(
    tmp_path: Path, change: dict[str, float], expected: float
) -> None:
    before = {"factor": 10.0, "shift": 1.0}
    assert _answer(tmp_path, **before) == (20.0, 0)
    assert _answer(tmp_path, **before) == (20.0, 1)
    assert _answer(tmp_path, **{**before, **change}) == (expected, 0)


def _kept(folder: Path) -> list[Path]:
    return list((folder / "kept").glob("*.code"))


@pytest.mark.slow
@pytest.mark.parametrize("left", [0, 40, -1])
def test_damaged_code_is_compiled_anew_and_kept_whole(tmp_path: Path, left: int) -> None:
    values = {"factor": 10.0, "shift": 1.0}
    assert _answer(tmp_path, **values) == (20.0, 0)
    for path in _kept(tmp_path):
        path.write_bytes(path.read_bytes()[:left])
    assert _answer(tmp_path, **values) == (20.0, 0)
    assert _answer(tmp_path, **values) == (20.0, 1)


@pytest.mark.slow
def test_code_is_kept_for_its_owner_alone_and_anothers_is_not_loaded(tmp_path: Path) -> None:
    values = {"factor": 10.0, "shift": 1.0}
    _answer(tmp_path, **values)
    assert (tmp_path / "kept").stat().st_mode & 0o777 == 0o700
    (tmp_path / "kept").chmod(0o777)
    assert _answer(tmp_path, **values) == (20.0, 0)


def test_without_any_folder_that_takes_it_code_is_compiled_and_not_kept(tmp_path: Path) -> None:
    (tmp_path / "kept").write_text("a file, no folder")
    assert _answer(tmp_path, factor=10.0, shift=1.0) == (20.0, 0)


def test_a_full_disk_or_a_vanished_folder_does_not_stop_who_compiled(tmp_path: Path) -> None:
    assert not _written(tmp_path / "gone" / "a.code", b"code")
    assert not _written(Path("/dev/full") / "a.code", b"code")


def test_the_exponent_of_a_power_law_is_found() -> None:
    assert fitted_exponent([10.0, 20.0, 40.0], [1.0, 4.0, 16.0]) == pytest.approx(2.0)
    with pytest.raises(ValueError, match="two sizes"):
        fitted_exponent([10.0], [1.0])


def test_images_matter_less_on_a_larger_domain() -> None:
    assert periodic_correction(2.0, 1e5) == pytest.approx(0.5 * periodic_correction(1.0, 1e5))


class Clock:
    """CPU time that passes when it is told to, and then asks for a sample."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s

    def passes(self, cpu_s: float) -> None:
        self.now_s += cpu_s
        signal.raise_signal(signal.SIGPROF)


def parts() -> SampledTime:
    return SampledTime({"outer": ((__file__, "outer_work"),), "inner": ((__file__, "inner_work"),)})


def test_time_goes_to_the_innermost_named_function(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock()
    monkeypatch.setattr("studies.benchmarks.sampled_time.time.process_time", clock)
    monkeypatch.setattr("studies.benchmarks.sampled_time.signal.setitimer", lambda *_: None)
    with parts() as sampled:
        outer_work(clock, 0.2)
        clock.passes(0.01)
    assert sampled.seconds == pytest.approx({"inner": 0.4, "outer": 0.2, "rest": 0.01})


def outer_work(clock: Clock, cpu_s: float) -> None:
    clock.passes(cpu_s)
    inner_work(clock, 2.0 * cpu_s)


def inner_work(clock: Clock, cpu_s: float) -> None:
    clock.passes(cpu_s)


def test_samples_are_taken_while_a_program_works() -> None:
    began = time.process_time()
    with parts() as sampled:
        while not sampled.seconds["rest"]:
            pass
    assert 0.0 < sampled.seconds["rest"] <= time.process_time() - began


def test_the_parts_of_a_run_are_functions_that_exist() -> None:
    for functions in PARTS.values():
        for file, name in functions:
            tree = ast.parse((bench_calculix.REPOSITORY / file).read_text(encoding="utf-8"))
            assert name in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_increments_are_averaged_over_classes_of_doubled_size() -> None:
    increments = Increments(
        np.array([8.0] * 10 + [12.0] * 10 + [40.0] * 3), np.array([1.0] * 10 + [2.0] * 10 + [9.0] * 3)
    )
    assert size_classes(increments) == [SizeClass(20, 10.0, 1.5)]


def test_the_table_of_scaling_ends_with_the_exponent() -> None:
    rows = scaling_table([SizeClass(20, 10.0, 0.001), SizeClass(20, 20.0, 0.002), SizeClass(20, 40.0, 0.008)])
    assert rows[-2].endswith("power 1.50 (all)")
    assert rows[-1].endswith("power 2.00 (the larger half)")


def test_splu_and_nested_substructures_give_the_same_schur_complement() -> None:
    mesh = brick((6, 5, 4), (1.0, 0.9, 0.7), distortion=0.2)
    kept = patch_on(mesh).nodes.ravel()
    eliminated = np.setdiff1d(np.arange(len(mesh.points)), np.union1d(kept, mesh.surface_nodes("grip")))
    matrix = stiffness_matrix(mesh, STEEL)
    direct = splu_schur_complement(matrix, kept, eliminated, 3)
    assert direct == pytest.approx(schur_complement(matrix, kept, eliminated, 3), abs=1e-12 * np.abs(direct).max())
