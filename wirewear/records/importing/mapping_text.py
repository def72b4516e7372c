"""A guessed mapping spelled as TOML: what should be looked at stands above it, columns on one line each."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from wirewear.base.quantity import as_sentence
from wirewear.base.reading import toml_text
from wirewear.records.importing.guessing import SURFACES, GuessedMapping
from wirewear.records.importing.mistaken import open_lines


def mapping_text(guess: GuessedMapping) -> str:
    """The mapping, to be read by `wirewear import`."""
    tables = dict(guess.tables)
    lines = ["# Guessed by `wirewear new --mapping`; `wirewear import --dry-run` draws what it gives."]
    lines += [f"# – {as_sentence(remark)}" for remark in guess.remarks]
    sources = ("loops", "evolution", *SURFACES)
    lines += ["", toml_text({key: own for key, own in tables.items() if key not in sources}).strip()]
    lines += ["", "[stated]  # what you believe of the rig; `wirewear fit` finds friction, stiffness and wear"]
    for name in ("loops", "evolution"):
        if name in tables:
            lines += _source(name, tables[name])
    for kind in SURFACES:
        for body, source in tables.get(kind, {}).items():
            lines += _source(f"{kind}.{body}", source)
    text = "\n".join(lines) + "\n"
    left = {number for number, _ in open_lines(text)}
    marked = (f"{line}  # fill in" if number in left else line for number, line in enumerate(text.splitlines(), 1))
    return "\n".join(marked) + "\n"


def _source(name: str, source: Mapping[str, Any]) -> list[str]:
    own = {key: value for key, value in source.items() if key != "columns"}
    lines = ["", f"[{name}]", *(f"{key} = {_spelled(value)}" for key, value in own.items())]
    if "columns" in source:
        lines.append(f"[{name}.columns]")
        for key, column in source["columns"].items():
            inside = ", ".join(f"{word} = {_spelled(value)}" for word, value in column.items())
            lines.append(f"{key} = {{ {inside} }}")
    return lines


def _spelled(value: object) -> str:
    # A pattern's backslashes stay as they are.
    if isinstance(value, str) and "\\" in value and "'" not in value:
        return f"'{value}'"
    return json.dumps(value, ensure_ascii=False)
