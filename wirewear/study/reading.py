"""Reading a study: TOML text, variants merged over the base, every key checked."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from wirewear.base.errors import StudyError, shown
from wirewear.base.reading import Held, parsed_toml, read_toml, require_no_other
from wirewear.study.consistency import checked_tables, merged
from wirewear.study.lines import LineTables
from wirewear.study.study import LineStudy, Study
from wirewear.study.tables import CROSSED_WIRES, PLANAR_KINDS

FILE_KEYS = ("profile_file", "file")  #: Keys that name a file.


def load_study(path: str | Path) -> Study:
    """Read a study of a contact at a point from a TOML file.
    Raises StudyError, in one sentence, if the file cannot be read, or is no valid study of one.
    """
    return point_study(read_study(path), str(path))


def point_study(data: Mapping[str, Any], where: str) -> Study:
    """A study of a contact at a point from nested tables.
    Raises StudyError, in one sentence, if the tables are no valid study of one.
    """
    if data.get("kind") in PLANAR_KINDS:
        raise StudyError(
            f'{where} is a study of kind "{data["kind"]}", which is not taken here: give one of kind "{CROSSED_WIRES}".'
        )
    study: Study = study_from_tables(data, where)
    return study


def read_study(path: str | Path) -> dict[str, Any]:
    """The tables of the file of a study of any kind.
    Raises StudyError, in one sentence, if it cannot be read, or is another file of ours or of a laboratory.
    """
    require_no_other(Path(path), StudyError, Held.STUDY)
    return _found_from(Path(path).parent, read_toml(Path(path), StudyError, "study file"))


def _found_from(folder: Path, table: dict[str, Any]) -> dict[str, Any]:
    """The table with the files that it names beside the study's own."""
    return {
        key: _found_from(folder, value)
        if isinstance(value, dict)
        else str(folder / value)
        if key in FILE_KEYS and isinstance(value, str)
        else value
        for key, value in table.items()
    }


def parse_study(text: str, where: str) -> Study:
    """Read a study from TOML text; `where` names its origin in messages.
    Raises StudyError, in one sentence, if the text is no valid study.
    """
    return point_study(parsed_toml(text, where, StudyError), where)


def study_from_tables(data: Mapping[str, Any], where: str) -> Any:
    """Build a study of any kind from nested tables such as `Study.resolved()` returns.
    Raises StudyError, in one sentence, if the tables are no valid study.
    """
    base = {key: value for key, value in data.items() if key != "variants"}
    tables: Any = checked_tables(base, where)
    variants: tuple[tuple[str, Any], ...] = tuple(
        (name, checked_tables(merged(base, overrides), where, overrides, f"variants.{name}"))
        for name, overrides in variants_in(data, where)
    )
    return {LineTables: LineStudy}.get(type(tables), Study)(tables, variants)


def variants_in(data: Mapping[str, Any], where: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Names of the variants in a study's tables, and what each has different.
    Raises StudyError if they are no tables, or have no proper names.
    """
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
            if not isinstance(value, Mapping) and key not in ("effects", "programme"):
                raise StudyError(
                    f"{shown(key)} in [variants.{name}] of {where} is {shown(value)}, but a variant holds only tables "
                    f"such as [variants.{name}.holder]."
                )
        yield name, overrides
