"""What a fit says stays within physical bounds, and play is distinguished from the rig's stiffness in any record."""

import json
import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geometry.arrays import Array
from tests.commands import wirewear
from tests.diagnosis.diagnosis_cases import nominal, record, states
from wirewear.base.errors import RecordError
from wirewear.diagnosis.answer import estimates, forms
from wirewear.diagnosis.fit import FittedParameter, FittedTest, fit_record
from wirewear.diagnosis.fit.fast_fit import FastFit, LoopsOfTests, fast_fit, figures_of_model
from wirewear.diagnosis.fit.fit import _misfit
from wirewear.diagnosis.surrogate.candidates import Candidate, library
from wirewear.effects import effect_named
from wirewear.effects.parameter import limit_um
from wirewear.records import ExperimentRecord, MeasuredLoop, write_record
from wirewear.views.fit_report import fit_json

pytestmark = pytest.mark.seconds
CYCLES = (100, 1000, 10_000)


@pytest.fixture(autouse=True)
def _closed_form_states(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("wirewear.diagnosis.surrogate.nominal_model.PointModel.states", lambda *_: (states(), ()))


def changed(one: ExperimentRecord, change: Callable[[MeasuredLoop], MeasuredLoop]) -> ExperimentRecord:
    return replace(one, loops=tuple(map(change, one.loops)))


def fitted(one: ExperimentRecord) -> FittedTest:
    """The fit, all of whose numbers are finite and in their intervals."""
    fit = fit_record(one)
    json.dumps(fit_json(fit, None), allow_nan=False)
    for found in (fit.parameters | fit.found).values():
        assert 0.0 < found.interval95[0] <= found.value <= found.interval95[1] < math.inf
    return fit


def holds(parameter: FittedParameter, truth: float) -> bool:
    return parameter.interval95[0] <= truth <= parameter.interval95[1]


@pytest.mark.first_case
@pytest.mark.parametrize(("rig_N_per_mm", "play_um"), [(80.0, 3.0), (40.0, 5.0), (500.0, 5.0), (167.0, 0.0)])
def test_a_play_is_fitted_and_not_laid_into_the_stiffness(rig_N_per_mm: float, play_um: float) -> None:
    loose = {"free_play": {"gap_um": play_um}} if play_um else {}
    one = record(loose, samples=128, cycles=CYCLES, repeats=2, stiffness_N_per_mm=rig_N_per_mm, evolution=False)
    fit = fitted(one)
    stiffness = fit.parameters["tangential_stiffness_N_per_mm"]
    assert holds(stiffness, rig_N_per_mm)
    assert stiffness.value == pytest.approx(rig_N_per_mm, rel=0.02)
    gaps = [effect.values["gap_um"] for effect in fit.study.effects if effect.name == "free_play"]
    if not play_um:
        assert gaps == []
        assert "free_play_um" not in fit.parameters
        return
    assert holds(fit.parameters["free_play_um"], play_um)
    assert gaps == [pytest.approx(play_um, rel=0.05)]


def test_forces_that_scatter_between_repeats_leave_positive_intervals() -> None:
    scale = {1: 1.0, 2: 0.3, 3: 0.3}
    one = changed(
        record(cycles=CYCLES[:2], evolution=False),
        lambda loop: replace(loop, tangential_force_N=scale[loop.repeat] * loop.tangential_force_N),
    )
    fit = fitted(one)
    assert holds(fit.found["rig_stiffness_of_first_loops_N_per_mm"], 167.0)
    assert holds(fit.found["measured_stiffness_N_per_mm"], 158.0)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda loop: replace(loop, tangential_force_N=np.abs(loop.tangential_force_N)),
        lambda loop: replace(loop, tangential_force_N=-loop.tangential_force_N),
        lambda loop: replace(loop, tangential_force_N=100.0 + loop.tangential_force_N),
        lambda loop: replace(loop, displacement_um=np.clip(loop.displacement_um, -42.0, 42.0)),
        lambda loop: replace(loop, normal_force_N=1e3 * loop.normal_force_N),
        lambda loop: loop.taken(np.arange(loop.time_s.size) % 10 == 0),
    ],
    ids=["rectified", "wrong sign", "offset", "clipped", "millinewtons", "few samples"],
)
def test_spoilt_channels_are_refused_or_give_finite_numbers(spoil: Callable[[MeasuredLoop], MeasuredLoop]) -> None:
    one = changed(record(cycles=CYCLES[:2], repeats=2, evolution=False), spoil)
    with suppress(RecordError):
        fitted(one)


def test_intervals_of_positive_values_are_positive_and_those_of_small_scatter_even() -> None:
    wide = FittedParameter.of_repeats([161.0, 48.0, 48.0], "N_per_mm")
    assert 0.0 < wide.interval95[0] < 48.0
    assert wide.interval95[1] > 161.0
    narrow = FittedParameter.of_repeats([100.0, 101.0, 99.0], "N_per_mm")
    assert narrow.interval95[1] - 100.0 == pytest.approx(100.0 - narrow.interval95[0], rel=0.03)
    open_ = FittedParameter.of_repeats([1e-9], "N_per_mm", deviation=1e9)
    assert 0.0 < open_.interval95[0] < open_.interval95[1] < math.inf


def test_an_effects_parameters_are_finite_and_intervals_of_its_form_reach_1_96_deviations() -> None:
    candidate = Candidate.of(effect_named("tangential_compliance"), {})
    (found,) = estimates(candidate, np.zeros(1), np.ones(1), dispersion=1e12).values()
    assert 0.0 < found.interval95[0] < found.value < found.interval95[1] < math.inf
    assert math.isfinite(limit_um(1.0, 30.0).value(1e6))
    candidate = next(one for one in library(nominal()) if one.forms)
    estimated = forms(candidate, np.zeros(len(candidate.unknowns)), np.full(len(candidate.unknowns), 0.3), 4.0)
    for name, form in candidate.forms.items():
        assert sorted(estimated[name].interval95) == pytest.approx(sorted(form.value(z) for z in (-1.176, 1.176)))


@pytest.mark.parametrize(("times", "noted"), [(2.9, False), (3.1, True)])
def test_a_misfit_is_that_of_each_degree_of_freedom(times: float, *, noted: bool) -> None:
    none = np.zeros(4)
    assert bool(_misfit(FastFit(none, none, none, none, none, misfit=6.0 * times**2, points=10))) is noted


@pytest.mark.seconds
def test_off_a_terminal_each_stage_of_a_fit_is_a_line(tmp_path: Path) -> None:
    folder = write_record(tmp_path / "record", record(cycles=CYCLES[:1], repeats=1, evolution=False))
    asked = ["fit", str(folder), "--output", str(tmp_path / "fitted"), "--check", "none"]
    ended = wirewear(*asked)
    for stage in ("reading the record", "measuring the loops", "fitting all cycles"):
        assert f"wirewear: {stage}\n" in ended.stderr


@pytest.mark.slow
def test_running_in_and_compliance_are_found_as_surely_as_their_covariance_says() -> None:
    """Of the model's own figures that scatter by 1 %: misfit and squared distances are χ² over their freedoms."""
    true, cycles = np.array([math.log(0.5), math.log(0.7), math.log(2000.0), 8.0]), np.geomspace(1.0, 1e5, 4)
    exact = figures_of_model(states(), nominal(), true, cycles, 128)
    scatter = 0.01 * exact
    figures = exact + scatter * np.random.default_rng(4).standard_normal((3, *exact.shape))
    loops = LoopsOfTests((1, 2, 3), cycles, figures, scatter, np.full((3, 4, 2), np.nan), 128)
    found = fast_fit(states(), nominal(), loops)
    assert 0.5 < found.misfit / (found.points - true.size) < 2.0

    def distance(coordinates: Array, tests: int) -> float:
        return (
            float((coordinates - true) @ np.linalg.solve(3.0 / tests * found.covariance, coordinates - true))
            / true.size
        )

    assert 0.2 < distance(found.coordinates, 3) < 2.4
    assert 0.4 < np.mean([distance(own, 1) for own in found.repeats]) < 2.0
    assert found.friction.at(2000.0) == pytest.approx(0.7 - 0.2 / math.e, rel=0.02)
    assert found.compliance_um_per_N == pytest.approx(8.0, rel=0.01)
