"""Line contacts: a laboratory's files imported, and parameters fitted to records whose truth is known."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geometry import Cylinder, Flat, RoundedFlat
from tests.commands import wirewear
from tests.records.logger_files import CYLINDER, FLAT, LOAD_N, LENGTH_mm, line_record, write_line_german
from tests.studies import line_study
from wirewear.base.errors import RecordError, StudyError
from wirewear.diagnosis import diagnose
from wirewear.diagnosis.fit import FittedTest, fit_record
from wirewear.diagnosis.fit.wear import fitted_wear
from wirewear.diagnosis.preparation import prepared
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.line_wear import WornLineContact, worn_line
from wirewear.effects import Effect, effect_named
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.records import LineRecord, check_record, read_record, record_of_result
from wirewear.records.contact_tables import LineStated
from wirewear.records.importing import import_record
from wirewear.records.importing.profilometry import levelled
from wirewear.reference import hertz_line
from wirewear.simulation import simulate as run_alone
from wirewear.test import LineStudy, study_from_tables

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
    result = run_alone(study_from_tables(tables, "study.toml"), fidelity="quick")
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
    assert isinstance(fit.study, LineStudy)
    assert fit.study.of_length(1.0).holder.tangential_stiffness_N_per_mm == pytest.approx(2000.0, rel=0.06)
    assert fit.study.log.loop_cycles == (1, 30, 300, CYCLES)


@pytest.mark.slow
def test_play_is_distinguished_from_the_rigs_stiffness() -> None:
    fit = fitted("cylinder", 4.0)
    assert fit.parameters["free_play_um"].value == pytest.approx(4.0, rel=0.1)
    assert fit.parameters["tangential_stiffness_N_per_mm"].value == pytest.approx(16000.0, rel=0.1)
    assert [effect.name for effect in fit.study.effects] == ["free_play"]


def test_energies_and_volumes_of_a_line_contact_are_those_of_the_whole() -> None:
    record = line_record(CYLINDER)
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


OPTIONS = {
    "rounded flat": (FLAT, ("--face-half-width", 0.3, "--edge-radius", 3.0)),
    "cylinder": (CYLINDER, ("--radius", 6.0)),
}


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("face", OPTIONS)
def test_a_guessed_mapping_gives_the_files_record(tmp_path: Path, face: str) -> None:
    keys, options = OPTIONS[face]
    truth = line_record(keys)
    wirewear("new", "--mapping", *write_line_german(truth, tmp_path), "--length", LENGTH_mm, *options)
    wirewear("import", tmp_path / "mapping.toml", "--output", tmp_path / "record")
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
        ("normal_load_N_per_mm = 20.0", "", "missing key 'normal_load_N'"),
        ("[stated]", "normal_load_N = 160.0\n[stated]", "gives both normal_load_N_per_mm and normal_load_N"),
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
    with pytest.raises(RecordError, match=complaint) as message:
        import_record(mapped(tmp_path, MAPPING.replace(old, new)))
    assert "\n" not in str(message.value)


def effect(name: str, **values: float) -> Effect[Any]:
    return effect_named(name)(**values)


ROOT = Path(__file__).parents[2]
TITANIUM = ROOT / "studies" / "atlas" / "arnaud2021"
#: A steel cylinder of 6 mm, worn by 1500 µm² of both bodies.
WORN_STEEL = WornLineContact(Cylinder(6.0, curved_along=True), 18.5, 0.0359, 110000.0, 0.5, 3.2e-3)
AREA_mm2 = 1.5e-3


def test_the_fresh_contact_of_the_profile_model_is_hertzs() -> None:
    barely = worn_line(replace(WORN_STEEL, reach_mm=0.1, most_area_mm2=1e-9))
    hertz = hertz_line(18.5, 6.0, 110000.0)
    assert barely.depth_mm[-1][0] > barely.depth_mm[-1][10]
    # Wear goes with the pressure: half-elliptic, of that half-width.
    shape = barely.depth_mm[-1] / barely.depth_mm[-1][0]
    ellipse = np.sqrt(np.maximum(1.0 - (barely.x_mm / hertz.half_width_mm) ** 2, 0.0))
    assert np.abs(shape - ellipse).max() < 0.06


def test_a_worn_scar_is_a_chord_and_debris_narrows_it_by_radius() -> None:
    """Once wear is deep against the elastic approach, A = 2 w³/(3 R)."""
    worn = worn_line(WORN_STEEL)
    assert worn.half_width_at(AREA_mm2) == pytest.approx((1.5 * 6.0 * AREA_mm2) ** (1.0 / 3.0), rel=0.03)
    # A bed that does not give way fills f of the gap: R (1 − f) in place of R.
    filled = worn_line(replace(WORN_STEEL, retained_fraction=0.6))
    narrower = filled.half_width_at(AREA_mm2) / worn_line(WORN_STEEL).half_width_at(AREA_mm2)
    assert narrower == pytest.approx(0.4 ** (1.0 / 3.0), rel=0.05)


def test_a_test_on_another_length_of_the_contact_is_as_much_to_the_millimetre() -> None:
    spring = effect("tangential_compliance", stiffness_N_per_mm=5000.0)
    bent = effect("displacement_load_coupling", linear_um_per_N=0.01, quadratic_um_per_N2=1e-4)
    stop = {"stop": {"worn_volume_mm3": 0.02, "depth_um": 5.0}}
    blocks = {"programme": [{"cycles": 100, "conditions": {"normal_load_N": 100.0, "held_energy_mJ": 3.0}}]}
    oxygen = effect("contact_oxygenation", supply_W=1e-4, starved_factor=0.3)
    whole = line_study(contact={"length_mm": 10.0}, **stop, **blocks).with_effects(spring, bent, oxygen)
    one_mm = whole.of_length(1.0)
    assert one_mm.effects[0].values == {"stiffness_N_per_mm": 500.0}
    assert one_mm.effects[1].values == pytest.approx({"linear_um_per_N": 0.1, "quadratic_um_per_N2": 1e-2})
    # A power per area times the square of a distance: as much for any length.
    assert one_mm.effects[2].values == oxygen.values
    assert one_mm.conditions.normal_load_N == pytest.approx(0.1 * whole.conditions.normal_load_N)
    assert one_mm.conditions.frequency_Hz == whole.conditions.frequency_Hz
    assert one_mm.tables.stop is not None
    assert one_mm.tables.stop.worn_volume_mm3 == pytest.approx(0.002)
    assert one_mm.tables.stop.depth_um == 5.0
    assert one_mm.tables.programme[0].conditions == pytest.approx({"normal_load_N": 10.0, "held_energy_mJ": 0.3})
    again = one_mm.of_length(10.0)
    assert [one.values for one in again.effects] == [pytest.approx(one.values) for one in (spring, bent, oxygen)]


def test_a_variant_of_another_length_keeps_the_load_that_is_stated_per_millimetre() -> None:
    longer = {"longer": {"contact": {"length_mm": 20.0}}, "whole": {"conditions": {"normal_load_N": 450.0}}}
    study = line_study(contact={"length_mm": 10.0}, conditions={"normal_load_N_per_mm": 30.0}, variants=longer)
    assert study.conditions.normal_load_N == 300.0
    assert study.variant("longer").conditions.normal_load_N == 600.0
    assert study.variant("whole").conditions.normal_load_N == 450.0
    with pytest.raises(StudyError, match=r"length_mm, which is the same for the whole test"):
        line_study(programme=[{"cycles": 100, "contact": {"length_mm": 5.0}}])


@pytest.fixture(scope="module")
def titanium() -> LineRecord:
    return read_record(TITANIUM / "record_2Hz")


@pytest.mark.slow
def test_titanium_at_a_tenth_of_a_hertz_is_explained_by_debris_that_stays() -> None:
    answer = diagnose(read_record(TITANIUM / "record_0p1Hz")).diagnosis
    assert answer.verdict == "explained"
    (cause,) = answer.causes[:1]
    assert cause.effect == "third_body"
    assert cause.parameters["retained_fraction"].value > 0.9


@pytest.mark.slow
def test_titanium_at_2_hz_has_debris_and_lacks_oxygen_or_wears_less(titanium: LineRecord) -> None:
    answer = diagnose(titanium).diagnosis
    assert answer.verdict == "ambiguous"
    joint = [cause.effect for cause in answer.causes if cause.joint]
    assert set(joint[::2]) == {"third_body"}
    assert "contact_oxygenation" in joint


@pytest.mark.slow
def test_the_fast_model_predicts_what_the_full_one_makes_of_debris_and_oxygen(titanium: LineRecord) -> None:
    """168.7 µm with debris, 101.5 µm and 43.2 µm in the middle with both, at standard fidelity."""
    states, nominal, _ = prepared(titanium)[0].nominal()
    bed = nominal.with_effect(effect("third_body", retained_fraction=0.95, modulus_MPa=134600.0))
    both = bed.with_effect(effect("contact_oxygenation", supply_W=0.14, starved_factor=0.196))
    end = np.array([5000.0])
    _, deep = simulate(states, bed, end).profiles["specimen"]
    x, starved = simulate(states, both, end).profiles["specimen"]
    assert deep.max() == pytest.approx(168.7, rel=0.07)
    assert starved.max() == pytest.approx(101.5, rel=0.07)
    assert np.interp(0.0, x, starved) == pytest.approx(43.2, rel=0.07)


def rounded_flat(stiffness_N_per_mm: float) -> LineRecord:
    """A rig of 16 000 N/mm with a rounded flat, of another mesh; its owner states a stiffness."""
    record = record_of("rounded flat")
    stated = {
        "friction": 0.7,
        "pad_energy_wear_coefficient_mm3_per_J": 2e-5,
        "specimen_energy_wear_coefficient_mm3_per_J": 4e-5,
        "tangential_stiffness_N_per_mm": stiffness_N_per_mm,
    }
    return replace(record, tables=record.tables.model_copy(update={"stated": LineStated.model_validate(stated)}))


@pytest.mark.slow
def test_a_rounded_flat_as_stated_has_no_gap_and_a_softer_rig_is_found() -> None:
    assert diagnose(rounded_flat(16000.0)).diagnosis.verdict == "no_gap"
    softer = diagnose(rounded_flat(24000.0)).diagnosis
    assert softer.verdict == "explained"
    found = next(cause for cause in softer.to_json()["causes"] if cause["effect"] == "tangential_compliance")
    low, high = found["parameters"]["stiffness_N_per_mm"]["interval95"]
    assert low <= 1.0 / (1.0 / 16000.0 - 1.0 / 24000.0) <= high
