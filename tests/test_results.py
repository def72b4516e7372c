"""Values of results: what they accept, and what scars and runs answer."""

import dataclasses
import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from click.testing import CliRunner, Result

from tests import synthetic_results
from tests.studies import MINIMAL
from tests.synthetic_results import bowl, loop, result
from wirewear.base.errors import ResultError
from wirewear.faces import cli
from wirewear.results import EVOLUTION_COLUMNS, LATER_COLUMNS, Evolution, RunResult, Scar, write_result
from wirewear.results.checks import require_increasing
from wirewear.results.vtk import write_time_series

EXAMPLE = Path("studies/steel_wires/example_records/no_gap")
VARIANTS = '[variants.rigid.holder]\ntangential_stiffness_N_per_mm = "rigid"\n'


def test_every_logged_scar_is_a_surface_that_its_pvd_file_lists_by_cycle(tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    run = result(milestones=(100, 1_000, 100_000))
    paths = write_time_series(run, tmp_path / "vtk")
    assert [path.name for path in paths] == ["scar_moving.pvd", "scar_fixed.pvd"]
    for path, upward in zip(paths, (1.0, -1.0), strict=True):
        scars = [scar for scar in run.scars if f"scar_{scar.body}.pvd" == path.name]
        sets = ET.parse(path).getroot().findall("./Collection/DataSet")
        assert [float(item.attrib["timestep"]) for item in sets] == [scar.cycle for scar in scars]
        for item, scar in zip(sets, scars, strict=True):
            surface = pyvista.read(path.parent / item.attrib["file"])
            assert surface.n_points == scar.depth_um.size
            assert surface.point_data["depth_um"] == pytest.approx(scar.depth_um.ravel())
            assert upward * surface.points[:, 2].max() <= 1e-6 or upward < 0.0
            # The crown is where the surface is least worn or unworn: worn points lie below it.
            deepest = int(np.argmax(surface.point_data["depth_um"]))
            assert upward * surface.points[deepest, 2] <= -0.99 * scar.max_depth_um
    assert not list((tmp_path / "vtk").glob(".*"))


def test_paraview_s_reader_opens_the_series(tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    path = write_time_series(result(milestones=(10, 100)), tmp_path)[1]
    reader = pyvista.get_reader(path)
    assert list(reader.time_values) == [10.0, 100.0]
    reader.set_active_time_value(100.0)
    assert "pressure_MPa" in reader.read()[0].point_data


VARIANTS += "[variants.compliant.holder]\ntangential_stiffness_N_per_mm = 167.0\n"


def wirewear(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    asked: dict[str, Any] = {}

    def run_study(study: Any, **options: Any) -> list[Any]:
        asked.update(options, study=study)
        return [synthetic_results.result(variant="compliant", stiffness_N_per_mm=167.0)]

    monkeypatch.setattr("wirewear.simulation.run_study", run_study)
    return asked


@pytest.fixture
def study_file(tmp_path: Path) -> Path:
    path = tmp_path / "wires.toml"
    path.write_text(MINIMAL, encoding="utf-8")
    return path


@pytest.mark.parametrize("place", ["result.h5", "compliant/result.h5"])
def test_a_complete_result_is_overwritten_only_when_that_is_asked_for(
    study_file: Path, asked: dict[str, Any], place: str
) -> None:
    folder = study_file.with_name("out")
    write_result(folder / place, synthetic_results.result(variant="", stiffness_N_per_mm=167.0))
    refused = wirewear("run", study_file, "--output", folder)
    assert refused.exit_code == 2
    assert "is a complete result, and is not overwritten" in refused.stderr
    assert asked == {}
    for option in ("--overwrite", "--resume"):
        assert wirewear("run", study_file, "--output", folder, option).exit_code == 0


def test_a_run_can_log_the_cycles_of_the_record_that_it_will_be_compared_with(
    study_file: Path, asked: dict[str, Any]
) -> None:
    study_file.write_text(MINIMAL + VARIANTS, encoding="utf-8")
    result = wirewear("run", study_file, "--cycles-of", EXAMPLE)
    assert result.exit_code == 0, result.output
    last = asked["study"].conditions.cycles
    for study in (asked["study"], asked["study"].variant("rigid")):
        assert study.tables.log.loop_cycles == tuple(
            sorted({c for c in (100, 1000, 10000, 100000) if c <= last} | {last})
        )


def test_a_value_that_every_variant_replaces_is_told(study_file: Path, asked: dict[str, Any]) -> None:
    own = "[holder]\ntangential_stiffness_N_per_mm = 200.0\n"
    study_file.write_text(MINIMAL + own + VARIANTS, encoding="utf-8")
    result = wirewear("run", study_file)
    assert "[holder] tangential_stiffness_N_per_mm = 200.0 is used by no variant" in result.stderr
    study_file.write_text(MINIMAL + own.replace("200", "167") + VARIANTS, encoding="utf-8")
    assert wirewear("run", study_file).stderr == ""


def test_a_run_given_to_check_is_named_as_one(tmp_path: Path) -> None:
    write_result(tmp_path / "run" / "result.h5", synthetic_results.result(variant="", stiffness_N_per_mm=167.0))
    result = wirewear("check", tmp_path / "run")
    assert result.exit_code == 2
    assert "is a result of a run, and no record" in result.stderr


def test_a_kind_of_contact_that_is_yet_to_come_is_named_as_such(study_file: Path) -> None:
    study_file.write_text(MINIMAL.replace('"crossed-wires"', '"sphere-on-flat"'), encoding="utf-8")
    assert 'sphere-on-flat", which is not supported yet' in wirewear("run", study_file).stderr


def test_worn_volume_is_the_integral_of_the_depth() -> None:
    """A paraboloid bowl of half-axes L, B and depth h holds πLBh/2, here to 0.1 % on 241 × 201 lines."""
    scar = bowl("moving", depth_um=12.0, half_length_um=110.0, half_width_um=70.0, lines=(241, 201))
    assert scar.volume_mm3 == pytest.approx(1e-9 * math.pi * 110.0 * 70.0 * 12.0 / 2.0, rel=1e-3)


def test_worn_volume_of_a_bilinear_depth_is_exact() -> None:
    """On any graded grid the trapezoid rule integrates a bilinear field to round-off."""
    axial, transverse = np.array([0.0, 1.0, 4.0]), np.array([0.0, 3.0, 5.0, 10.0])
    depth = 1.0 + axial[:, None] * transverse[None, :]
    zero = np.zeros_like(depth)
    scar = Scar(1, "fixed", 0.45, 90.0, axial, transverse, depth, zero, zero, zero)
    assert scar.volume_mm3 == pytest.approx(1e-9 * (40.0 + 8.0 * 50.0), rel=1e-13)


@pytest.mark.parametrize("angle", [0.0, 30.0, 60.0, 90.0, 180.0, -90.0])
def test_sampling_turns_the_wire_into_the_sliding_frame(angle: float) -> None:
    """A plane of depths, tilted along and across the wire, is tilted along the turned directions."""
    axial, transverse = np.linspace(-50.0, 50.0, 11), np.linspace(-50.0, 50.0, 11)
    depth = 300.0 + axial[:, None] + 3.0 * transverse[None, :]
    zero = np.zeros_like(depth)
    scar = Scar(1, "fixed", 0.45, angle, axial, transverse, depth, zero, zero, zero)
    x, y = np.array([-20.0, 0.0, 10.0]), np.array([-7.0, 25.0])
    a = math.radians(angle)
    along = x[:, None] * math.cos(a) + y[None, :] * math.sin(a)
    across = y[None, :] * math.cos(a) - x[:, None] * math.sin(a)
    np.testing.assert_allclose(scar.sampled(x, y), 300.0 + along + 3.0 * across, rtol=1e-12)


def test_sampling_outside_the_grid_gives_zero() -> None:
    """Beyond the recorded grid nothing is worn."""
    scar = bowl("moving", 5.0, 40.0, 20.0)
    assert scar.sampled(np.array([1e3, 0.0]), np.array([0.0])).tolist() == [[0.0], [5.0]]


def test_coordinates_there_and_back_are_the_same_point() -> None:
    """The two frames are turned against each other and share the origin."""
    scar = bowl("fixed", 5.0, 40.0, 20.0, axis_angle_deg=37.0)
    x, y = np.array([3.0, -8.0]), np.array([11.0, 0.5])
    np.testing.assert_allclose(scar.sliding_coordinates(*scar.wire_coordinates(x, y)), (x, y), atol=1e-12)


@pytest.mark.parametrize(("angle", "half_um"), [(0.0, 80.0), (90.0, 30.0)])
def test_section_along_motion_crosses_the_scar_at_its_middle(angle: float, half_um: float) -> None:
    """Along the motion it is the axial section, across it the transverse one: depth·(1 − (x/half)²)."""
    scar = bowl("fixed", depth_um=9.0, half_length_um=80.0, half_width_um=30.0, axis_angle_deg=angle)
    x, depth = scar.section_along_motion()
    np.testing.assert_allclose(depth, 9.0 * np.maximum(1.0 - (x / half_um) ** 2, 0.0), atol=1e-9)
    assert x[0] == pytest.approx(-1.5 * half_um)
    assert x[-1] == pytest.approx(1.5 * half_um)


def test_section_of_a_skew_wire_agrees_with_its_samples() -> None:
    """At 60° the section lies on sampled(x, 0) and stays within the grid."""
    scar = bowl("fixed", 9.0, 80.0, 30.0, axis_angle_deg=60.0)
    x, depth = scar.section_along_motion()
    np.testing.assert_allclose(depth, scar.sampled(x, np.array([0.0]))[:, 0], atol=1e-12)
    assert np.all(np.diff(x) > 0.0)
    assert abs(x).max() == pytest.approx(1.5 * 30.0 / math.sin(math.radians(60.0)))


def test_unworn_wire_is_a_circle_below_its_crown() -> None:
    """Height is 0 at the crown and −R at the flank of a 0.45 mm wire."""
    scar = bowl("moving", 5.0, 40.0, 20.0)
    np.testing.assert_allclose(scar.unworn_height_um([0.0, 225.0]), [0.0, -225.0])


def test_a_logged_cycle_near_the_wanted_one_is_taken() -> None:
    """The nearest logged cycle within a factor of two stands for the wanted one."""
    run = result()
    assert run.loop(120).cycle == 100
    assert run.loop(60_000).cycle == 100_000
    assert (run.scar(1, "fixed").cycle, run.scar(1, "fixed").body) == (1, "fixed")
    assert run.evolution.at(100_000)["cycle"] == 100_000


def test_a_cycle_far_from_all_logged_ones_is_refused_with_their_list() -> None:
    """Nothing is silently shown in place of a cycle that was not reached."""
    run = result(milestones=(1, 10, 100))
    with pytest.raises(ResultError, match=r"scars of the moving wire.*100000.*logged cycles are: 1, 10, 100"):
        run.scar(100_000, "moving")
    with pytest.raises(ResultError, match=r"loops: .*cycle 3000;"):
        run.loop(3000)


def test_cycles_with_both_scars_are_listed() -> None:
    """A milestone counts once both wires are logged."""
    run = result(milestones=(1, 10))
    assert dataclasses.replace(run, scars=run.scars[:3]).scar_cycles() == (1,)


def test_label_is_the_variant_or_else_the_name() -> None:
    """Pictures of one run without variants carry the study's name."""
    assert (result("rigid").label, result().label) == ("rigid", "made-up wires")


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"body": "upper"}, "wire must be one of moving, fixed, not 'upper'"),
        ({"diameter_mm": 0.0}, "diameter_mm must be positive"),
        ({"depth_um": -np.ones((61, 41))}, "depth_um must not be negative, but -1 is"),
        ({"depth_um": np.ones((61, 40))}, r"shape of the grid \(61, 41\), not \(61, 40\)"),
        ({"pressure_MPa": np.full((61, 41), np.nan)}, "pressure_MPa must be finite everywhere"),
        ({"axial_um": np.zeros(61)}, "axial_um must increase strictly"),
        ({"transverse_um": [0.0]}, "transverse_um must have at least two grid lines"),
        ({"transverse_um": ["a", "b"]}, "transverse_um must hold real numbers"),
    ],
)
def test_a_scar_that_cannot_be_is_refused(change: dict[str, object], sentence: str) -> None:
    """Each mistake is named in one sentence."""
    with pytest.raises(ResultError, match=sentence):
        dataclasses.replace(bowl("moving", 5.0, 40.0, 20.0), **change)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"time_s": np.zeros(3)}, "all columns must be equally long, not time_s 3"),
        ({"normal_force_N": np.full(200, np.inf)}, "loop of cycle 7: normal_force_N must be finite"),
        ({"time_s": np.zeros((200, 1))}, "time_s must have 1 dimension"),
    ],
)
def test_a_loop_that_cannot_be_is_refused(change: dict[str, object], sentence: str) -> None:
    """Each mistake is named in one sentence."""
    with pytest.raises(ResultError, match=sentence):
        dataclasses.replace(loop(7, 167.0), **change)  # type: ignore[arg-type]


def test_an_evolution_has_all_columns_equally_long_and_increasing_cycles() -> None:
    """Missing, unequal or unordered columns are refused."""
    columns = dict(result().evolution)
    with pytest.raises(ResultError, match=r"column\(s\) missing: cycle"):
        Evolution({name: column for name, column in columns.items() if name != "cycle"})
    with pytest.raises(ResultError, match="equally long"):
        Evolution({**columns, "jump_cycles": np.zeros(2)})
    with pytest.raises(ResultError, match="cycle must increase"):
        Evolution({**columns, "cycle": columns["cycle"][::-1]})


def test_numbers_increase_also_where_their_difference_overflows() -> None:
    require_increasing("x", np.array([-1.7e308, 1.7e308]))
    for wrong in ([1.0, 1.0], [1.0, math.nan], [2.0, 1.0]):
        with pytest.raises(ResultError, match="x must increase strictly"):
            require_increasing("x", np.array(wrong))


def test_columns_that_older_results_lack_are_unknown() -> None:
    """Files of earlier versions stay readable."""
    columns = {name: column for name, column in result().evolution.items() if name not in LATER_COLUMNS}
    evolution = Evolution(columns)
    for name in LATER_COLUMNS:
        assert np.isnan(evolution[name]).all()
        assert evolution[name].shape == evolution["cycle"].shape


def test_an_evolution_is_made_of_rows() -> None:
    """Rows give columns, no rows give empty ones, a row with a hole is refused."""
    rows = [dict.fromkeys(EVOLUTION_COLUMNS, float(i)) for i in (1, 2)]
    assert Evolution.from_rows(rows)["jump_cycles"].tolist() == [1.0, 2.0]
    assert Evolution.from_rows([])["cycle"].size == 0
    del rows[1]["jump_cycles"]
    with pytest.raises(ResultError, match="'jump_cycles' is missing in some rows"):
        Evolution.from_rows(rows)


def test_arrays_of_a_result_cannot_be_changed() -> None:
    """Results are values: their arrays are read-only copies."""
    run: RunResult = result()
    with pytest.raises(ValueError, match="read-only"):
        run.loops[0].tangential_force_N[0] = 1.0


def test_an_unknown_status_is_refused() -> None:
    """Only complete, running and failed runs exist."""
    with pytest.raises(ResultError, match="complete, running, failed, not 'fine'"):
        result(status="fine")
