"""Line contacts: a laboratory's files imported, and parameters fitted to records whose truth is known."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

from geometry import Cylinder, Flat, RoundedFlat
from tests.logger_files import CYLINDER, FLAT, LOAD_N, LENGTH_mm, line_record, write_line_german
from wirewear.base.errors import RecordError
from wirewear.faces import cli
from wirewear.fitting import FittedTest, fit_record
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.planar import PlanarStudy, planar_study_from_tables, run_planar_study
from wirewear.records import LineRecord, check_record, read_record, record_of_result
from wirewear.records.contact_tables import LineStated
from wirewear.records.importing import import_record
from wirewear.records.importing.profilometry import levelled

CYCLES = 2000
STEEL = {"youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.3}
NOISE = Sensor(noise=SensorNoise(displacement_um=0.05, tangential_force_N=0.5, normal_force_N=0.5))

FACES: dict[str, tuple[dict[str, float], float]] = {
    "cylinder": ({"radius_mm": 6.0}, 20.0),
    "rounded flat": ({"face_half_width_mm": 0.15, "edge_radius_mm": 3.0}, 25.0),
}


@cache
def record_of(face: str, play_um: float = 0.0) -> LineRecord:
    """Two tests of µ 0.7 on a rig of 2000 N/mm² and 2 and 4·10⁻⁵ mm³/J; nothing but load and stroke is stated."""
    keys, load = FACES[face]
    tables: dict[str, Any] = {
        "format": 1,
        "name": face,
        "kind": "line-contact",
        "pad": keys | STEEL,
        "specimen": STEEL,
        "conditions": {
            "normal_load_N_per_mm": load,
            "displacement_amplitude_um": 35.0,
            "cycles": CYCLES,
            "frequency_Hz": 5.0,
        },
        "contact": {"friction": 0.7},
        "wear": {"pad_energy_mm3_per_J": 2.0e-5, "specimen_energy_mm3_per_J": 4.0e-5},
        "holder": {"tangential_stiffness_N_per_mm2": 2000.0},
        "effects": [{"name": "free_play", "gap_um": play_um}] if play_um else [],
        "log": {"loop_cycles": [1, 30, 300, CYCLES]},
        "mesh": {"contact_mesh_um": 9.0, "jump_tolerance": 0.05, "increments_per_cycle": 80},
    }
    result = run_planar_study(planar_study_from_tables(tables, "study.toml"), fidelity="quick")
    options: dict[str, Any] = {"sensor": NOISE, "depth_noise_um": 0.005, "repeats": 2, "seed": 1, "samples": 256}
    record = record_of_result(result, LENGTH_mm, **options)
    return replace(record, tables=record.tables.model_copy(update={"stated": LineStated()}))


@cache
def fitted(face: str, play_um: float = 0.0) -> FittedTest:
    return fit_record(record_of(face, play_um))


def within(fit: FittedTest, name: str, truth: float, share: float) -> None:
    """The truth lies in the interval, and the value is near it."""
    found = fit.parameters[name]
    assert found.interval95[0] <= truth <= found.interval95[1]
    assert found.value == pytest.approx(truth, rel=share)


@pytest.mark.slow
@pytest.mark.parametrize("face", FACES)
def test_friction_rig_and_wear_of_both_bodies_are_found(face: str) -> None:
    fit = fitted(face)
    within(fit, "friction", 0.7, 0.02)
    within(fit, "tangential_stiffness_N_per_mm", 2000.0 * LENGTH_mm, 0.06)
    for body, truth in (("pad", 2e-5), ("specimen", 4e-5)):
        assert fit.parameters[f"{body}_energy_wear_coefficient_mm3_per_J"].value == pytest.approx(truth, rel=0.03)
    volume, energy = fit.found["worn_volume_specimen_mm3"].value, fit.found["accumulated_energy_J"].value
    coefficient = fit.parameters["specimen_energy_wear_coefficient_mm3_per_J"].value
    assert volume / energy == pytest.approx(coefficient, rel=0.01)
    assert isinstance(fit.study, PlanarStudy)
    assert fit.study.holder.tangential_stiffness_N_per_mm2 == pytest.approx(2000.0, rel=0.06)
    assert fit.study.log.loop_cycles == (1, 30, 300, CYCLES)


@pytest.mark.slow
def test_play_is_told_from_the_rigs_stiffness() -> None:
    fit = fitted("cylinder", 4.0)
    assert fit.parameters["free_play_um"].value == pytest.approx(4.0, rel=0.1)
    assert fit.parameters["tangential_stiffness_N_per_mm"].value == pytest.approx(16000.0, rel=0.1)
    assert [effect.name for effect in fit.study.effects] == ["free_play"]


def record_of_nothing() -> LineRecord:
    from tests.logger_files import CYLINDER, line_record

    return line_record(CYLINDER)


def test_energies_and_volumes_of_a_line_contact_are_those_of_the_whole() -> None:
    from wirewear.fitting.wear import fitted_wear

    record = record_of_nothing()
    parameters, found, notes = fitted_wear(record)
    loop = record.loops[0]
    x, q = loop.displacement_um, loop.tangential_force_N
    area_mJ = 0.5e-3 * abs(float(np.sum(q * (np.roll(x, -1) - np.roll(x, 1)))))
    assert found["accumulated_energy_J"].value == pytest.approx(1e-3 * area_mJ * 1000, rel=0.01)
    # A parabola of 600 µm and 2.5 µm along 8 mm.
    assert found["worn_volume_specimen_mm3"].value == pytest.approx(2.0 / 3.0 * 0.6 * 2.5e-3 * 8.0, rel=0.01)
    ratio = found["worn_volume_pad_mm3"].value / found["accumulated_energy_J"].value
    assert parameters["pad_energy_wear_coefficient_mm3_per_J"].value == pytest.approx(ratio)
    assert notes == []


def wirewear(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


OPTIONS = {
    "cylinder": (CYLINDER, ("--radius", 6.0)),
    "rounded flat": (FLAT, ("--face-half-width", 0.3, "--edge-radius", 3.0)),
}


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("face", OPTIONS)
def test_a_guessed_mapping_gives_the_record_that_the_files_were_made_of(tmp_path: Path, face: str) -> None:
    keys, options = OPTIONS[face]
    truth = line_record(keys)
    guessed = wirewear("new", "--mapping", *write_line_german(truth, tmp_path), "--length", LENGTH_mm, *options)
    assert guessed.exit_code == 0, guessed.output
    imported = wirewear("import", tmp_path / "mapping.toml", "--output", tmp_path / "record")
    assert imported.exit_code == 0, imported.output
    record = read_record(tmp_path / "record")
    assert record.tables.pad.profile == truth.tables.pad.profile
    assert record.tables.conditions.normal_load_N == pytest.approx(LOAD_N)
    assert record.tables.conditions.cycles == 1000
    assert record.tables.conditions.frequency_Hz == pytest.approx(4.0, rel=1e-3)
    for own, other in zip(record.loops, truth.loops, strict=True):
        assert (own.repeat, own.cycle) == (other.repeat, other.cycle)
        np.testing.assert_allclose(own.displacement_um, other.displacement_um, atol=1e-3)
        np.testing.assert_allclose(own.tangential_force_N, other.tangential_force_N, atol=1e-3)
    for body in ("pad", "specimen"):
        for made, worn in zip(record.scars_of(body), truth.scars_of(body), strict=True):
            assert made.depth_um.max() == pytest.approx(worn.depth_um.max(), abs=0.08)
            assert made.area_um2 == pytest.approx(worn.area_um2, rel=0.02)
            assert sum(made.edges_um) == pytest.approx(0.0, abs=12.0)
    assert not check_record(record).problems


@pytest.mark.parametrize("face", [Flat(), Cylinder(6.0, curved_along=True), RoundedFlat(0.3, 3.0)])
def test_a_fitted_face_does_not_follow_the_scar_nor_what_is_piled_up_beside_it(face: Flat) -> None:
    x = np.linspace(-600.0, 600.0, 801)
    worn = 3.0 * np.maximum(1.0 - (x / 380.0) ** 2, 0.0) - 0.8 * np.exp(-(((x - 420.0) / 25.0) ** 2))
    own = 1e3 * face.height(np.column_stack([1e-3 * (x + 15.0), 0.0 * x]))
    height = own + 7.0 - 0.004 * x - worn + 0.02 * np.random.default_rng(2).standard_normal(x.size)
    found = levelled(Path("x"), 1, "pad", face, (x, height), subtract=True).depth_um
    np.testing.assert_allclose(found, worn, atol=0.12)
    assert found.min() == pytest.approx(worn.min(), abs=0.1)


MAPPING = """
format = 1
name = "stylus"
[contact]
kind = "cylinder-on-flat"
length_mm = 8.0
[pad]
radius_mm = 6.0
material = "steel"
[specimen]
material = "Ti-6Al-4V"
[conditions]
normal_load_N_per_mm = 20.0
displacement_amplitude_um = 60.0
frequency_Hz = 4.0
cycles = 1000
[stated]
friction = 0.6
[profiles.specimen]
files = "depth.csv"
delimiter = "semicolon"
decimal = ","
[profiles.specimen.columns]
x_um = { column = "x", unit = "mm" }
depth_um = "t"
"""


def mapped(folder: Path, text: str = MAPPING) -> Path:
    (folder / "depth.csv").write_text("x;t\n-0,3;0\n-0,1;1,5\n0;2,0\n0,1;\n0,3;-0,2\n", encoding="utf-8")
    (folder / "mapping.toml").write_text(text, encoding="utf-8")
    return folder / "mapping.toml"


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("normal_load_N_per_mm = 20.0", "", "gives neither of normal_load_N"),
        ("[stated]", "normal_load_N = 160.0\n[stated]", "gives both of normal_load_N"),
        ("radius_mm = 6.0", "", "does not say which face the pad has"),
        ('"cylinder-on-flat"', '"ball"', 'must be "line-contact" or "cylinder-on-flat"'),
        ("length_mm = 8.0", "", "missing key 'length_mm'"),
        ('depth_um = "t"', "", "must give either depth_um or height_um"),
        ('depth_um = "t"', 'height_um = "t"', "needs 20 points"),
        ('depth_um = "t"', 'depth_um = "tiefe"', "tiefe"),
        ('unit = "mm"', 'unit = "N/mm"', "cannot be in 'N/mm'"),
        ('"depth.csv"', '"none.csv"', "there is no file"),
        ('"depth.csv"', '["depth.csv", "depth.csv"]\nname_pattern = "(?P<repeat>)depth"', "no whole numbers"),
        ("[profiles.specimen", "[profiles.specimens", "specimens"),
        (MAPPING[MAPPING.index("[profiles.specimen]") :], "", "maps nothing"),
    ],
)
def test_a_wrong_mapping_is_one_sentence(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    assert old in MAPPING
    with pytest.raises(RecordError, match=complaint) as told:
        import_record(mapped(tmp_path, MAPPING.replace(old, new)))
    assert "\n" not in str(told.value)
