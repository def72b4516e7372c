"""What a study's TOML file may hold, and how it is read.

What it offers is loaded when it is first asked for: the command line lists the levels of fidelity, and reads no study.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from wirewear.study.fidelity import FIDELITIES

if TYPE_CHECKING:
    from wirewear.study.reading import load_study, parse_study, study_from_tables
    from wirewear.study.study import Study, Wire
    from wirewear.study.tables import FidelitySettings

#: The file of each name.
_HOMES = {
    "reading": ("load_study", "parse_study", "study_from_tables"),
    "study": ("Study", "Wire"),
    "tables": ("FidelitySettings",),
}

__all__ = [
    "FIDELITIES",
    "FidelitySettings",
    "Study",
    "Wire",
    "load_study",
    "parse_study",
    "study_from_tables",
]


def __getattr__(name: str) -> Any:
    for file, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"wirewear.study.{file}"), name)
    raise AttributeError(f"module 'wirewear.study' has no attribute {name!r}")
