"""A study and its refinements: what is refined, and where its figures are said to tend."""

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from tests import synthetic_results
from tests.studies import MINIMAL
from wirewear import parse_study
from wirewear.results import Evolution, RunResult
from wirewear.simulation import NoObserver, convergence, discretise
from wirewear.study import Study

WORN = MINIMAL + "[wear]\nenergy_wear_coefficient_mm3_per_J = 3e-5\n"
RUNS = (*convergence.MESH.runs, *convergence.POSITIONS.runs, *convergence.JUMPS.runs)


def _nobody(_label: str) -> nullcontext[NoObserver]:
    return nullcontext(NoObserver())


class FakeRunner:
    """Gives every variant figures that err by known powers of its resolutions, and keeps what it was asked."""

    def __init__(self, mesh: float, positions: float, jumps: float, order: float) -> None:
        self.shares, self.order = (mesh, positions, jumps), order
        self.asked: list[tuple[str, Path, bool]] = []

    def __call__(
        self, study: Study, *, fidelity: str, output: Path, resume: bool, observer_of: object, jobs: int, engine: object
    ) -> list[RunResult]:
        assert (observer_of, jobs, engine) == (_nobody, 3, None)
        base = discretise(study.variant(convergence.BASE), fidelity)
        results = []
        for name in study.variant_names:
            plan = discretise(study.variant(name), fidelity)
            self.asked.append((name, output / name, resume))
            spacings = (
                plan.fixed.transverse.outer_mm / base.fixed.transverse.outer_mm,
                base.increments_per_wear_cycle / plan.increments_per_wear_cycle,
                (plan.jump_tolerance / base.jump_tolerance) ** 0.5,
            )
            factor = 1.0 + sum(a * h**self.order for a, h in zip(self.shares, spacings, strict=True))
            exact = synthetic_results.result(variant=name)
            columns = {key: column * (1.0 if key == "cycle" else factor) for key, column in exact.evolution.items()}
            results.append(replace(exact, evolution=Evolution(columns)))
        return results


def test_each_refinement_refines_one_resolution_and_leaves_the_others() -> None:
    study = convergence.refined_study(parse_study(WORN, "s.toml"), "quick")
    plans = {name: discretise(study.variant(name), "quick") for name in study.variant_names}
    base = plans.pop(convergence.BASE)
    assert tuple(plans) == RUNS
    for factor, name in zip(convergence.MESH.factors, convergence.MESH.runs, strict=True):
        assert plans[name].fixed.transverse.fine_mm == pytest.approx(base.fixed.transverse.fine_mm / factor)
        assert plans[name].fixed.transverse.outer_mm == pytest.approx(base.fixed.transverse.outer_mm / factor)
    for factor, name in zip(convergence.POSITIONS.factors, convergence.POSITIONS.runs, strict=True):
        assert plans[name].increments_per_wear_cycle == factor * base.increments_per_wear_cycle
    for factor, name in zip(convergence.JUMPS.factors, convergence.JUMPS.runs, strict=True):
        assert plans[name].jump_tolerance == pytest.approx(base.jump_tolerance / factor**2)
    for name, plan in plans.items():
        assert plan.increments_per_cycle == base.increments_per_cycle
        assert (plan.fixed == base.fixed) == (name not in convergence.MESH.runs)
        assert (plan.increments_per_wear_cycle == base.increments_per_wear_cycle) == (
            name not in convergence.POSITIONS.runs
        )
        assert (plan.jump_tolerance == base.jump_tolerance) == (name not in convergence.JUMPS.runs)


def rows_of(runner: FakeRunner, output: Path) -> list[convergence.Converged]:
    study, subject = parse_study(WORN, "s.toml"), replace(convergence.point_contact(("moving", "fixed")), run=runner)
    return convergence.converge(study, subject, fidelity="quick", output=output, observer_of=_nobody, jobs=3)


def converged(runner: FakeRunner, output: Path) -> list[tuple[float, float, float]]:
    """Value, limit and error of every figure, over its exact value."""
    exact = synthetic_results.result()
    found = []
    for row, figure in zip(rows_of(runner, output), convergence.figures_of(("moving", "fixed")), strict=True):
        truth = figure.of(exact)
        found.append((row.value / truth, row.limit / truth, row.error / truth))
    return found


def test_figures_tend_to_what_they_would_be_without_any_error(tmp_path: Path) -> None:
    for value, limit, error in converged(FakeRunner(0.03, -0.01, 0.02, order=1.4), tmp_path):
        assert value == pytest.approx(1.04, rel=1e-9)
        assert limit == pytest.approx(1.0, rel=1e-6)
        assert 0.0 < error < 0.06


def test_an_error_that_falls_faster_than_can_be_believed_leaves_the_limit_within_its_error(tmp_path: Path) -> None:
    for value, limit, error in converged(FakeRunner(0.03, 0.01, 0.02, order=3.0), tmp_path):
        assert value == pytest.approx(1.06)
        assert abs(limit - 1.0) <= error


@given(st.floats(0.5, 2.0), st.floats(-0.5, 0.5), st.floats(1.1, 3.0), st.floats(1.1, 3.0), st.floats(0.1, 1e6))
def test_a_power_law_is_extrapolated_exactly_whatever_the_spacings(
    order: float, share: float, first: float, second: float, limit: float
) -> None:
    assume(abs(share) > 1e-3)
    spacings = [1.0, 1.0 / first, 1.0 / (first * second)]
    found = convergence.richardson(spacings, [limit * (1.0 + share * h**order) for h in spacings])
    assert found.value == pytest.approx(limit, rel=1e-6)
    assert found.order == pytest.approx(order, abs=1e-4)
    assert found.error == pytest.approx(abs(share) * limit * spacings[-1] ** order, rel=1e-3)


@pytest.mark.seconds
@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_values_without_a_trend_are_not_extrapolated(one: float, two: float, three: float) -> None:
    assume((two - one) * (three - two) < 0.0 and max(abs(two - one), abs(three - two)) > 1e-3)
    found = convergence.richardson([1.0, 0.5, 0.25], [one, two, three])
    assert found.value == three
    assert found.order is None
    assert found.error == max(one, two, three) - min(one, two, three)
