"""The figures of a scored batch, as JSON: every case counts, none is left out."""

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from studies.blind.scoring.answers import Answer
from studies.blind.scoring.judging import OPEN_KINDS, Judgement, exact_label
from studies.blind.scoring.statistics import (
    area_interval,
    area_under_curve,
    calibration_error,
    reliability,
    roc_curve,
    share,
)

#: Edges of the gap's size in scatters of one test; the aims hold above 5.
GAP_EDGES = (0.0, 2.0, 5.0, 10.0, 20.0, float("inf"))
LARGE_GAP = 5.0
PAIR_GAP = 3.0  #: Pairs count as seen whose weaker effect changes a figure by more than this beyond the other.
SHRINK_REGRET = 0.05  #: Largest loss of shrink against an oracle, in parts of one.


def batch_figures(judgements: Sequence[Judgement], oracle: Mapping[str, Answer | None]) -> dict[str, Any]:
    """All figures of the contract, each share with its Wilson interval and counts."""
    return {
        "cases": len(judgements),
        "unanswered": sum(j.answer is None for j in judgements),
        "kinds": dict(sorted(Counter(j.truth.kind for j in judgements).items())),
        **_detection(judgements),
        **_classes(judgements),
        **_probabilities(judgements),
        "parameters": _parameters(judgements),
        "open_set": _open_set(judgements),
        "pairs": _pairs(judgements),
        "shrink": _shrink(judgements, oracle),
        "confusion": _confusion(judgements),
        "by_effect": _by_effect(judgements),
        "by_gap": _by_gap(judgements),
    }


def _of(judgements: Sequence[Judgement], *kinds: str) -> list[Judgement]:
    return [j for j in judgements if j.truth.kind in kinds]


def _open(judgements: Sequence[Judgement], *kinds: str) -> list[Judgement]:
    """Those whose effect nothing in the library contains."""
    return [j for j in _of(judgements, *kinds) if j.truth.is_open]


def _large(judgements: Sequence[Judgement]) -> list[Judgement]:
    return [j for j in judgements if j.truth.gap_in_scatter > LARGE_GAP]


def _detection(judgements: Sequence[Judgement]) -> dict[str, Any]:
    free, with_gap = _of(judgements, "none"), [j for j in judgements if j.truth.kind != "none"]
    large = _large(with_gap)
    return {
        "false_alarms": share([j.gap_seen for j in free]).to_json(),
        "false_causes": share([j.effect_named for j in free]).to_json(),
        "detected": share([j.gap_seen for j in with_gap]).to_json(),
        "detected_large": share([j.gap_seen for j in large]).to_json(),
    }


def _classes(judgements: Sequence[Judgement]) -> dict[str, Any]:
    singles = _of(judgements, "single")
    large = _large(singles)
    return {
        "top1": share([j.first_right for j in singles]).to_json(),
        "top2": share([j.second_right for j in singles]).to_json(),
        "top1_large": share([j.first_right for j in large]).to_json(),
        "top2_large": share([j.second_right for j in large]).to_json(),
        "right_given_detection": share([j.first_right for j in singles if j.effect_named]).to_json(),
        "right_given_gap_seen": share([j.first_right for j in singles if j.gap_seen]).to_json(),
        "true_where_named": share(
            [j.first_right or bool(j.pair_found) for j in judgements if j.effect_named]
        ).to_json(),
        "mean_class_size": _mean([j.class_size for j in singles if j.answer is not None]),
    }


def _probabilities(judgements: Sequence[Judgement]) -> dict[str, Any]:
    answered = [j for j in judgements if j.answer is not None]
    bins = reliability([j.leading_probability for j in answered], [j.leading_right for j in answered])
    alone = [j for j in judgements if j.truth.kind != "pair"]
    seen = [j.truth_probability for j in alone if j.truth.kind != "none" and j.gap_seen]
    return {
        "truth_probability": {
            kind: _mean([j.truth_probability for j in _of(judgements, kind)])
            for kind in ("none", "single", *OPEN_KINDS)
        },
        "truth_probability_detected": _mean(seen),
        "calibration_error": _rounded(calibration_error(bins)),
        "reliability": [
            {"from": b.low, "to": b.high, "probability": round(b.probability, 4), "right": b.right.to_json()}
            for b in bins
        ],
        "set_coverage": share([j.set_holds_truth for j in alone]).to_json(),
        "mean_set_size": _mean([j.set_size for j in alone if j.answer is not None]),
    }


def _parameters(judgements: Sequence[Judgement]) -> dict[str, Any]:
    by_name: dict[str, list[bool]] = {}
    for judgement in judgements:
        for name, covered in judgement.parameters.items():
            by_name.setdefault(name, []).append(covered)
    everything = [covered for marks in by_name.values() for covered in marks]
    return {
        "coverage": share(everything).to_json(),
        "by_parameter": {name: share(marks).to_json() for name, marks in sorted(by_name.items())},
    }


def _open_set(judgements: Sequence[Judgement]) -> dict[str, Any]:
    opened, known = _open(judgements, *OPEN_KINDS), _of(judgements, "single", "pair")
    positive, negative = [j.outside_score for j in opened], [j.outside_score for j in known]
    false, true = roc_curve(positive, negative) if positive and negative else ([], [])
    return {
        "auroc": _area(opened, known),
        "auroc_large": _area(_large(opened), _large(known)),
        "rejected": {kind: share([j.rejected for j in _open(judgements, kind)]).to_json() for kind in OPEN_KINDS},
        "rejected_large": {
            kind: share([j.rejected for j in _large(_open(judgements, kind))]).to_json() for kind in OPEN_KINDS
        },
        "rejected_given_gap_seen": share([j.rejected for j in opened if j.gap_seen]).to_json(),
        "right_seam_large": share([j.right_seam for j in _large(opened) if j.right_seam is not None]).to_json(),
        "left_out_right": share([j.first_right for j in _of(judgements, "left_out")]).to_json(),
        "known_rejected": share([j.rejected for j in known]).to_json(),
        "roc": {"false": [round(v, 4) for v in false], "true": [round(v, 4) for v in true]},
    }


def _area(opened: Sequence[Judgement], known: Sequence[Judgement]) -> dict[str, Any]:
    positive, negative = [j.outside_score for j in opened], [j.outside_score for j in known]
    interval = area_interval(positive, negative)
    return {
        "value": _rounded(area_under_curve(positive, negative)),
        "interval95": None if interval is None else [round(end, 4) for end in interval],
        "of": [len(positive), len(negative)],
    }


def _pairs(judgements: Sequence[Judgement]) -> dict[str, Any]:
    pairs = _of(judgements, "pair")
    found = [j.pair_found or 0 for j in pairs]
    return {
        "both": share([count == 2 for count in found]).to_json(),
        "both_large": share(
            [j.pair_found == 2 for j in pairs if (j.truth.weaker_in_scatter or 0.0) > PAIR_GAP]
        ).to_json(),
        "at_least_one": share([count >= 1 for count in found]).to_json(),
    }


def _shrink(judgements: Sequence[Judgement], oracle: Mapping[str, Answer | None]) -> dict[str, Any]:
    rows: list[dict[str, Any]] = []
    losses: list[float] = []
    for judgement in judgements:
        answer, of_oracle = judgement.answer, oracle.get(judgement.truth.case)
        if judgement.truth.kind not in ("single", "pair"):
            continue
        if of_oracle is not None:
            losses.append(max(_shrunk(of_oracle), 0.0) - _shrunk(answer))
        if answer is None or not answer.gap_seen:
            continue
        rows.append(
            {
                "case": judgement.truth.case,
                "predicted": answer.predicted_shrink,
                "achieved": answer.achieved_shrink,
                "confirmed": answer.confirmed_shrink is not None,
                "oracle": None if of_oracle is None else of_oracle.achieved_shrink,
            }
        )
    both = [(r["predicted"], r["achieved"]) for r in rows if r["predicted"] is not None and r["achieved"] is not None]
    regrets = [r["oracle"] - r["achieved"] for r in rows if r["oracle"] is not None and r["achieved"] is not None]
    return {
        "cases": len(rows),
        "predicted": _mean([r["predicted"] for r in rows if r["predicted"] is not None]),
        "achieved": _mean([r["achieved"] for r in rows if r["achieved"] is not None]),
        "oracle": _mean([r["oracle"] for r in rows if r["oracle"] is not None]),
        "predicted_less_achieved": _mean([predicted - achieved for predicted, achieved in both]),
        "regret": _mean(regrets),
        "regret_of_all": _mean(losses),
        "regret_within_aim": share([regret <= SHRINK_REGRET for regret in regrets]).to_json(),
        "rows": rows,
    }


def _shrunk(answer: Answer | None) -> float:
    """How far an answer shrinks the gap: not at all where it found none or names nothing that does."""
    if answer is None or not answer.gap_seen:
        return 0.0
    return answer.achieved_shrink or 0.0


def _confusion(judgements: Sequence[Judgement]) -> dict[str, Any]:
    """Rows are truths, columns answers; effects of an exact class stand together, pairs are not in it."""
    counted: dict[str, Counter[str]] = {}
    for judgement in judgements:
        if judgement.truth.kind == "pair":
            continue
        row = exact_label(judgement.truth.hypotheses[0])
        counted.setdefault(row, Counter())[exact_label(judgement.label)] += 1
    columns = sorted({column for counts in counted.values() for column in counts} | set(counted), key=_confusion_order)
    rows = sorted(counted, key=_confusion_order)
    return {
        "truths": rows,
        "answers": columns,
        "counts": [[counted[row][column] for column in columns] for row in rows],
    }


def _confusion_order(label: str) -> tuple[bool, bool, str]:
    """Effects first, then what no effect is."""
    return label in ("none", "no answer"), label == "outside_library", label


def _by_effect(judgements: Sequence[Judgement]) -> dict[str, Any]:
    named: dict[str, list[Judgement]] = {}
    for judgement in judgements:
        if judgement.truth.kind in ("single", *OPEN_KINDS):
            kind = "left out: " if judgement.truth.kind == "left_out" else ""
            named.setdefault(f"{kind}{judgement.truth.effects[0]}", []).append(judgement)
    return {
        effect: {
            "right": share([j.first_right for j in own]).to_json(),
            "gap_seen": share([j.gap_seen for j in own]).to_json(),
            "median_gap_in_scatter": round(float(np.median([j.truth.gap_in_scatter for j in own])), 2),
        }
        for effect, own in sorted(named.items())
    }


def _by_gap(judgements: Sequence[Judgement]) -> list[dict[str, Any]]:
    singles = _of(judgements, "single")
    rows = []
    for low, high in pairwise(GAP_EDGES):
        inside = [j for j in singles if low <= j.truth.gap_in_scatter < high]
        rows.append(
            {
                "from": low,
                "to": high if np.isfinite(high) else None,
                "detected": share([j.gap_seen for j in inside]).to_json(),
                "top1": share([j.first_right for j in inside]).to_json(),
                "top2": share([j.second_right for j in inside]).to_json(),
            }
        )
    return rows


def _mean(values: Sequence[float]) -> float | None:
    return round(float(np.mean(values)), 4) if len(values) else None


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 4)
