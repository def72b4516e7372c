"""Packages whose modules are imported only when one of their names is first used (PEP 562)."""

import ast
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any


def loaded_late(package: str) -> Callable[[str], Any]:
    """The `__getattr__` of a package that imports each of its names on first use.

    package: its dotted name. Its `__init__` imports the names that it offers under `if TYPE_CHECKING:`, from where type
    checkers and this function read which module holds each.
    """

    def load(name: str) -> Any:
        home = _homes(package).get(name)
        if home is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return import_module(f"{home}.{name}") if home == package else getattr(import_module(home), name)

    return load


@cache
def _homes(package: str) -> dict[str, str]:
    """For each name that a package's `__init__` imports under `if TYPE_CHECKING:`, the module it comes from."""
    file = str(sys.modules[package].__file__)
    return {
        alias.name: node.module or ""
        for block in ast.parse(Path(file).read_text(encoding="utf-8"), file).body
        if isinstance(block, ast.If)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
