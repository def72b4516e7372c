"""What fits by something else than it is named for is not named: a rough layer that never wears in."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.diagnosis_cases import nominal
from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.recognised import unrecognised, without
from wirewear.diagnosis.infer.weighing import Weighed
from wirewear.diagnosis.model.candidates import Candidate, library
from wirewear.effects import all_effects
from wirewear.effects.roughness_compliance import RoughnessCompliance
from wirewear.views.diagnosis_notes import of_unrecognised

CYCLES = np.array([1.0, 1e3, 1e5])
SPRING, LAYER, PLAY = ("tangential_compliance",), ("roughness_compliance",), ("free_play",)


def layer() -> Candidate:
    return next(one for one in library(nominal()) if one.name == "roughness_compliance")


def fitted(cycles: float, lasting: float) -> Fit:
    """A rough layer of the library that wears in over so many cycles."""
    candidate = layer()
    wanted = {"layer_um": 2.0, "cycles": cycles, "lasting": lasting}
    places = [item.coordinate(wanted[name]) if name in wanted else 0.0 for name, item in candidate.unknowns.items()]
    return Fit((candidate,), np.array(places), np.eye(len(places)), nominal(), 1.0, 0.0)


@pytest.mark.parametrize(
    ("cycles", "lasting", "itself"), [(3e3, 0.01, True), (3e3, 0.5, True), (3e4, 0.01, True), (9e5, 0.6, False)]
)
def test_a_layer_is_one_as_long_as_it_wears_in_within_the_record(cycles: float, lasting: float, itself: bool) -> None:
    """Laws of other form that keep a third or a half of the layer count as layers."""
    found = unrecognised([fitted(cycles, lasting)], CYCLES)
    assert found == ({} if itself else {LAYER: LAYER})


def test_a_layer_that_has_worn_in_before_the_first_loop_is_no_layer_in_the_record() -> None:
    """Between the loops that there are it stays as it is."""
    effect = RoughnessCompliance(layer_um=2.0, cycles=30.0, lasting=0.5)
    assert effect.recognised_between(1.0, 1e5)
    assert not effect.recognised_between(1e3, 1e5)


@pytest.mark.parametrize("cycles", [[], [1e3], [1e3, 1e3]])
def test_loops_of_one_cycle_or_of_none_do_not_say_that_a_layer_stays(cycles: list[float]) -> None:
    assert unrecognised([fitted(9e5, 0.6)], np.array(cycles)) == {}


def test_other_effects_are_what_they_are_named_for() -> None:
    effects = [kind.sized("easy", nominal().stated) for kind in all_effects().values()]
    assert [one.name for one in effects if not one.recognised_between(1.0, 1e5)] == []


def test_what_is_not_recognised_counts_for_a_cause_of_no_library() -> None:
    weighed = Weighed({(): 0.1, LAYER: 0.6, PLAY: 0.1, (*PLAY, *LAYER): 0.1}, 0.1, (LAYER, PLAY))
    found = without(weighed, {LAYER: LAYER, (*PLAY, *LAYER): LAYER})
    assert found.outside == pytest.approx(0.8)
    assert found.probabilities == {(): 0.1, LAYER: 0.0, PLAY: 0.1, (*PLAY, *LAYER): 0.0}


def test_a_layer_that_stays_is_one_class_with_the_spring_that_it_imitates() -> None:
    """The class is right, whichever of its effects fits it best."""
    weighed = Weighed({(): 0.1, LAYER: 0.5, SPRING: 0.4}, 0.0, ((*SPRING, *LAYER),))
    assert without(weighed, {LAYER: LAYER}) == weighed


@given(st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4), st.sets(st.sampled_from([LAYER, SPRING, PLAY])))
def test_no_probability_is_lost(parts: list[float], failing: set[tuple[str]]) -> None:
    weighed = Weighed(dict(zip([(), LAYER, SPRING, PLAY], parts, strict=True)), 0.2, ((*SPRING, *LAYER), PLAY))
    found = without(weighed, {names: names for names in failing})
    assert sum(found.probabilities.values()) + found.outside == pytest.approx(sum(parts) + 0.2)


def test_a_reader_is_told_why_it_is_not_named() -> None:
    (note,) = of_unrecognised(LAYER)
    assert note.startswith("roughness compliance fits best, but does not show")
    assert "vanishes as it wears in" in note
    assert of_unrecognised(()) == ()
