"""Reading diagnoses: the parts of diagnosis.json that are scored."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from studies.blind.errors import BlindError
from studies.json_files import read_json
from wirewear.base.files import require_unchanged

FILE_NAME = "diagnosis.json"
VERDICTS = ("no_gap", "explained", "ambiguous", "unexplained")
ROUNDING = 0.01  #: What rounded probabilities may add up to beyond 1.
NONE, OUTSIDE = "none", "outside_library"  #: Hypotheses beside the effects, as `causes` may name them.


@dataclass(frozen=True)
class NamedCause:
    """An effect, or "none" or "outside_library", with its probability; `intervals` are 95 % ones by parameter."""

    effect: str
    probability: float
    intervals: Mapping[str, tuple[float, float]]
    joint: bool


@dataclass(frozen=True)
class Answer:
    """What a diagnosis said of one record; `stated_set` are the classes of its 90 % set, if it states one.

    `seam` is where an unexplained gap enters: that of the first family which it resembles, or empty.
    """

    verdict: str
    causes: tuple[NamedCause, ...]
    equivalent: tuple[frozenset[str], ...]
    undetectable: frozenset[str]
    shrink: float | None
    predicted_shrink: float | None
    confirmed_shrink: float | None
    stated_set: tuple[frozenset[str], ...] = ()
    seam: str = ""

    @property
    def gap_seen(self) -> bool:
        """Whether the diagnosis found a gap, explained or not."""
        return self.verdict != "no_gap"

    @property
    def names_an_effect(self) -> bool:
        """Whether it named at least one effect as the cause."""
        return self.verdict in ("explained", "ambiguous")

    @property
    def achieved_shrink(self) -> float | None:
        """Shrink by the full simulation where that was made, else on what was held out."""
        return self.shrink if self.confirmed_shrink is None else self.confirmed_shrink


def read_answers(folder: Path, names: list[str]) -> dict[str, Answer | None]:
    """The diagnosis of each record under its name, None where there is none.
    Raises BlindError if the folder is missing, or a diagnosis cannot be understood.
    """
    if not folder.is_dir():
        raise BlindError(f"there is no folder {folder}: name the one that holds a folder with {FILE_NAME} per record.")
    answers: dict[str, Answer | None] = {}
    for name in names:
        path = next((p for p in (folder / name / FILE_NAME, folder / f"{name}.json") if p.is_file()), None)
        answers[name] = None if path is None else read_answer(path)
    return answers


def require_any(answers: Mapping[str, Answer | None], folder: Path, batch: Path) -> None:
    """Raise BlindError if none of these answers, by record, is a diagnosis. folder, batch: named in its message."""
    if not any(answers.values()):
        raise BlindError(f"{folder} holds no diagnosis of a record of {batch}, as {next(iter(answers))}/{FILE_NAME}.")


def read_answer(path: Path) -> Answer:
    """One diagnosis. Raises BlindError if it is no JSON, or lacks what the contract asks for."""
    data = read_json(path, BlindError, "diagnosis")
    if not isinstance(data, dict) or data.get("verdict") not in VERDICTS:
        raise BlindError(f"{path} has no verdict: it must be one of {', '.join(VERDICTS)}.")
    require_unchanged(data, str(path), BlindError)
    try:
        return answer_of(data)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError) as problem:
        raise BlindError(f"{path} is not a diagnosis of format 1 ({type(problem).__name__}: {problem}).") from None


def answer_of(data: Mapping[str, Any]) -> Answer:
    """The parts of a diagnosis that are scored.
    Raises KeyError, IndexError, TypeError, ValueError or AttributeError if it is no diagnosis of format 1.
    """
    gap = data.get("gap") or {}
    causes = tuple(_cause(cause) for cause in data.get("causes", ()))
    if (total := sum(cause.probability for cause in causes)) > 1.0 + ROUNDING:
        raise ValueError(f"the probabilities of its causes add up to {total:.4g}")
    confirmed = gap.get("confirmed")
    return Answer(
        verdict=data["verdict"],
        causes=causes,
        equivalent=tuple(frozenset(map(str, members)) for members in data.get("equivalent", ())),
        undetectable=frozenset(map(str, data.get("undetectable", ()))),
        shrink=_number(gap.get("shrink")),
        predicted_shrink=_number(gap.get("predicted_shrink")),
        stated_set=tuple(frozenset(map(str, members)) for members in data.get("set90") or ()),
        seam=next((str(one["seam"]) for one in data.get("resembles") or ()), ""),
        confirmed_shrink=_number(confirmed.get("shrink") if isinstance(confirmed, Mapping) else confirmed),
    )


def _cause(cause: Mapping[str, Any]) -> NamedCause:
    probability = float(cause["probability"])
    if not 0.0 <= probability <= 1.0 + 1e-9:
        raise ValueError(f"the probability of {cause['effect']} is {probability}")
    intervals = {}
    for name, estimate in (cause.get("parameters") or {}).items():
        interval = estimate.get("interval95")
        if interval is not None and None not in interval:
            intervals[str(name)] = (float(interval[0]), float(interval[1]))
    return NamedCause(str(cause["effect"]), min(probability, 1.0), intervals, bool(cause.get("joint", False)))


def _number(value: object) -> float | None:
    if value is None or isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return float(value) if math.isfinite(value) else None
