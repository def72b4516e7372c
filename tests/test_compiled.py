"""Machine code that is kept on disk."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

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
