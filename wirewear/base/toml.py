"""TOML: files and texts read into tables, and tables spelled as text."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wirewear.base.errors import WirewearError
from wirewear.base.reading import read_text

#: What is written in a value's place by those who do not know TOML, and what it should be.
_HINTS = {
    r"([-+]?\d+),(\d+(?:e[-+]?\d+)?)": r"the decimal sign is a point: \1.\2",
    r"([-+]?)(\.\d+)": r"a number begins with a digit: \g<1>0\2",
    r"T(rue)": r"it is spelled so: t\1",
    r"F(alse)": r"it is spelled so: f\1",
    r"([-+]?\d[\d.]*(?:e[-+]?\d+)?)\s*[^\W\d][^#,]*": r"the unit stands in the key's name: \1",
    r"([^\W\d][\w.-]*(?: [\w.-]+)*)": r'a text stands in quotes: "\1"',
}


def read_toml(path: Path, kind: type[WirewearError], what: str = "TOML file") -> dict[str, Any]:
    """The tables of a TOML file.

    Raises:
        WirewearError: it cannot be read, or is no valid TOML; of the given kind.
    """
    return parsed_toml(read_text(path, kind, what), str(path), kind)


def parsed_toml(text: str, where: str, kind: type[WirewearError]) -> dict[str, Any]:
    """The tables of a TOML text; `where` names its origin in messages.

    Raises:
        WirewearError: the text is no valid TOML; of the given kind.
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        reason = str(problem)
        raise kind(f"{where} is not valid TOML: {reason[:1].lower()}{reason[1:]}{_hint(text, reason)}.") from None
    except (ValueError, RecursionError):  # what tomllib lets through of overlong integers and deep nesting
        raise kind(f"{where} is not valid TOML: a number is too long or the nesting too deep.") from None


def _hint(text: str, reason: str) -> str:
    """What would be right in the line of an error, where it is known."""
    if (at := re.search(r"line (\d+)", reason)) is None:
        return ""
    key, is_given, value = text.splitlines()[int(at[1]) - 1].split("#")[0].partition("=")
    for wrong, right in _HINTS.items():
        if is_given and (found := re.fullmatch(wrong, value.strip())):
            return f"; {found.expand(right).replace(': ', f': {key.strip()} = ', 1)}"
    return ""


def toml_text(tables: Mapping[str, Any], prefix: str = "") -> str:
    """Tables of texts, numbers, lists and tables as TOML."""
    own = [f"{key} = {_spelled(value)}" for key, value in tables.items() if not isinstance(value, Mapping)]
    inner = []
    for key, value in tables.items():
        if isinstance(value, Mapping) and value:
            name = f"{prefix}{key}"
            inner.append(f"\n[{name}]\n{toml_text(value, f'{name}.')}")
    return "".join(f"{line}\n" for line in own) + "".join(inner)


def _spelled(value: object) -> str:
    # JSON spells texts, numbers and lists as TOML does, but for one control character.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
