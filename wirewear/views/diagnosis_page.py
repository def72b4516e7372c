"""The diagnosis as one HTML page that needs no other file, and as ten lines of text."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from wirewear.base import frame
from wirewear.base.errors import ResultError, counted, unit_of, words_of
from wirewear.base.reading import with_checksum
from wirewear.base.writing import finite, json_text, write_text, writing
from wirewear.views.diagnosis_values import program
from wirewear.views.diagnosis_wording import next_measurement, parameters_told, plain, share, steps, told, worth_telling

if TYPE_CHECKING:
    from wirewear.views.diagnosis_values import Diagnosis
    from wirewear.views.diagnosis_wording import Diagnosed

TEMPLATE = Path(__file__).with_name("diagnosis.html")
JSON_FILE_NAME, REPORT_FILE_NAME = "diagnosis.json", "report.html"

#: Of each verdict the heading, and whether the summary is coloured as good, open or bad.
VERDICTS = {
    "no_gap": ("No gap", "good"), "explained": ("Gap explained", ""),
    "ambiguous": ("Gap with several possible causes", "open"), "unexplained": ("Gap without a known cause", "bad"),
}  # fmt: skip


def write_diagnosis(diagnosed: Diagnosed, folder: Path) -> list[Path]:
    """Write diagnosis.json and report.html; return their paths. Raises ResultError if they cannot be written."""
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

    diagnosis, found = diagnosed.diagnosis, diagnosed.search
    loops = shown.loops(diagnosed)
    filters = {"plain": plain, "told": told, "parameters": parameters_told, "share": share, "with_unit": _with_unit}
    values = {
        "d": diagnosis,
        "diagnosed": diagnosed,
        "said": VERDICTS[diagnosis.verdict],
        "map": shown.gap_map(diagnosed),
        "zones": shown.zone_bars(diagnosed),
        "likely": worth_telling(diagnosis)[:5],
        "gaps": shown.gap_bars(diagnosed),
        "steps": steps(diagnosis),
        "of_scar": bool(loops["sections"]) and shown.shows_in_scar(diagnosed),
        "next": next_measurement(diagnosis),
        "sections": loops["sections"],
        "data": frame.embedded(loops),
        "script": frame.script(frame.HERE / "charts.js", TEMPLATE.with_name("diagnosis.js")),
        "fits": sorted((found.none, *found.singles, *found.pairs), key=lambda one: -one.log_evidence)[:15],
        "program": program(),
    }
    return frame.rendered(TEMPLATE, values, filters)


def _with_unit(name: str) -> str:
    """For example: slip amplitude [µm]."""
    percent = name.removesuffix("_percent")
    return f"{words_of(percent)} [{unit_of(name) if percent == name else '%'}]"


def ten_lines(diagnosis: Diagnosis) -> str:
    """The answer for a terminal: the sentence of the page, and what stands under it there."""
    lines = [f"{diagnosis.record}: {diagnosis.sentence}"]
    for one in worth_telling(diagnosis)[:3]:
        values = "; ".join(filter(None, map(parameters_told, one.causes)))
        lines.append(f"  {share(one.probability)}: {one.words}{f': {values}' if values else ''}")
    if diagnosis.verdict != "no_gap":
        places = [f"  where: {one.text} ({share(one.share)} of the gap)" for one in diagnosis.where[:2]]
        lines += places or ["  where: no zone alone is beyond chance, many together are"]
        gap = diagnosis.shrink
        shrink, low, high = (round(one, 2) + 0.0 for one in (gap.shrink, *gap.interval95))
        lines.append(
            f"  gap {gap.before:.2f} → {gap.after:.2f} scatters (floor {gap.floor:.2f}); shrink {shrink:.0%} "
            f"({low:.0%} to {high:.0%}) on {', '.join(map(counted, gap.held_out)) or 'all'}"
        )
    lines += [f"  {what}: {text}" for what, text in steps(diagnosis)]
    if diagnosis.undetectable:
        lines.append(f"  could not be seen here: {', '.join(plain(name) for name in diagnosis.undetectable)}")
    return "\n".join(lines[:10])
