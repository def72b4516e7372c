"""A record without those columns of its evolution that its own loops contradict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wirewear.loops import LoopError
from wirewear.records import AnyRecord
from wirewear.records.checking import analysed
from wirewear.records.course_checks import other_definitions


def of_own_definitions(record: AnyRecord) -> tuple[AnyRecord, tuple[str, ...]]:
    """The record without the columns of its evolution that contradict its own loops (NaN), and a note on each."""
    if not record.evolution:
        return record, ()
    loops = {}
    for loop in analysed(record.loops):
        try:
            loops[loop.repeat, loop.cycle] = loop, loop.figures(record.tables.conditions.normal_load_N)
        except LoopError:
            continue
    other = other_definitions(loops, record.evolution)
    if not other:
        return record, ()
    left_out = {one.column for one in other}
    evolution = tuple(
        replace(
            part,
            columns={
                name: np.full_like(values, np.nan) if name in left_out else values
                for name, values in part.columns.items()
            },
        )
        for part in record.evolution
    )
    return replace(record, evolution=evolution), tuple(f"{one.text}, and left out" for one in other)
