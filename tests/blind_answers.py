"""Truths of the blind check and answers to them, for tests of its scorer."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from studies.blind.generators.cases import planned_cases
from studies.blind.generators.generator import LIBRARY_EFFECTS
from studies.blind.scoring.answers import Answer, NamedCause
from studies.blind.scoring.figures import batch_figures
from studies.blind.scoring.judging import Truth
from studies.blind.scoring.score import judge_all
from tests.blind_batches import PlainModel


def truths_of(number: int, seed: int = 1) -> tuple[Truth, ...]:
    """Truths of a plan, the gap's size following the ease."""
    random = np.random.default_rng(seed)
    return tuple(
        Truth(
            case=case.name,
            kind=case.kind,
            ease=case.ease,
            effects=tuple(effect.effect for effect in case.effects),
            parameters={effect.effect: effect.parameters for effect in case.effects},
            gap_in_scatter=0.0 if case.ease is None else float(random.uniform(*((1, 6), (6, 40))[case.ease == "easy"])),
        )
        for case in planned_cases(number, seed, LIBRARY_EFFECTS, PlainModel().outside)
    )


def a_truth(kind: str, effect: str | None = None) -> Truth:
    return Truth("case_001", kind, None if effect is None else "easy", (effect,) if effect else (), {}, 9.0)


def answer(
    verdict: str,
    causes: Mapping[str, float] | None = None,
    *,
    joint: bool = False,
    equivalent: Sequence[frozenset[str]] = (),
    intervals: Mapping[str, Mapping[str, tuple[float, float]]] | None = None,
    shrink: float | None = None,
    predicted: float | None = None,
) -> Answer:
    named = tuple(
        NamedCause(effect, probability, (intervals or {}).get(effect, {}), joint)
        for effect, probability in (causes or {}).items()
    )
    return Answer(verdict, named, tuple(equivalent), frozenset(), shrink, predicted, None)


def perfect(truth: Truth) -> Answer:
    if truth.kind == "none":
        return answer("no_gap", {"none": 1.0})
    if truth.is_open:
        return answer("unexplained", {"outside_library": 1.0})
    if truth.kind == "left_out":
        return answer("explained", dict.fromkeys(truth.hypotheses, 1.0))
    intervals = {e: {n: (v - 1.0, v + 1.0) for n, v in truth.parameters[e].items()} for e in truth.effects}
    causes = dict.fromkeys(truth.effects, 1.0)
    joint = truth.kind == "pair"
    return answer("explained", causes, joint=joint, intervals=intervals, shrink=0.95, predicted=0.97)


def figures(truths: Sequence[Truth], answers: Mapping[str, Answer | None]) -> dict[str, Any]:
    return batch_figures(judge_all(truths, answers), {})
