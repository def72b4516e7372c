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

from tests.browser import browser, needs_browser
from tests.synthetic_results import bowl, result
from wirewear import RecordError, check_record, read_record, record_of_result, write_record, write_result
from wirewear.faces import cli
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.records import ExperimentRecord, MeasuredScar
from wirewear.results import Loop, RunResult
from wirewear.study import load_study
from wirewear.views.comparison import compare
from wirewear.views.comparison_page import sentence, worst_differences
from wirewear.views.comparison_pictures import evolution_picture
from wirewear.views.differences import Difference
from wirewear.views.registration import register

ROOT = Path(__file__).parent.parent
STUDY = load_study(ROOT / "studies" / "steel_wires" / "study.toml")
EXAMPLE = ROOT / "studies" / "steel_wires" / "example_records" / "rigid_stated_compliant_rig"

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


def test_steps_that_a_simulation_chooses_move_its_loops_in_no_phase(run: RunResult) -> None:
    """Runs have short steps where the force bends, and long ones where the contact slides."""
    names = [field.name for field in dataclasses.fields(Loop) if field.name != "cycle"]

    def uneven(loop: Loop) -> Loop:
        rising = np.abs(np.gradient(loop.tangential_force_N)) > 1e-3
        kept = rising | np.roll(rising, -1) | np.roll(rising, 1) | (np.arange(rising.size) % 4 == 0)
        return dataclasses.replace(loop, **{name: getattr(loop, name)[kept] for name in names})

    simulated = dataclasses.replace(run, loops=tuple(uneven(loop) for loop in run.loops))
    for pair in compare(simulated, record_of_result(dataclasses.replace(run, scars=()))).loops:
        assert float(np.sqrt(np.mean((pair.simulated[1] - pair.measured[0, 1]) ** 2))) < 2e-3


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


@pytest.mark.slow
def test_with_noise_whole_loops_and_maps_differ_from_themselves_by_half_a_scatter(
    run: RunResult, noisy: ExperimentRecord, tmp_path: Path
) -> None:
    """Each sample is the mean of 4 repeats; of hundreds of samples the root mean square is near 1/√4."""
    record = read_record(write_record(tmp_path, noisy))
    assert not check_record(record).problems
    rows = compare(run, record).differences
    whole = [
        row.in_scatter for row in rows if row.quantity in ("force at equal phase (rms)", "depth (rms over the map)")
    ]
    assert len(whole) == len(run.loops) + 2
    for ratio in whole:
        # Noise of the displacement, read between samples, adds to that of the force.
        assert ratio is not None
        assert 0.45 < ratio < 0.7
    assert all(row.in_scatter is not None and abs(row.in_scatter) < 5.0 for row in rows)


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


def test_repeats_are_read_anew_and_a_seed_repeats_them(run: RunResult) -> None:
    first, again = (record_of_result(run, sensor=NOISY, repeats=2, seed=7) for _ in range(2))
    assert first.repeats == (1, 2)
    np.testing.assert_array_equal(first.loops[0].tangential_force_N, again.loops[0].tangential_force_N)
    assert not np.array_equal(first.loop(1, 1).tangential_force_N, first.loop(2, 1).tangential_force_N)
    noise = first.loop(1, 1).tangential_force_N - first.loop(2, 1).tangential_force_N
    assert np.std(noise) == pytest.approx(0.008 * np.sqrt(2.0), rel=0.2)


def test_what_the_study_believes_is_stated_and_what_is_ideal_is_not(run: RunResult) -> None:
    stated = record_of_result(run).tables.stated
    assert stated.friction == 0.62
    assert stated.tangential_stiffness_N_per_mm == 167.0
    rigid = dataclasses.replace(run, study=STUDY.variant("rigid").resolved())
    assert "tangential_stiffness_N_per_mm" not in record_of_result(rigid).tables.stated.model_fields_set


def test_unequal_wires_and_studies_without_wires_are_refused_in_one_sentence(run: RunResult) -> None:
    unequal = {**run.study, "wires": {**run.study["wires"], "fixed": {"diameter_mm": 0.6}}}
    with pytest.raises(RecordError, match=r"the fixed wire .* has its own diameter_mm"):
        record_of_result(dataclasses.replace(run, study=unequal))
    with pytest.raises(RecordError, match=r"missing key 'diameter_mm'"):
        record_of_result(result())


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


def test_a_round_scar_holds_its_rotation() -> None:
    simulated = bowl("fixed", 20.0, 80.0, 80.0)
    x = np.arange(-120.0, 121.0, 10.0)
    noise = 0.05 * np.random.default_rng(1).standard_normal((x.size, x.size))
    found = register(MeasuredScar(1, "fixed", x, x, np.maximum(simulated.sampled(x, x) + noise, 0.0)), simulated)
    assert found.rotation_held
    assert found.rotation_deg == 0.0


def test_without_a_common_cycle_the_refusal_names_both_lists(run: RunResult, noisy: ExperimentRecord) -> None:
    late = dataclasses.replace(run, loops=run.loops[-1:])
    early = dataclasses.replace(noisy, loops=tuple(loop for loop in noisy.loops if loop.cycle == 1))
    with pytest.raises(RecordError, match=r"cycles are 100\u2009000, the record's 1\."):
        compare(late, early)


def test_one_repeat_tells_its_loops_uncertainty_and_counts_no_difference_in_scatters(run: RunResult) -> None:
    record = record_of_result(run, sensor=NOISY, samples=256)
    rows = [row for row in compare(run, record).differences if row.quantity == "slip amplitude δ0"]
    assert {row.basis for row in rows} == {"one loop's uncertainty"}
    assert all(row.in_scatter is None and row.scatter is not None and row.scatter > 0.0 for row in rows)


def test_records_without_scars_evolution_and_load_are_compared_as_far_as_they_go(
    run: RunResult, noisy: ExperimentRecord
) -> None:
    loops = tuple(dataclasses.replace(loop, normal_force_N=None) for loop in noisy.loops)
    comparison = compare(run, dataclasses.replace(noisy, loops=loops, evolution=(), scars=()))
    assert {row.source for row in comparison.differences} == {"loops"}
    assert any("no scar of the moving wire" in note for note in comparison.notes)


def test_without_an_evolution_every_panel_shows_the_measured_loops(run: RunResult, noisy: ExperimentRecord) -> None:
    comparison = compare(run, dataclasses.replace(noisy, evolution=(), scars=()))
    figure = evolution_picture(comparison.result, comparison.record, comparison.loops)
    cycles = {loop.cycle for loop in noisy.loops if loop.cycle > 0}
    for axes in figure.axes:
        marked = [line for line in axes.lines if line.get_marker() not in ("None", "", None)]
        seen = {round(float(x)) for line in marked for x in np.asarray(line.get_xdata(), dtype=float)}
        assert cycles <= seen, axes.get_title()


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


@pytest.mark.slow
@needs_browser
def test_the_page_of_a_comparison_moves_its_loop_and_fits_a_phone(compared: Path) -> None:
    with browser() as page:
        page.open(compared / "comparison.html", 390, 844, phone=True)
        loop = "document.querySelector('#loop path.now').getAttribute('d')"
        last = page.value(loop)
        page.value("(s => { s.value = 0; s.dispatchEvent(new Event('input')); })(document.querySelector('#cycle'))")
        assert page.value(loop) != last
        assert page.value("[document.documentElement.scrollWidth, innerWidth]") == [390, 390]
        assert page.value("document.querySelectorAll('#slip_amplitude_um circle').length") > 0
        assert page.problems == []


def test_the_sentence_names_the_largest_difference_or_none() -> None:
    def row(quantity: str, ratio: float | None) -> Difference:
        return Difference("loops", quantity, "µm", 1000, 50.0, 48.0, 2.0, 0.4, ratio, "repeats")

    assert sentence([row("slip amplitude δ0", 1.0)]).startswith("Simulation and experiment agree: none of 1 quantities")
    assert sentence(worst_differences([row("energy", 1.0), row("slip amplitude δ0", -5.0)])) == (
        "1 of 2 quantities differ by more than three scatters. The largest is in slip amplitude δ0 (loops) at cycle "
        "1000: +2 µm, 5 scatters."
    )
    assert "no difference can be judged" in sentence([row("energy", None)])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--noise", "force=1"], "--noise holds 'force=1', but must be a list like displacement_um=0.1"),
        (["--gain", "displacement=-1"], "numbers that are not negative"),
        (["--variant", "soft"], "there is no variant 'soft'"),
    ],
)
def test_options_of_export_that_make_no_sense_are_one_sentence(
    run: RunResult, tmp_path: Path, options: list[str], words: str
) -> None:
    write_result(tmp_path / "result.h5", run)
    outcome = CliRunner().invoke(cli, ["export", str(tmp_path), "--as-record", str(tmp_path / "r"), *options])
    assert outcome.exit_code == 2
    assert words in outcome.stderr


def test_the_command_exports_through_a_sensor_coupled_to_the_load(run: RunResult, tmp_path: Path) -> None:
    path = tmp_path / "result.h5"
    write_result(path, run)
    sensor = "linear_um_per_N=-0.5,quadratic_um_per_N2=0.2"
    command = ["export", str(path), "--as-record", str(tmp_path / "record"), "--sensor", sensor]
    assert CliRunner().invoke(cli, command).exit_code == 0
    true, read = run.loops[0], read_record(tmp_path / "record").loops[0]
    force = true.tangential_force_N
    np.testing.assert_allclose(read.displacement_um, true.displacement_um - 0.5 * force + 0.2 * force**2)
    refused = CliRunner().invoke(cli, [*command[:-1], "friction=0.5"])
    assert refused.exit_code == 2
    assert "--sensor holds 'friction=0.5', but must be a list like" in refused.stderr


def test_cycles_that_a_run_has_not_logged_are_told_in_one_sentence(run: RunResult, noisy: ExperimentRecord) -> None:
    late = dataclasses.replace(run, loops=run.loops[-1:])
    told = [note for note in compare(late, noisy).notes if "no loops near" in note]
    assert len(told) == 1
    assert "1, 100, 1000, 10\u2009000" in told[0]
    assert "--cycles-of RECORD" in told[0]


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
