"""TOML: files and texts read into tables, and tables spelled as text."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wirewear.errors import WirewearError
from wirewear.files.reading import read_text


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
        raise kind(f"{where} is not valid TOML: {reason[:1].lower()}{reason[1:]}.") from None
    except (ValueError, RecursionError):  # what tomllib lets through of overlong integers and deep nesting
        raise kind(f"{where} is not valid TOML: a number is too long or the nesting too deep.") from None


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
