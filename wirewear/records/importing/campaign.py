"""Campaigns: all tests of a rig, imported by one mapping in whose file names {test} stands for the test.

What differs between tests, as their load, stands in a table beside the mapping, tests.csv: a column `test`, and keys of
the mapping such as `normal_load_N` (of [conditions]) or `contact.friction`.
"""

import csv
import re
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from pathlib import Path
from typing import Any

from wirewear.base.errors import RecordError
from wirewear.base.files import read_text, read_toml
from wirewear.base.words import shown
from wirewear.records.importing.guessed_scars import Touching
from wirewear.records.importing.guessing import GuessedMapping, guessed_mapping, with_files_from
from wirewear.records.importing.importing import import_record

PLACE = "{test}"  #: What stands for a test's name in a campaign's mapping.
MAPPING, TABLE = "mapping.toml", "tests.csv"


@dataclass(frozen=True)
class CampaignTest:
    """One test of a campaign: its name, and the values of its own by the mapping's dotted keys."""

    name: str
    stated: Mapping[str, float | str] = field(default_factory=dict)

    def tables(self, data: dict[str, Any]) -> dict[str, Any]:
        """A mapping's tables for this test: `data` with its name and values in them."""
        found: dict[str, Any] = _named(data, self.name)
        if PLACE not in str(data.get("name", PLACE)):
            found["name"] = f"{data['name']} {self.name}"
        for key, value in self.stated.items():
            table, here = key.split(".") if "." in key else ("conditions", key), found
            for name in table[:-1]:
                here = here.setdefault(name, {})
            here[table[-1]] = value
        return found


def _named(data: Any, name: str) -> Any:
    match data:
        case dict():
            return {key: _named(value, name) for key, value in data.items()}
        case list():
            return [_named(value, name) for value in data]
        case str():
            return data.replace(PLACE, name)
    return data


def campaign_tests(folder: Path) -> list[CampaignTest]:
    """The tests of a campaign's folder, by name: those whose files the mapping finds, and those of tests.csv.

    Raises RecordError if the folder has no mapping, the mapping names no {test}, there is no test, or tests.csv cannot
    be read.
    """
    path = folder / MAPPING
    if not path.is_file():
        raise RecordError(
            f"{folder} has no {MAPPING}: `wirewear new --mapping {folder}` guesses one, in whose file names {PLACE} "
            "stands for the test."
        )
    patterns = [one for one in _files_in(read_toml(path, RecordError)) if PLACE in one]
    if not patterns:
        raise RecordError(
            f"{path} names no {PLACE}: write it in place of what differs between the files of tests, as in files = "
            f'"{PLACE}.csv" or "{PLACE}/loops.csv".'
        )
    stated = _stated(folder / TABLE)
    names = {name for pattern in patterns for name in _names(folder, pattern)} | stated.keys()
    if not names:
        raise RecordError(f"no file below {folder} has a name like {shown(patterns[0])}, as {path} says.")
    return [CampaignTest(name, stated.get(name, {})) for name in sorted(names, key=_natural)]


def why_refused(folder: Path, test: CampaignTest, refusal: str) -> str:
    """Why a test is not read: `refusal` or, where tests.csv has rows of others but none of this one, what keeps its
    files from being read even with what those state, or that the row is missing.
    """
    stated = _stated(folder / TABLE)
    others = {key: value for own in stated.values() for key, value in own.items()}
    if test.name in stated or not others:
        return refusal
    try:
        import_record(folder / MAPPING, replace(test, stated=others))
    except RecordError as problem:
        return str(problem)
    return f"{folder / TABLE} has no row of {test.name}, which must state {', '.join(others)}."


def guessed_campaign(
    folder: Path, known: Mapping[str, object], touching: Touching
) -> tuple[GuessedMapping, list[dict[str, object]]]:
    """Guess the mapping of a campaign's folder, and the rows of its tests.csv, which are conditions that differ.

    A test is a folder, or what begins the names of files that end alike, as A in A_raw.csv and A_scar.csv beside
    B_raw.csv. known, touching: as in `guessed_mapping`. Raises RecordError if no test can be read.
    """
    found: dict[str, GuessedMapping] = {}
    unread = []
    for name, files in _tests_of(folder).items():
        try:
            guess = with_files_from(
                guessed_mapping(files, {"name": PLACE} | dict(known), touching), files[0].parent, folder
            )
        except RecordError as problem:
            unread.append(f"{name} cannot be read: {str(problem).removesuffix('.')}")
        else:
            found[name] = replace(guess, tables=_with_place(guess.tables, name))
    if not found:
        raise RecordError(f"{folder} holds no test that can be read: {'; '.join(unread) or 'it is empty'}.")
    chosen = max(found.values(), key=lambda one: len(one.tables))
    conditions = {name: one.tables.get("conditions", {}) for name, one in found.items()}
    asked = chosen.tables.get("conditions", {})
    differing = [key for key in asked if len({own.get(key) for own in conditions.values()}) > 1]
    alike = {key: own for key, own in asked.items() if key not in differing}
    unlike = [name for name, one in found.items() if _sources(one.tables) != _sources(chosen.tables)]
    remarks = [
        f"{len(found)} tests: {', '.join(found)}",
        *([f"what differs between tests stands in {TABLE}: {', '.join(differing)}"] if differing else []),
        *([f"{', '.join(unlike)}: other columns or another form"] if unlike else []),
        *unread,
    ]
    rows = [{"test": name} | {key: own[key] for key in differing if key in own} for name, own in conditions.items()]
    mapping = GuessedMapping(chosen.tables | {"conditions": alike}, (*remarks, *chosen.remarks))
    return mapping, rows if differing else []


def _tests_of(folder: Path) -> dict[str, list[Path]]:
    """Files of each test below a folder, by its name, in natural order."""
    visible = [path for path in folder.glob("*") if not path.name.startswith(".") and path.name not in (MAPPING, TABLE)]
    within = {path.name: sorted(file for file in path.iterdir() if file.is_file()) for path in visible if path.is_dir()}
    found = {name: files for name, files in within.items() if files} or _beside(
        sorted(path for path in visible if path.is_file())
    )
    return {name: found[name] for name in sorted(found, key=_natural)}


def _beside(files: Sequence[Path]) -> dict[str, list[Path]]:
    """Files of each test where all lie in one folder: those that share the words before endings which most tests have
    (A_raw.csv, A_scar.csv), or else those of one stem.
    """
    words = {path: re.findall(r"[_\W]*[^_\W]+", path.name) for path in files}
    for number in range(1, max(map(len, words.values()), default=0)):
        found = defaultdict[str, list[Path]](list)
        for path, own in words.items():
            found["".join(own[: min(number, len(own) - 1)])].append(path)
        ends = Counter(tuple(path.name.removeprefix(name) for path in own) for name, own in found.items())
        common, tests = max(ends.items(), key=lambda one: len(one[0]) * one[1], default=((), 0))
        if len(common) > 1 and tests > 1 and 2 * len(common) * tests > len(files):
            return found
    return {stem: list(own) for stem, own in groupby(files, lambda path: path.stem)}


def _with_place(data: Any, name: str) -> Any:
    """Copy of a mapping's tables with {test} for the test's name in those of its files."""
    if not isinstance(data, dict):
        return data
    return {
        key: [PLACE + one.removeprefix(name) for one in own] if key == "files" and isinstance(own, list)
        else PLACE + own.removeprefix(name) if key == "files" else _with_place(own, name)
        for key, own in data.items()
    }  # fmt: skip


def _sources(tables: Mapping[str, Any]) -> dict[str, Any]:
    return {key: own for key, own in tables.items() if key not in ("name", "conditions")}


def _files_in(data: Any) -> Iterator[str]:
    """All values of keys `files` in a mapping's tables."""
    if isinstance(data, dict):
        for key, value in data.items():
            if key == "files":
                yield from [value] if isinstance(value, str) else map(str, value)
            else:
                yield from _files_in(value)


def _names(folder: Path, pattern: str) -> Iterator[str]:
    """Names of tests in the paths below a folder that a pattern with {test} fits."""
    parts, places = re.split(r"(\{test\}|\*|\?)", pattern), {"*": "[^/]*", "?": "[^/]"}
    expression = "".join(places.get(part, PLACE if part == PLACE else re.escape(part)) for part in parts)
    expression = expression.replace(PLACE, "(?P<test>[^/]+?)", 1).replace(PLACE, "(?P=test)")
    for path in folder.glob(pattern.replace(PLACE, "*")):
        if (
            path.is_file()
            and path.name not in (MAPPING, TABLE)
            and (found := re.fullmatch(expression, path.relative_to(folder).as_posix()))
        ):
            yield found["test"]


def _natural(name: str) -> list[tuple[int, str]]:
    """Key of an order in which 2 comes before 10."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", name)]


def _stated(path: Path) -> dict[str, dict[str, float | str]]:
    if not path.is_file():
        return {}
    lines = read_text(path, RecordError, "table of tests").splitlines()
    # Where semicolons part the columns, commas are decimal signs.
    parted = ";" if lines and ";" in lines[0] else ","
    rows = list(csv.DictReader(lines, delimiter=parted, skipinitialspace=True))
    if not rows or "test" not in rows[0]:
        raise RecordError(f"{path} must have a column named test, and a row for each test.")
    found: dict[str, dict[str, float | str]] = {}
    for row in rows:
        name = (row.pop("test") or "").strip()
        if name in found:
            raise RecordError(f"{path} has the test {shown(name)} twice.")
        if None in row:
            raise RecordError(f"{path}: the row of {shown(name)} has more fields than columns.")
        found[name] = {key.strip(): _value(text.strip(), parted) for key, text in row.items() if text and text.strip()}
    return found


def _value(text: str, parted: str) -> float | str:
    try:
        return float(text.replace(",", ".") if parted == ";" else text)
    except ValueError:
        return text
