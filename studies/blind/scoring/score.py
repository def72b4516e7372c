"""Scoring a batch: seal and records verified, every case judged, the run logged, report written."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from studies.blind.errors import BlindError
from studies.blind.generators.files import record_hash
from studies.blind.make import KEY, MANIFEST
from studies.blind.scoring.answers import Answer, read_answers, require_any
from studies.blind.scoring.figures import batch_figures
from studies.blind.scoring.history import SCORE_JSON, logged_run
from studies.blind.scoring.judging import Judgement, Truth, judged
from studies.blind.scoring.table import aim_rows, share_text, words
from studies.blind.sealing import fingerprint, opened, read_key_file
from studies.json_files import read_json
from wirewear.base import frame
from wirewear.base.writing import json_text, usable_folder, write_text, writing

KINDS = (
    ("none", "without a gap"),
    ("single", "with one effect"),
    ("pair", "with two effects"),
    ("outside", "with an effect of no library"),
    ("left_out", "with an effect that was left out of the library"),
)
TEMPLATE = Path(__file__).with_name("page.html")

#: What stands below each panel.
CAPTIONS = (
    "Single effects by the size of their gap; ticks are single records, above: right, below: wrong. Bars: 95 %.",
    "Stated probability of the leading answer, and how often it was right. Bars: 95 %.",
    "Effects of no library against known ones.",
    "Share of the records whose gap shrinks at least so far with the answer, as predicted and as achieved.",
)

ORACLE, BASELINES = "oracle", "baselines"
SCORE_PAGE = "score.html"


def score_page(report: Mapping[str, Any], judgements: Sequence[Judgement]) -> str:
    """The page of a score."""
    from studies.blind.scoring.pictures import confusion_picture, panel_pictures, singles_of
    from wirewear.pictures.style import svg

    aims = aim_rows(report)
    panels = panel_pictures(report, singles_of(judgements))
    drawn = [frame.inline_svg(svg(draw), f"p{n}") for n, draw in enumerate(panels)]
    confusion = frame.inline_svg(svg(lambda: confusion_picture(report["confusion"])), "c")
    return frame.rendered(
        TEMPLATE,
        {
            "report": report,
            "aims": aims,
            "missed": [row.what for row in aims if row.met is False],
            "met": sum(row.met is True for row in aims),
            "kinds": KINDS,
            "panels": list(zip(drawn, CAPTIONS, strict=True)),
            "confusion": confusion,
            "judgements": judgements,
        },
        {"share": share_text, "number": lambda value, digits=3: frame.figure(value, digits), "words": words},
    )


@dataclass(frozen=True)
class Score:
    """A scored batch: its judgements, the figures of the contract, and those of the baselines beside it."""

    judgements: tuple[Judgement, ...]
    report: Mapping[str, Any]


@dataclass(frozen=True)
class VerifiedBatch:
    """A batch whose key and records are the promised ones: truths of its records, and planned cases without one."""

    manifest: Mapping[str, Any]
    truths: tuple[Truth, ...]
    unmade: tuple[Mapping[str, Any], ...]


def score_batch(folder: str | Path, diagnoses: str | Path, *, key_path: Path, output: Path | None = None) -> Score:
    """Verify a batch, score the diagnoses of its records, log the run and write score.json and score.html.

    `diagnoses` holds a folder with diagnosis.json for each record. Beside them, oracle/ may hold those of a diagnosis
    that was given the truth, and baselines/NAME/ those of simpler methods.
    Raises BlindError if key, manifest or records do not belong together, or a diagnosis cannot be understood. Raises
    RunError if the report could not be written; the run is not logged then.
    """
    folder, diagnoses = Path(folder), Path(diagnoses)
    usable_folder(output or diagnoses)
    batch = verified(folder, key_path)
    manifest, truths = batch.manifest, batch.truths
    names = [truth.case for truth in truths]
    answers = read_answers(diagnoses, names)
    require_any(answers, diagnoses, folder)
    judgements = judge_all(truths, answers)
    oracle = read_answers(diagnoses / ORACLE, names) if (diagnoses / ORACLE).is_dir() else {}
    report = {
        "format": 1,
        "tier": manifest["tier"],
        "model": manifest["model"],
        "made_by_wirewear": manifest["wirewear"],
        "key_sha256": manifest["key_sha256"],
        "unmade": list(batch.unmade),
        **batch_figures(judgements, oracle),
        "baselines": _baselines(diagnoses / BASELINES, truths),
        "lines": [_line(judgement) for judgement in judgements],
    }
    headline = {name: report[name] for name in ("false_alarms", "top1", "right_given_detection")}
    report["run"] = logged_run(folder, diagnoses, headline, key_path)
    _write(output or diagnoses, report, judgements)
    return Score(judgements, report)


def judge_all(truths: Sequence[Truth], answers: Mapping[str, Answer | None]) -> tuple[Judgement, ...]:
    """Every case judged, also those without an answer."""
    return tuple(judged(truth, answers.get(truth.case)) for truth in truths)


def _line(judgement: Judgement) -> dict[str, Any]:
    """What was true of a case and what was said: with it the batch is spent."""
    truth, said = judgement.truth, judgement.answer
    return {
        "case": truth.case,
        "kind": truth.kind,
        "effects": {name: dict(truth.parameters[name]) for name in truth.effects},
        "gap_in_scatter": round(truth.gap_in_scatter, 2),
        "verdict": None if said is None else said.verdict,
        "causes": [[cause.effect, round(cause.probability, 3)] for cause in judgement.leading_causes],
        "right": judgement.first_right if truth.kind != "pair" else (judgement.pair_found or 0),
    }


def _unmade(case: Mapping[str, Any]) -> dict[str, Any]:
    """A case without a record, as the report names it."""
    effects = [effect["effect"] for effect in case["effects"]]
    return {"case": case["case"], "kind": case["kind"], "effects": effects, "reason": case["reason"]}


def verified(folder: Path, key_path: Path) -> VerifiedBatch:
    """A batch's manifest and what its key says, once key and records have been found to be those that it binds.
    Raises BlindError if they are not, or something is missing.
    """
    try:
        manifest = read_json(folder / MANIFEST, BlindError, "manifest")
        token = (folder / KEY).read_bytes()
        bound = {str(name): str(case["sha256"]) for name, case in manifest["cases"].items()}
        left_out = {str(name): case.get("left_out") for name, case in manifest["cases"].items()}
        promised = manifest["key_sha256"]
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as problem:
        raise BlindError(f"{folder} is no finished batch: {MANIFEST} or {KEY} cannot be read ({problem}).") from None
    key = opened(token, read_key_file(key_path), str(folder / KEY))
    if fingerprint(key) != promised:
        raise BlindError(f"the key of {folder} is not the one that {MANIFEST} promised: it was exchanged afterwards.")
    if sorted(bound) != sorted(case["case"] for case in key["truths"]):
        raise BlindError(f"{MANIFEST} of {folder} lists other records than the key.")
    if key.get("format", 1) > 1:
        _require_sealed(folder, {**manifest, "records": bound, "left_out": left_out}, key)
    altered = [name for name, own in bound.items() if record_hash(folder / name) != own]
    if altered:
        raise BlindError(f"the record {folder / altered[0]} was altered after it was made ({len(altered)} in all).")
    # Batches of earlier versions stopped at a case that could not be made.
    unmade = tuple(_unmade(case) for case in key.get("unmade", []))
    return VerifiedBatch(manifest, tuple(Truth.of_key(case) for case in key["truths"]), unmade)


def _require_sealed(folder: Path, manifest: Mapping[str, Any], key: Mapping[str, Any]) -> None:
    """See that the manifest says what the key, which nobody else can write, has sealed.
    Raises BlindError if it does not.
    """
    sealed_too = {**key, "left_out": {case["case"]: case.get("left_out") for case in key["truths"]}}
    for name in ("format", "records", "left_out", "tier", "model", "wirewear"):
        if sealed_too.get(name) != manifest.get(name):
            raise BlindError(f"{MANIFEST} of {folder} was altered: its {name} are not those that the key has sealed.")


def _baselines(folder: Path, truths: Sequence[Truth]) -> dict[str, Any]:
    if not folder.is_dir():
        return {}
    found = {}
    for own in sorted(path for path in folder.iterdir() if path.is_dir()):
        figures = batch_figures(judge_all(truths, read_answers(own, [truth.case for truth in truths])), {})
        found[own.name] = {
            name: figures[name]
            for name in ("unanswered", "false_alarms", "top1", "top1_large", "top2", "right_given_detection")
        }
    return found


def _write(folder: Path, report: Mapping[str, Any], judgements: Sequence[Judgement]) -> None:

    texts = {SCORE_JSON: json_text(report, indent=1) + "\n", SCORE_PAGE: score_page(report, judgements)}
    with writing(BlindError, f"the report cannot be written to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            write_text(folder / name, text)
