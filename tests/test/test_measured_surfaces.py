"""Tests that begin with a surface as it was measured: old scars go on wearing, errors of form are another form."""

from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from geometry import ContactPatch, Flat
from geometry.arrays import Array
from solvers import CondensedBody, place, press, unloaded_state
from tests.studies import line_study
from tests.synthetic_results import result as made_up
from tests.test.pads import BALL, LINE, POINTS, STEEL, STEEL_MODULUS, BALL_RADIUS_mm, study
from wirewear import read_record, record_of_result, reference, write_record
from wirewear.base.errors import RecordError, StudyError
from wirewear.diagnosis import diagnose
from wirewear.diagnosis.surrogate.nominal import nominal_study
from wirewear.kinds import any_study, load_any_study
from wirewear.loops import Sensor, SensorNoise, analyse_loop
from wirewear.records import LineRecord, check_record
from wirewear.records.values import stated_study
from wirewear.results import BODIES, RunResult
from wirewear.results.export import profiles_table, scars_table
from wirewear.simulation import problem as problem_module
from wirewear.simulation import run_study, simulate
from wirewear.simulation.expected_contact import stands_out
from wirewear.simulation.line_model import bodies_stiffness_N_per_mm2
from wirewear.simulation.point_runs import PointRun
from wirewear.simulation.problem import measured
from wirewear.test import LineStudy, Study, load_study, study_from_tables
from wirewear.test.study import read_study
from wirewear.test.surfaces import StatedSurface, kept_map

HALF = 1500
#: What tables call the column of bodies.
BODY = {"test": "body", "body": "wire"}


def surface_of(lines: tuple[Array, Array], depth_um: Any, frame: str = "test") -> StatedSurface:
    x, y = lines
    return StatedSurface.model_validate({"frame": frame, **kept_map(x, y, depth_um(x[:, None], y[None, :]))})


WIRES = {
    "kind": "crossed-wires",
    "wires": {"diameter_mm": 0.45, **STEEL, "crossing_angle_deg": 60.0},
    "conditions": POINTS["conditions"] | {"normal_load_N": 2.0, "displacement_amplitude_um": 30.0},
}


def worn(contact: dict[str, Any], folder: Path, cycles: int, surfaces: dict[str, dict[str, str]]) -> RunResult:
    tables = {"conditions": POINTS["conditions"]} | deepcopy(contact)
    bodies = tables.get("bodies") or tables["wires"]
    for body, surface in surfaces.items():
        bodies[body] = bodies.get(body, {}) | {"surface": surface}
    tables["conditions"]["cycles"] = cycles
    asked = study(tables, log={"loop_cycles": [HALF, cycles]}, fidelity={"quick": {"increments_per_cycle": 16}})
    (result,) = run_study(asked, fidelity="quick", output=folder)
    return result


@pytest.mark.slow
@pytest.mark.parametrize(("contact", "frame"), [(BALL, "test"), (WIRES, "body")], ids=["ball", "wires"])
def test_bodies_go_on_from_their_scars_as_without_a_break(tmp_path: Path, contact: dict[str, Any], frame: str) -> None:
    whole = worn(contact, tmp_path / "whole", 2 * HALF, {})
    surfaces = {}
    for body in whole.bodies:
        scar, file = whole.scar(HALF, body), tmp_path / f"scar_{body}.csv"
        table = scars_table(whole).filter((pl.col("cycle") == HALF) & (pl.col(BODY[frame]) == body))
        if frame == "body":
            along, across = np.meshgrid(scar.axial_um, scar.transverse_um, indexing="ij")
            table = table.with_columns(x_um=along.ravel(), y_um=across.ravel())
        table.write_csv(file)
        surfaces[body] = {"file": str(file), "frame": frame}
    rest = worn(contact, tmp_path / "rest", HALF, surfaces)
    for name, tolerance in (
        ("dissipated_energy_mJ", 1e-3),
        ("contact_half_width_um", 0.05),
        ("max_mean_pressure_MPa", 0.05),
    ):
        assert rest.evolution[name][-1] == pytest.approx(whole.evolution[name][-1], rel=tolerance), name
    x, y = np.linspace(-200.0, 200.0, 81), np.linspace(-160.0, 160.0, 65)
    for body in whole.bodies:
        before, after, at_once = whole.scar(HALF, body), rest.scar(HALF, body), whole.scar(2 * HALF, body)
        assert before.volume_mm3 + after.volume_mm3 == pytest.approx(at_once.volume_mm3, rel=2e-3)
        depth = before.sampled(x, y) + after.sampled(x, y)
        assert np.abs(depth - at_once.sampled(x, y)).max() < 0.05 * at_once.max_depth_um
    with pytest.raises(RecordError, match="began with a measured surface"):
        record_of_result(rest)


@pytest.mark.seconds
def test_a_line_contact_goes_on_from_its_own_exported_profiles_as_without_a_break(tmp_path: Path) -> None:
    def ran(cycles: int, surfaces: str = "") -> RunResult:
        text = LINE.format(pad="radius_mm = 6.0").replace("cycles = 2000", f"cycles = {cycles}")
        path = tmp_path / "line.toml"
        path.write_text(text.replace("[2000]", f"[1000, {cycles}]") + surfaces, encoding="utf-8")
        return simulate(study_from_tables(read_study(path), str(path)), fidelity="quick")

    whole = ran(2000)
    for body in whole.bodies:
        of_body = profiles_table(whole).filter((pl.col("cycle") == 1000) & (pl.col("body") == body))
        of_body.write_csv(tmp_path / f"{body}.csv")
    rest = ran(1000, "".join(f'[{body}.surface]\nfile = "{body}.csv"\n' for body in whole.bodies))
    assert rest.evolution["dissipated_energy_mJ"][-1] == pytest.approx(
        whole.evolution["dissipated_energy_mJ"][-1], rel=1e-3
    )
    for body in whole.bodies:
        before, after, at_once = whole.scar(1000, body), rest.scar(1000, body), whole.scar(2000, body)
        assert before.area_um2 + after.area_um2 == pytest.approx(at_once.area_um2, rel=2e-3)
        depth = before.depth_um + np.interp(before.axial_um, after.axial_um, after.depth_um[:, 0])[:, None]
        assert np.abs(depth - at_once.depth_um).max() < 0.02 * at_once.max_depth_um


@pytest.mark.seconds
def test_a_ball_that_measures_as_a_larger_one_touches_as_that_one() -> None:
    """A surface above the unworn one, as large as the difference of two parabolas."""
    larger_mm = 9.0
    x = np.linspace(-500.0, 500.0, 101)
    bulge = surface_of((x, x), lambda x, y: 5e-4 * (x**2 + y**2) * (1.0 / larger_mm - 1.0 / BALL_RADIUS_mm))
    contact: dict[str, Any] = deepcopy(BALL)
    contact["bodies"]["ball"]["surface"] = bulge.model_dump(exclude_none=True)
    meshes = PointRun.of(study(contact, wear=None, fidelity={}), "quick").meshes
    problem = meshes.problem(meshes.first(), lambda _: None)
    state, report = press(problem, unloaded_state(problem))
    load = POINTS["conditions"]["normal_load_N"]
    hertz = reference.hertz_point(load, larger_mm, STEEL_MODULUS)
    assert report.max_pressure == pytest.approx(hertz.peak_pressure_MPa, rel=0.02)
    assert -state.holder_z == pytest.approx(hertz.approach_mm, rel=0.03)


@pytest.mark.parametrize("upper", [False, True])
@pytest.mark.parametrize("angle_deg", [0.0, 60.0])
def test_a_map_along_the_motion_and_one_along_the_axis_are_one_surface(*, upper: bool, angle_deg: float) -> None:
    def slanted(x: Array, y: Array) -> Array:
        return 2.0 + 0.03 * x - 0.01 * y

    lines, angle = np.linspace(-0.1, 0.1, 5), np.radians(angle_deg)
    bare = CondensedBody.whole(ContactPatch(lines, lines, np.arange(25).reshape(5, 5), Flat()), np.eye(75))
    far = np.linspace(-200.0, 200.0, 9)

    def along_axis(a: Array, t: Array) -> Array:
        return slanted(a * np.cos(angle) - t * np.sin(angle), a * np.sin(angle) + t * np.cos(angle))

    for frame, depth in (("test", slanted), ("body", along_axis)):
        body = place(
            measured(bare, surface_of((far, far), depth, frame), angle_deg, upper=upper),
            upper=upper,
            axis_angle_rad=float(angle),
        )
        x, y = 1e3 * body.node_positions.T
        facing = -1.0 if upper else 1.0
        np.testing.assert_allclose(body.worn(np.zeros((5, 5))).heights, -1e-3 * facing * slanted(x, y), atol=1e-9)
        sample = body.sample(body.node_positions, np.zeros((5, 5)))
        np.testing.assert_allclose(sample.slope, np.tile(-facing * np.array([0.03, -0.01]), (25, 1)), atol=1e-6)


def scarred(x: Array, y: Array) -> Array:
    """Heights in µm of a ball, tilted, with a scar of 3 µm beside the map's middle, and some noise."""
    noise = 0.02 * np.random.default_rng(1).standard_normal(np.broadcast_shapes(x.shape, y.shape))
    r = 1e3 * BALL_RADIUS_mm
    shape = np.sqrt(r**2 - x**2 - y**2) - r
    scar = np.maximum(3.0 - 3.0 * ((x - 60.0) ** 2 + (y + 40.0) ** 2) / 150.0**2, 0.0)
    return np.asarray(7.0 + 0.01 * x - 0.02 * y + shape - scar + noise)


@pytest.mark.parametrize("form", ["table", "map"])
def test_heights_of_a_ball_are_levelled_to_the_depths_of_its_scar(tmp_path: Path, form: str) -> None:
    x = np.linspace(-400.0, 400.0, 161)
    heights = scarred(x[:, None], x[None, :])
    if form == "table":
        columns = {"x_um": np.repeat(x, x.size), "y_um": np.tile(x, x.size), "height_um": heights.ravel()}
        pl.DataFrame(columns).write_csv(tmp_path / "ball.csv")
        surface_table: dict[str, Any] = {"file": str(tmp_path / "ball.csv")}
        middle = 0.0, 0.0
    else:
        np.save(tmp_path / "ball.npy", 1e3 * heights)
        surface_table = {"file": str(tmp_path / "ball.npy"), "step_um": 5.0, "height_unit": "nm", "centred_on": "map"}
        middle = 60.0, -40.0
    tables = study(BALL).resolved()
    tables["bodies"]["ball"]["surface"] = surface_table
    read = any_study(tables, "s.toml")
    assert isinstance(read, Study)
    surface = read.bodies[1].surface
    assert surface is not None
    Path(surface_table["file"]).unlink()
    assert study_from_tables(read.resolved(), "again").resolved() == read.resolved()
    at_x, at_y, depth = surface.map
    at_x, at_y = at_x - middle[0], at_y - middle[1]
    inside = np.hypot(at_x[:, None], at_y[None, :]) < 140.0
    exact = 3.0 - 3.0 * (at_x[:, None] ** 2 + at_y[None, :] ** 2) / 150.0**2
    assert np.abs(depth - exact)[inside].max() < 0.15
    assert surface.volume_mm3 == pytest.approx(1e-9 * 0.5 * np.pi * 3.0 * 150.0**2, rel=0.1)


def test_a_profile_of_heights_is_levelled_against_the_pads_face(tmp_path: Path) -> None:
    x = np.arange(-400.0, 401.0, 2.0)
    scar = np.maximum(2.0 - 2.0 * ((x - 30.0) / 120.0) ** 2, 0.0)
    height = 1.0 + 0.02 * x - x**2 / 12e3 - scar + 0.01 * np.random.default_rng(2).standard_normal(x.size)
    pl.DataFrame({"x_um": x, "height_um": height}).write_csv(tmp_path / "pad.csv")
    path = tmp_path / "line.toml"
    path.write_text(LINE.format(pad="radius_mm = 6.0") + '[pad.surface]\nfile = "pad.csv"\n', encoding="utf-8")
    read = load_any_study(path)
    assert isinstance(read, LineStudy)
    surface = read.pad.surface
    assert surface is not None
    places, _, depth = surface.map
    assert np.abs(depth[:, 0] - (2.0 - 2.0 * (places / 120.0) ** 2))[(np.abs(places) < 110.0)].max() < 0.1


@pytest.mark.parametrize(
    ("rows", "surface", "complaint"),
    [
        (None, {}, r"cannot be taken: .*scar\.csv"),
        ("x_um,y_um,depth_um\n0,0,1\n1,0,1\n0,1,1\n", {}, "3 points lie on 2 × 2 lines, which is no whole grid"),
        ("x_um,depth_um\n0,1\n1,1\n", {"frame": "map"}, r"frame .* is 'map', but must be"),
        ("x_um,y_um\n0,0\n1,1\n2,3\n", {}, "cannot be taken"),
        (None, {"file": None}, "gives no file, or depths that are not those of its lines"),
        (None, {"file": None, "x_um": [0, 1], "y_um": [0, 1], "depths": "eJw="}, "depths that are not those"),
    ],
)
def test_a_surface_that_cannot_be_taken_is_stated_in_one_sentence(
    tmp_path: Path, rows: str | None, surface: dict[str, Any], complaint: str
) -> None:
    file = tmp_path / "scar.csv"
    if rows is not None:
        file.write_text(rows, encoding="utf-8")
    tables = study(BALL).resolved()
    surface_table = {key: value for key, value in ({"file": str(file)} | surface).items() if value is not None}
    tables["bodies"]["ball"]["surface"] = surface_table
    with pytest.raises(StudyError, match=complaint) as found:
        any_study(tables, "s.toml")
    assert "\n" not in str(found.value)


@pytest.mark.parametrize(("rise_um", "where"), [(1e3, "at the rim of its map"), (300.0, "outside the finely")])
@pytest.mark.parametrize("body", ["ball", "flat"])
def test_a_surface_that_stands_out_where_the_bodies_then_touch_is_named_before_anything_is_meshed(
    monkeypatch: pytest.MonkeyPatch, body: str, rise_um: float, where: str
) -> None:
    monkeypatch.setattr(problem_module, "build_body", None)
    tables, line = study(BALL).resolved(), np.linspace(-1e3, 1e3, 11)
    depth = np.zeros((11, 11))
    depth[(0, 0) if "rim" in where else (2, 5)] = -rise_um
    tables["bodies"][body]["surface"] = kept_map(line, line, depth)
    at = r"\(-1000, -1000\)" if "rim" in where else r"\(-600, 0\)"
    with pytest.raises(StudyError, match=rf"{body} stands out by {rise_um:g} um .*at {at} um, {where}"):
        simulate(any_study(tables, "s.toml"), fidelity="quick")


@pytest.mark.parametrize(("rise_um", "alone"), [(1.5, False), (10.0, True)])
def test_a_rise_that_the_load_levels_stands_out_nowhere(rise_um: float, alone: bool) -> None:
    """The approach of the fresh bodies is 2.5 um; the gap where the map ends 0.2 um."""
    line = np.linspace(-50.0, 50.0, 21)
    rise = rise_um * np.exp(-(((line[:, None] - 50.0) ** 2 + line[None, :] ** 2) / 20.0**2))
    tables = study(BALL).resolved()
    tables["bodies"]["ball"]["surface"] = kept_map(line, line, -rise)
    own = any_study(tables, "s.toml")
    assert isinstance(own, Study)
    assert (stands_out(own, 0.1) is not None) == alone


def test_heights_name_where_to_be_read_by_what_does_not_level_them(tmp_path: Path) -> None:
    (tmp_path / "map.csv").write_text("x_um,y_um,height_um\n0,0,1\n1,0,1\n0,1,1\n", encoding="utf-8")
    tables = study(BALL).resolved()
    tables["bodies"]["ball"]["surface"] = {"file": str(tmp_path / "map.csv")}
    with pytest.raises(StudyError, match="heights and maps are read where a study is loaded as by"):
        study_from_tables(tables, "s.toml")


STEEL_WIRES = Path(__file__).parents[2] / "studies" / "steel_wires" / "study.toml"
LENGTH_mm = 8.0


@pytest.fixture(scope="module")
def low() -> RunResult:
    """Two cycles of bodies of 5 and 4 mm on a rigid rig."""
    bodies = {"pad": {"height_mm": 5.0, "half_width_mm": 4.0}, "specimen": {"height_mm": 4.0}}
    return simulate(line_study(**bodies, conditions={"cycles": 2}, log={"loop_cycles": [1, 2]}), fidelity="quick")


@pytest.fixture(scope="module")
def record(low: RunResult) -> LineRecord:
    return record_of_result(low, LENGTH_mm)


def stating(record: LineRecord, **stated: object) -> LineRecord:
    own = record.tables.stated.model_copy(update=stated)
    return replace(record, tables=record.tables.model_copy(update={"stated": own}))


def test_a_runs_record_carries_its_bodies_into_the_model_that_is_made_of_it(record: LineRecord, tmp_path: Path) -> None:
    read = read_record(write_record(tmp_path, record))
    study = stated_study(read.tables)
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


def test_the_compliance_of_bodies_is_in_doubt_unless_they_or_their_stiffness_are_described(record: LineRecord) -> None:
    assert not record.tables.doubts_bodies
    bare = undescribed(record)
    assert bare.tables.doubts_bodies
    assert stating(bare, stiffness_includes="bodies").tables.doubts_bodies
    assert not stating(bare, stiffness_includes="bodies", tangential_stiffness_N_per_mm=1e4).tables.doubts_bodies


@pytest.mark.slow
def test_a_small_pad_has_no_gap_with_or_without_its_support_stated() -> None:
    """Where 10 mm were taken in place of 3.3 mm, a pad of R 3 mm was a column, and the gap 20 scatters."""
    small = line_study(
        pad={"radius_mm": 3.0, "height_mm": 3.3},
        specimen={"height_mm": 3.3},
        conditions={"displacement_amplitude_um": 20.0, "cycles": 5000},
        holder={"tangential_stiffness_N_per_mm2": 20000.0},
        log={"loop_cycles": [10, 100, 1000, 5000]},
    )
    run = simulate(small, fidelity="quick")
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
    bodies = bodies_stiffness_N_per_mm2(stated_study(record.tables))
    assert bodies == pytest.approx(1e3 * measured.value, rel=0.03)


def test_a_stiffness_that_includes_the_bodies_leaves_the_rig_what_remains(record: LineRecord) -> None:
    bodies = LENGTH_mm * bodies_stiffness_N_per_mm2(stated_study(record.tables))
    alone = stated_study(stating(record, tangential_stiffness_N_per_mm=0.25 * bodies).tables)
    assert alone.holder.tangential_stiffness_N_per_mm == pytest.approx(0.25 * bodies)
    both = stating(record, tangential_stiffness_N_per_mm=0.25 * bodies, stiffness_includes="bodies")
    # In series: 1/0.25 = 1/(1/3) + 1.
    rig = stated_study(both.tables).holder.tangential_stiffness_N_per_mm
    assert rig == pytest.approx(bodies / 3.0, rel=0.01)
    with pytest.raises(RecordError, match=r"that includes the bodies, but these alone have"):
        stated_study(stating(both, tangential_stiffness_N_per_mm=1.5 * bodies).tables)


@pytest.mark.seconds
def test_a_record_of_wires_carries_how_they_are_gripped(tmp_path: Path) -> None:
    grips = {"wires.grip_angle_deg": 60.0, "wires.grip_length_mm": 0.8, "wires.grip_stiffness_N_per_mm3": 5e5}
    for values in ({}, grips):
        study = load_study(STEEL_WIRES).variant("compliant").with_values(values)
        record = record_of_result(replace(made_up("", 167.0), study=study.resolved()))
        read = read_record(write_record(tmp_path / str(len(values)), record))
        assert len(read.tables.wires.model_fields_set & {key.removeprefix("wires.") for key in grips}) == len(values)
        nominal = nominal_study(read).wires
        for key in grips:
            assert getattr(nominal, key.removeprefix("wires.")) == getattr(study.wires, key.removeprefix("wires."))
