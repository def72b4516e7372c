"""New study files for users: every key with its meaning, as a comment where the program chooses the value."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from wirewear.base.files import spelled
from wirewear.base.units import UNIT_SYMBOLS
from wirewear.test.keys import Table, quantity_of, table_of

#: Keys that are left out: tables, and keys that few users need.
HIDDEN = (
    "friction_law", "moving", "fixed", "surface", "layers", "bulk", "update", "explicit_jump_cycles", "formulation",
    "primary_wire",
)  # fmt: skip

COMMENTS_AT = 52  #: Column at which comments begin, where a key and its value leave room.

#: The test of steel wires of the article, with which a new study begins.
EXAMPLE: Mapping[str, Any] = {
    "wires": {"diameter_mm": 0.45, "youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.3},
    "conditions": {"normal_load_N": 2.0, "displacement_amplitude_um": 60.0, "frequency_Hz": 3.0, "cycles": 10000},
    "contact": {"friction": 0.62},
    "wear": {"energy_wear_coefficient_mm3_per_J": 3.0e-5},
    "holder": {"tangential_stiffness_N_per_mm": "rigid"},
}

COMMON = ("conditions", "contact", "wear", "holder", "log")  #: Tables that every contact at a point has, spelled out.


@dataclass(frozen=True)
class Template:
    """A new study of a kind, to be written: the tables `shown`, the nested values of `example`, and the comment
    `above`. tables: class of the whole study. left_out: keys with dots that are not written.
    """

    kind: str
    tables: type[Table]
    shown: tuple[str, ...]
    example: Mapping[str, Any] = field(repr=False)
    above: str
    left_out: tuple[str, ...] = ()


def study_text(
    name: str, template: Template, data: Mapping[str, object] | None = None, above: str | None = None
) -> str:
    """A study as commented TOML text. name: its title, unless `data` gives one; data: nested values, None for the
    template's example; above: comment at its top, None for the template's.
    """
    data, above = template.example if data is None else data, template.above if above is None else above
    lines = [f"# {line}".rstrip() for line in above.splitlines()]
    lines += ["# `wirewear run` runs this study; beside each key stands what it means.", ""]
    lines += ["format = 1", f"name = {spelled(data.get('name', name))}", f"kind = {spelled(template.kind)}"]
    for table in template.shown:
        described = template.tables.model_fields[table]
        inner = table_of(described)
        own = data.get(table)
        # A study without the table of wear does not wear.
        if inner is None or (own is None and table == "wear"):
            continue
        lines += _section(table, described, inner, own if isinstance(own, Mapping) else {}, template.left_out)
    for several in ("effects", "programme"):
        listed = data.get(several)
        lines += _several(several, listed if isinstance(listed, list | tuple) else ())
    return "\n".join(lines) + "\n"


def _section(
    name: str, described: FieldInfo, table: type[Table], own: Mapping[str, Any], left_out: tuple[str, ...]
) -> list[str]:
    keys = _keys(table, own, [*HIDDEN, *(place.removeprefix(f"{name}.") for place in left_out)])
    lines = ["", f"[{name}]  # {described.description}", *keys] if keys else []
    for key, inside in table.model_fields.items():
        inner = table_of(inside)
        if inner is not None and (key in own or key not in HIDDEN):
            stated = own.get(key, {})
            lines += (
                _section(f"{name}.{key}", inside, inner, stated, left_out)
                if isinstance(stated, Mapping)
                else _several(f"{name}.{key}", stated)
            )
    return lines


def _several(name: str, tables: Iterable[Mapping[str, Any]]) -> list[str]:
    keys = ((f"{key} = {spelled(value)}" for key, value in one.items() if value != {}) for one in tables)
    return [line for own in keys for line in ("", f"[[{name}]]", *own)]


def _keys(table: type[Table], own: Mapping[str, Any], hidden: list[str]) -> list[str]:
    lines = []
    # What has a value comes first.
    for key, described in sorted(table.model_fields.items(), key=lambda field: field[0] not in own):
        if (key in hidden and key not in own) or table_of(described) is not None:
            continue
        quantity = quantity_of(described)
        unit = UNIT_SYMBOLS[quantity.unit].strip() if quantity is not None else ""
        meaning = f"{described.description}{f' [{unit}]' if unit else ''}"
        if key in own:
            lines.append(f"{f'{key} = {spelled(own[key])}':{COMMENTS_AT - 2}}  # {meaning}")
            continue
        default = described.examples[0] if described.examples else described.default
        if default is PydanticUndefined or default is None or isinstance(default, tuple) or key == "material":
            lines.append(f"{f'# {key} = ...':{COMMENTS_AT - 2}}  # {meaning}")
        else:
            lines.append(f"{f'# {key} = {spelled(default)}':{COMMENTS_AT - 2}}  # {meaning}")
    return lines
