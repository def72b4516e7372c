"""The atlas on one page."""

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from studies.atlas.entry import Entry, Row
from studies.atlas.table import compared, sentence
from wirewear.base.frame import inline_svg, rendered
from wirewear.base.writing import write_text
from wirewear.pictures.style import GREY, VARIANT_COLOURS, new_figure, styled

WORST = 10
FLOOR, CEILING = 1e-4, 3.0  #: Relative errors are drawn between these.


def write_page(entries: Sequence[Entry], rows: Sequence[Row], fidelity: str, path: Path) -> Path:
    """Write the page of all entries: agreement, the worst misses, then entry by entry."""
    image = BytesIO()
    with styled():
        picture(rows).savefig(image, format="svg")
    values = {
        "summary": sentence(rows),
        "fidelity": fidelity,
        "worst": compared(rows)[:WORST],
        "picture": inline_svg(image.getvalue(), "errors"),
        "entries": [(entry, _rows_of(rows, entry)) for entry in entries],
    }
    return write_text(path, rendered(Path(__file__).parent / "page.html", values))


def _rows_of(rows: Sequence[Row], entry: Entry) -> list[Row]:
    """Figures of an entry that something was measured or predicted of."""
    return [row for row in rows if row.entry == entry.name and (row.measured is not None or row.predicted is not None)]


def picture(rows: Sequence[Row]) -> Figure:
    """Error of every figure, entry by entry; predictions apart from what was simulated."""
    names = list(dict.fromkeys(row.entry for row in compared(rows)))
    figure = new_figure(0.6 + 0.22 * len(names))
    axes = figure.subplots()
    for label, colour, predicted in (("simulated", VARIANT_COLOURS[0], False), ("predicted", VARIANT_COLOURS[1], True)):
        chosen = [row for row in compared(rows) if (row.predicted is not None) is predicted]
        errors = np.clip([abs(row.error or 0.0) for row in chosen], FLOOR, CEILING)
        places = [-names.index(row.entry) for row in chosen]
        axes.plot(errors, places, "o", color=colour, markersize=3.5, alpha=0.7, label=label)
    for row in compared(rows):
        axes.plot([row.tolerance], [-names.index(row.entry)], "|", color=GREY, markersize=9)
    axes.set_yticks([-place for place in range(len(names))], names)
    axes.set(xscale="log", xlabel="relative error (grey: tolerances)", ylim=(0.6 - len(names), 0.6))
    figure.legend(loc="outside right upper")
    return figure
