"""The score as one HTML page that needs no other file."""

from __future__ import annotations

import base64
from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wirewear.blind.scoring.judging import Judgement
from wirewear.blind.scoring.table import aim_rows, share_text, words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KINDS = (
    ("none", "without a gap"),
    ("single", "with one effect"),
    ("pair", "with two effects"),
    ("outside", "with an effect of no library"),
    ("left_out", "with an effect that was left out of the library"),
)
TEMPLATE = Path(__file__).with_name("page.html")
DOTS_PER_INCH = 130


def score_page(report: Mapping[str, Any], judgements: Sequence[Judgement]) -> str:
    """The page of a score."""
    import jinja2

    from wirewear.blind.scoring.pictures import confusion_picture, overview_picture

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    environment.filters["share"] = share_text
    environment.filters["number"] = lambda value, digits=3: "–" if value is None else f"{value:.{digits}g}"
    environment.filters["words"] = words
    template = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    return template.render(
        report=report,
        aims=aim_rows(report),
        kinds=KINDS,
        overview=_png(lambda: overview_picture(report, judgements)),
        confusion=_png(lambda: confusion_picture(report["confusion"])),
        judgements=judgements,
    )


def _png(draw: Callable[[], Figure]) -> str:
    from wirewear.pictures.style import styled

    target = BytesIO()
    with styled():
        draw().savefig(target, format="png", dpi=DOTS_PER_INCH)
    return base64.b64encode(target.getvalue()).decode("ascii")
