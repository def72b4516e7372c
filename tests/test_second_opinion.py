"""The second opinion on a diagnosis: sampled evidence, a classifier taught by simulations, and what is kept of both."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from studies.diagnosis.sampled_evidence import sampled_log_evidence
from studies.diagnosis.simulated_classifier import Classifier, Signals, Worth, taught

Array = NDArray[np.float64]

NUMBERS = 30


def signals(*directions: int) -> Signals:
    """Effects that move one number each, to either side, by ten deviations as a rule."""
    random = np.random.default_rng(4)
    rows = []
    for direction in directions:
        sizes = 10.0 * random.standard_normal(150)
        rows.append(sizes[:, None] * np.eye(NUMBERS)[direction])
    labels = np.repeat(np.arange(1, len(directions) + 1), 150)
    return Signals(("none", *(f"effect {place}" for place in range(len(directions)))), np.concatenate(rows), labels)


@pytest.fixture(scope="module")
def learned() -> tuple[Classifier, Worth]:
    return taught(signals(3, 7, 3), seed=1)


@pytest.mark.slow
@pytest.mark.parametrize("side", [12.0, -12.0])
def test_an_effect_is_told_on_either_side_of_nothing(learned: tuple[Classifier, Worth], side: float) -> None:
    found = learned[0].probabilities(side * np.eye(NUMBERS)[[7]])[0]
    assert found[2] > 0.9


def line(slopes: Array, seen: Array) -> Any:
    """A problem whose numbers are linear in the coordinates of one effect, and that effect at its best."""
    candidate = SimpleNamespace(
        name="some effect", applied=lambda _, z: z, unknowns=dict.fromkeys(range(slopes.shape[1]))
    )
    spread = np.linalg.inv(slopes.T @ slopes + np.eye(slopes.shape[1]))
    best = spread @ slopes.T @ seen
    rest = seen - slopes @ best
    evidence = -0.5 * float(rest @ rest + best @ best) + 0.5 * float(np.linalg.slogdet(spread)[1])
    fit = SimpleNamespace(candidates=(candidate,), coordinates=best, spread=spread, log_evidence=evidence)
    return SimpleNamespace(setup=None, whitened=lambda z: seen - slopes @ z), fit


@pytest.mark.parametrize("size", [3.0, 0.2])
def test_sampled_evidence_is_exact_where_the_model_is_linear(size: float) -> None:
    slopes = size * np.random.default_rng(2).standard_normal((8, 2))
    problem, fit = line(slopes, slopes @ np.array([1.0, -0.5]) + 0.3)
    assert sampled_log_evidence(problem, fit, live=60, seed=3) == pytest.approx(fit.log_evidence, abs=0.8)


def opinion(**changes: Any) -> dict[str, Any]:
    """What is kept of a record of which both say the same."""
    return {
        "record": "case_001",
        "verdict": "explained",
        "named": ["free_play"],
        "probability": 0.99,
        "classes": [["free_play", "third_body"]],
        "laplace": {"free_play": 20.0},
        "sampled": {"free_play": 20.3},
        "learned": {"free_play": 0.9},
        "chosen": "free_play",
        "chosen_probability": 0.9,
        "chosen_below_best": 0.0,
        "best_above_none": 20.0,
        "farthest_coordinate": 1.0,
        "worth": {"clear": 100, "named": 90, "right": 95, "small": 10, "small_right": 8},
        "cpu_s": {"diagnosis": 6.0, "opinions": 20.0},
        **changes,
    }
