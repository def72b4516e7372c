"""Wear states of the steel wires' nominal run, frozen, so that tests diagnose without a finite element run.

python -m tests.exam.frozen_states        # computes them again and writes tests/data/steel_wires_states.json
"""

import json
from collections.abc import Mapping
from dataclasses import fields
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from wirewear.diagnosis.surrogate.nominal import nominal_run, nominal_study
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.records import ExperimentRecord

FILE = Path(__file__).parents[1] / "data" / "steel_wires_states.json"
DIGITS = 8  #: Digits that are kept: many more than differences between solvers leave.


@cache
def frozen_states() -> WearStates:
    """The states of the file."""
    return of_table(json.loads(FILE.read_text(encoding="utf-8")))


def present_states(record: ExperimentRecord) -> WearStates:
    """The states of a record's nominal run, run now unless it stands in the cache."""
    return WearStates.of_run(nominal_run(nominal_study(record)))


def of_table(table: Mapping[str, Any]) -> WearStates:
    """From one entry an attribute, lists for arrays."""
    values: dict[str, Any] = {
        name: np.array(value) if isinstance(value, list) else value for name, value in table.items()
    }
    return WearStates(**values)


def to_table(states: WearStates) -> dict[str, Any]:
    """The reverse of `of_table`, rounded."""
    values = {field.name: getattr(states, field.name) for field in fields(states)}
    return {
        name: _rounded(value.tolist() if isinstance(value, np.ndarray) else value) for name, value in values.items()
    }


def _rounded(value: Any) -> Any:
    return [_rounded(part) for part in value] if isinstance(value, list) else float(f"{value:.{DIGITS}g}")


if __name__ == "__main__":
    from tests.exam.independent_records import independent_record

    FILE.parent.mkdir(exist_ok=True)
    lines = [
        f' "{name}": {json.dumps(value)}' for name, value in to_table(present_states(independent_record())).items()
    ]
    FILE.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")
