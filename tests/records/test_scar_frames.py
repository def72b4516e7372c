"""A scar has a frame and its wire an angle: what was measured comes back as the run that it was exported from."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from tests.commands import wirewear
from tests.diagnosis.diagnosis_cases import concluded
from tests.studies import line_study
from tests.synthetic_results import bowl, result
from wirewear import RecordError, read_record, write_record, write_result
from wirewear.comparison.comparison import compare
from wirewear.comparison.registration import register, scar_pairs
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.surrogate.line_states import LineStates
from wirewear.diagnosis.surrogate.nominal_model import nominal_line_inputs
from wirewear.records import ExperimentRecord, MeasuredScar, record_of_result
from wirewear.records.importing import import_record
from wirewear.records.writing import frame_of
from wirewear.results import RunResult
from wirewear.simulation import simulate
from wirewear.test import load_study

pytestmark = pytest.mark.seconds
STEEL = Path(__file__).parents[2] / "studies" / "steel_wires" / "study.toml"
NOISE_um = 0.05


def run_at(angle_deg: float) -> RunResult:
    """A made-up run whose wires cross at an angle; its scars are as long as they are not wide."""
    study = load_study(STEEL).variant("compliant").with_values({"wires.crossing_angle_deg": angle_deg}).resolved()
    scars = (bowl("moving", 6.0, 110.0, 60.0), bowl("fixed", 8.0, 90.0, 70.0, axis_angle_deg=angle_deg))
    return dataclasses.replace(result("", 167.0), study=study, scars=scars)


def laid_askew(folder: Path) -> list[str]:
    """All tables of a folder, those of heights tilted, raised, and off the middle."""
    paths = sorted(folder.glob("*.csv"))
    for path in paths:
        table = pl.read_csv(path)
        for axis, slope, shift in (("x_um", 0.02, 900.0), ("y_um", -0.01, -40.0)):
            if {axis, "height_um"} <= set(table.columns):
                tilted = table["height_um"] + slope * table[axis]
                table = table.with_columns(tilted.alias("height_um"), table[axis] + shift)
        if "height_um" in table.columns:
            table.with_columns(table["height_um"] + 7.0).write_csv(path)
    return [str(path) for path in paths]


def exported(run: RunResult, folder: Path, angle_deg: float) -> list[str]:
    """The run's loops, and its heights in each wire's frame with noise, tilt, level and the wire off the middle."""
    write_result(folder / "result.h5", run)
    noise = f"displacement_um=0.15,tangential_force_N=0.008,depth_um={NOISE_um}"
    wirewear("export", folder / "result.h5", "--as-heights", folder, "--samples", 128, "--noise", noise)
    files = laid_askew(folder)
    call = ["new", "--mapping", *files, "--diameter", "0.45", "--crossing-angle", str(angle_deg)]
    wirewear(*call, "--frequency", "3")
    return files


@pytest.mark.first_case
@pytest.mark.parametrize("angle_deg", [90.0, 60.0, 45.0, 30.0])
def test_heights_in_the_wires_frame_come_back_as_the_run_that_they_are_of(tmp_path: Path, angle_deg: float) -> None:
    run = run_at(angle_deg)
    exported(run, tmp_path, angle_deg)
    record = import_record(tmp_path / "mapping.toml")
    record = dataclasses.replace(
        record,
        tables=record.tables.model_copy(
            update={"conditions": record.tables.conditions.model_copy(update={"cycles": 100_000})}
        ),
    )
    pairs, notes = scar_pairs(run, record)
    assert not notes
    for pair in pairs:
        (turned,) = pair.registrations
        assert abs(turned.rotation_deg) < 1.0
        assert float(np.sqrt(np.nanmean((pair.simulated - pair.mean) ** 2))) < 3.0 * NOISE_um
        assert pair.measured_volumes_mm3[0] == pytest.approx(pair.simulated_volumes_mm3[0], rel=0.02)


def test_heights_in_the_tests_frame_are_recognised_and_lose_the_wire(tmp_path: Path) -> None:
    run = run_at(60.0)
    exported(run, tmp_path, 60.0)
    path = tmp_path / "scar_fixed_1.csv"
    table = pl.read_csv(path)
    x, y = table["x_um"].to_numpy() - 900.0, table["y_um"].to_numpy() + 40.0
    cosine, sine = np.cos(np.radians(60.0)), np.sin(np.radians(60.0))
    table.with_columns(x_um=x * cosine - y * sine, y_um=x * sine + y * cosine).write_csv(path)
    (tmp_path / "mapping.toml").unlink()
    files = sorted(str(file) for file in tmp_path.glob("*.csv"))
    call = ["new", "--mapping", *files, "--diameter", "0.45", "--crossing-angle", "60", "--frequency", "3"]
    assert 'frame = "test", x along the motion' in wirewear(*call).output
    (scar,) = import_record(tmp_path / "mapping.toml").scars_of("fixed")
    assert abs(register(scar, run.scars[1]).rotation_deg) < 1.0
    assert scar.volume_mm3 == pytest.approx(run.scars[1].volume_mm3, rel=0.02)
    # At another angle than the map shows, the wire cannot be taken away, and that is said.
    text = (tmp_path / "mapping.toml").read_text(encoding="utf-8")
    (tmp_path / "mapping.toml").write_text(text.replace("angle_deg = 60", "angle_deg = 90"), encoding="utf-8")
    with pytest.raises(RecordError, match=r"the fixed wire lies at 60° to the map's x, not at 90°"):
        import_record(tmp_path / "mapping.toml")


@pytest.mark.parametrize("angle_deg", [90.0, 60.0])
def test_a_table_of_depths_in_its_wires_frame_is_read_into_that_of_the_test(tmp_path: Path, angle_deg: float) -> None:
    """Records of the first two editions say nothing, and are read as they were."""
    run = run_at(angle_deg)
    folder = write_record(tmp_path / "record", record_of_result(run))
    before = read_record(folder)
    scar = run.scars[1]
    a, t = np.meshgrid(np.arange(-150.0, 151.0, 5.0), np.arange(-120.0, 121.0, 5.0), indexing="ij")
    depth = scar.depth_at(*scar.sliding_coordinates(a, t))
    columns = {"repeat": np.ones(a.size, dtype=int), "x_um": a.ravel(), "y_um": t.ravel(), "depth_um": depth.ravel()}
    frame_of(columns).write_csv(folder / "scar_fixed.csv")
    toml = folder / "experiment.toml"
    text = toml.read_text(encoding="utf-8").split("\n# The files as")[0]
    toml.write_text(f'{text}\n[files.frames]\nscar_fixed = "wire"\n', encoding="utf-8")
    after = read_record(folder)
    for one, other in zip(before.scars, after.scars, strict=True):
        assert one.volume_mm3 == pytest.approx(other.volume_mm3, rel=0.003)
        own = run.scars[0 if other.body == "moving" else 1]
        assert np.nanmax(np.abs(other.depth_um - own.sampled(other.x_um, other.y_um))) < 0.2
    toml.write_text(text + '\n[files.frames]\nscar_fixed = "holder"\n', encoding="utf-8")
    with pytest.raises(RecordError, match=r'must be "test" \(x along the motion\) or "wire"'):
        read_record(folder)


def test_a_plain_ellipse_is_never_called_too_round_and_a_wrong_frame_is_found_as_a_rotation() -> None:
    simulated = bowl("moving", 6.0, 60.0, 45.0)
    x = np.arange(-300.0, 301.0, 6.0)
    noise = NOISE_um * np.random.default_rng(1).standard_normal((x.size, x.size))
    scar = MeasuredScar(1, "moving", x, x, simulated.sampled(x, x) + noise)
    for angle in (0.0, 30.0, 60.0):
        found = register(scar.turned(angle), simulated)
        assert not found.rotation_held
        assert found.rotation_deg == pytest.approx(angle, abs=1.0)


@pytest.mark.parametrize(("length", "is_round"), [(60.6, True), (66.0, False)])
def test_a_scar_that_is_all_but_round_has_no_rotation(length: float, *, is_round: bool) -> None:
    simulated = bowl("moving", 6.0, length, 60.0)
    x = np.arange(-150.0, 151.0, 10.0)
    noise = NOISE_um * np.random.default_rng(1).standard_normal((x.size, x.size))
    assert (
        register(MeasuredScar(1, "moving", x, x, simulated.sampled(x, x) + noise), simulated).rotation_held is is_round
    )


def test_quarters_of_a_turn_keep_every_point() -> None:
    depth = np.arange(12.0).reshape(4, 3)
    scar = MeasuredScar(1, "fixed", np.arange(4.0), np.arange(3.0), depth)
    np.testing.assert_array_equal(scar.turned(90.0).turned(90.0).turned(180.0).depth_um, depth)
    assert scar.turned(90.0).depth_um[-1, 2] == depth[2, 0]


def test_noise_around_a_scar_leaves_its_volume_the_same_everywhere_given() -> None:
    """Depths are never clipped: six maps of a noisy scar have the mean of the scar that they are of."""
    run = run_at(90.0)
    record: ExperimentRecord = record_of_result(run, depth_noise_um=0.3, repeats=6, seed=3)
    for wire, true in zip(("moving", "fixed"), run.scars, strict=True):
        maps = record.scars_of(wire)
        assert min(float(scar.depth_um.min()) for scar in maps) < -0.6
        mean = float(np.mean([scar.volume_mm3 for scar in maps]))
        assert mean == pytest.approx(true.volume_mm3, rel=0.005)
    pairs, _ = scar_pairs(run, record)
    volumes = record.worn_volumes_mm3
    for pair in pairs:
        assert dict(zip(pair.repeats, pair.measured_volumes_mm3, strict=True)) == volumes[pair.wire]
        assert np.mean(pair.simulated_volumes_mm3) == pytest.approx(np.mean(pair.measured_volumes_mm3), rel=0.005)


def stating(mapping: Path, stated: str) -> Path:
    """The mapping once the owner has stated his rig."""
    text = mapping.read_text(encoding="utf-8")
    mapping.write_text(re.sub(r"(\[stated\].*\n)", rf"\1{stated}\n", text), encoding="utf-8")
    return mapping


@pytest.mark.slow
def test_a_line_contacts_heights_come_back_as_the_run_that_they_were_exported_from(tmp_path: Path) -> None:
    study = line_study()
    run = simulate(study, fidelity="quick")
    write_result(tmp_path / "run" / "result.h5", run)
    noise = f"displacement_um=0.15,tangential_force_N=0.2,depth_um={NOISE_um}"
    call = ["export", str(tmp_path / "run"), "--as-heights", str(tmp_path), "--length", "8", "--noise", noise]
    wirewear(*call)
    files = laid_askew(tmp_path)
    call = ["new", "--mapping", *files, "--length", "8", "--radius", "6", "--cycles", "20000", "--frequency", "1"]
    wirewear(*call)
    mapping = stating(
        tmp_path / "mapping.toml",
        """friction = 0.6
pad_energy_wear_coefficient_mm3_per_J = 4e-5
specimen_energy_wear_coefficient_mm3_per_J = 2e-5""",
    )
    mapping.write_text(mapping.read_text(encoding="utf-8").replace("= 210000.0", "= 200000.0"), encoding="utf-8")
    record = import_record(mapping)
    comparison = compare(run, record)
    left = [row.difference for row in comparison.differences if row.quantity == "depth (rms over the map)"]
    assert len(left) == 2
    assert max(left) < 3.0 * NOISE_um
    loops = [row for row in comparison.differences if row.source == "loops"]
    # A stiffness is read of the few samples of a steep branch, whose displacements are noisy.
    near = {row: 0.04 if row.quantity == "measured stiffness" else 0.01 for row in loops}
    assert all(abs(row.difference) < share * row.simulated for row, share in near.items() if row.simulated)
    setup = nominal_line_inputs(study.of_length(8.0), record.tables.conditions.drive)
    states = LineStates.of_line(run, study.pad.profile, 8.0)
    assert concluded(record, study.of_length(8.0), states, reduce(record), setup=setup).diagnosis.verdict == "no_gap"


@pytest.mark.parametrize("deepest_um", [0.1, 0.006, 0.002])
def test_a_shallow_ring_on_a_map_without_noise_has_its_volume(deepest_um: float) -> None:
    """A ring of the depth D sin²(π (r − c)/w) from the radius r = c to c + w has the volume π D w (c + w/2)."""
    x, core, wide = np.linspace(-130.0, 130.0, 105), 50.0, 70.0
    out = np.hypot(x[:, None], x) - core
    depth = deepest_um * np.sin(np.pi * np.clip(out / wide, 0.0, 1.0)) ** 2
    scar = MeasuredScar(1, "fixed", x, x, depth)
    assert 1e9 * scar.volume_mm3 == pytest.approx(np.pi * deepest_um * wide * (core + 0.5 * wide), rel=1e-3)
