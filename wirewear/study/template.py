"""A study file spelled out for people: every key with its meaning, those left to the program as comments."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from pydantic_core import PydanticUndefined

from wirewear.quantity import UNIT_SYMBOLS
from wirewear.study.keys import Table, quantity_of, table_of
from wirewear.study.tables import StudyTables

#: Tables that a template shows with all their keys; the others are for whoever refines meshes.
SHOWN = ("wires", "conditions", "contact", "wear", "holder", "log")

#: Keys that are spelled otherwise than a number or text, or make sense to few.
HIDDEN = ("friction_law", "moving", "fixed", "update", "explicit_jump_cycles", "formulation", "primary_wire")

#: Column at which comments begin, where a key and its value leave room.
COMMENTS_AT = 52

#: The article's test, which a study begins with.
EXAMPLE: Mapping[str, Any] = {
    "wires": {"diameter_mm": 0.45, "youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.3},
    "conditions": {
        "normal_load_N": 2.0,
        "displacement_amplitude_um": 60.0,
        "frequency_Hz": 3.0,
        "cycles": 10000,
    },
    "contact": {"friction": 0.62},
    "wear": {"energy_wear_coefficient_mm3_per_J": 3.0e-5},
    "holder": {"tangential_stiffness_N_per_mm": "rigid"},
}


def study_text(name: str, data: Mapping[str, Any] = EXAMPLE, above: str = "") -> str:
    """A study of crossed wires as commented TOML; `data` are its tables, `above` what is said in its first lines."""
    lines = [f"# {line}".rstrip() for line in above.splitlines()]
    lines += ["# `wirewear run` runs this study; beside each key stands what it means.", ""]
    lines += ["format = 1", f"name = {_spelled(data.get('name', name))}", 'kind = "crossed-wires"']
    for table in SHOWN:
        field = StudyTables.model_fields[table]
        inner = table_of(field)
        own = data.get(table)
        # A study without the table of wear does not wear.
        if inner is None or (own is None and table == "wear"):
            continue
        lines += ["", f"[{table}]  # {field.description}", *_keys(inner, own or {})]
    for effect in data.get("effects", ()):
        lines += ["", "[[effects]]", *(f"{key} = {_spelled(value)}" for key, value in effect.items())]
    return "\n".join(lines) + "\n"


def _keys(table: type[Table], own: Mapping[str, Any]) -> list[str]:
    lines = []
    for key, field in table.model_fields.items():
        if key in HIDDEN and key not in own:
            continue
        quantity = quantity_of(field)
        unit = UNIT_SYMBOLS[quantity.unit].strip() if quantity is not None else ""
        meaning = f"{field.description}{f' [{unit}]' if unit else ''}"
        if key in own:
            lines.append(f"{f'{key} = {_spelled(own[key])}':{COMMENTS_AT}}# {meaning}")
            continue
        default = field.examples[0] if field.examples else field.default
        if default is PydanticUndefined or default is None or isinstance(default, tuple) or key == "material":
            lines.append(f"{f'# {key} = ...':{COMMENTS_AT}}# {meaning}")
        else:
            lines.append(f"{f'# {key} = {_spelled(default)}':{COMMENTS_AT}}# {meaning}")
    return lines


def _spelled(value: object) -> str:
    return json.dumps(list(value) if isinstance(value, tuple) else value, ensure_ascii=False)
