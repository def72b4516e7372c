"""The files that a comparison leaves: a page, its pictures, and the table as CSV and JSON."""

from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from wirewear.comparison.comparison import RecordComparison
from wirewear.comparison.page import page
from wirewear.comparison.pictures import evolution_picture, loops_picture
from wirewear.comparison.scar_pictures import maps_picture, sections_picture
from wirewear.errors import RecordError
from wirewear.files import write_text, writing
from wirewear.files.interchange import json_text, write_csv
from wirewear.pictures.style import save, svg

TABLE_NAME, PAGE_NAME = "differences", "comparison.html"


def write_comparison(comparison: RecordComparison, folder: Path) -> list[Path]:
    """Write one self-contained HTML page, its pictures, and the table as CSV and JSON; return their paths.

    Raises:
        RecordError: the folder cannot be written.
    """
    drawings: dict[str, Callable[[], Figure]] = {
        "loops": partial(loops_picture, comparison.loops),
        "evolution": partial(evolution_picture, comparison.result, comparison.record, comparison.loops),
    }
    if comparison.scars:
        drawings["scar_maps"] = partial(maps_picture, comparison.scars)
        drawings["scar_sections"] = partial(sections_picture, comparison.scars)
    with writing(RecordError, f"cannot write the comparison to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        pictures = {name: save(draw, folder / f"{name}.png") for name, draw in drawings.items()}
        texts = {
            f"{TABLE_NAME}.json": json_text(comparison.to_json()),
            PAGE_NAME: page(comparison, svg(drawings["scar_maps"]) if comparison.scars else None),
        }
        for name, text in texts.items():
            write_text(folder / name, text)
        table = write_csv(folder / f"{TABLE_NAME}.csv", [asdict(row) for row in comparison.differences])
    return [folder / PAGE_NAME, table, folder / f"{TABLE_NAME}.json", *pictures.values()]
