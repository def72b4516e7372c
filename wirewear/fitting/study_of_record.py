"""A record's test as the tables of a study: what its owner states, and what the loops say where nothing is stated."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wirewear.base.errors import RecordError
from wirewear.fitting.loops_of_tests import loops_of_tests
from wirewear.records import AnyRecord
from wirewear.records.line_believed import stated_friction, tables_of_test

if TYPE_CHECKING:
    from wirewear.records import ExperimentRecord, LineRecord


def tables_of_record(record: ExperimentRecord) -> dict[str, Any]:
    """Load, amplitude, wires, loop cycles and stated values of a record, as tables of a study.

    Friction that is not stated is the mean of the loops' geometry-independent one.

    Raises:
        RecordError: friction is not stated, and no loop slides as a whole.
    """
    tables = record.tables
    stated = tables.stated.model_dump(mode="json", exclude_unset=True, exclude_none=True)
    friction = tables.stated.final_friction
    if friction is None:
        friction = _friction_of_loops(record)
    conditions = tables.conditions.model_dump(mode="json", exclude={"drive"})
    if tables.wires.motion_angle_deg:
        conditions["motion_angle_deg"] = tables.wires.motion_angle_deg
    holder = {key: stated[key] for key in _HOLDER if key in stated}
    data: dict[str, Any] = {
        "name": record.name,
        "wires": tables.wires.model_dump(mode="json", exclude={"motion_angle_deg"}, exclude_none=True),
        "conditions": conditions,
        "contact": {"friction": friction},
        "holder": holder or {"tangential_stiffness_N_per_mm": "rigid"},
        "log": {"loop_cycles": [cycle for cycle in record.cycles if 1 <= cycle <= conditions["cycles"]]},
    }
    wear = {key: stated[key] for key in ("energy_wear_coefficient_mm3_per_J", "moving_share") if key in stated}
    if "energy_wear_coefficient_mm3_per_J" in wear:
        data["wear"] = wear
    known = ("friction_evolution", "wear_rate_evolution")
    effects = [{"name": name, **stated[name]} for name in known if name in stated]
    return data | ({"effects": effects} if effects else {})


def tables_of_line_record(record: LineRecord) -> dict[str, Any]:
    """The same of a line contact's record, per millimetre of the contact.

    Raises:
        RecordError: friction is not stated, and no loop slides as a whole.
    """
    friction = stated_friction(record.tables)
    if friction is None:
        friction = _friction_of_loops(record)
    data = tables_of_test(record.tables, friction)
    last = record.tables.conditions.cycles
    return data | {"log": {"loop_cycles": sorted({*(one for one in record.cycles if 1 <= one <= last), last})}}


def _friction_of_loops(record: AnyRecord) -> float:
    try:
        return round(float(np.nanmean(loops_of_tests(record).figures[:, :, 0])), 3)
    except RecordError as problem:
        raise RecordError(f"[stated] gives no friction, and {problem}") from None


_HOLDER = (
    "tangential_stiffness_N_per_mm",
    "rotational_stiffness_N_mm_per_rad",
    "pivot_height_mm",
    "normal_spring_stiffness_N_per_mm",
)
