"""The diagnosis as one HTML page that needs no other file, and as ten lines of text."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.quantity import counted, unit_of, words_of
from wirewear.base.reading import with_checksum
from wirewear.base.writing import finite, json_text, write_text, writing
from wirewear.views.diagnosis_values import program
from wirewear.views.diagnosis_wording import first_sentence, plain, told, with_unit

if TYPE_CHECKING:
    from wirewear.views.diagnosis_values import Diagnosis
    from wirewear.views.diagnosis_wording import Diagnosed

TEMPLATE = Path(__file__).with_name("diagnosis.html")
JSON_FILE_NAME, REPORT_FILE_NAME = "diagnosis.json", "report.html"

VERDICTS = {
    "no_gap": "No gap",
    "explained": "Gap explained",
    "ambiguous": "Gap with several possible causes",
    "unexplained": "Gap without a known cause",
}

#: Verdicts whose summary is coloured as good, open or bad.
MOODS = {"no_gap": "good", "explained": "", "ambiguous": "open", "unexplained": "bad"}


def write_diagnosis(diagnosed: Diagnosed, folder: Path) -> list[Path]:
    """Write diagnosis.json and report.html; return their paths.

    Raises:
        ResultError: they cannot be written.
    """
    texts = {
        JSON_FILE_NAME: json_text(with_checksum(finite(diagnosed.diagnosis.to_json())), indent=1) + "\n",
        REPORT_FILE_NAME: page(diagnosed),
    }
    with writing(ResultError, f"cannot write the diagnosis to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return [write_text(folder / name, text) for name, text in texts.items()]


def page(diagnosed: Diagnosed) -> str:
    """The page of a diagnosis, to be opened in any browser."""
    from wirewear.views import diagnosis_shown as shown

    weighed, found = diagnosed.weighed, diagnosed.search
    best = max((one.log_evidence for one in (found.none, *found.singles, *found.pairs)), default=0.0)
    first, rest = first_sentence(diagnosed.diagnosis.sentence)
    loops = shown.loops(diagnosed)
    fits = sorted((found.none, *found.singles, *found.pairs), key=lambda one: -one.log_evidence)
    return frame.rendered(
        TEMPLATE,
        {
            "d": diagnosed.diagnosis,
            "heading": VERDICTS[diagnosed.diagnosis.verdict],
            "mood": MOODS.get(diagnosed.diagnosis.verdict, "open"),
            "map": shown.gap_map(diagnosed),
            "causes": shown.cause_bars(diagnosed),
            "gaps": shown.gap_bars(diagnosed),
            "loops_are": bool(loops["cycles"]),
            "contact": diagnosed.setup.contact_kind,
            "first": first,
            "rest": rest,
            "next": shown.next_measurement(diagnosed.diagnosis),
            "sections": loops["sections"],
            "data": frame.embedded(loops),
            "script": frame.script(frame.HERE / "charts.js", TEMPLATE.with_name("diagnosis.js")),
            "fits": [
                (
                    " and ".join(one.names) or "none",
                    one.distance2,
                    one.log_evidence - best,
                    weighed.probabilities.get(one.names, 0.0),
                )
                for one in fits
            ],
            "observables": len(found.problem.layout),
            "scatter": found.covariance.scatter,
            "repeats": diagnosed.observed.repeats,
            "program": program(),
        },
        {
            "plain": plain,
            "told": told,
            "with_unit": lambda pair: with_unit(*pair),
            "share": _share,
            "plain_with_unit": _plain_with_unit,
        },
    )


def _plain_with_unit(name: str) -> str:
    """For example: slip amplitude [µm]."""
    if name.endswith("_percent"):
        return f"{name.removesuffix('_percent').replace('_', ' ')} [%]"
    return f"{words_of(name)} [{unit_of(name)}]"


def _share(value: float) -> str:
    return "less than 1 %" if value < 0.01 else f"{100.0 * value:.0f} %"


def ten_lines(diagnosis: Diagnosis) -> str:
    """The answer for a terminal."""
    shrink = diagnosis.shrink
    lines = [f"{diagnosis.record}: {VERDICTS[diagnosis.verdict].lower()}", diagnosis.sentence]
    lines += [f"  where: {finding.text} ({_share(finding.share)} of the gap)" for finding in diagnosis.where[:2]] or [
        "  where: nowhere beyond scatter"
    ]
    lines += [f"  behaves like ({one.probability:.0%}): {one.family}" for one in diagnosis.resembles[:2]]
    for cause in diagnosis.causes[:3]:
        values = ", ".join(with_unit(name, estimate) for name, estimate in cause.parameters.items())
        joint = " (acting together with another)" if cause.joint else ""
        lines.append(f"  {cause.probability:4.0%}  {told(cause)}{joint}{': ' if values else ''}{values}")
    if diagnosis.verdict != "no_gap":
        low, high = shrink.interval95
        lines.append(
            f"  gap {shrink.before:.2f} → {shrink.after:.2f} scatters (floor {shrink.floor:.2f}); shrink "
            f"{shrink.shrink:.0%} ({low:.0%} to {high:.0%}) on {', '.join(map(counted, shrink.held_out)) or 'all'}"
        )
        for members in diagnosis.equivalent[:1]:
            lines.append(f"  cannot be told apart here: {', '.join(plain(name) for name in members)}")
        if diagnosis.next_measurement is not None:
            lines.append(f"  measure next: {diagnosis.next_measurement['what']}")
    if diagnosis.undetectable:
        lines.append(f"  could not be seen here: {', '.join(plain(name) for name in diagnosis.undetectable)}")
    return "\n".join(lines[:10])
