"""Contacts that share a load: a table, a picture and a page."""

from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.frame import figure as written
from wirewear.base.writing import json_text, write_csv, write_text, writing
from wirewear.pictures.style import new_figure, save, svg, variant_style
from wirewear.sweeps.shared_load import SharedLoad

_HEADINGS = {
    "contact": "contact",
    "at_mm": "at [mm]",
    "normal_load_N": "load [N]",
    "approach_um": "approach [µm]",
    "worn_depth_um": "worn depth [µm]",
    "worn_volume_mm3": "worn volume [mm³]",
}


def sentence(shared: SharedLoad) -> str:
    """Sentences on the shares of the load in N at the start and at the end, and on how well they are known."""
    first, last = ("; ".join(written(each) for each in shared.load_N[:, block]) for block in (0, -1))
    then = f", after {shared.ends[-1]} cycles {last}" if len(shared.ends) > 1 else ""
    # Clamps carry, too.
    carry = "share" if not shared.test.span.clamped_at_mm else "and clamps share"
    return (
        f"{len(shared.load_N)} contacts {carry} {written(shared.test.load_N)} N: at first {first} N{then}. Runs and "
        f"wire agree within {100.0 * shared.change:.2g} % of the mean load after {shared.rounds} rounds."
    )


def contacts_json(shared: SharedLoad) -> str:
    """JSON object with the sentences, and a row for each contact and block of cycles; null is the approach of an open
    contact.
    """
    return json_text({"sentence": sentence(shared), "contacts": shared.rows})


def write_contacts(shared: SharedLoad, folder: Path) -> Path:
    """Write contacts.csv, loads.png and contacts.html; return the path of the last. Raises ResultError if the folder
    cannot be written to.
    """
    drawn = partial(draw_loads, shared)
    rows = shared.rows
    with writing(ResultError, f"cannot write to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        write_csv(folder / "contacts.csv", rows)
        save(drawn, folder / "loads.png")
        values = {
            "name": shared.test.study.name,
            "summary": sentence(shared),
            "picture": frame.inline_svg(svg(drawn), "loads"),
            "headings": list(_HEADINGS.values()),
            "table": [
                (label, [written(row[key]) for key in _HEADINGS])
                for label, row in zip(shared.labels, rows[len(shared.ends) - 1 :: len(shared.ends)], strict=True)
            ],
        }
        return write_text(folder / "contacts.html", frame.rendered(Path(__file__).parent / "contacts.html", values))


def draw_loads(shared: SharedLoad) -> Figure:
    """Figure of the load of each contact over the cycles, constant within each block."""
    figure = new_figure(3.2)
    axes = figure.subplots()
    starts = [0, *shared.ends]
    for number, (own, loads) in enumerate(zip(shared.test.contacts, shared.load_N, strict=True)):
        axes.stairs(loads, starts, baseline=None, label=f"at {own.at_mm:g} mm", **variant_style(number))
    axes.set(xlabel="cycles", ylabel="normal load [N]")
    axes.legend(frameon=False)
    return figure
