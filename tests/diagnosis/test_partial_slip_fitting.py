"""Fits of tests whose loops all stick in their middle, made by bristles that are dragged to and fro behind a rig."""

import dataclasses

import numpy as np
import pytest

from tests.exam.independent_records import independent_record
from tests.synthetic_loops import bristle_loop
from wirewear.base.errors import RecordError
from wirewear.diagnosis.fit import fit_record
from wirewear.diagnosis.fit.fit import tables_of_record
from wirewear.diagnosis.fit.without_plateau import left_out
from wirewear.records import ExperimentRecord

FRICTION, LOAD_N = 0.62, 2.0


def sticking_record(share: float, rig_N_per_mm: float) -> ExperimentRecord:
    """Two tests of the article's wires, of a contact as stiff as theirs."""
    record = independent_record({}, repeats=2, scars=False)
    own = 1.0 / record.tables.contact_stiffness_N_per_um
    loops = []
    for seed, loop in enumerate(loop for loop in record.loops if loop.cycle == record.cycles[0]):
        made = bristle_loop(FRICTION * LOAD_N, share, seed, own, 1e3 / rig_N_per_mm)
        time, displacement, force = made
        normal = np.full(time.size, LOAD_N)
        loops.append(
            dataclasses.replace(
                loop, time_s=time, displacement_um=displacement, tangential_force_N=force, normal_force_N=normal
            )
        )
    asked = {"displacement_amplitude_um": round(0.5 * float(np.ptp(loops[0].displacement_um)), 2)}
    conditions = record.tables.conditions.model_copy(update=asked)
    return dataclasses.replace(
        record, loops=tuple(loops), tables=record.tables.model_copy(update={"conditions": conditions})
    )


def test_a_record_in_partial_slip_alone_is_fitted_with_friction_and_rig_as_intervals() -> None:
    record = sticking_record(0.8, 4000.0)
    fit = fit_record(record)
    friction, rig = fit.parameters["friction"], fit.parameters["tangential_stiffness_N_per_mm"]
    assert friction.interval95[0] < FRICTION < friction.interval95[1] < 2.0 * friction.interval95[0]
    assert rig.interval95[0] < 4000.0 < rig.interval95[1]
    assert fit.study.given()["contact"]["friction"] == pytest.approx(friction.value, rel=1e-3)
    assert any("no loop slides as a whole" in note for note in fit.notes)


def test_friction_that_is_only_bounded_below_is_refused_with_its_bound() -> None:
    with pytest.raises(RecordError, match=r"none bounds friction above: it is at least 0\.(0[6-9]|[1-5])"):
        fit_record(sticking_record(0.1, 100.0))


def test_a_record_in_partial_slip_that_states_no_friction_has_that_of_its_loops() -> None:
    record = sticking_record(0.9, 4000.0)
    stated = record.tables.stated.model_copy(update={"friction": None})
    record = dataclasses.replace(record, tables=record.tables.model_copy(update={"stated": stated}))
    assert tables_of_record(record)["contact"]["friction"] == pytest.approx(FRICTION, rel=0.1)


def test_a_fit_to_a_mixed_test_says_which_loops_it_leaves_out_and_what_they_say() -> None:
    sliding, sticking = independent_record({}, repeats=1, scars=False), sticking_record(0.9, 4000.0)
    mixed = dataclasses.replace(sliding, loops=(*sliding.loops[:2], sticking.loops[0]))
    (said,) = left_out(mixed)
    assert said.startswith("a mixed test: 1 of 3 loops")
    assert "friction from 0." in said
    assert left_out(sliding) == left_out(sticking) == []
