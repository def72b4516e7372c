"""Records of line contacts: read as written, checked, made of a simulation and set beside one."""

import json
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geometry.arrays import Array
from tests.browser import page_faults
from tests.commands import wirewear
from tests.studies import line_study
from wirewear.base.errors import RecordError
from wirewear.comparison.comparison import compare
from wirewear.kinds import contacts_of
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.pictures.line_contacts import line_variants
from wirewear.records import LineRecord, MeasuredProfile, check_record, read_record, record_of_result, write_record
from wirewear.records.remarks import Remark
from wirewear.records.values import stated_study
from wirewear.results import RunResult, read_result, write_result
from wirewear.simulation import simulate
from wirewear.views.comparison_page import write_comparison

pytestmark = pytest.mark.seconds
MCCOLL = Path(__file__).parents[2] / "studies" / "atlas" / "mccoll2004" / "record"
NOISE = Sensor(noise=SensorNoise(displacement_um=0.05, tangential_force_N=1.0, normal_force_N=1.0))


@pytest.fixture(scope="module")
def result() -> RunResult:
    mesh = {"contact_mesh_um": 20.0, "jump_tolerance": 0.1, "increments_per_cycle": 24}
    study = line_study(conditions={"cycles": 200}, log={"loop_cycles": [1, 200]}, mesh=mesh)
    return simulate(study, fidelity="quick")


@pytest.fixture(scope="module")
def record(result: RunResult) -> LineRecord:
    return record_of_result(result, 8.0, sensor=NOISE, depth_noise_um=0.001, repeats=3, seed=1)


def test_a_record_reads_back_as_it_was_written(record: LineRecord, tmp_path: Path) -> None:
    write_record(tmp_path, record)
    again = read_record(tmp_path)
    assert again.tables.model_copy(update={"files": record.tables.files}) == record.tables
    assert again.repeats == (1, 2, 3)
    assert again.cycles == (1, 200)
    for mine, theirs in zip(again.loops, record.loops, strict=True):
        np.testing.assert_array_equal(mine.tangential_force_N, theirs.tangential_force_N)
    for own, other in zip(again.scars_of("pad"), record.scars_of("pad"), strict=True):
        np.testing.assert_array_equal(own.depth_um, other.depth_um)
    parts = replace(record, loops=(), evolution=(), scars=record.scars_of("specimen"))
    write_record(tmp_path, parts)
    assert not (tmp_path / "loops.csv").exists()
    assert read_record(tmp_path).loops == ()


def test_an_exported_simulation_is_sound_and_agrees_with_itself(result: RunResult, record: LineRecord) -> None:
    report = check_record(record)
    assert report.problems == ()
    assert "Depth, width and worn area of the pad and specimen at the end." in report.supports
    assert report.supports[-1].startswith("A simulation from the record alone")
    assert "source: simulated" in report.metadata
    exact = compare(result, record_of_result(result, 8.0))
    assert {pair.cycle for pair in exact.loops} == {1, 200}
    assert {pair.wire for pair in exact.scars} == {"pad", "specimen"}
    for row in exact.differences:
        assert row.difference == pytest.approx(0.0, abs=1e-6 * max(abs(row.simulated or 0.0), 1.0)), row.quantity
    noisy = compare(result, record)
    assert all(row.scatter is not None and row.scatter > 0.0 for row in noisy.differences if "force" in row.quantity)
    (forces,) = (row for row in noisy.differences if row.quantity.startswith("largest"))
    assert forces.simulated == pytest.approx(8.0 * 0.6 * 30.0, rel=0.02)


@pytest.mark.seconds
def test_a_profile_that_lies_aside_is_moved_onto_the_simulated_one(result: RunResult, tmp_path: Path) -> None:
    x, profile = result.scar(200, "specimen").section_along_motion()
    moved = MeasuredProfile(1, "specimen", x + 17.0, 1.2 * profile)
    exact = record_of_result(result, 8.0)
    comparison = compare(result, replace(exact, loops=(), evolution=(), scars=(moved,)))
    (pair,) = comparison.scars
    assert pair.registrations[0].shift_x_um == pytest.approx(17.0, abs=0.1)
    rows = {row.quantity: row for row in comparison.differences}
    volume = rows["worn volume"]
    assert volume.measured == pytest.approx(1.2 * (volume.simulated or 0.0), rel=0.01)
    assert volume.simulated == pytest.approx(1e3 * 8.0 * result.scar(200, "specimen").volume_mm3, rel=0.01)
    assert rows["width"].measured == pytest.approx(rows["width"].simulated, rel=0.01)
    with pytest.raises(RecordError, match="no analysable loop of a common cycle"):
        compare(result, replace(exact, loops=(), scars=()))
    written = write_comparison(comparison, tmp_path)
    assert [path.name for path in written] == [
        "comparison.html", "differences.csv", "differences.json", "scar_sections.png",
    ]  # fmt: skip
    assert page_faults(written[0]) == []


def test_an_export_states_the_rig_of_the_whole_contact_as_its_model_has_it_per_mm(result: RunResult) -> None:
    study = deepcopy(dict(result.study))
    study["holder"] |= {"tangential_stiffness_N_per_mm": 250.0}
    record = record_of_result(replace(result, study=study), 8.0)
    assert record.tables.stated.tangential_stiffness_N_per_mm == pytest.approx(8.0 * 250.0)
    study = stated_study(record.tables)
    assert study.of_length(1.0).holder.tangential_stiffness_N_per_mm == pytest.approx(250.0)
    assert study.wear.model_dump() == line_study().wear.model_dump()


def test_a_run_in_blocks_is_exported_unless_its_rig_changes(result: RunResult) -> None:
    blocks = [{"cycles": 10}, {"cycles": 10, "holder": {"tangential_stiffness_N_per_mm": 250.0}}]
    same, other = (line_study(programme=each).resolved() for each in (blocks[:1], blocks))
    assert record_of_result(replace(result, study=same), 8.0).tables.programme[0].cycles == 10
    with pytest.raises(RecordError, match="the rig of this run changes"):
        record_of_result(replace(result, study=other), 8.0)


def test_a_sensor_of_a_millimetre_reads_of_the_whole_contact_the_same(result: RunResult) -> None:
    soft = Sensor(remote_compliance_um_per_N=1e-3, linear_um_per_N=2e-4, quadratic_um_per_N2=1e-7)
    longer, shorter = (record_of_result(result, length_mm, sensor=soft).loops[0] for length_mm in (8.0, 2.0))
    np.testing.assert_allclose(longer.displacement_um, shorter.displacement_um, rtol=1e-12)
    np.testing.assert_allclose(longer.tangential_force_N, 4.0 * shorter.tangential_force_N, rtol=1e-12, atol=1e-9)


def test_pictures_and_loops_of_a_run_are_had_from_its_file(result: RunResult, tmp_path: Path) -> None:
    path = tmp_path / "result.h5"
    write_result(path, result)
    wirewear("show", path, "--output", tmp_path / "pictures")
    assert {one.name for one in (tmp_path / "pictures").iterdir()} == {"profiles.png", "loops.png"}
    result = read_result(path)
    contacts_of(result).write_beside([result], tmp_path)
    beside = {"profiles.csv", "loops.csv", "evolution.csv", "profiles.png", "loops.png"}
    assert {one.name for one in tmp_path.iterdir()} == {"result.h5", "pictures", *beside}
    figure = line_variants([result, replace(result, variant="other")])
    assert [axes.get_xlabel() for axes in figure.axes] == [*3 * ["x [µm]"], "displacement δ [µm]"]
    loops = json.loads(wirewear("loops", path, "--json").stdout)["loops"]
    assert {"the forces are those of 1 mm of the contact"} == {loop["notes"][0] for loop in loops}
    energies = [loop["dissipated_energy_mJ"]["value"] for loop in loops]
    evolution = result.evolution
    at = [int(np.argmin(np.abs(evolution["cycle"] - loop.cycle))) for loop in result.loops]
    assert energies == pytest.approx(evolution["dissipated_energy_mJ"][at], rel=0.05)


def test_what_is_wrong_with_a_record_is_stated(record: LineRecord) -> None:
    loop, profile = record.loops[0], record.scars[0]
    record = replace(record, scars=tuple(one for one in record.scars if one.repeat == loop.repeat))

    def topics(changed: LineRecord) -> set[str]:
        return {remark.topic for remark in check_record(changed).problems}

    turned = replace(loop, tangential_force_N=-loop.tangential_force_N)
    assert topics(replace(record, loops=(turned,))) == {"tangential force"}
    load = record.tables.conditions.normal_load_N
    for factor, words in ((1e3, "looks like millinewtons"), (1.0 / 8.0, "looks like the force of a millimetre")):
        other = replace(record, loops=(replace(loop, normal_force_N=np.full_like(loop.time_s, factor * load)),))
        (problem,) = (one for one in check_record(other).problems if one.topic == "normal force")
        assert words in problem.text
        assert problem.refuses
    half = profile.x_um > 0.0
    cut = MeasuredProfile(1, "pad", profile.x_um[half], profile.depth_um[half])
    assert topics(replace(record, scars=(cut,))) == {"profiles"}
    in_nm = MeasuredProfile(1, "pad", profile.x_um, 1e3 * profile.depth_um)
    assert "check its units" in check_record(replace(record, scars=(in_nm,))).problems[0].text
    unworn = MeasuredProfile(1, "pad", profile.x_um, 0.0 * profile.depth_um)
    assert topics(replace(record, scars=(unworn,))) == set()


def test_profiles_of_exchanged_bodies_show_as_the_flats_scar_is_longer_by_the_stroke(record: LineRecord) -> None:
    x = np.linspace(-600.0, 600.0, 601)
    half = float(np.sqrt(2e3 * (record.tables.pad.radius_mm or 0.0) * 2.0))
    reach = record.tables.conditions.displacement_amplitude_um
    pad, flat = (np.maximum(1.0 - (x / wide) ** 2, 0.0) for wide in (half, half + reach))
    random = np.random.default_rng(1)

    def remarks_on(**depths: Array) -> tuple[Remark, ...]:
        profiles = (
            MeasuredProfile(1, body, x, d + 0.01 * random.standard_normal(x.size)) for body, d in depths.items()
        )
        return check_record(replace(record, scars=tuple(profiles))).problems

    assert not [one for one in remarks_on(pad=pad, specimen=flat) if "shorter" in one.text]
    assert [one for one in remarks_on(pad=flat, specimen=pad) if "shorter than the pad's that wore it" in one.text]


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("length_mm = 10.0", "length_um = 10.0", "the length of the line contact is given as length_mm"),
        ('kind = "cylinder-on-flat"', 'kind = "ball"', 'must be "line-contact" or "cylinder-on-flat"'),
        ('profile_specimen = "profile_specimen.csv"', "", "names no file"),
        ('"profile_specimen.csv"', '"../x.csv"', "must name a file in the record's own folder"),
        ('"profile_specimen.csv"', '"none.csv"', "there is no file"),
        ("radius_mm = 6.0", "", "does not say which face the pad has: give radius_mm"),
        ("radius_mm = 6.0", "edge_radius_mm = 6.0", "does not say which face the pad has: give radius_mm"),
    ],
)
def test_a_mistake_is_one_sentence(old: str, new: str, complaint: str, tmp_path: Path) -> None:
    text = (MCCOLL / "experiment.toml").read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "experiment.toml").write_text(text.replace(old, new), encoding="utf-8")
    (tmp_path / "profile_specimen.csv").write_bytes((MCCOLL / "profile_specimen.csv").read_bytes())
    with pytest.raises(RecordError, match=complaint):
        read_record(tmp_path)


def test_a_run_logs_the_cycles_of_a_record(record: LineRecord, tmp_path: Path) -> None:
    folder = write_record(tmp_path / "record", record)
    wirewear("new", tmp_path / "mine", "--from", folder)
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    short = text.replace("cycles = 200 ", "cycles = 2 ").replace("[1, 200]", "[]")
    variants = "[variants.stiff.holder]\ntangential_stiffness_N_per_mm2 = 5000.0\n[mesh]\ncontact_mesh_um = 40.0\n"
    (tmp_path / "mine.toml").write_text(short + variants, encoding="utf-8")
    asked = ["run", str(tmp_path / "mine.toml"), "--fidelity", "quick", "--cycles-of", str(folder), "--jobs", "1"]
    wirewear(*asked, "--output", tmp_path / "run")
    # Cycle 200 lies beyond this test's end.
    assert [loop.cycle for loop in read_result(tmp_path / "run" / "stiff").loops] == [1, 2]


def test_noise_neither_narrows_a_shallow_scar_nor_adds_to_its_area() -> None:
    """A parabola of 0.3 µm with noise of 0.05 µm: its area is 2/3 of depth times width, however it is read."""
    x = np.arange(-400.0, 401.0, 1.0)
    true = 0.3 * np.maximum(1.0 - (x / 200.0) ** 2, 0.0)
    random = np.random.default_rng(4)
    profiles = [MeasuredProfile(1, "pad", x, true + 0.05 * random.standard_normal(x.size)) for _ in range(20)]
    assert np.mean([one.area_um2 for one in profiles]) == pytest.approx(0.3 * 400.0 * 2.0 / 3.0, rel=0.02)
    assert np.mean([one.width_um for one in profiles]) == pytest.approx(400.0, rel=0.06)
    assert np.mean([one.smooth_um.max() for one in profiles]) == pytest.approx(0.3, rel=0.06)
    np.testing.assert_array_equal(MeasuredProfile(1, "pad", x, true).smooth_um, true)
