"""Reading a study: TOML text, variants merged over the base, every key checked."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from wirewear.errors import StudyError
from wirewear.files.reading import read_text
from wirewear.files.toml import parsed_toml
from wirewear.quantity import shown
from wirewear.study.consistency import inconsistency
from wirewear.study.messages import Keys, place, validated
from wirewear.study.study import Study
from wirewear.study.tables import PLANAR_KINDS, Log, StudyTables


def load_study(path: str | Path) -> Study:
    """Read a study from a TOML file.

    Raises:
        StudyError: the file cannot be read, or is no valid study; the message is one sentence.
    """
    text = read_text(Path(path), StudyError, "study file")
    return parse_study(text, str(path))


def parse_study(text: str, where: str) -> Study:
    """Read a study from TOML text; `where` names its origin in messages.

    Raises:
        StudyError: the text is no valid study; the message is one sentence.
    """
    return study_from_tables(parsed_toml(text, where, StudyError), where)


def study_from_tables(data: Mapping[str, Any], where: str) -> Study:
    """Build a study from nested tables such as `Study.resolved()` returns.

    Raises:
        StudyError: the tables are no valid study; the message is one sentence.
    """
    if data.get("kind") in PLANAR_KINDS:
        raise StudyError(
            f'{where} is a study of kind "{data["kind"]}", which only `wirewear run` takes: '
            'give one of kind "crossed-wires" here.'
        )
    base = {key: value for key, value in data.items() if key != "variants"}
    tables = _checked(base, where, {}, "")
    variants = tuple(
        (name, _checked(_merged(base, overrides), where, overrides, f"variants.{name}"))
        for name, overrides in _variants(data, where)
    )
    return Study(tables, variants)


def default_loop_cycles(cycles: int) -> tuple[int, ...]:
    """The series 1, 2, 5, 10, 20, 50, ... up to the last cycle, which always belongs to it."""
    decades = [10**exponent for exponent in range(len(str(cycles)))]
    series = {factor * decade for decade in decades for factor in (1, 2, 5)}
    return tuple(sorted({cycle for cycle in series if cycle < cycles} | {cycles}))


def _variants(data: Mapping[str, Any], where: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    variants = data.get("variants", {})
    if not isinstance(variants, Mapping):
        raise StudyError(
            f"variants in {where} is {shown(variants)}, but must hold tables like [variants.rigid.holder]."
        )
    for name, overrides in variants.items():
        if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}", name):
            raise StudyError(
                f"the variant {shown(name)} in {where} needs another name: letters, digits, _ and - only, 64 at most."
            )
        if not isinstance(overrides, Mapping):
            raise StudyError(
                f"variants.{name} in {where} is {shown(overrides)}, but must be a table like [variants.{name}.holder]."
            )
        for key, value in overrides.items():
            if not isinstance(value, Mapping) and key != "effects":
                raise StudyError(
                    f"{shown(key)} in [variants.{name}] of {where} is {shown(value)}, but a variant holds only tables "
                    f"such as [variants.{name}.holder]."
                )
        yield name, overrides


def _merged(base: Mapping[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the keys of `overrides` in their place, table by table."""
    merged = dict(base)
    for key, value in overrides.items():
        below = merged.get(key)
        merged[key] = _merged(below, value) if isinstance(value, Mapping) and isinstance(below, Mapping) else value
    return merged


def _checked(data: Mapping[str, Any], where: str, overrides: Mapping[str, Any], prefix: str) -> StudyTables:
    """The tables, checked; `overrides` are those under `prefix`, for messages to name the right table."""

    def spelled(keys: Keys) -> str:
        table = ".".join(str(key) for key in keys[:-1])
        return f"{prefix}.{table}".rstrip(".") if prefix and _holds(overrides, keys) else table

    tables = validated(StudyTables, data, where, StudyError, spelled)
    contradiction = inconsistency(tables)
    if contradiction is not None:
        keys, problem = contradiction
        variant = f" (in the variant {prefix.removeprefix('variants.')!r})" if prefix else ""
        raise StudyError(f"{keys[-1]} {place(keys, where, spelled)} {problem}{variant}.")
    if not tables.log.loop_cycles:
        tables = tables.model_copy(update={"log": Log(loop_cycles=default_loop_cycles(tables.conditions.cycles))})
    return tables


def _holds(overrides: Mapping[str, Any], keys: Keys) -> bool:
    """Whether `overrides` hold the key at the end of the path `keys`."""
    here: Any = overrides
    for key in keys:
        if not isinstance(here, Mapping) or key not in here:
            return False
        here = here[key]
    return True
