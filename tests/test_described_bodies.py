"""Records describe what their rigs hold: a line contact's bodies, and the grips of wires."""

from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import pytest

from tests.synthetic_results import result as made_up
from tests.test_planar_study import TABLES
from wirewear import RecordError, read_record, record_of_result, write_record
from wirewear.diagnosis import diagnose
from wirewear.diagnosis.model.nominal import nominal_study
from wirewear.loops import Sensor, SensorNoise, analyse_loop
from wirewear.planar import planar_study_from_tables, run_planar_study
from wirewear.planar.model import bodies_stiffness_N_per_mm2
from wirewear.records import LineRecord, check_record
from wirewear.records.values import believed_study
from wirewear.results import BODIES, RunResult
from wirewear.study import load_study

STEEL = Path(__file__).resolve().parent.parent / "studies" / "steel_wires" / "study.toml"


LENGTH_mm = 8.0


@pytest.fixture(scope="module")
def low() -> RunResult:
    """Two cycles of bodies of 5 and 4 mm on a rigid rig."""
    tables = deepcopy(TABLES)
    tables["pad"] |= {"height_mm": 5.0, "half_width_mm": 4.0}
    tables["specimen"] |= {"height_mm": 4.0}
    tables["conditions"] |= {"cycles": 2}
    tables["log"] = {"loop_cycles": [1, 2]}
    return run_planar_study(planar_study_from_tables(tables, "study.toml"), fidelity="quick")


@pytest.fixture(scope="module")
def record(low: RunResult) -> LineRecord:
    return record_of_result(low, LENGTH_mm)


def stating(record: LineRecord, **stated: object) -> LineRecord:
    own = record.tables.stated.model_copy(update=stated)
    return replace(record, tables=record.tables.model_copy(update={"stated": own}))


def test_a_runs_record_carries_its_bodies_into_the_model_that_is_made_of_it(record: LineRecord, tmp_path: Path) -> None:
    read = read_record(write_record(tmp_path, record))
    study = believed_study(read.tables)
    assert (study.pad.height_mm, study.pad.half_width_mm, study.specimen.height_mm) == (5.0, 4.0, 4.0)
    assert not [remark for remark in check_record(read).remarks if remark.topic == "bodies"]


def test_what_is_assumed_of_bodies_that_are_not_described_is_said(record: LineRecord) -> None:
    pad = record.tables.pad.model_copy(update={"height_mm": None})
    bare = replace(record, tables=record.tables.model_copy(update={"pad": pad}))
    (remark,) = (one for one in check_record(bare).remarks if one.topic == "bodies")
    assert remark.level == "note"
    assert remark.text.startswith("The pad is taken to be 8 mm high")


def undescribed(record: LineRecord) -> LineRecord:
    bare = {body: getattr(record.tables, body).model_copy(update={"height_mm": None}) for body in BODIES}
    return replace(record, tables=record.tables.model_copy(update=bare))


def test_a_pad_of_unknown_height_is_taken_for_a_block_and_not_for_a_column_that_bends(record: LineRecord) -> None:
    def taken(radius_mm: float) -> dict[str, float]:
        pad = record.tables.pad.model_copy(update={"radius_mm": radius_mm, "half_width_mm": None})
        bare = undescribed(replace(record, tables=record.tables.model_copy(update={"pad": pad})))
        return bare.tables.assumed_heights_mm

    assert taken(40.0) == {"pad": 10.0, "specimen": 10.0}
    assert taken(3.0) == pytest.approx({"pad": 4.8, "specimen": 10.0})
    assert record.tables.assumed_heights_mm == {}


def test_the_compliance_of_bodies_is_in_doubt_unless_they_are_described_or_part_of_a_stated_stiffness(
    record: LineRecord,
) -> None:
    assert not record.tables.doubts_bodies
    bare = undescribed(record)
    assert bare.tables.doubts_bodies
    assert stating(bare, stiffness_includes="bodies").tables.doubts_bodies
    assert not stating(bare, stiffness_includes="bodies", tangential_stiffness_N_per_mm=1e4).tables.doubts_bodies


@pytest.mark.slow
def test_a_record_of_a_small_pad_has_no_gap_whether_or_not_it_says_how_the_pad_is_held() -> None:
    """Where 10 mm were taken in place of 3.3 mm, a pad of R 3 mm was a column, and the gap 20 scatters."""
    tables = deepcopy(TABLES)
    tables["pad"] |= {"radius_mm": 3.0, "height_mm": 3.3}
    tables["specimen"] |= {"height_mm": 3.3}
    tables["conditions"] |= {"displacement_amplitude_um": 20.0, "cycles": 5000}
    tables["holder"] = {"tangential_stiffness_N_per_mm2": 20000.0}
    tables["log"] = {"loop_cycles": [10, 100, 1000, 5000]}
    run = run_planar_study(planar_study_from_tables(tables, "study.toml"), fidelity="quick")
    sensor = Sensor(noise=SensorNoise(displacement_um=0.05, tangential_force_N=0.2))
    read = record_of_result(run, LENGTH_mm, sensor=sensor, repeats=3, samples=200, depth_noise_um=0.05)
    described = stating(read, tangential_stiffness_N_per_mm=20000.0 * LENGTH_mm)
    assert diagnose(described).diagnosis.verdict == "no_gap"
    answer = diagnose(undescribed(described)).diagnosis
    assert answer.verdict == "no_gap"
    assert any("held is not stated" in note for note in answer.notes)


def test_the_bodies_stiffness_is_that_of_the_loop_on_a_rigid_rig(low: RunResult, record: LineRecord) -> None:
    (loop, *_) = low.loops
    channels = loop.displacement_um, loop.tangential_force_N, loop.normal_force_N
    measured = analyse_loop(*channels, time_s=loop.time_s).measured_stiffness_N_per_um
    assert measured is not None
    bodies = bodies_stiffness_N_per_mm2(believed_study(record.tables))
    assert bodies == pytest.approx(1e3 * measured.value, rel=0.03)


def test_a_stiffness_that_includes_the_bodies_leaves_the_rig_what_remains(record: LineRecord) -> None:
    bodies = LENGTH_mm * bodies_stiffness_N_per_mm2(believed_study(record.tables))
    alone = believed_study(stating(record, tangential_stiffness_N_per_mm=0.25 * bodies).tables)
    assert alone.holder.tangential_stiffness_N_per_mm2 == pytest.approx(0.25 * bodies / LENGTH_mm)
    both = stating(record, tangential_stiffness_N_per_mm=0.25 * bodies, stiffness_includes="bodies")
    # In series: 1/0.25 = 1/(1/3) + 1.
    rig = believed_study(both.tables).holder.tangential_stiffness_N_per_mm2
    assert rig == pytest.approx(bodies / 3.0 / LENGTH_mm, rel=0.01)
    with pytest.raises(RecordError, match=r"that includes the bodies, but these alone have"):
        believed_study(stating(both, tangential_stiffness_N_per_mm=1.5 * bodies).tables)


@pytest.mark.seconds
def test_a_record_of_wires_carries_how_they_are_gripped(tmp_path: Path) -> None:
    grips = {"wires.grip_angle_deg": 60.0, "wires.grip_length_mm": 0.8, "wires.grip_stiffness_N_per_mm3": 5e5}
    for values in ({}, grips):
        study = load_study(STEEL).variant("compliant").with_values(values)
        record = record_of_result(replace(made_up("", 167.0), study=study.resolved()))
        read = read_record(write_record(tmp_path / str(len(values)), record))
        assert len(read.tables.wires.model_fields_set & {key.removeprefix("wires.") for key in grips}) == len(values)
        believed = nominal_study(read).wires
        for key in grips:
            assert getattr(believed, key.removeprefix("wires.")) == getattr(study.wires, key.removeprefix("wires."))
