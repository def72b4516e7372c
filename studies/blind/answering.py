"""Answers to one record of a blind batch: the diagnosis, that of an oracle given the truth, and simple baselines."""

import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from wirewear import WirewearError
from wirewear.base.writing import write_text
from wirewear.diagnosis import Diagnosed, diagnose
from wirewear.records import read_record

DIAGNOSIS, FAILURE, COST = "diagnosis.json", "failed.txt", "cost.json"
BASELINES = ("smallest_chi_square", "bic")

#: A chi-square baseline sees a gap above this quantile, and calls an explanation none above the other.
SEEN, UNEXPLAINED = 0.95, 0.999


def answered(folder: Path) -> bool:
    """Whether a record has its answer, be it that it could not be diagnosed."""
    return (folder / DIAGNOSIS).exists() or (folder / FAILURE).exists()


def answer(record: Path, left_out: Sequence[str], diagnoses: Path) -> None:
    """Diagnose a record without the effects left out; a refusal is kept as its sentence, the CPU time beside it.

    An answer that breaks down is a refusal, too: the other records of the batch want theirs.
    """
    folder, name = diagnoses / record.name, record.name
    folder.mkdir(parents=True, exist_ok=True)
    started = time.process_time(), time.perf_counter()
    try:
        diagnosed = _diagnosed(record, left_out)
    except Exception as problem:  # noqa: BLE001 - whatever it is, it counts
        how = "" if isinstance(problem, WirewearError) else f"broke down by {type(problem).__name__}: "
        write_text(folder / FAILURE, f"{how}{problem}\n")
        return
    spent = {"cpu_s": time.process_time() - started[0], "wall_s": time.perf_counter() - started[1]}
    for baseline, verdict in baseline_answers(diagnosed).items():
        write_json(diagnoses / "baselines" / baseline / name / DIAGNOSIS, verdict)
    write_json(folder / COST, {key: round(value, 2) for key, value in spent.items()})
    write_json(folder / DIAGNOSIS, diagnosed.diagnosis.to_json())


def answer_of_oracle(record: Path, effects: Sequence[str], others: Sequence[str], oracle: Path) -> None:
    """Diagnose a record with the true effects alone in the library."""
    folder = oracle / record.name
    folder.mkdir(parents=True, exist_ok=True)
    try:
        diagnosed = _diagnosed(record, [name for name in others if name not in effects])
    except WirewearError as problem:
        write_text(folder / FAILURE, f"{problem}\n")
        return
    write_json(folder / DIAGNOSIS, diagnosed.diagnosis.to_json())


def _diagnosed(record: Path, left_out: Sequence[str]) -> Diagnosed:
    from threadpoolctl import threadpool_limits

    with threadpool_limits(limits=1, user_api="blas"):
        return diagnose(read_record(record), left_out=left_out)


def baseline_answers(diagnosed: Diagnosed) -> dict[str, dict[str, Any]]:
    """What simpler choices among the same fits say: the smallest chi-square, and Schwarz's criterion (BIC)."""
    from scipy.stats import chi2

    found, size = diagnosed.search, diagnosed.search.problem.whitening.shape[0]
    fits = [found.none, *found.singles, *found.pairs]
    free = [one.coordinates.size for one in fits]
    squares = np.array([one.distance2 for one in fits])
    criteria = squares + np.array(free) * np.log(size)
    weights = np.exp(-0.5 * (criteria - criteria.min()))
    best, likeliest = int(np.argmin(squares)), int(np.argmin(criteria))

    def fails(place: int) -> bool:
        return bool(squares[place] > chi2.ppf(UNEXPLAINED, max(size - free[place], 1)))

    smallest = 0 if squares[0] < chi2.ppf(SEEN, size) else best
    return {
        BASELINES[0]: _said([one.names for one in fits], np.eye(len(fits))[smallest], smallest, fails(smallest)),
        BASELINES[1]: _said([one.names for one in fits], weights / weights.sum(), likeliest, fails(likeliest)),
    }


def _said(names: Sequence[Sequence[str]], probabilities: Any, chosen: int, unexplained: bool) -> dict[str, Any]:
    causes = [
        {"effect": name, "probability": probability / max(len(own), 1), "joint": len(own) > 1}
        for own, probability in zip(names, probabilities.tolist(), strict=True)
        for name in own or ("none",)
    ]
    verdict = "unexplained" if unexplained else "explained" if names[chosen] else "no_gap"
    return {"format": 1, "verdict": verdict, "causes": sorted(causes, key=lambda c: -c["probability"])}


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write a table as JSON in one step, into a folder that is made if need be."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, json.dumps(data, indent=1, ensure_ascii=False) + "\n")
