"""Machine code that is kept: compiled again where what it comes from changes, healed, and its owner's alone."""

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from solvers.jit_cache import _written

_INNER = """
from solvers.jit_cache import compiled

FACTOR = {factor}


@compiled
def shifted(x):
    return x + {shift}
"""
_OUTER = """
from solvers.jit_cache import compiled
from things.inner import (
    FACTOR,
    shifted,
)


@compiled
def twice_removed(x):
    return FACTOR * shifted(x)
"""
_LAST = """
from solvers.jit_cache import compiled
from things.outer import twice_removed


@compiled
def answer(x):
    return twice_removed(x)
"""


def _answer(folder: Path, values: Mapping[str, float], kept: Path | None = None) -> tuple[float, int]:
    """What the chain of modules answers in a process of its own, and how many functions that loaded from disk."""
    package = folder / "things"
    package.mkdir(exist_ok=True)
    sources = {"__init__": "", "inner": _INNER.format(**values), "outer": _OUTER, "last": _LAST}
    for name, text in sources.items():
        (package / f"{name}.py").write_text(text, encoding="utf-8")
    here = os.pathsep.join([str(folder), *sys.path])
    script = "from things.last import answer; print(answer(1.0), sum(answer.stats.cache_hits.values()))"
    ran = subprocess.run(
        [sys.executable, "-B", "-c", script],
        env={**os.environ, "PYTHONPATH": here, "NUMBA_CACHE_DIR": str(kept or folder / "kept")},
        capture_output=True,
        text=True,
        check=True,
    )
    value, loaded = ran.stdout.split()
    return float(value), int(loaded)


@pytest.mark.slow
@pytest.mark.parametrize(("change", "expected"), [({"factor": 20.0}, 40.0), ({"shift": 2.0}, 30.0)])
def test_code_from_functions_and_numbers_of_other_files_is_compiled_again_when_those_change(
    tmp_path: Path, change: dict[str, float], expected: float
) -> None:
    before = {"factor": 10.0, "shift": 1.0}
    assert _answer(tmp_path, before) == (20.0, 0)
    assert _answer(tmp_path, before) == (20.0, 1)
    assert _answer(tmp_path, {**before, **change}) == (expected, 0)


@pytest.mark.slow
@pytest.mark.parametrize("left", [0, 40, -1])
def test_damaged_code_is_compiled_again_and_kept_whole(tmp_path: Path, left: int) -> None:
    values = {"factor": 10.0, "shift": 1.0}
    assert _answer(tmp_path, values) == (20.0, 0)
    for path in (tmp_path / "kept").glob("*.code"):
        path.write_bytes(path.read_bytes()[:left])
    assert _answer(tmp_path, values) == (20.0, 0)
    assert _answer(tmp_path, values) == (20.0, 1)


@pytest.mark.slow
def test_code_is_kept_for_its_owner_alone_and_anothers_is_not_loaded(tmp_path: Path) -> None:
    values = {"factor": 10.0, "shift": 1.0}
    _answer(tmp_path, values)
    assert (tmp_path / "kept").stat().st_mode & 0o777 == 0o700
    (tmp_path / "kept").chmod(0o777)
    assert _answer(tmp_path, values) == (20.0, 0)


@pytest.mark.seconds
@pytest.mark.slow
def test_two_copies_of_the_program_share_a_folder_and_keep_their_own_code(tmp_path: Path) -> None:
    values, first, second = {"factor": 10.0, "shift": 1.0}, tmp_path / "first", tmp_path / "second"
    for copy, other in ((first, 10.0), (second, 20.0)):
        copy.mkdir()
        assert _answer(copy, values | {"factor": other}, tmp_path / "kept")[1] == 0
    assert _answer(first, values, tmp_path / "kept") == (20.0, 1)


def test_without_a_folder_code_is_compiled_and_a_full_disk_stops_nobody(tmp_path: Path) -> None:
    (tmp_path / "kept").write_text("a file, no folder")
    assert _answer(tmp_path, {"factor": 10.0, "shift": 1.0}) == (20.0, 0)
    assert not _written(tmp_path / "gone" / "a.code", b"code")
    assert not _written(Path("/dev/full") / "a.code", b"code")
