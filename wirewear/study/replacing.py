"""Values put in place of a study's own, named by their keys with dots between: `conditions.normal_load_N`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wirewear.errors import StudyError
from wirewear.quantity import shown
from wirewear.study.checked import checked_tables, default_loop_cycles
from wirewear.study.tables import StudyTables

#: The key that follows the length of the test where it was left to the program.
LOGGED = "log.loop_cycles"


def with_values(tables: StudyTables, values: Mapping[str, Any], where: str) -> StudyTables:
    """The tables with these values, checked as a file's are; None takes a key back to its default.

    A test of another length is recorded at the same cycles as far as it goes, and at its last.

    Raises:
        StudyError: there is no such key, or its value cannot be; the message is one sentence.
    """
    data = tables.model_dump(mode="json", exclude_none=True)
    for key, value in values.items():
        _put(data, key, value, where)
    if "conditions.cycles" in values and LOGGED not in values:
        data["log"]["loop_cycles"] = _as_far(tables, values["conditions.cycles"])
    return checked_tables(data, where)


def value_at(tables: StudyTables, key: str) -> Any:
    """What stands at a key with dots in it; None where there is none."""
    here: Any = tables.model_dump(mode="json")
    for part in key.split("."):
        here = here.get(part) if isinstance(here, Mapping) else None
    return here


def _as_far(tables: StudyTables, end: object) -> list[int]:
    """The cycles that are recorded up to another end; none, for the program to choose, where the end is no number."""
    logged = tables.log.loop_cycles
    if not isinstance(end, int) or logged == default_loop_cycles(tables.conditions.cycles):
        return []
    return [*logged, end]


def _put(data: dict[str, Any], key: str, value: Any, where: str) -> None:
    *path, last = key.split(".")
    here = data
    for part in path:
        inner = here.setdefault(part, {})
        if not isinstance(inner, dict):
            raise StudyError(f"{shown(part)} in the key {shown(key)} for {where} is no table but a value.")
        here = inner
    if value is None:
        here.pop(last, None)
    else:
        here[last] = value
