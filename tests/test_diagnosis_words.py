"""Sizes of gaps in words: a logarithm is told as a ratio or as per cent."""

import pytest

from wirewear.diagnosis.infer.where import _compared
from wirewear.diagnosis.observe.scars import ScarFigures


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
