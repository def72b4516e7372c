"""What is kept of a scored batch: the score as small JSON with one line a case, and the report's pictures.

`python -m studies.blind.summary FOLDER...` draws the pictures anew from the score.json of folders.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click

from studies.blind import Judgement, Score
from studies.blind.errors import BlindError
from studies.blind.scoring.pictures import Single, confusion_picture, overview_picture, singles_of
from wirewear.files import usable_folder, write_text
from wirewear.files.reading import read_json
from wirewear.pictures import save
from wirewear.study_script import StudyScript, understanding

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
    return [path, *drawn(report, singles_of(score.judgements), folder)]


def drawn(report: Mapping[str, Any], singles: Sequence[Single], folder: Path) -> list[Path]:
    """Draw the pictures of a score into a folder."""
    return [
        save(partial(overview_picture, report, singles), folder / "overview.png"),
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


@click.command(cls=StudyScript)
@click.argument("folders", nargs=-1, required=True, type=click.Path(exists=True, file_okay=False, path_type=Path))
def main(folders: tuple[Path, ...]) -> None:
    """Draw the pictures of scored batches anew from the score.json in their FOLDERS."""
    for folder in folders:
        report = read_json(folder / "score.json", BlindError, "score")
        with understanding(folder / "score.json", "score of a blind batch"):
            lines = [line for line in report["lines"] if line["kind"] == "single"]
            written = drawn(report, [(line["gap_in_scatter"], line["right"]) for line in lines], usable_folder(folder))
        for path in written:
            click.echo(path)


if __name__ == "__main__":
    main()
