"""Keys of a sweep file. A design is how values of varied keys are chosen: on a grid, or drawn between ends."""

from typing import Annotated

from pydantic import BeforeValidator, Field, PlainValidator

from wirewear.base.units import Quantity
from wirewear.base.words import shown
from wirewear.test import FIDELITIES
from wirewear.test.keys import CheckedFlag, NamedTable, Table, checked_text, one_of

GRID, LATIN_HYPERCUBE, SOBOL = "grid", "latin-hypercube", "sobol"
LINEAR, LOGARITHMIC = "linear", "logarithmic"

_NUMBER = Quantity("1", -1e15, 1e15)


def _checked_values(value: object) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or len(value) < 2:
        raise ValueError(f"is {shown(value)}, but must be a list of at least two numbers")
    numbers = []
    for item in value:
        try:
            numbers.append(float(_NUMBER(item)))
        except ValueError as problem:
            raise ValueError(f"holds an item that {problem}") from None
    if len(set(numbers)) < len(numbers):
        raise ValueError(f"is {shown(value)}, but must name every value once")
    return tuple(numbers)


def _checked_list(value: object) -> object:
    if not isinstance(value, list | tuple) or not value:
        raise ValueError("must be given as tables [[vary]], at least one")
    return tuple(value)


Number = Annotated[float, PlainValidator(_NUMBER)]


class Vary(Table):
    """Keys of a varied key of the study: two ends for a drawn design, or a list of values for a grid."""

    key: Annotated[str, PlainValidator(checked_text)] = Field(
        description="key of the study, or effects.<effect>.<parameter>", examples=["contact.friction"]
    )
    low: Number | None = Field(None, description="lower end")
    high: Number | None = Field(None, description="upper end")
    scale: Annotated[str, PlainValidator(one_of(LINEAR, LOGARITHMIC))] = Field(
        LINEAR, description="how values are spread between the ends"
    )
    values: Annotated[tuple[float, ...] | None, PlainValidator(_checked_values)] = Field(
        None, description="the values of a grid"
    )


class SweepTables(NamedTable):
    """All tables of a sweep file."""

    study: Annotated[str, PlainValidator(checked_text)] = Field(
        description="the study's file, beside the sweep's", examples=["study.toml"]
    )
    variant: Annotated[str | None, PlainValidator(checked_text)] = Field(None, description="variant of the study")
    fidelity: Annotated[str, PlainValidator(one_of(*FIDELITIES))] = Field("quick", description="level of fidelity")
    design: Annotated[str, PlainValidator(one_of(GRID, LATIN_HYPERCUBE, SOBOL))] = Field(
        description="way in which the values of the varied keys are chosen", examples=[LATIN_HYPERCUBE]
    )
    samples: Annotated[int | None, PlainValidator(Quantity("1", 2, 10_000_000, whole=True))] = Field(
        None, description="runs of a latin-hypercube; base samples of sobol, a power of 2"
    )
    seed: Annotated[int, PlainValidator(Quantity("1", 0, 2**32 - 1, whole=True))] = Field(
        1, description="seed of what is drawn"
    )
    keep_results: CheckedFlag = Field(False, description="whether each run's result file is kept, in runs/")
    vary: Annotated[tuple[Vary, ...], BeforeValidator(_checked_list)] = Field(description="the keys that are varied")
