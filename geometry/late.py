"""What a package offers is loaded when it is first asked for (PEP 562)."""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def loaded_late(package: str) -> Callable[[str], Any]:
    """The `__getattr__` of a package whose `__init__` names under `if TYPE_CHECKING:` what it offers, and from where.

    Types are checked as if it had been imported there; whoever imports one name waits for that name's module alone.
    """
    file = str(sys.modules[package].__file__)
    homes = {
        alias.name: node.module or ""
        for block in ast.parse(Path(file).read_text(encoding="utf-8"), file).body
        if isinstance(block, ast.If)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }

    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        home = homes[name]
        return import_module(f"{home}.{name}") if home == package else getattr(import_module(home), name)

    return load
