"""What a diagnosis says: the contract's JSON as a value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import floor
from typing import Any, Literal

import numpy as np

from wirewear.diagnosis.calibration import digest
from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.diagnosis.infer.where import Finding
from wirewear.diagnosis.model.candidates import Candidate
from wirewear.diagnosis.model.setup import Array

FORMAT = 1

Verdict = Literal["no_gap", "explained", "ambiguous", "unexplained"]


@dataclass(frozen=True)
class Estimate:
    """A parameter's value with its 95 % interval."""

    value: float
    interval95: tuple[float, float]


def estimates(candidate: Candidate, coordinates: Array, deviations: Array, dispersion: float) -> dict[str, Estimate]:
    """A fitted effect's parameters with intervals, their variances times `dispersion`.

    Held ones are as expected, and what follows them is as unknown.
    """
    values = candidate.values(coordinates)
    found = {}
    for i, (name, parameter) in enumerate(candidate.parameters.items()):
        reach = 1.96 * float(np.hypot(deviations[i] * dispersion**0.5, candidate.unknown_spread(name)))
        ends = sorted(parameter.value(float(coordinates[i]) + side * reach) for side in (-1.0, 1.0))
        found[name] = Estimate(values[name], (ends[0], ends[1]))
    for name, parameter in candidate.held.items():
        found[name] = Estimate(values[name], parameter.interest)
    return found


@dataclass(frozen=True)
class Cause:
    """An effect with its probability and parameters; `joint` if it acts together with another one of the list."""

    effect: str
    probability: float
    parameters: Mapping[str, Estimate]
    joint: bool = False


@dataclass(frozen=True)
class Confirmed:
    """The shrink that the full simulation with the leading effects achieved."""

    shrink: float
    after: float
    effects: tuple[str, ...]


@dataclass(frozen=True)
class Diagnosis:
    """The answer: verdict, where, causes, what cannot be told apart, and how far the gap shrinks.

    `physical` pairs measurement less model before and after; `notes` are sentences about what limits the answer.
    """

    record: str
    model: str
    verdict: Verdict
    sentence: str
    shrink: Shrink
    physical: Mapping[str, tuple[float, float]]
    confirmed: Confirmed | None
    where: tuple[Finding, ...]
    causes: tuple[Cause, ...]
    equivalent: tuple[tuple[str, ...], ...]
    undetectable: tuple[str, ...]
    next_measurement: Mapping[str, Any] | None
    notes: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """The contract's JSON, figures rounded to what they mean."""
        s = self.shrink
        return {
            "format": FORMAT,
            "record": self.record,
            "model": self.model,
            "calibration": digest(),
            "verdict": self.verdict,
            "sentence": self.sentence,
            "gap": {
                "before": _rounded(s.before),
                "after": _rounded(s.after),
                "floor": _rounded(s.floor),
                "shrink": _rounded(s.shrink),
                "shrink_interval95": [_rounded(v) for v in s.interval95],
                "predicted_shrink": _rounded(s.predicted),
                "held_out": [f"{'scar of the fixed wire, ' if s.scar_held_out else ''}cycle {n}" for n in s.held_out],
                "placebo_shrink": {
                    "best_wrong_effect": _rounded(s.best_wrong_effect),
                    "free_smooth_fit": _rounded(s.free_smooth_fit),
                },
                "physical": {name: [_rounded(v) for v in pair] for name, pair in self.physical.items()},
                "confirmed": None if self.confirmed is None else asdict(self.confirmed),
            },
            "where": [asdict(finding) for finding in self.where],
            "causes": [
                {
                    "effect": cause.effect,
                    "probability": _rounded_down(cause.probability),
                    "parameters": {
                        name: {"value": _rounded(e.value), "interval95": [_rounded(v) for v in e.interval95]}
                        for name, e in cause.parameters.items()
                    },
                    **({"joint": True} if cause.joint else {}),
                }
                for cause in self.causes
            ],
            "equivalent": [list(members) for members in self.equivalent],
            "undetectable": list(self.undetectable),
            "next_measurement": None if self.next_measurement is None else dict(self.next_measurement),
            "notes": list(self.notes),
        }


def _rounded_down(probability: float) -> float:
    """To four digits, such that a sum of many stays within one."""
    return floor(1e4 * probability) / 1e4


def _rounded(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.4g}")
