"""Campaigns: all tests of a rig, imported by one mapping in whose file names {test} stands for the test.

What differs between tests, as their load, stands in a table beside the mapping, tests.csv: a column `test`, and keys of
the mapping such as `normal_load_N` (of [conditions]) or `contact.friction`.
"""

import csv
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from wirewear.base.errors import RecordError
from wirewear.base.files import read_text, read_toml
from wirewear.base.words import shown

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
            f"{folder} has no {MAPPING}: prepare one from a file of any test (wirewear new --mapping FILE), and write "
            f"{PLACE} in its file names in place of the test's."
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
