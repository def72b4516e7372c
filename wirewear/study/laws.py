"""How a study names a friction law: by its name, or in a table with the law's parameters."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator

from solvers import FrictionLaw, SolverError, friction_law
from wirewear.base.quantity import shown


def _law_of(value: object) -> FrictionLaw:
    """The law that a key's value describes; ValueError when there is none such."""
    if isinstance(value, FrictionLaw):
        return value
    table = {"name": value} if isinstance(value, str) else value
    if not isinstance(table, dict) or not isinstance(table.get("name"), str):
        raise ValueError(
            f'is {shown(value)}, but must be "coulomb" or a table such as '
            '{ name = "shear-limited", shear_strength_MPa = 800.0 }'
        )
    parameters = {key: number for key, number in table.items() if key != "name"}
    for key, number in parameters.items():
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise ValueError(f"gives {key} = {shown(number)}, but must give a number")
    try:
        return friction_law(table["name"], parameters)
    except SolverError as problem:
        raise ValueError(f"is {shown(value)}: {problem}") from None


def _described(law: FrictionLaw) -> str | dict[str, Any]:
    parameters = asdict(law)
    return {"name": law.name, **parameters} if parameters else law.name


#: A key that takes a friction law.
FrictionLawKey = Annotated[FrictionLaw, PlainValidator(_law_of), PlainSerializer(_described)]
