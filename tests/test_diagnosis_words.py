"""Sizes of gaps in words: a logarithm is told as a ratio or as per cent."""

import pytest

from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.diagnosis.infer.where import GapFinding, _compared
from wirewear.diagnosis.observe.scars import ScarFigures
from wirewear.views.diagnosis_values import Cause, Estimate
from wirewear.views.diagnosis_wording import sentence_of


@pytest.mark.parametrize(
    ("difference", "words"),
    [
        (-2.295, "9.9 times smaller than the model"),
        (2.3026, "10 times larger than the model"),
        (0.1, "10.5 % above the model"),
        (-0.1, "9.5 % below the model"),
    ],
)
def test_a_logarithm_is_told_as_a_ratio(difference: float, words: str) -> None:
    assert f"{_compared(ScarFigures(), difference)} the model" == words


def test_a_sentence_says_where_a_gap_lies_in_words_and_not_by_the_key_of_its_zone() -> None:
    text = "worn depth along the profile at the edges of the scar: the measurement is 0.1 µm below the model at cycle 9"
    found = GapFinding("worn depth along the profile", "profile_edges", (9, 9), 1.0, 3.0, text)
    shrink = Shrink(2.0, 2.0, 1.0, 0.0, (0.0, 0.0), 0.0, (9,), None, None)
    said = sentence_of("unexplained", (), (), shrink, (found,))
    assert said.endswith("It lies mostly in the worn depth along the profile at the edges of the scar.")


@pytest.mark.parametrize(
    ("none", "begins"), [(0.4, "There may be a gap, though none is likeliest;"), (0.2, "There is a gap;")]
)
def test_an_open_answer_states_no_gap_that_is_less_likely_than_none(none: float, begins: str) -> None:
    flattened = Cause("plasticity", 0.3, {"flattening_um": Estimate(0.45, (0.3, 0.7))})
    causes = sorted((flattened, Cause("none", none, {})), key=lambda cause: -cause.probability)
    shrink = Shrink(1.0, 1.0, 1.0, 0.0, (0.0, 0.0), 0.0, (9,), None, None)
    said = sentence_of("ambiguous", causes, (), shrink, ())
    assert said.startswith(begins)
    assert "plasticity, flattening 0.45 µm" in said
