"""Experiment records of contacts at a point: written, read, checked, and imported from heights for any two bodies."""

import dataclasses
import tomllib
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from tests.commands import wirewear
from tests.records.point_records import SHAPES, DEPTH_um, NOISE_um, RADIUS_mm, SPOT_um, run_of, run_of_wires
from tests.simulation.point_contacts import STEEL
from tests.synthetic_results import AMPLITUDE_um, bowl
from wirewear import RecordError, read_record, record_of_result, write_record, write_result
from wirewear.comparison.comparison import compare
from wirewear.diagnosis.fit.wear import fitted_wear
from wirewear.diagnosis.surrogate.nominal import nominal_study
from wirewear.records import ExperimentRecord, MeasuredScar, RecordTables, check_record
from wirewear.records.importing import import_record
from wirewear.reference import Elastic, contact_modulus, hertz_point, mindlin_stiffness, tangential_contact_modulus
from wirewear.test import study_from_tables


@pytest.mark.parametrize("kind", SHAPES)
def test_an_exported_run_comes_back_as_its_own_record_without_problems(tmp_path: Path, kind: str) -> None:
    run = run_of(kind)
    record = read_record(write_record(tmp_path / "record", record_of_result(run, depth_noise_um=NOISE_um)))
    assert record.contact_kind == kind
    assert [problem.text for problem in check_record(record).problems] == []
    assert study_from_tables(tables_of_study(record), "s").bodies == study_from_tables(run.study, "s").bodies
    for body in run.bodies:
        assert record.worn_volumes_mm3[body][1] == pytest.approx(run.scar(100_000, body).volume_mm3, rel=0.01)


def test_a_record_states_a_pad_of_revolution_layers_and_the_form_of_the_wear_law(tmp_path: Path) -> None:
    run = run_of("point-contact")
    cut = {"shape": "pad", "radius_mm": RADIUS_mm, "face_half_width_mm": 0.1, **STEEL}
    flat = {"shape": "flat", "layers": [{"thickness_um": 1.0, "friction": 0.3}], **STEEL}
    law = {"name": "energy-threshold", "threshold_mJ_per_mm2": 200.0}
    changed = {"bodies": {"lower": flat, "upper": cut}, "wear": {**run.study["wear"], "law": law}}
    study = study_from_tables({**run.study, **changed}, "s")
    record = record_of_result(dataclasses.replace(run, study=study.resolved()))
    again = read_record(write_record(tmp_path / "record", record))
    stated = study_from_tables(tables_of_study(again), "s")
    assert (stated.bodies, stated.laws) == (study.bodies, study.laws)


def tables_of_study(record: ExperimentRecord[Any, Any]) -> dict[str, Any]:
    from wirewear.records.values import stated_tables

    return stated_tables(record.tables, 0.62)


def test_a_ball_is_as_stiff_as_hertz_and_mindlin_make_it_and_as_crossed_cylinders() -> None:
    ball, crossed = (record_of_result(run_of(kind)).tables for kind in SHAPES)
    steel = Elastic(STEEL["youngs_modulus_MPa"], STEEL["poissons_ratio"])
    radius = hertz_point(2.0, RADIUS_mm, contact_modulus(steel, steel)).contact_radius_mm
    expected = 1e-3 * mindlin_stiffness(tangential_contact_modulus(steel, steel), radius)
    assert ball.contact_stiffness_N_per_um == pytest.approx(expected, rel=1e-3)
    assert crossed.contact_stiffness_N_per_um == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (
            lambda scar: dataclasses.replace(scar, x_um=scar.y_um, y_um=scar.x_um, depth_um=scar.depth_um.T),
            "across the motion as the other",
        ),
        (lambda scar: dataclasses.replace(scar, depth_um=1e4 * scar.depth_um), "more than the smallest diameter"),
        (lambda scar: dataclasses.replace(scar, depth_um=10.0 * scar.depth_um), "times as wide as both scars' depths"),
    ],
)
def test_scars_of_a_ball_that_cannot_be_are_stated(spoil: Any, says: str) -> None:
    record = record_of_result(run_of("ball-on-flat"))
    flat, ball = record.scars
    problems = check_record(dataclasses.replace(record, scars=(spoil(flat), ball))).problems
    assert any(says.lower() in problem.text.lower() for problem in problems), problems


def test_a_scar_without_loops_is_said_and_one_of_noise_alone_shows_no_wear() -> None:
    record = record_of_result(run_of("ball-on-flat"), depth_noise_um=NOISE_um)
    first = record.scars[0]
    bare = [
        one.of_field(NOISE_um * np.random.default_rng(1).standard_normal(one.depth_um.shape)) for one in record.scars
    ]
    assert fitted_wear(record)[0]
    worn, _, notes = fitted_wear(dataclasses.replace(record, scars=tuple(bare)))
    assert not worn
    assert "the scars of repeat 1 may be noise" in notes[0]
    two = check_record(dataclasses.replace(record, scars=(*record.scars, dataclasses.replace(first, repeat=2))))
    assert any(f"Repeat 2 has a scar of the {first.body} and no loops" in one.text for one in two.problems)


def test_lists_of_an_export_that_are_repeated_add_up(tmp_path: Path) -> None:
    write_result(tmp_path / "result.h5", run_of("ball-on-flat"))
    noises = ["--noise", "displacement_um=0.1", "--noise", "tangential_force_N=0.2,"]
    wirewear("export", tmp_path / "result.h5", "--as-record", tmp_path / "record", *noises)
    text = (tmp_path / "record" / "experiment.toml").read_text(encoding="utf-8")
    assert tomllib.loads(text)["noise"] == {"displacement_um": 0.1, "tangential_force_N": 0.2}
    assert "[bodies.ball]" in text
    assert "[bodies]" not in text
    assert "layers" not in text


@pytest.mark.first_case
@pytest.mark.parametrize("kind", SHAPES)
def test_heights_of_any_bodies_come_back_as_their_scars(tmp_path: Path, kind: str) -> None:
    """Tilted, raised and off the middle, as a profilometer has them."""
    run = run_of(kind)
    write_result(tmp_path / "result.h5", run)
    noise = f"depth_um={NOISE_um},displacement_um=0.1,tangential_force_N=0.01"
    wirewear("export", tmp_path / "result.h5", "--as-heights", tmp_path, "--samples", 128, "--noise", noise)
    for path in tmp_path.glob("scar_*.csv"):
        table = pl.read_csv(path)
        tilted = table["height_um"] + 0.01 * table["x_um"] - 0.02 * table["y_um"] + 7.0
        table.with_columns(tilted, table["x_um"] + 40.0).write_csv(path)
    if kind == "ball-on-flat":
        files = [str(path) for path in sorted(tmp_path.glob("*.csv"))]
        options = ["--kind", kind, "--diameter", str(2 * RADIUS_mm), "--frequency", "3"]
        wirewear("new", "--mapping", *files, *options)
    else:
        (tmp_path / "mapping.toml").write_text(MAPPING, encoding="utf-8")
    record = import_record(tmp_path / "mapping.toml")
    assert record.contact_kind == kind
    for body in run.bodies:
        assert record.worn_volumes_mm3[body][1] == pytest.approx(run.scar(100_000, body).volume_mm3, rel=0.03), body
    assert [one.text for one in check_record(record).problems] == []
    shifts = [pair.registrations[0] for pair in compare(run, record).scars]
    assert max(abs(one.shift_x_um) + abs(one.shift_y_um) for one in shifts) < 5.0


def test_a_run_of_another_ball_is_not_of_the_records_test() -> None:
    run = run_of("ball-on-flat")
    record = record_of_result(run)
    other = deepcopy(run.study)
    other["bodies"]["ball"]["diameter_mm"] = 6.0
    assert compare(run, record).unlike is None
    message = compare(dataclasses.replace(run, study=other), record).unlike
    assert message is not None
    assert "diameter_mm of the ball is 6 in the run and 3 in the record" in message


MAPPING = f"""
format = 1
name = "crossed cylinders"
[contact]
kind = "point-contact"
[bodies.lower]
shape = "cylinder"
diameter_mm = {2 * RADIUS_mm}
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[bodies.upper]
shape = "cylinder"
diameter_mm = {2 * RADIUS_mm}
axis_angle_deg = 90.0
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = {AMPLITUDE_um}
frequency_Hz = 3.0
cycles = 100000
[loops]
files = "loops.csv"
columns = {{ displacement_um = "displacement_um", tangential_force_N = "tangential_force_N", cycle = "cycle" }}
[scars.lower]
files = "scar_lower_1.csv"
columns = {{ x_um = "x_um", y_um = "y_um", height_um = "height_um" }}
[scars.upper]
files = "scar_upper_1.csv"
columns = {{ x_um = "x_um", y_um = "y_um", height_um = "height_um" }}
"""


def changed(folder: Path, old: str, new: str) -> Path:
    write_record(folder, record_of_result(run_of("ball-on-flat")))
    path = folder / "experiment.toml"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    return folder


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('kind = "ball-on-flat"', 'kind = "ball-on-ball"', "'ball-on-ball'"),
        ("diameter_mm = 3.0", "diameter_mm = 3000.0", "diameter_mm"),
        ("diameter_mm = 3.0", "", "diameter_mm"),
        ("[bodies.ball]", "[bodies.bal]", "bodies"),
        ('scar_ball = "scar_ball.csv"', 'scar_bal = "scar_ball.csv"', "scar_bal"),
        ('[contact]\nkind = "ball-on-flat"', "", "contact"),
        ('scar_ball = "scar_ball.csv"', 'scar_fixed = "scar_ball.csv"', "a ball-on-flat has a flat and a ball"),
    ],
)
def test_what_a_record_of_bodies_says_wrongly_is_stated(tmp_path: Path, old: str, new: str, says: str) -> None:
    with pytest.raises(RecordError) as caught:
        read_record(changed(tmp_path / "record", old, new))
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_bodies_that_touch_along_a_line_are_no_record_of_a_point(tmp_path: Path) -> None:
    write_record(tmp_path, record_of_result(run_of("point-contact")))
    path = tmp_path / "experiment.toml"
    text = path.read_text(encoding="utf-8").replace("axis_angle_deg = 90.0", "axis_angle_deg = 0.5")
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RecordError, match="touch along a line"):
        read_record(tmp_path)


def test_a_record_without_a_kind_is_still_one_of_crossed_wires(tmp_path: Path) -> None:
    assert isinstance(read_record(write_record(tmp_path, record_of_result(run_of_wires()))).tables, RecordTables)


def test_unlike_wires_at_a_small_angle_are_stated_as_such_or_as_bodies(tmp_path: Path) -> None:
    run = run_of_wires(crossing_angle_deg=10.0, motion_angle_deg=-5.0, fixed={"diameter_mm": 0.6, "material": "steel"})
    read = read_record(write_record(tmp_path, record_of_result(run)))
    assert [body.axis_angle_deg for body in read.tables.bodies_of_test] == [5.0, 15.0]
    assert [body.diameter_mm for body in read.tables.wires.of_test()] == [0.45, 0.6]
    assert nominal_study(read).bodies == read.tables.bodies_of_test
    assert compare(run, read).unlike is None
    steel = "youngs_modulus_MPa = 210000.0\npoissons_ratio = 0.3\n"
    path, of_test = tmp_path / "experiment.toml", read.tables.bodies_of_test
    text = path.read_text(encoding="utf-8")
    by_bodies = (
        f'[contact]\nkind = "crossed-wires"\n[bodies.moving]\nshape = "wire"\ndiameter_mm = 0.45\naxis_angle_deg = 5\n'
        f"{steel}[bodies.fixed]\ndiameter_mm = 0.6\naxis_angle_deg = 15\n{steel}"
    )
    path.write_text(text[: text.index("[wires]")] + by_bodies + text[text.index("[conditions]") :], encoding="utf-8")
    again = read_record(tmp_path)
    assert again.tables.bodies_of_test == of_test
    assert not [note for note in again.notes if "passed over" in note]
    thick = again.tables.wires.model_copy(update={"diameter_mm": 0.5})
    other = dataclasses.replace(again, tables=again.tables.model_copy(update={"wires": thick}))
    assert "diameter_mm of the moving wire is 0.45 in the run and 0.5" in str(compare(run, other).unlike)


def test_an_exported_map_reaches_as_far_as_the_depth_between_coarse_nodes() -> None:
    """A ball's elements may be wider than any margin; a map that ends within the scar has lost volume."""
    coarse = bowl("flat", DEPTH_um, SPOT_um, SPOT_um, axis_angle_deg=0.0, lines=(9, 7))
    seen = MeasuredScar.of_run(coarse, 1, 0.0, np.random.default_rng(0))
    assert seen.rim_um.max() < 1e-9
    assert seen.volume_mm3 == pytest.approx(coarse.volume_mm3, rel=0.01)
