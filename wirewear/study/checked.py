"""Nested tables, as a TOML file holds them, made into a study's tables: every key checked, alone and with others."""

from collections.abc import Mapping
from typing import Any

from wirewear.base.errors import StudyError
from wirewear.study.consistency import inconsistency
from wirewear.study.messages import Keys, place, validated
from wirewear.study.tables import Log, StudyTables


def default_loop_cycles(cycles: int) -> tuple[int, ...]:
    """The series 1, 2, 5, 10, 20, 50, ... up to the last cycle, which always belongs to it."""
    decades = [10**exponent for exponent in range(len(str(cycles)))]
    series = {factor * decade for decade in decades for factor in (1, 2, 5)}
    return tuple(sorted({cycle for cycle in series if cycle < cycles} | {cycles}))


def log_within(log: Log, end: int) -> Log:
    """The cycles that a test records: those asked for as far as it goes, and its last in place of later ones."""
    return log.of_cycles(tuple(sorted({min(cycle, end) for cycle in log.loop_cycles or default_loop_cycles(end)})))


def merged(base: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the keys of `overrides` in their place, table by table."""
    whole = dict(base)
    for key, value in overrides.items():
        below = whole.get(key)
        whole[key] = merged(below, value) if isinstance(value, Mapping) and isinstance(below, Mapping) else value
    return whole


def checked_tables(
    data: Mapping[str, Any], where: str, overrides: Mapping[str, Any] | None = None, prefix: str = ""
) -> StudyTables:
    """The tables, checked; `overrides` are those under `prefix`, for messages to name the right table.

    Raises:
        StudyError: they are no tables of a study; the message is one sentence.
    """

    def spelled(keys: Keys) -> str:
        table = ".".join(str(key) for key in keys[:-1])
        return f"{prefix}.{table}".rstrip(".") if prefix and _holds(overrides or {}, keys) else table

    tables = validated(StudyTables, data, where, StudyError, spelled)
    contradiction = inconsistency(tables)
    if contradiction is not None:
        keys, problem = contradiction
        variant = f" (in the variant {prefix.removeprefix('variants.')!r})" if prefix else ""
        raise StudyError(f"{keys[-1]} {place(keys, where, spelled)} {problem}{variant}.")
    return tables.model_copy(update={"log": log_within(tables.log, tables.conditions.cycles)})


def _holds(overrides: Mapping[str, Any], keys: Keys) -> bool:
    """Whether `overrides` hold the key at the end of the path `keys`."""
    here: Any = overrides
    for key in keys:
        if not isinstance(here, Mapping) or key not in here:
            return False
        here = here[key]
    return True
