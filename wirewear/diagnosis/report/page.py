"""The diagnosis as one HTML page that needs no other file, and as ten lines of text."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import TYPE_CHECKING

from wirewear.diagnosis.calibration import digest
from wirewear.diagnosis.report.wording import plain, with_unit
from wirewear.errors import ResultError
from wirewear.files import write_text, writing

if TYPE_CHECKING:
    from wirewear.diagnosis.report.diagnosed import Diagnosed
    from wirewear.diagnosis.report.values import Diagnosis

TEMPLATE = Path(__file__).with_name("report.html")
JSON_FILE_NAME, REPORT_FILE_NAME = "diagnosis.json", "report.html"

VERDICTS = {
    "no_gap": "No gap",
    "explained": "Gap explained",
    "ambiguous": "Gap with several possible causes",
    "unexplained": "Gap without a known cause",
}


def write_diagnosis(diagnosed: Diagnosed, folder: Path) -> list[Path]:
    """Write diagnosis.json and report.html; return their paths.

    Raises:
        ResultError: they cannot be written.
    """
    from wirewear.diagnosis.report.pictures import drawn

    texts = {
        JSON_FILE_NAME: json.dumps(diagnosed.diagnosis.to_json(), indent=1, ensure_ascii=False) + "\n",
        REPORT_FILE_NAME: page(diagnosed, drawn(diagnosed)),
    }
    with writing(ResultError, f"cannot write the diagnosis to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return [write_text(folder / name, text) for name, text in texts.items()]


def page(diagnosed: Diagnosed, pictures: dict[str, bytes]) -> str:
    """The page of a diagnosis and its PNG pictures by name."""
    import jinja2

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    environment.filters["plain"] = plain
    environment.filters["with_unit"] = lambda pair: with_unit(*pair)
    environment.filters["figure"] = _figure
    environment.filters["share"] = _share
    template = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    images = {name: base64.b64encode(data).decode("ascii") for name, data in pictures.items()}
    stated, found = diagnosed.weighed.stated, diagnosed.search
    best = max((one.log_evidence for one in (found.none, *found.singles, *found.pairs)), default=0.0)
    fits = sorted((found.none, *found.singles, *found.pairs), key=lambda one: -one.log_evidence)
    return template.render(
        d=diagnosed.diagnosis,
        heading=VERDICTS[diagnosed.diagnosis.verdict],
        pictures=images,
        fits=[
            (
                " and ".join(one.names) or "none",
                one.distance2,
                one.log_evidence - best,
                stated.probabilities.get(one.names, 0.0),
            )
            for one in fits
        ],
        observables=len(found.problem.layout),
        scatter=found.covariance.scatter,
        repeats=diagnosed.observed.repeats,
        calibration=digest(),
    )


def _figure(value: float | None, digits: int = 3) -> str:
    return "–" if value is None else f"{value + 0.0:.{digits}g}".replace("-", "−")


def _share(value: float) -> str:
    return "less than 1 %" if value < 0.01 else f"{100.0 * value:.0f} %"


def ten_lines(diagnosis: Diagnosis) -> str:
    """The answer for a terminal."""
    shrink = diagnosis.shrink
    lines = [f"{diagnosis.record}: {VERDICTS[diagnosis.verdict].lower()}", diagnosis.sentence]
    lines += [f"  where: {finding.text} ({_share(finding.share)} of the gap)" for finding in diagnosis.where[:2]] or [
        "  where: nowhere beyond scatter"
    ]
    for cause in diagnosis.causes[:3]:
        values = ", ".join(with_unit(name, estimate) for name, estimate in cause.parameters.items())
        joint = " (acting together with another)" if cause.joint else ""
        lines.append(f"  {cause.probability:4.0%}  {plain(cause.effect)}{joint}{': ' if values else ''}{values}")
    if diagnosis.verdict != "no_gap":
        low, high = shrink.interval95
        lines.append(
            f"  gap {shrink.before:.2f} → {shrink.after:.2f} scatters (floor {shrink.floor:.2f}); shrink "
            f"{shrink.shrink:.0%} ({low:.0%} to {high:.0%}) on {', '.join(f'{c:,}' for c in shrink.held_out) or 'all'}"
        )
        for members in diagnosis.equivalent[:1]:
            lines.append(f"  cannot be told apart here: {', '.join(plain(name) for name in members)}")
        if diagnosis.next_measurement is not None:
            lines.append(f"  measure next: {diagnosis.next_measurement['what']}")
    if diagnosis.undetectable:
        lines.append(f"  could not be seen here: {', '.join(plain(name) for name in diagnosis.undetectable)}")
    return "\n".join(lines[:10])
