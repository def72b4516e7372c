"""A public challenge: sealed records of tests in several parts, and answers to them in one file.

A record is named after its part and case, as "wires/case_001". What is true of it is in keys outside the repository.
"""

import csv
import hashlib
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies import blind
from studies.blind.errors import BlindError
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.nominal import BallNominal, Nominal, drawn_nominals
from studies.blind.make import KEY, MANIFEST
from studies.blind.scoring.answers import NONE, OUTSIDE, Answer, NamedCause
from studies.blind.scoring.figures import batch_figures
from studies.blind.scoring.score import judge_all
from studies.blind.scoring.statistics import share
from studies.json_files import read_json
from wirewear.base.files import read_text
from wirewear.base.writing import write_text
from wirewear.records import AnyRecord, read_record

HERE = Path(__file__).parent
SEALED = HERE / "sealed.json"  #: SHA-256 of each part's manifest, which has that of its key and of each record.
COLUMNS = ("record", "cause", "probability")
SURE = 0.8  #: A cause is named alone from this probability on.

#: What an answer costs who acts on it: a wrong part is bought, work is lost on no gap, a gap is not found or explained.
COSTS = {"wrong name": 5.0, "name without a gap": 5.0, "other alarm": 1.0, "missed": 1.0, "left open": 1.0}


@dataclass(frozen=True)
class Balls(IndependentModel):
    """Balls on flats by the simulator of wires on a foundation: the gap of a ball is that of such wires at 90°."""

    library: Sequence[str] = tuple(one for one in blind.LIBRARY_EFFECTS if one != "crossing_angle_error")

    def nominals(self, number: int, random: np.random.Generator) -> tuple[Nominal, ...]:
        return drawn_nominals(number, random, BallNominal)


@dataclass(frozen=True)
class Part:
    """Records of one simulator. tests: different nominal tests among them."""

    generator: Callable[[], blind.Generator]
    cases: int
    tests: int


PARTS = {
    "wires": Part(partial(blind.generator_of, "T2", law="iwan"), 44, 5),
    "others": Part(partial(blind.generator_of, blind.OTHERS, law="development"), 22, 5),
    "any_angle": Part(partial(blind.generator_of, blind.OTHERS, law="scoring"), 22, 5),
    "balls": Part(partial(Balls, "bouc"), 12, 3),
}


def make(folder: Path, keys: Path, seed: int, parts: Sequence[str], progress: Callable[[str], None]) -> None:
    """Make the records of these parts in `folder`, or go on, and name each when it is done. seed: of all that is drawn,
    to be kept as secret as the keys.
    """
    for name in parts:
        part, own = PARTS[name], seed + [*PARTS].index(name)
        generator, key = part.generator(), keys / f"{name}.key"
        blind.make_batch(folder / name, cases=part.cases, seed=own, generator=generator, tests=part.tests, key_path=key)
        progress(name)


def seals_of(folder: Path) -> dict[str, str]:
    """SHA-256 of each part's manifest. Raises BlindError if no part is finished."""
    found = {one.parent.name: hashlib.sha256(one.read_bytes()).hexdigest() for one in folder.glob(f"*/{MANIFEST}")}
    if not found:
        raise BlindError(f"{folder} holds no finished part of a challenge: make it first.")
    return dict(sorted(found.items()))


def require_sealed(folder: Path, sealed: Path = SEALED) -> None:
    """See that the records are those of which the hashes were published. Raises BlindError if they are not."""
    if seals_of(folder) != read_json(sealed, BlindError, "list of seals"):
        raise BlindError(
            f"the manifests of {folder} are not those of {sealed}: it is another challenge, or was altered."
        )


def pack(folder: Path, archive: Path) -> str:
    """Write records, manifests and sealed keys with the README into a ZIP archive, and return its SHA-256; the same
    records give the same archive.
    """
    names = [folder / part / one for part in seals_of(folder) for one in (MANIFEST, KEY)]
    records = [path for part in seals_of(folder) for path in (folder / part).glob("*/*") if path.parent.name[0] != "."]
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for path in (HERE / "README.md", *sorted([*names, *records])):
            name = path.relative_to(folder).as_posix() if path.is_relative_to(folder) else path.name
            packed.writestr(zipfile.ZipInfo(name), path.read_bytes(), zipfile.ZIP_DEFLATED)
    return hashlib.sha256(archive.read_bytes()).hexdigest()


def records_of(folder: Path) -> dict[str, Path]:
    """The folder of each record by its name, in the manifests' order."""
    parts = {part: read_json(folder / part / MANIFEST, BlindError, "manifest")["cases"] for part in seals_of(folder)}
    return {f"{part}/{case}": folder / part / case for part, cases in parts.items() for case in cases}


def truths_of(folder: Path, keys: Path) -> list[blind.Truth]:
    """What is true of each record, under its name. Raises BlindError if keys and records do not belong together."""
    return [
        replace(truth, case=f"{part}/{truth.case}")
        for part in seals_of(folder)
        for truth in blind.verified(folder / part, keys / f"{part}.key").truths
    ]


def write_answers(path: Path, rows: Sequence[tuple[str, str, float]]) -> None:
    """Write the file of answers: name of a record, cause, and its probability."""
    lines = [",".join(COLUMNS), *(f"{name},{cause},{probability:.4f}" for name, cause, probability in rows)]
    write_text(path, "\n".join(lines) + "\n")


def read_answers(path: Path) -> dict[str, Answer]:
    """Answers by record. A cause is an effect, several that cannot be distinguished joined by "/", two such that act
    together joined by "+", "none" or "outside_library"; the likeliest is the verdict. Raises BlindError if the file
    lacks a column, or probabilities are no numbers or more than one together.
    """
    stated: dict[str, dict[str, float]] = {}
    try:
        for row in csv.DictReader(read_text(path, BlindError, "file of answers").splitlines()):
            causes = stated.setdefault(row["record"], {})
            causes[row["cause"]] = causes.get(row["cause"], 0.0) + float(row["probability"])
    except (KeyError, TypeError, ValueError) as problem:
        raise BlindError(f"{path} is no file of answers with the columns {', '.join(COLUMNS)} ({problem}).") from None
    for name, causes in stated.items():
        if not (min(causes.values()) >= 0.0 and sum(causes.values()) <= 1.01):
            raise BlindError(f"{path}: the probabilities of {name} must lie from 0 to 1 and be at most 1 together.")
    return {name: _answer(causes) for name, causes in stated.items()}


def _answer(causes: Mapping[str, float]) -> Answer:
    leading = max(causes, key=lambda cause: causes[cause])
    named = "explained" if causes[leading] >= SURE else "ambiguous"
    verdict = {NONE: "no_gap", OUTSIDE: "unexplained"}.get(leading, named)
    parts = [(cause.split("+"), probability) for cause, probability in causes.items()]
    found = [NamedCause(one.split("/")[0], p / len(both), {}, len(both) > 1) for both, p in parts for one in both]
    classes = (frozenset(one.split("/")) for both, _ in parts for one in both)
    return Answer(verdict, tuple(found), tuple(one for one in classes if len(one) > 1), frozenset(), None, None, None)


def rows_of(name: str, diagnosis: Mapping[str, Any]) -> list[tuple[str, str, float]]:
    """Rows of answers of a diagnosis.json; of effects that act together the likeliest pair has the probability of
    all.
    """
    stand_in = {one: "/".join(members) for members in diagnosis.get("equivalent", ()) for one in members}
    found: dict[str, float] = {}
    joint: dict[str, float] = {}
    for cause in diagnosis["causes"]:
        own = stand_in.get(cause["effect"], cause["effect"])
        into = joint if cause.get("joint") else found
        into[own] = into.get(own, 0.0) + cause["probability"]
    if joint:
        found["+".join(sorted(joint, key=lambda one: -joint[one])[:2])] = sum(joint.values())
    return [(name, cause, probability) for cause, probability in found.items() if probability > 0.0]


def score(folder: Path, keys: Path, answers: Mapping[str, Answer]) -> dict[str, Any]:
    """The score of answers: counts in all parts together, and the right ones of each part.

    detection, alarms, isolation: as the competition DX 2025 has them; isolation is the mean probability of the true
    cause where a gap was rightly found. cost: mean of `COSTS`. The other figures are those of the blind check. Records
    without an answer count as wrong. Raises BlindError if keys and records do not belong together.
    """
    truths = truths_of(folder, keys)
    judgements = judge_all(truths, {truth.case: answers.get(truth.case) for truth in truths})
    free = [one for one in judgements if one.truth.kind == "none"]
    gaps = [one for one in judgements if one.truth.kind != "none"]
    right = {one.truth.case: one.first_right if one.pair_found is None else one.pair_found == 2 for one in judgements}
    found, costs = batch_figures(judgements, {}), []
    for one in judgements:
        if one.truth.kind == "none":
            what = "name without a gap" if one.effect_named else "other alarm"
        elif one.effect_named:
            what = "left open" if one.first_right or one.pair_found else "wrong name"
        else:
            what = "left open" if one.gap_seen else "missed"
        costs.append(0.0 if right[one.truth.case] else COSTS[what])
    return {
        "detection": share([one.gap_seen for one in gaps]).to_json(),
        "alarms": share([one.gap_seen for one in free]).to_json(),
        "isolation": float(np.mean([one.truth_probability for one in gaps if one.gap_seen] or [0.0])),
        "cost": float(np.mean(costs)),
        **{name: found[name] for name in ("top1_large", "right_given_detection", "mean_class_size")},
        "unknown_unexplained": found["open_set"]["rejected_large"]["outside"],
        "pairs": found["pairs"]["both"],
        **{
            f"right, {part}": share([own for name, own in right.items() if name.split("/")[0] == part]).to_json()
            for part in seals_of(folder)
        },
    }


def nearest(folder: Path, known: Path, keys: Path) -> list[tuple[str, str, float]]:
    """Answers of the nearest neighbour: what is true of the record of a challenge that was opened, `known`, whose
    `figures` are nearest, in standard deviations of these.
    """
    paths, truths = records_of(known), truths_of(known, keys)
    table = np.array([figures(read_record(paths[truth.case])) for truth in truths])
    size = table.std(axis=0) + 1e-9
    rows = []
    for name, path in records_of(folder).items():
        apart = (((table - figures(read_record(path))) / size) ** 2).sum(axis=1)
        rows.append((name, "+".join(truths[int(np.argmin(apart))].hypotheses), 1.0))
    return rows


def figures(record: AnyRecord) -> NDArray[np.float64]:
    """Figures (8,) of a record: amplitude, area, largest and mean force of the first and of the last loop, over what
    its test asks for at a friction of 0.6; zeros without loops.
    """
    asked, found = record.tables.conditions, []
    for first_or_last in (min, max)[: 2 * bool(record.loops)]:
        own = first_or_last(record.loops, key=lambda one: one.cycle)
        x, q = own.displacement_um / asked.displacement_amplitude_um, own.tangential_force_N / asked.normal_load_N / 0.6
        area = float(np.sum(0.5 * (q + np.roll(q, -1)) * (np.roll(x, -1) - x)))
        found += [0.5 * np.ptp(x), 0.25 * abs(area), 0.5 * np.ptp(q), q.mean()]
    return np.array(found or np.zeros(8))
