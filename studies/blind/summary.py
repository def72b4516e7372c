"""What is kept of a scored batch: the score as small JSON with one line a case, and the report's pictures."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import Any

from wirewear.blind import Judgement, Score
from wirewear.blind.scoring.pictures import confusion_picture, overview_picture
from wirewear.files import write_text
from wirewear.pictures import save

from .answering import COST


def write_summary(score: Score, diagnoses: Path, folder: Path) -> list[Path]:
    """Write score.json and the pictures into a folder; the truth of every case stands in it, so the batch is spent."""
    folder.mkdir(parents=True, exist_ok=True)
    report = dict(score.report)
    report["cost"] = _costs(diagnoses)
    report["lines"] = [_line(judgement) for judgement in score.judgements]
    path = folder / "score.json"
    text = json.dumps({key: value for key, value in report.items() if key != "lines"}, indent=1, ensure_ascii=False)
    lines = ",\n".join("  " + json.dumps(line, ensure_ascii=False) for line in report["lines"])
    write_text(path, f'{text[:-2]},\n "lines": [\n{lines}\n ]\n}}\n')
    return [
        path,
        save(partial(overview_picture, report, score.judgements), folder / "overview.png"),
        save(partial(confusion_picture, report["confusion"]), folder / "confusion.png"),
    ]


def _line(judgement: Judgement) -> dict[str, Any]:
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


def _costs(diagnoses: Path) -> dict[str, float]:
    spent = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(diagnoses.glob(f"*/{COST}"))]
    seconds = sorted(float(one["cpu_s"]) for one in spent)
    if not seconds:
        return {}
    return {"records": len(seconds), "median_cpu_s": seconds[len(seconds) // 2], "largest_cpu_s": seconds[-1]}
