"""The second opinion on a diagnosis: sampled evidence, a classifier taught by simulations, and what is kept of both."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray

from studies.diagnosis.sampled_evidence import sampled_log_evidence
from studies.diagnosis.second_opinion import agrees, main, reason
from studies.diagnosis.simulated_classifier import Classifier, Signals, Worth, taught
from wirewear.base.identity import code_hash

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


@pytest.mark.slow
def test_nothing_is_told_as_none_where_that_is_believed_before_looking(learned: tuple[Classifier, Worth]) -> None:
    found = learned[0].probabilities(np.zeros((1, NUMBERS)), [0.97, 0.01, 0.01, 0.01])[0]
    assert found.argmax() == 0
    assert found.sum() == pytest.approx(1.0)


@pytest.mark.slow
def test_what_effects_do_spans_few_directions(learned: tuple[Classifier, Worth]) -> None:
    assert learned[0].directions.shape == (2, NUMBERS)


@pytest.mark.slow
def test_an_effect_that_imitates_the_true_one_is_right_but_not_by_name(learned: tuple[Classifier, Worth]) -> None:
    worth = learned[1]
    assert worth.right > 0.95 * worth.clear > 20
    assert worth.named < 0.8 * worth.clear


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


def test_a_box_that_is_too_narrow_is_widened() -> None:
    slopes = np.random.default_rng(2).standard_normal((8, 1)) * 0.6
    problem, fit = line(slopes, slopes @ np.array([1.0]))
    right = fit.log_evidence
    # A fit that believes itself forty times too sure.
    fit.spread = fit.spread / 40.0**2
    assert sampled_log_evidence(problem, fit, live=60, seed=3) == pytest.approx(right, abs=0.8)


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


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({}, ""),
        ({"chosen": "third_body"}, ""),
        ({"named": [], "classes": [], "verdict": "no_gap", "chosen": "none"}, ""),
        ({"named": [], "classes": [], "chosen": "sensor_lag", "chosen_below_best": 1.0}, "too little to tell"),
        ({"chosen": "none", "chosen_below_best": 20.0, "chosen_probability": 0.5}, "unsure itself"),
        ({"chosen": "none", "chosen_below_best": 20.0, "farthest_coordinate": 2.6}, "few examples"),
        ({"chosen": "none", "chosen_below_best": 20.0}, "it errs"),
        ({"named": ["a", "b"], "classes": [["a"], ["b"]], "chosen": "b"}, ""),
        ({"named": ["a", "b"], "classes": [["a"], ["b"]], "chosen": "c"}, "a pair"),
    ],
)
def test_classes_are_compared_and_a_difference_has_a_reason(changes: dict[str, Any], words: str) -> None:
    one = opinion(**changes)
    assert agrees(one) == (not words)
    assert words in reason(one)


def test_what_is_kept_is_summed_up_without_computing_anything(tmp_path: Path) -> None:
    record = tmp_path / "batch" / "records" / "case_001"
    record.mkdir(parents=True)
    folder = tmp_path / "out" / f"opinions-{code_hash()[:12]}"
    folder.mkdir(parents=True)
    asked = [str(tmp_path / "out"), str(record), "--most-hours", "0"]
    ended = CliRunner().invoke(main, asked)
    assert ended.exit_code == 2
    assert "there is no opinion yet" in ended.stderr
    (folder / "batch_case_001.json").write_text(json.dumps(opinion()), encoding="utf-8")
    ended = CliRunner().invoke(main, asked)
    assert ended.exit_code == 0, ended.stderr
    assert "1 of 1 records" in ended.output
    assert "+0.30 on average, 0.30 at most" in ended.output
    assert "95 of 100 in the right class" in ended.output
    assert "named with more than 0.8, the classifier agrees on 1 of 1" in ended.output
