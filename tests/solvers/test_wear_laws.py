"""Wear laws: by powers, beyond a threshold, where oxygen gets; against integrals over a Hertz pressure."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import solvers
from geometry.arrays import Array
from tests.bodies import FRICTION
from tests.solvers.wear_jumps import LINE_LOAD_N_per_mm, STROKE_mm, at_the_end, hertz_of_line, jumped, line_contact
from wirewear.base.errors import StudyError
from wirewear.test import parse_study

pytestmark = pytest.mark.seconds
FREQUENCY_Hz, CYCLES = 4.0, 100.0
RATES = (3e-13, 1e-13)  # So small that surfaces keep their shape.
HERTZ = hertz_of_line()


@pytest.fixture(scope="module")
def line() -> solvers.ContactProblem:
    timing = solvers.DriveTiming(solvers.Drive(STROKE_mm), FREQUENCY_Hz)
    return replace(line_contact(), wear=solvers.WearRates(*RATES), timing=timing)


@pytest.fixture(scope="module")
def start(line: solvers.ContactProblem) -> solvers.ContactState:
    return at_the_end(line, STROKE_mm)


def worn(problem: solvers.ContactProblem, start: solvers.ContactState, *jumps: float) -> solvers.WearState:
    for cycles in jumps:
        start = jumped(problem, start, cycles, stroke_mm=STROKE_mm).state
    return start.wear


def by(law: solvers.WearLaw, problem: solvers.ContactProblem) -> solvers.ContactProblem:
    return replace(problem, wear=replace(problem.wear, law=law))


def mean_over_load(weight: Array) -> float:
    """Of a weight at places over the half-width, under the pressure of Hertz."""
    place = np.linspace(-1.0, 1.0, len(weight))
    pressure = np.sqrt(1.0 - place**2)
    return float(np.trapezoid(weight * pressure, place) / np.trapezoid(pressure, place))


PLACES = np.linspace(-1.0, 1.0, 20001)


@pytest.mark.parametrize("exponent", [-0.4, 0.5])
def test_wear_by_powers_weighs_the_energy_by_pressure_slip_and_frequency(
    line: solvers.ContactProblem, start: solvers.ContactState, exponent: float
) -> None:
    law = solvers.PowerReduced(500.0, 10.0, exponent, 0.3, -0.2)
    plain, weighed = worn(line, start, CYCLES), worn(by(law, line), start, CYCLES)
    slip_um = 1e3 * plain.energy_mJ / CYCLES / (4.0 * FRICTION * LINE_LOAD_N_per_mm)
    pressure = HERTZ.peak_pressure_MPa * np.sqrt(1.0 - PLACES**2) + 1e-9
    expected = mean_over_load((pressure / 500.0) ** exponent) * (slip_um / 10.0) ** 0.3 * FREQUENCY_Hz**-0.2
    assert weighed.energy_mJ == pytest.approx(plain.energy_mJ, rel=1e-6)
    assert weighed.primary_volume_mm3 / plain.primary_volume_mm3 == pytest.approx(expected, rel=5e-3)
    assert weighed.primary_volume_mm3 == pytest.approx(3.0 * weighed.secondary_volume_mm3, rel=1e-9)


def test_beyond_a_threshold_every_place_of_both_bodies_has_worn_by_the_rest_of_its_energy(
    line: solvers.ContactProblem, start: solvers.ContactState
) -> None:
    threshold = 5000.0
    problem = by(solvers.EnergyThreshold(threshold), line)
    once, often = worn(problem, start, 400.0), worn(problem, start, 10.0, 90.0, 300.0)
    with threadpool_limits(limits=1, user_api="blas"):
        singly = solvers.run_cycle(problem, start, solvers.Drive(STROKE_mm), 32, 400.0)[0].wear
    assert 2.0 * threshold < float(once.primary_energy.max()) < 3.0 * threshold
    for wear in (once, often, singly):
        for rate, depth, energy in zip(RATES, wear.depths, (wear.primary_energy, wear.secondary_energy), strict=True):
            assert depth == pytest.approx(rate * np.maximum(energy - threshold, 0.0), rel=1e-9, abs=1e-20)
    areas = line.primary.node_areas
    assert often.primary_volume_mm3 == pytest.approx(float(areas @ often.primary_depth.ravel()), rel=1e-9)


def test_where_oxygen_does_not_get_wear_is_less(line: solvers.ContactProblem, start: solvers.ContactState) -> None:
    law = solvers.OxygenDistance(0.2, distance_mm=0.08)
    mean_MPa = LINE_LOAD_N_per_mm / (2.0 * HERTZ.half_width_mm)
    reach = 0.08 * FREQUENCY_Hz**-0.22 * (mean_MPa / 100.0) ** -0.32
    assert reach == pytest.approx(law.reach_mm(FREQUENCY_Hz, mean_MPa))
    assert 0.5 < reach / HERTZ.half_width_mm < 0.9
    inside = HERTZ.half_width_mm * (1.0 - np.abs(PLACES))
    expected = mean_over_load(np.where(inside <= reach, 1.0, 0.2))
    plain, starved = worn(line, start, CYCLES), worn(by(law, line), start, CYCLES)
    assert starved.primary_volume_mm3 / plain.primary_volume_mm3 == pytest.approx(expected, rel=0.02)
    assert law.reach_mm(1.0, 100.0) == 0.08
    assert solvers.OxygenDistance(0.2).distance_mm == 1.51


STUDY = (Path(__file__).parents[2] / "studies" / "steel_wires" / "study.toml").read_text()


@pytest.mark.parametrize(
    ("law", "says"),
    [
        ('"fast"', "there is no wear law 'fast'"),
        ("3", 'must be "energy" or a table such as'),
        ('"archard"', "takes archard_wear_coefficient_mm3_per_N_m: give that in place of the other"),
        ('{ name = "energy-threshold" }', "takes threshold_mJ_per_mm2, but is given none"),
        ('{ name = "energy-threshold", threshold_mJ_per_mm2 = -1 }', "must not be negative, but is -1"),
        (
            '{ name = "oxygen-distance", starved_factor = 0.2 }\nupdate = "explicit"\nexplicit_jump_cycles = 10',
            "which the explicit wear update does not know",
        ),
    ],
)
def test_a_study_with_a_wrong_wear_law_is_refused_with_the_reason(law: str, says: str) -> None:
    with pytest.raises(StudyError) as refused:
        parse_study(STUDY.replace("[wear]", f"[wear]\nlaw = {law}"), "s.toml")
    assert says in str(refused.value)


def test_a_study_chooses_its_wear_law_and_its_coefficient_does_without_one() -> None:
    given = '{ name = "energy-threshold", threshold_mJ_per_mm2 = 500 }'
    wear = parse_study(STUDY.replace("[wear]", f"[wear]\nlaw = {given}"), "s.toml").wear
    assert wear is not None
    assert wear.of_law == solvers.EnergyThreshold(500)
    wear = parse_study(STUDY, "s.toml").wear
    assert wear is not None
    assert wear.of_law == solvers.EnergyLaw()
