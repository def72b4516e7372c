"""What a record's owner states beyond constants: running-in, and the scatter between tests."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.diagnosis_cases import diagnosed, record, states, tables
from wirewear import RecordError, read_record, write_record
from wirewear.diagnosis.infer.covariance import SCATTER, estimate
from wirewear.diagnosis.model.candidates import nominal_setup
from wirewear.diagnosis.model.nominal import nominal_study
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.records import ExperimentRecord
from wirewear.records.tables import RecordTables
from wirewear.views.diagnosis_notes import of_scatter

RUNNING_IN = {"initial": 0.5, "final": 0.62, "cycles": 3000.0}


def stating(one: ExperimentRecord, **changes: object) -> ExperimentRecord:
    """The record with other entries in its tables; those of `stated` are added."""
    data = one.tables.model_dump(exclude_none=True, exclude_unset=True)
    for key, value in changes.items():
        data[key] = {**data.get(key, {}), **value} if isinstance(value, dict) else value
    return replace(one, tables=RecordTables.model_validate(data))


@pytest.mark.slow
def test_running_in_that_is_stated_is_part_of_the_model_and_no_gap() -> None:
    one = record({"friction_evolution": RUNNING_IN})
    assert diagnosed(stating(one, stated={"friction_evolution": RUNNING_IN})).diagnosis.verdict == "no_gap"


def test_the_final_friction_stands_in_for_the_coefficient() -> None:
    data = tables().model_dump(exclude_none=True)
    del data["stated"]["friction"]
    data["stated"]["friction_evolution"] = RUNNING_IN
    study = nominal_study(ExperimentRecord(RecordTables.model_validate(data), ()))
    assert study.contact.friction == RUNNING_IN["final"]
    (effect,) = study.effects
    assert effect.values == RUNNING_IN


def test_friction_that_is_stated_twice_and_differently_is_refused() -> None:
    wrong = stating(record(repeats=1), stated={"friction_evolution": {**RUNNING_IN, "final": 0.7}})
    with pytest.raises(RecordError, match=r"gives friction = 0\.62, but final = 0\.7"):
        nominal_study(wrong)


def test_a_record_with_all_that_may_be_stated_is_read_as_it_was_written(tmp_path: Path) -> None:
    wear = {"initial_factor": 2.0, "final_factor": 1.0, "cycles": 1e4}
    one = stating(
        record(repeats=1, evolution=False),
        stated={"friction_evolution": RUNNING_IN, "wear_rate_evolution": wear},
        scatter={"friction": 0.05, "force_zero_N": 0.02},
    )
    write_record(tmp_path / "record", one)
    again = read_record(tmp_path / "record").tables
    assert again.stated == one.tables.stated
    assert again.scatter == one.tables.scatter


def scatter_of(one: ExperimentRecord) -> tuple[dict[str, float], tuple[str, ...]]:
    found = estimate(states(), nominal_setup(nominal_study(one), "sensor"), reduce(one))
    return dict(found.scatter), found.contradicted


def test_scatter_that_is_stated_replaces_the_expectation() -> None:
    one = record(repeats=1)
    plain, _ = scatter_of(one)
    assert plain == pytest.approx(SCATTER)
    stated, _ = scatter_of(stating(one, scatter={"friction": 0.07, "normal_load": 0.02, "force_zero_N": 0.03}))
    assert stated["friction"] == pytest.approx(0.07)
    assert stated["load"] == pytest.approx(0.02)
    assert stated["force_offset"] == pytest.approx(0.015)
    assert stated["wear"] == pytest.approx(SCATTER["wear"])


def test_repeats_that_scatter_more_than_stated_say_so() -> None:
    one = record(scatter=4.0, seed=3)
    _, contradicted = scatter_of(stating(one, scatter={"friction": 0.002}))
    assert any("scatter more in friction than [scatter] states" in note for note in of_scatter(contradicted))
    _, honest = scatter_of(stating(one, scatter={"friction": 0.05}))
    assert of_scatter(honest) == ()


@pytest.mark.slow
def test_a_wide_scatter_that_is_stated_makes_a_difference_of_its_size_no_gap() -> None:
    """A friction 6 % off is a gap to a laboratory that repeats within 1 %, and none to one that scatters by 5 %."""
    one = record({"friction_offset": {"friction": 0.66}}, repeats=1, seed=2)
    close = diagnosed(stating(one, scatter={"friction": 0.01})).diagnosis
    wide = diagnosed(stating(one, scatter={"friction": 0.06})).diagnosis
    assert close.verdict != "no_gap"
    assert wide.verdict == "no_gap"
    assert np.isfinite(close.shrink.before)
