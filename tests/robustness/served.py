"""A process that has loaded all and computed nothing, so that others can be forked from it; it is asked in JSON.

Threads of libraries do not survive a fork, and starting Python takes longer than most of what is asked.
"""

import importlib
import json
import pkgutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import wirewear

#: What commands load of others when they need it.
OF_OTHERS = ("cryptography.fernet", "gmsh", "h5py", "jinja2", "matplotlib.pyplot", "polars", "rich.progress")


class Served:
    """That process, running a module of this folder."""

    def __init__(self, module: str, *arguments: str) -> None:
        """Start it."""
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
            cwd=Path(__file__).parents[2],
        )  # fmt: skip

    def __enter__(self) -> Self:
        return self

    def __exit__(self, _t: type[BaseException] | None, _e: BaseException | None, _b: TracebackType | None) -> None:
        with self._process as process:
            if process.stdin is not None:
                process.stdin.close()

    def ask(self, asked: Mapping[str, Any]) -> dict[str, Any]:
        """Its answer. Raises RuntimeError if it has ended."""
        stdin, stdout = self._process.stdin, self._process.stdout
        if stdin is None or stdout is None:
            raise RuntimeError("the process that others are forked from has no pipes")
        stdin.write(json.dumps(asked) + "\n")
        stdin.flush()
        line = stdout.readline()
        if not line:
            raise RuntimeError("the process that others are forked from has ended")
        found: dict[str, Any] = json.loads(line)
        return found


def serve(answer: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    """Answer requests until there are no more."""
    for line in sys.stdin:
        sys.stdout.write(json.dumps(answer(json.loads(line))) + "\n")
        sys.stdout.flush()


def load_everything() -> None:
    """Load all that commands need, and compute nothing."""
    ours = (module.name for module in pkgutil.walk_packages(wirewear.__path__, "wirewear."))
    for name in (*OF_OTHERS, *ours):
        # Some modules need packages that need not be there, and one is the program itself.
        with suppress(ImportError):
            if not name.endswith("__main__"):
                importlib.import_module(name)
