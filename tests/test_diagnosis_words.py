"""Sizes of gaps in words: a logarithm is told as a ratio or as per cent."""

import pytest

from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.views.diagnosis_values import Cause, Estimate
from wirewear.views.diagnosis_wording import sentence_of


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
