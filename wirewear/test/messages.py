"""Failed checks of a TOML file's tables as one sentence: what is wrong, where, and what would be right.

`keys` are the path from the top of a file to a key, a number standing for the place in a list of tables; `where` is the
name of the file in messages; a `Spelling` gives the table that holds a key, as that file writes it.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from typing import TypeVar

from pydantic import ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from wirewear.base.errors import WirewearError
from wirewear.base.units import UNIT_NAMES, words_of
from wirewear.base.words import as_sentence, shown
from wirewear.test.keys import Table, quantity_of, table_of
from wirewear.test.tables import StudyTables

Model = TypeVar("Model", bound=Table)
Keys = Sequence[int | str]
Spelling = Callable[[Keys], str]  #: Gives the table that holds a key, as it is spelled in the file.


def table_above(keys: Keys) -> str:
    """The table that holds a key, as a file without variants writes it: "holder" for ("holder", "pivot_height_mm")."""
    return ".".join(map(str, keys[:-1]))


def validated(
    model: type[Model],
    data: Mapping[str, object],
    where: str,
    kind: type[WirewearError],
    spelled: Spelling = table_above,
) -> Model:
    """An instance of `model` of these tables. Raises `kind`, in one sentence, if they do not fit the model."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise kind(first_problem(error, where, model, spelled)) from None


def first_problem(
    error: ValidationError, where: str, model: type[Table] = StudyTables, spelled: Spelling = table_above
) -> str:
    """One sentence on what pydantic found in the tables of `model`; several if there are several unknown keys."""
    problems = error.errors(include_url=False)
    unknown = [problem for problem in problems if problem["type"] == "extra_forbidden"]
    sentences: list[str] = []
    for problem in unknown or problems[:1]:
        start, _, rest = _sentence(problem, where, model, spelled).partition(": ")
        # What follows is said once for all keys of a table.
        said = not rest or any(one.endswith(f": {rest}") for one in sentences)
        sentences.append(as_sentence(start) if said else f"{start}: {rest}")
    return " ".join([sentences[0], *(f"{one[0].upper()}{one[1:]}" for one in sentences[1:])])


def _sentence(problem: ErrorDetails, where: str, model: type[Table], spelled: Spelling) -> str:
    *table, key = problem["loc"]
    match problem["type"]:
        case "extra_forbidden":
            return _unknown_key(table, str(key), where, spelled, model)
        case "missing":
            return _missing_key(table, str(key), where, spelled, model)
        case "value_error":
            return as_sentence(f"{key} {place([*table, key], where, spelled)} {problem['ctx']['error']}")
        case kind:  # the remaining types say that a table is expected, or several
            wanted = "a list of tables, each under a heading in double brackets" if kind == "tuple_type" else "a table"
            named = f"number {key + 1} of the list" if isinstance(key, int) else key
            return f"{named} {place([*table, key], where, spelled)} is {shown(problem['input'])}, but must be {wanted}."


def telling_problem(error: ValidationError) -> ErrorDetails:
    """The problem that explains the others: an unknown key, else the first one."""
    problems = error.errors(include_url=False)
    return next((p for p in problems if p["type"] == "extra_forbidden"), problems[0])


def place(keys: Keys, where: str, spelled: Spelling) -> str:
    """A key's table in words, as "in [wires] of study.toml", or "in study.toml" for a key at the top."""
    if len(keys) > 2 and isinstance(keys[-2], int):
        return f"in [[{'.'.join(map(str, keys[:-2]))}]] number {keys[-2] + 1} of {where}"
    table = spelled(keys)
    return f"in [{table}] of {where}" if table else f"in {where}"


def _unknown_key(table: Keys, key: str, where: str, spelled: Spelling, model: type[Table]) -> str:
    known = known_fields(table, model)
    start = f"unknown key {shown(key)} {place([*table, key], where, spelled)}"
    if hint := _table_at(table, model).elsewhere.get(key):
        return f"{start}: {hint}."
    for name, field in known.items():
        quantity = quantity_of(field)
        if quantity is not None and same_but_for_unit(key, name, quantity.unit):
            return f"{start}: the {field.description} is given as {name}, in {UNIT_NAMES[quantity.unit]}."
    # A key without the words that distinguish it from others is meant as the one that must be given.
    given = set(words_of(key).split())
    whole = [name for name in known if given and given <= set(words_of(name).split())]
    whole.sort(key=lambda name: not known[name].is_required())
    close = whole or get_close_matches(key, known, n=1)
    if close:
        return f"{start}: did you mean {close[0]!r}?"
    homes = [name for name in model.model_fields if key in known_fields([name], model)]
    if homes:
        return (
            f"{start}: {f'write {homes[0]}.{key}' if table and homes[0] in known else f'it belongs in [{homes[0]}]'}."
        )
    # A key may be called by what another one is said to be part of: an amplitude is half the stroke.
    # Keys that must be given are meant first.
    words = words_of(key).split()
    for name, field in sorted(known.items(), key=lambda one: not one[1].is_required()):
        if any(word in words for word in re.split(r"\W+", field.description or "") if len(word) > 3):
            return f"{start}: give {name}, the {field.description}."
    return f"{start}: the keys known there are {', '.join(known)}."


def _missing_key(table: Keys, key: str, where: str, spelled: Spelling, model: type[Table]) -> str:
    field = known_fields(table, model)[key]
    if table_of(field) is not None:
        inner_fields = known_fields([*table, key], model)
        required = ", ".join(name for name, inner in inner_fields.items() if inner.is_required())
        return f"missing table [{'.'.join([*map(str, table), key])}] in {where}: it must give {required}."
    quantity = quantity_of(field)
    example = field.examples[0] if field.examples else ""
    unit = f", in {UNIT_NAMES[quantity.unit]}" if quantity is not None and UNIT_NAMES[quantity.unit] else ""
    example_text = f'"{example}"' if isinstance(example, str) else f"{example}"
    return (
        f"missing key '{key}' {place([*table, key], where, spelled)}: "
        f"give the {field.description}{unit}, for example {key} = {example_text}."
    )


def same_but_for_unit(key: str, name: str, unit: str) -> bool:
    """True if `key` is `name` but for another unit, none, or other letter case; False if `name` ends not in `unit`."""
    suffix = f"_{unit}"
    if not name.endswith(suffix):
        return False
    stem = name.removesuffix(suffix)
    return key == stem or key.startswith(f"{stem}_") or key.lower() == name.lower()


def field_of(model: type[Table], key: str) -> FieldInfo | None:
    """The model's field of a key or of a synonym of it; None if there is none."""
    named = (field for field in model.model_fields.values() if key in getattr(field.validation_alias, "choices", ()))
    return model.model_fields.get(key) or next(named, None)


def known_fields(table: Keys, model: type[Table]) -> Mapping[str, FieldInfo]:
    """The fields by key of the table at the path `table` in a model; empty if no table is there."""
    return _table_at(table, model).model_fields


def _table_at(table: Keys, model: type[Table]) -> type[Table]:
    inner: type[Table] | None = model
    # The place of a table in a list is no key.
    for key in (one for one in table if isinstance(one, str)):
        field = field_of(inner, key) if inner is not None else None
        inner = table_of(field) if field is not None else None
    return Table if inner is None else inner
