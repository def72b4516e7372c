"""Sizes of gaps in the diagnosis's own deviations."""

import numpy as np
import pytest

from studies.blind.generators.cases import TrueEffect
from studies.blind.own_sizes import own_size
from tests.diagnosis_cases import nominal, states
from tests.test_blind_traces import case
from wirewear.diagnosis.infer.covariance import Covariance
from wirewear.diagnosis.infer.inference import Problem
from wirewear.diagnosis.observe.amplitude import Amplitude
from wirewear.diagnosis.observe.evolution import LargestForce, SlipAmplitude
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.sites import Site

CYCLES = (100, 1000, 10_000)
SPRING = TrueEffect("tangential_compliance", {"stiffness_N_per_mm": 300.0})
SLIPPERY = TrueEffect("friction_offset", {"friction": 0.5})


def problem() -> tuple[Problem, Covariance]:
    """Three figures of three cycles without a gap; solvers make up three quarters of their variance."""
    sites = [Site(cycle) for cycle in CYCLES]
    layout = Layout.of_sites((Amplitude(), sites), (SlipAmplitude(), sites), (LargestForce(), sites))
    start, setup = states(), nominal()
    total = np.diag(np.repeat([0.2, 0.2, 0.01], len(CYCLES)) ** 2)
    mean = np.zeros(len(layout))
    covariance = Covariance(mean, total, np.diag(total), 0.75 * total, 0.25 * total, {})
    mean[:] = Problem.of(start, setup, layout, covariance).predicted(setup)
    return Problem.of(start, setup, layout, covariance), covariance


def test_without_solvers_a_gap_is_as_much_larger_as_deviations_are_smaller() -> None:
    sizes = own_size(case("single", SPRING), *problem())
    assert sizes["all"] > 1.0
    assert sizes["without_solvers"] == pytest.approx(2.0 * sizes["all"], rel=1e-3)


def test_a_pair_is_as_large_as_what_neither_of_its_effects_imitates() -> None:
    known, covariance = problem()
    alone = own_size(case("single", SPRING), known, covariance)["all"]
    pair = own_size(case("pair", SPRING, SLIPPERY), known, covariance)["all"]
    whole = own_size(case("single", SPRING, SLIPPERY), known, covariance)["all"]
    assert 1.0 < pair < whole
    assert pair < alone + 0.1


@pytest.mark.slow
def test_what_is_in_no_library_and_not_seen_has_no_size() -> None:
    assert own_size(case("outside", TrueEffect("bent_guide", {})), *problem())["all"] == 0.0
