"""The score as one HTML page that needs no other file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from studies.blind.scoring.judging import Judgement
from studies.blind.scoring.table import aim_rows, share_text, words
from wirewear.base import frame

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
