"""Python interface to the fatigue lives of a run's bodies."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from wirewear.results import RunResult
    from wirewear.stress.life import BodyLife


def lives(
    result: RunResult,
    bodies: Sequence[str] = (),
    *,
    values: Mapping[str, object] | None = None,
    wear_states: int | None = None,
    tell: Callable[[str, int], None] = lambda _body, _cycle: None,
) -> tuple[BodyLife, ...]:
    """Fatigue lives of the bodies of a run, both by default, by [life] of its study.

    bodies: their names, or "lower" and "upper". values: replace keys of [life]. wear_states: most wear states used in
    each block of cycles. tell: called with each body and cycle before it is computed.
    Raises StudyError if a value is not allowed, or data are lacking; ResultError if the run has recorded no contact
    forces; GeometryError if wear distorts a mesh too much.
    """
    from wirewear.kinds import contacts_of
    from wirewear.results.scar import body_named
    from wirewear.stress.averaging import averaging_radius_mm
    from wirewear.stress.life import WEAR_STATES, life_of, recorded_cycles
    from wirewear.stress.strength import StrengthAsked, assessable
    from wirewear.test import study_from_tables
    from wirewear.test.any_study import life_data

    inside = contacts_of(result).inside
    study = study_from_tables(result.study, result.label)
    named = [body_named(body, result.label, result.bodies) for body in bodies or result.bodies]
    found = []
    for body, table in life_data(study, named, values or {}).items():
        length_um = 2e3 * averaging_radius_mm(table, plane=False)
        first = min(recorded_cycles(result, body), default=1)
        assessable(result, body, first, StrengthAsked(averaging_length_um=length_um), inside)
        states_at, watch = partial(inside.states, result, body), partial(tell, body)
        most = wear_states or WEAR_STATES
        found.append(life_of(result, body, table, states_at, study.schedule, wear_states=most, watch=watch))
    return tuple(found)
