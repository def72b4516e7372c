"""The comparison as one HTML page that needs no other file."""

import base64
from collections.abc import Mapping
from pathlib import Path
from typing import Any

TEMPLATE = Path(__file__).with_name("page.html")

#: Pictures in the page's order, with their captions.
CAPTIONS = {
    "loops": "Loops at matching cycles, at equal phase. The band spans the repeats.",
    "evolution": "Evolution over the cycles. Friction measures are those of the loops above.",
    "scar_maps": "Scars after registration, all depths on one scale.",
    "scar_sections": "Sections of the registered scars through the origin.",
}


def page(report: Mapping[str, Any], pictures: Mapping[str, bytes]) -> str:
    """The page of a comparison's JSON report and its PNG pictures by name."""
    import jinja2

    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    environment.filters["number"] = _number
    environment.filters["hundredths"] = _hundredths
    template = environment.from_string(TEMPLATE.read_text(encoding="utf-8"))
    shown = [
        (name, CAPTIONS[name], base64.b64encode(pictures[name]).decode("ascii"))
        for name in CAPTIONS
        if name in pictures
    ]
    return template.render(report=report, pictures=shown)


def _number(value: float | None, digits: int = 4, sign: bool = False) -> str:
    """A figure of the table; a dash for what does not exist."""
    if value is None:
        return "–"
    return f"{value + 0.0:{'+' if sign else ''}.{digits}g}".replace("-", "−")


def _hundredths(value: float) -> str:
    """A figure with two decimals, without the minus of a rounded zero."""
    return f"{round(value, 2) + 0.0:.2f}".replace("-", "−")
