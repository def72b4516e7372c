"""A simulation exported as a record, checked, and compared with a simulation."""

import csv
import dataclasses
import html
import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.stats import binom, t

from tests.synthetic_results import bowl, result
from wirewear import check_record, read_record, record_of_result, write_record, write_result
from wirewear.faces import cli
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.records import ExperimentRecord, MeasuredScar
from wirewear.results import RunResult
from wirewear.study import load_study
from wirewear.views.comparison import compare
from wirewear.views.registration import register

pytestmark = pytest.mark.seconds

ROOT = Path(__file__).parent.parent
STUDY = load_study(ROOT / "studies" / "steel_wires" / "study.toml")

NOISY = Sensor(noise=SensorNoise(displacement_um=0.15, tangential_force_N=0.008, normal_force_N=0.01))


@pytest.fixture(scope="module")
def run() -> RunResult:
    return dataclasses.replace(result("", 167.0), study=STUDY.variant("compliant").resolved())


@pytest.fixture(scope="module")
def noisy(run: RunResult) -> ExperimentRecord:
    return record_of_result(run, sensor=NOISY, depth_noise_um=0.05, repeats=4, seed=5, samples=256)


def test_a_simulation_exported_and_compared_with_itself_differs_by_round_off_only(
    run: RunResult, tmp_path: Path
) -> None:
    record = read_record(write_record(tmp_path, record_of_result(run)))
    assert not check_record(record).problems
    comparison = compare(run, record)
    assert len(comparison.loops) == len(run.loops)
    assert {row.source for row in comparison.differences} == {
        "loops", "evolution", "scar, moving wire", "scar, fixed wire",
    }  # fmt: skip
    for row in comparison.differences:
        size = max(abs(row.simulated or 0.0), 1.0)
        assert abs(row.difference) <= 1e-9 * size, row
        assert row.in_scatter == 0.0
    for pair in comparison.scars:
        (registration,) = pair.registrations
        assert abs(registration.shift_x_um) + abs(registration.shift_y_um) < 1e-6
        assert abs(registration.rotation_deg) < 1e-6


@pytest.mark.slow
def test_with_noise_a_simulation_differs_from_itself_as_students_t_has_it(run: RunResult) -> None:
    """The mean of 4 repeats over their scatter, times √4, follows Student's t with 3 degrees of freedom.

    Of slip amplitudes and stiffnesses, which noise does not bias; half of the ratios lie within the quartiles of t, and
    one in twenty beyond its 95 % limit, as far as counting can tell. A scatter wrong by a factor of two would show.
    """
    ratios = []
    for seed in range(10):
        record = record_of_result(run, sensor=NOISY, repeats=4, seed=seed, samples=256)
        rows = compare(run, dataclasses.replace(record, scars=(), evolution=())).differences
        wanted = [row for row in rows if row.quantity in ("slip amplitude δ0", "measured stiffness")]
        assert {row.basis for row in wanted} == {"repeats"}
        ratios += [2.0 * abs(row.in_scatter or 0.0) for row in wanted]
    count = len(ratios)
    assert count == 10 * 2 * len(run.loops)
    for probability in (0.5, 0.95):
        within = int(np.sum(np.array(ratios) < t.ppf(0.5 + 0.5 * probability, df=3)))
        assert binom.ppf(0.005, count, probability) <= within <= binom.ppf(0.995, count, probability)


def test_a_stiffer_model_stands_out_by_many_scatters(noisy: ExperimentRecord, run: RunResult) -> None:
    stiffer = dataclasses.replace(result("", 2000.0), study=run.study)
    worst = {
        row.quantity: row.in_scatter or 0.0 for row in compare(stiffer, noisy).differences if row.source == "loops"
    }
    assert worst["slip amplitude δ0"] > 20.0
    assert worst["measured stiffness"] > 20.0


def test_a_gain_of_the_sensor_shows_in_amplitude_slip_and_energy(run: RunResult) -> None:
    record = record_of_result(run, sensor=Sensor(displacement_gain=1.1))
    part = record.evolution[0].columns
    for name in ("displacement_amplitude_um", "slip_amplitude_um", "dissipated_energy_mJ"):
        true = run.evolution[name][np.unique(run.evolution["cycle"], return_index=True)[1]]
        np.testing.assert_allclose(part[name][-1], 1.1 * true[-1], rtol=1e-6)
    np.testing.assert_allclose(record.loops[0].displacement_um, 1.1 * run.loops[0].displacement_um)


@pytest.mark.parametrize("shift", [(0.0, 0.0), (23.0, -14.0)])
@pytest.mark.parametrize("turn_deg", [0.0, 8.0])
def test_registration_finds_shift_and_rotation_of_a_noisy_map(shift: tuple[float, float], turn_deg: float) -> None:
    simulated = bowl("moving", 12.0, 120.0, 60.0)
    x, y = np.arange(-200.0, 201.0, 10.0), np.arange(-150.0, 151.0, 10.0)
    cosine, sine = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg))
    from_x, from_y = np.meshgrid(x - shift[0], y - shift[1], indexing="ij")
    depth = simulated.depth_at(from_x * cosine + from_y * sine, from_y * cosine - from_x * sine)
    noise = 0.05 * np.random.default_rng(1).standard_normal(depth.shape)
    depth = np.where(np.random.default_rng(2).random(depth.shape) < 0.02, np.nan, np.maximum(depth + noise, 0.0))
    found = register(MeasuredScar(1, "moving", x, y, depth), simulated)
    assert not found.rotation_held
    np.testing.assert_allclose((found.shift_x_um, found.shift_y_um), shift, atol=0.3)
    assert found.rotation_deg == pytest.approx(turn_deg, abs=0.3)
    assert abs(found.shift_x_um - shift[0]) < 5.0 * found.shift_x_deviation_um


@pytest.fixture(scope="module")
def compared(run: RunResult, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that `export`, `check` and `compare` leave."""
    folder = tmp_path_factory.mktemp("compared")
    write_result(folder / "run" / "result.h5", run)
    runner, record = CliRunner(), str(folder / "record")
    noise = "displacement_um=0.15,tangential_force_N=0.008,depth_um=0.05"
    options = ["--noise", noise, "--repeats", "2", "--seed", "1"]
    exported = runner.invoke(cli, ["export", str(folder / "run"), "--as-record", record, *options])
    assert exported.exit_code == 0, exported.output
    assert runner.invoke(cli, ["check", record]).exit_code == 0
    told = runner.invoke(cli, ["compare", str(folder / "run"), record, "--output", str(folder / "out")])
    assert told.exit_code == 0, told.output
    return folder / "out"


@pytest.mark.slow
def test_the_commands_export_check_and_compare_leave_a_page_that_needs_no_other_file(compared: Path) -> None:
    assert sorted(path.name for path in compared.iterdir()) == [
        "comparison.html", "differences.csv", "differences.json", "evolution.png", "loops.png", "scar_maps.png",
        "scar_sections.png",
    ]  # fmt: skip
    page = (compared / "comparison.html").read_text(encoding="utf-8")
    assert re.findall(r"(?:src|href)=[\"'](?!data:|#)[^\"']*", page) == []
    assert len(page) < 1_500_000
    with (compared / "differences.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    report = json.loads((compared / "differences.json").read_text(encoding="utf-8"))
    assert len(rows) == len(report["differences"]) > 40
    assert len(report["registrations"]) == 4
    # Every difference is in the page, but a reader meets one line for each quantity first.
    first, rest = page.split("All ", 1)
    assert first.count("<tr") < 30 < rest.count("<tr")


def test_a_run_and_a_record_of_other_conditions_are_not_compared_without_a_word(run: RunResult, tmp_path: Path) -> None:
    record = record_of_result(run)
    assert compare(run, record).unlike is None
    conditions = {"normal_load_N": 5.0, "displacement_amplitude_um": 30.0, "cycles": 200_000}
    wires = {"diameter_mm": 0.6, "crossing_angle_deg": 60.0}
    tables = record.tables.model_copy(
        update={
            "conditions": record.tables.conditions.model_copy(update=conditions),
            "wires": record.tables.wires.model_copy(update=wires),
        }
    )
    other = dataclasses.replace(record, tables=tables)
    comparison = compare(run, other)
    assert comparison.unlike is not None
    for key in ("normal_load_N is 2 in the run and 5 in the record", *conditions, *wires):
        assert key in comparison.unlike
    write_result(tmp_path / "result.h5", run)
    write_record(tmp_path / "record", other)
    call = ["compare", str(tmp_path / "result.h5"), str(tmp_path / "record"), "--output", str(tmp_path / "out")]
    assert comparison.unlike in CliRunner().invoke(cli, call).stderr
    assert json.loads((tmp_path / "out" / "differences.json").read_text())["unlike_conditions"] == comparison.unlike
    page = (tmp_path / "out" / "comparison.html").read_text(encoding="utf-8")
    assert comparison.unlike in html.unescape(page.partition("<details>")[0])
