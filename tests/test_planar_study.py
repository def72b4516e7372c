"""Planar studies: what their files may hold, what a run leaves, and how scars grow."""

from copy import deepcopy
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import polars as pl
import pytest
from click.testing import CliRunner
from rich.console import Console

from tests.synthetic_results import profile
from wirewear import Study, reference
from wirewear.base.errors import ResultError, RunError, StudyError
from wirewear.base.hdf5 import hdf5_image
from wirewear.faces import cli
from wirewear.kinds import load_any_study
from wirewear.planar import run_planar_study
from wirewear.planar.model import plan
from wirewear.planar.pictures import draw_planar_result
from wirewear.planar.reading import planar_study_from_tables
from wirewear.planar.tables import PlanarStudy
from wirewear.results import RunResult, read_result
from wirewear.results.summary import summary
from wirewear.simulation import NoObserver
from wirewear.simulation.checkpoint import CHECKPOINT_FILE_NAME
from wirewear.simulation.observers import Moment

STUDY = Path(__file__).resolve().parent.parent / "studies" / "cylinder_on_flat" / "study.toml"
TABLES: dict[str, Any] = {
    "format": 1,
    "name": "cylinder on flat",
    "kind": "cylinder-on-flat",
    "pad": {"radius_mm": 6.0, "youngs_modulus_MPa": 2e5, "poissons_ratio": 0.3},
    "specimen": {"youngs_modulus_MPa": 2e5, "poissons_ratio": 0.3},
    "conditions": {"normal_load_N_per_mm": 30.0, "displacement_amplitude_um": 12.0, "cycles": 20_000},
    "contact": {"friction": 0.6},
    "wear": {"pad_energy_mm3_per_J": 4e-5, "specimen_energy_mm3_per_J": 2e-5},
    "log": {"loop_cycles": [1, 5000, 20_000]},
    "mesh": {"contact_mesh_um": 12.0, "jump_tolerance": 0.05},
}


def study(**changes: dict[str, Any]) -> PlanarStudy:
    tables = deepcopy(TABLES)
    for table, values in changes.items():
        tables[table] = tables.get(table, {}) | values
    return planar_study_from_tables(tables, "study.toml")


@pytest.fixture(scope="module")
def worn() -> RunResult:
    return run_planar_study(study(), fidelity="quick")


@pytest.mark.slow
def test_the_figures_of_a_run_stand_whole_with_their_units_on_a_narrow_screen(worn: RunResult) -> None:
    console = Console(width=80)
    with console.capture() as shown:
        console.print(summary([worn]))
    text = shown.get()
    assert "…" not in text
    assert "1 mm of the contact" in " ".join(text.split())
    for name, column in (
        ("largest tangential force [N]", "max_tangential_force_N"),
        ("deepest wear, pad [µm]", "max_depth_pad_um"),
    ):
        cell = next(line.split()[-1] for line in text.splitlines() if name in line)
        assert float(cell) == pytest.approx(worn.evolution[column].max(), rel=1e-3)


def test_mean_pressures_are_over_half_the_fresh_contact_unless_the_study_says() -> None:
    planned = plan(study(), "quick")
    assert planned.settings()["pressure_length_um"] == pytest.approx(1e3 * planned.hertz.half_width_mm)
    stated = study(log={"pressure_length_um": 20.0})
    assert plan(stated, "quick").pressure_length_mm == pytest.approx(0.02)
    assert stated.log.loop_cycles == (1, 5000, 20_000)


@pytest.mark.slow
def test_a_run_has_mean_pressures_of_every_loop(worn: RunResult) -> None:
    """A mean is no more than the largest at a node, and about mid-stroke no more than the cycle's."""
    evolution = worn.evolution
    assert np.all(evolution["max_mean_pressure_MPa"] <= 1.01 * evolution["max_pressure_MPa"])
    assert np.all(evolution["mid_stroke_mean_pressure_MPa"] <= evolution["max_mean_pressure_MPa"])
    conditions = worn.study["conditions"]
    fresh = reference.hertz_line(conditions["normal_load_N_per_mm"], 6.0, 2e5 / (2.0 * 0.91))
    exact = fresh.mean_over_segment_MPa(1e-3 * worn.settings["pressure_length_um"])
    assert evolution["mid_stroke_mean_pressure_MPa"][0] == pytest.approx(exact, rel=0.02)


def test_the_shipped_planar_study_is_valid() -> None:
    shipped = load_any_study(STUDY)
    assert isinstance(shipped, PlanarStudy)
    assert plan(shipped, "standard").hertz.half_width_mm == pytest.approx(0.558, rel=0.01)
    assert isinstance(load_any_study(STUDY.parent.parent / "steel_wires" / "study.toml"), Study)


@pytest.mark.parametrize(
    ("table", "values", "complaint"),
    [
        ("pad", {"radius_mm": -1.0}, r"radius_mm in \[pad\] of study.toml is -1.0, but must lie between"),
        ("pad", {"radius_um": 1.0}, r"given as radius_mm, in millimetres"),
        ("conditions", {"motion": "square"}, 'must be "triangular" or "sinusoidal"'),
        ("wear", {"pad_archard_mm3_per_N_m": 1e-5}, "a body wears by one law"),
        ("holder", {"tangential_stiffness_N_per_mm2": "soft"}, 'or "rigid"'),
    ],
)
def test_a_mistake_in_a_planar_study_is_told_in_one_sentence(
    table: str, values: dict[str, Any], complaint: str
) -> None:
    with pytest.raises(StudyError, match=complaint):
        study(**{table: values})


def test_archard_wear_without_friction_is_refused() -> None:
    with pytest.raises(StudyError, match="computed from friction energy"):
        study(contact={"friction": 0.0}, wear={"pad_energy_mm3_per_J": 0.0, "pad_archard_mm3_per_N_m": 1e-5})


def test_a_contact_that_does_not_fit_on_a_body_is_refused() -> None:
    with pytest.raises(StudyError, match="the specimen is too narrow"):
        plan(study(specimen={"half_width_mm": 0.2}), "quick")


@pytest.mark.slow
def test_a_worn_planar_contact_is_a_segment_of_the_cylinder(worn: RunResult) -> None:
    """Oracle of line contacts in gross slip: A = 2b³/(3R), h = b²/(2R); 5 % for the elastic contact's own width."""
    pad, specimen = (worn.scar(20_000, body) for body in ("pad", "specimen"))
    exact = reference.line_contact_scar(1e-6 * (pad.area_um2 + specimen.area_um2), 6.0)
    depth = sum(np.interp(0.0, *scar.section_along_motion()) for scar in (pad, specimen))
    left, right = pad.edges_um()
    assert 1e-3 * depth == pytest.approx(exact.depth_mm, rel=0.05)
    assert 0.5e-3 * (right - left) == pytest.approx(exact.half_width_mm, rel=0.05)


@pytest.mark.slow
def test_planar_scars_deepen_as_the_cycles_to_two_thirds(worn: RunResult) -> None:
    before, after = worn.evolution["max_depth_pad_um"][1:]
    assert np.log(after / before) / np.log(4.0) == pytest.approx(2.0 / 3.0, abs=0.07)


@pytest.mark.slow
def test_each_body_loses_its_coefficient_times_the_energy(worn: RunResult) -> None:
    assert worn.quality["volume_against_energy"] < 1e-10
    ratio = worn.evolution["worn_volume_pad_mm3"][1:] / worn.evolution["worn_volume_specimen_mm3"][1:]
    assert ratio == pytest.approx(2.0, rel=1e-9)


def test_archards_law_wears_what_the_energy_law_wears_at_the_same_friction() -> None:
    archard = {"pad_energy_mm3_per_J": 0.0, "pad_archard_mm3_per_N_m": 4e-5 * 0.6}
    same = study(wear=archard)
    assert same.energy_coefficients() == pytest.approx((4e-5, 2e-5), rel=1e-12)


def test_the_motion_sets_the_time_and_nothing_else() -> None:
    short = {"cycles": 1}
    log = {"loop_cycles": [1]}
    loops = [
        run_planar_study(study(conditions={**short, "motion": motion}, log=log), fidelity="quick").loops[0]
        for motion in ("triangular", "sinusoidal")
    ]
    assert np.array_equal(loops[0].tangential_force_N, loops[1].tangential_force_N)
    triangle, sine = loops
    corners = np.interp(triangle.time_s, [0.0, 0.25, 0.75, 1.0], [0.0, 12.0, -12.0, 0.0])
    assert triangle.displacement_um == pytest.approx(corners, abs=1e-9)
    assert sine.displacement_um == pytest.approx(12.0 * np.sin(2.0 * np.pi * sine.time_s), abs=1e-9)
    for loop in loops:
        assert np.all(np.diff(loop.time_s) > 0.0)


def test_the_edges_of_a_scar_lie_where_its_depth_vanishes() -> None:
    x = np.linspace(-100.0, 100.0, 201)
    depth = np.maximum(10.0 * (1.0 - (x - 5.0) ** 2 / 40.0**2), 0.0)
    assert profile("pad", x, depth).edges_um() == pytest.approx((-34.8, 44.8), abs=0.2)
    assert np.isnan(profile("pad", x, 0.0 * x).edges_um()).all()


@pytest.mark.slow
def test_the_command_leaves_tables_result_and_pictures(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    text = STUDY.read_text(encoding="utf-8").replace("cycles = 10000", "cycles = 20")
    file.write_text(text.replace("[1, 100, 1000, 3000, 10000]", "[1, 20]"), encoding="utf-8")
    out = tmp_path / "out"
    result = CliRunner().invoke(cli, ["run", str(file), "--fidelity", "quick", "--output", str(out)])
    assert result.exit_code == 0, result.output
    assert "titanium cylinder on flat" in result.stdout
    names = {"result.h5", "report.html", "profiles.csv", "loops.csv", "evolution.csv", "profiles.png", "loops.png"}
    assert {path.name for path in out.iterdir()} == names
    profiles = pl.read_csv(out / "profiles.csv")
    with h5py.File(out / "result.h5") as stored:
        deepest = max(float(group["depth_um"][()].max()) for group in stored["scars"].values())
    assert profiles["depth_um"].max() == pytest.approx(deepest)
    assert pl.read_csv(out / "evolution.csv")["cycle"].to_list() == [1.0, 20.0]
    assert set(profiles["body"].unique()) == {"pad", "specimen"}


def test_a_variant_that_a_planar_study_has_not_is_told() -> None:
    result = CliRunner().invoke(cli, ["run", str(STUDY), "--variant", "rigid"])
    assert result.exit_code == 2
    assert "has no variant 'rigid': it has no variants" in result.stderr


class Killer(NoObserver):
    """Interrupts in the middle of a cycle, some increments after a number of logged loops."""

    def __init__(self, stop_after: int) -> None:
        self.logged_loops, self.stop_after = 0, stop_after

    def moved(self, moment: Moment) -> None:
        if self.logged_loops == self.stop_after and moment.cycle > 2.0:
            raise KeyboardInterrupt

    def logged(self, result: RunResult) -> None:
        assert result.status == "running"
        self.logged_loops += 1


@pytest.mark.slow
def test_a_planar_run_that_was_killed_and_resumed_ends_with_the_same_result(tmp_path: Path) -> None:
    short = study(conditions={"cycles": 400}, log={"loop_cycles": [1, 40, 400]})
    unbroken = run_planar_study(short, fidelity="quick")
    with pytest.raises(KeyboardInterrupt):
        run_planar_study(short, fidelity="quick", output=tmp_path, observer=Killer(1))
    assert read_result(tmp_path / "result.h5").status == "running"
    resumed = run_planar_study(short, fidelity="quick", output=tmp_path, resume=True)
    assert resumed.status == "complete"
    assert not (tmp_path / CHECKPOINT_FILE_NAME).exists()
    assert resumed.quality == unbroken.quality
    for name, column in unbroken.evolution.items():
        np.testing.assert_array_equal(resumed.evolution[name], column, err_msg=name)
    for mine, theirs in zip(resumed.scars, unbroken.scars, strict=True):
        np.testing.assert_array_equal(mine.depth_um, theirs.depth_um)
    for mine_loop, theirs_loop in zip(resumed.loops, unbroken.loops, strict=True):
        np.testing.assert_array_equal(mine_loop.tangential_force_N, theirs_loop.tangential_force_N)
    complete = (tmp_path / "result.h5").read_bytes()
    # As if it had been killed while it drew.
    (tmp_path / "loops.png").unlink()
    run_planar_study(short, fidelity="quick", output=tmp_path, resume=True)
    assert (tmp_path / "result.h5").read_bytes() == complete
    assert (tmp_path / "loops.png").exists()
    with pytest.raises(RunError, match="another study"):
        run_planar_study(study(), fidelity="quick", output=tmp_path, resume=True)


def test_a_file_that_is_no_planar_result_is_refused(tmp_path: Path) -> None:
    image = hdf5_image(lambda file: file.attrs.__setitem__("kind", "something else"))
    (tmp_path / "result.h5").write_bytes(image)
    with pytest.raises(ResultError, match="is no wirewear result file"):
        read_result(tmp_path / "result.h5")


def test_planar_pictures_are_drawn_also_when_nothing_is_worn(tmp_path: Path) -> None:
    unworn = {"pad_energy_mm3_per_J": 0.0, "specimen_energy_mm3_per_J": 0.0}
    result = run_planar_study(study(conditions={"cycles": 1}, log={"loop_cycles": [1]}, wear=unworn), fidelity="quick")
    for path in draw_planar_result(tmp_path, result):
        assert path.stat().st_size > 10_000
    with pytest.raises(ResultError, match="scars of the pad: nothing is logged near cycle 7"):
        result.scar(7, "pad")
