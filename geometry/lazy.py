"""What a package offers is loaded when it is first asked for (PEP 562)."""

import ast
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any


def loaded_late(package: str) -> Callable[[str], Any]:
    """The `__getattr__` of a package whose `__init__` names under `if TYPE_CHECKING:` what it offers, and from where.

    Types are checked as if it had been imported there; whoever imports one name waits for that name's module alone.
    """

    def load(name: str) -> Any:
        home = _homes(package).get(name)
        if home is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return import_module(f"{home}.{name}") if home == package else getattr(import_module(home), name)

    return load


@cache
def _homes(package: str) -> dict[str, str]:
    """The module of each name that a package's `__init__` names under `if TYPE_CHECKING:`."""
    file = str(sys.modules[package].__file__)
    return {
        alias.name: node.module or ""
        for block in ast.parse(Path(file).read_text(encoding="utf-8"), file).body
        if isinstance(block, ast.If)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
