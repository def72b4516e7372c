"""Laws of other form keep an effect's size and scale, and change how it comes and goes."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from studies.blind.generators.cases import TrueEffect
from studies.blind.generators.independent.model import IndependentModel, figures_of
from studies.diagnosis.gap_free import case_of, drawn_tests
from studies.diagnosis.laws_of_other_form import LAWS, RUNNING_IN, WEARING_IN, ModelOfOtherForm, Remaining, by
from wirewear.base.course import Course

CYCLES = np.geomspace(1e-3, 1e6, 400)
LAWS_OF_COURSES = {**RUNNING_IN, **WEARING_IN}
EFFECTS = {
    "friction_evolution": {"initial": 0.5, "final": 0.7, "cycles": 3000.0},
    "wear_rate_evolution": {"initial_factor": 3.0, "final_factor": 1.0, "cycles": 3000.0},
    "roughness_compliance": {"layer_um": 2.0, "cycles": 3000.0},
    "third_body": {"retained_fraction": 0.4, "modulus_MPa": 1e4},
}


@pytest.mark.parametrize("remaining", LAWS_OF_COURSES.values(), ids=LAWS_OF_COURSES)
def test_a_course_by_another_law_goes_from_the_initial_value_towards_the_final_one(remaining: Remaining) -> None:
    course = by(Course(0.5, 0.7, 100.0), remaining)
    values = course.at(CYCLES)
    assert values[0] == pytest.approx(0.5, rel=1e-4)
    assert np.all(np.diff(values) >= 0.0)
    assert values[-1] <= 0.7
    assert np.max(np.abs(values - Course(0.5, 0.7, 100.0).at(CYCLES))) > 0.01
    assert [course.at(float(cycle)) for cycle in CYCLES] == pytest.approx(values.tolist())


@pytest.mark.parametrize("remaining", LAWS_OF_COURSES.values(), ids=LAWS_OF_COURSES)
def test_scatter_between_specimens_keeps_the_law(remaining: Remaining) -> None:
    course = by(Course(0.5, 0.7, 100.0), remaining)
    np.testing.assert_allclose(course.times(1.1).at(CYCLES), 1.1 * course.at(CYCLES))


def relative(difference: np.ndarray, to: np.ndarray) -> float:
    size = float(np.max(np.abs(to)))
    return float(np.max(np.abs(difference))) / size if size > 1e-6 else 0.0


@pytest.mark.slow
@pytest.mark.parametrize("effect", LAWS)
def test_every_law_gives_other_readings_of_the_same_effect(effect: str) -> None:
    test = replace(drawn_tests(1, 23)[0], cycles=20_000)
    case = case_of(test, "any", (TrueEffect(effect, EFFECTS[effect]),))
    models = [IndependentModel(), *(ModelOfOtherForm(form=(effect, law)) for law in LAWS[effect])]
    figures = [figures_of(model.true_world(case), (100, 3000, 20_000), 10) for model in models]
    for one, other in combinations(figures, 2):
        apart = [relative(one[name] - other[name], one[name]) for name in one]
        assert max(apart) > 1e-3
