"""Diagnoses of line contacts: profiles alone, loops, the fast model against the full one, and what it foresees."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geometry import Cylinder
from tests.test_line_fitting import record_of
from wirewear.diagnosis import Diagnosed, diagnose
from wirewear.diagnosis.diagnose import beginning_of
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.line_wear import WornLineContact, worn_line
from wirewear.effects import Effect, effect_named
from wirewear.planar.tables import of_whole_contact, per_mm
from wirewear.records import LineRecord, read_record
from wirewear.records.contact_tables import LineStated
from wirewear.reference import hertz_line


def effect(name: str, **values: float) -> Effect[Any]:
    return effect_named(name)(**values)


ROOT = Path(__file__).parent.parent
TITANIUM = ROOT / "studies" / "titanium_oxygenation"

#: A steel cylinder of 6 mm, worn by 1500 µm² of both bodies.
STEEL = WornLineContact(Cylinder(6.0, curved_along=True), 18.5, 0.0359, 110000.0, 0.5, 3.2e-3)
AREA_mm2 = 1.5e-3


def test_the_fresh_contact_of_the_profile_model_is_hertzs() -> None:
    barely = worn_line(replace(STEEL, reach_mm=0.1, most_area_mm2=1e-9))
    hertz = hertz_line(18.5, 6.0, 110000.0)
    assert barely.depth_mm[-1][0] > barely.depth_mm[-1][10]
    # Wear goes with the pressure: half-elliptic, of that half-width.
    shape = barely.depth_mm[-1] / barely.depth_mm[-1][0]
    ellipse = np.sqrt(np.maximum(1.0 - (barely.x_mm / hertz.half_width_mm) ** 2, 0.0))
    assert np.abs(shape - ellipse).max() < 0.06


def test_a_worn_scar_is_a_chord_of_the_cylinder() -> None:
    """Once wear is deep against the elastic approach, A = 2 w³/(3 R)."""
    worn = worn_line(STEEL)
    assert worn.half_width_at(AREA_mm2) == pytest.approx((1.5 * 6.0 * AREA_mm2) ** (1.0 / 3.0), rel=0.03)


def test_debris_narrows_a_scar_as_a_smaller_radius_would() -> None:
    """A bed that does not give way fills f of the gap: R (1 − f) in place of R."""
    filled = worn_line(replace(STEEL, retained_fraction=0.6))
    narrower = filled.half_width_at(AREA_mm2) / worn_line(STEEL).half_width_at(AREA_mm2)
    assert narrower == pytest.approx(0.4 ** (1.0 / 3.0), rel=0.05)


def test_effects_of_a_whole_contact_are_those_of_a_millimetre_times_its_length() -> None:
    spring = effect("tangential_compliance", stiffness_N_per_mm=5000.0)
    bent = effect("displacement_load_coupling", linear_um_per_N=0.01, quadratic_um_per_N2=1e-4)
    one_mm = per_mm((spring, bent), 10.0)
    assert one_mm[0].values == {"stiffness_N_per_mm": 500.0}
    assert one_mm[1].values == pytest.approx({"linear_um_per_N": 0.1, "quadratic_um_per_N2": 1e-2})
    again = of_whole_contact(one_mm, 10.0)
    assert [one.values for one in again] == [pytest.approx(one.values) for one in (spring, bent)]


@pytest.fixture(scope="module")
def titanium() -> LineRecord:
    return read_record(TITANIUM / "record_2Hz")


@pytest.fixture(scope="module")
def with_oxygenation(titanium: LineRecord) -> Diagnosed:
    return diagnose(titanium)


@pytest.mark.slow
def test_titanium_at_2_hz_is_explained_by_debris_and_a_lack_of_oxygen(with_oxygenation: Diagnosed) -> None:
    """The supply agrees with the 0.31 to 0.38 W that 39 tests of another publication ask for, within its factor two."""
    answer = with_oxygenation.diagnosis
    assert answer.verdict == "explained"
    joint = {cause.effect: cause.parameters for cause in answer.causes if cause.joint}
    assert set(joint) == {"third_body", "contact_oxygenation"}
    assert 0.31 / 2.0 < joint["contact_oxygenation"]["supply_W"].value < 0.38 * 2.0
    # The published model's error.
    before, after = answer.physical["profile_depth_um"]
    assert after < 0.15 * 65.0 < before


@pytest.mark.slow
def test_the_fast_model_foresees_what_the_full_one_makes_of_debris_and_oxygen(titanium: LineRecord) -> None:
    """README of the study: 81.5 µm with debris, 66.5 µm and 45.1 µm in the middle with both, at standard fidelity."""
    nominal = beginning_of(titanium, None).run(None)
    bed = nominal.setup.with_effect(effect("third_body", retained_fraction=0.913, modulus_MPa=17350.0))
    both = bed.with_effect(effect("contact_oxygenation", supply_W=0.307, starved_factor=0.23))
    end = np.array([5000.0])
    _, deep = simulate(nominal.states, bed, end).profiles["specimen"]
    x, starved = simulate(nominal.states, both, end).profiles["specimen"]
    assert deep.max() == pytest.approx(81.5, rel=0.07)
    assert starved.max() == pytest.approx(66.5, rel=0.07)
    assert np.interp(0.0, x, starved) == pytest.approx(45.1, rel=0.07)


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
