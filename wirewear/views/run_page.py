"""The page of one run, or of the runs of a study's variants side by side, in one file: of wires or of line contacts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.writing import json_text, write_text, writing
from wirewear.results import BODIES, RunResult
from wirewear.results.flat import named_for_users
from wirewear.results.quality import health, limit_of
from wirewear.views import run_wording as wording
from wirewear.views.run_data import numbers, of_any_kind, page_data
from wirewear.views.run_maps import TRANSITION

PAGE_NAME = "report.html"
HERE = Path(__file__).parent

#: Panels over the cycles: the name of each in the page, and its title.
PANELS = (
    ("amplitudes", "Displacement and slip amplitude"),
    ("energy", "Energy per cycle"),
    ("force", "Largest tangential force"),
    ("worn", "Deepest wear"),
    ("peak", "Largest pressure"),
    ("volume", "Worn area against friction energy"),
)


def runs_json(results: Sequence[RunResult]) -> str:
    """A list with an object for each run: its sentence, its last row of the evolution, its qualities and limits."""
    return json_text([_run(result) for result in results])


def _run(result: RunResult) -> dict[str, object]:
    columns = named_for_users(result, result.evolution)
    last = {name: float(column[-1]) for name, column in columns.items() if len(column)}
    return {
        "name": result.name,
        "variant": result.variant,
        "fidelity": result.fidelity,
        "status": result.status,
        "sentence": wording.sentence(result),
        "last": last,
        "quality": {
            name: {"worst": worst, "limit": limit_of(name), "sound": worst <= limit_of(name)}
            for name, worst in result.quality.items()
        },
    }


def run_page(results: Sequence[RunResult]) -> str:
    """The page of runs, all of one study.

    Raises:
        ResultError: none has measured a cycle yet.
    """
    shown = measured(results)
    special = {"results": shown, "balance": [wording.balance(result) for result in shown], "transition": TRANSITION}
    return page_of("run", results, [wording.sentence(result) for result in results], page_data(shown), special)


def line_page(results: Sequence[RunResult]) -> str:
    """The page of runs, all of one study.

    Raises:
        ResultError: none has measured a cycle yet.
    """
    shown = measured(results)
    data = {"runs": [_line_run(result, index) for index, result in enumerate(shown)]}
    special = {"labels": [result.label for result in shown], "panels": PANELS}
    return page_of("line", results, [wording.sentence(result) for result in shown], data, special)


def _line_run(result: RunResult, index: int) -> dict[str, Any]:
    return of_any_kind(result, index) | {
        "profiles": [
            {"cycle": cycle} | {body: _profile(result, cycle, body) for body in BODIES}
            for cycle in result.scar_cycles()
        ],
    }


def _profile(result: RunResult, cycle: int, body: str) -> dict[str, list[float | None]]:
    scar = result.scar(cycle, body)
    columns = {
        "x_um": scar.axial_um,
        "depth_um": scar.depth_um,
        "pressure_MPa": scar.pressure_MPa,
        "slip_amplitude_um": 0.25 * scar.slip_distance_um,
    }
    return {name: numbers(column.ravel()) for name, column in columns.items()}


def measured(results: Sequence[RunResult]) -> list[RunResult]:
    """Those that have measured a cycle.

    Raises:
        ResultError: none has.
    """
    shown = [result for result in results if len(result.evolution["cycle"])]
    if not shown:
        raise ResultError("nothing is measured yet, so there is nothing to report")
    return shown


def page_of(
    kind: str,
    results: Sequence[RunResult],
    sentences: Sequence[str],
    data: Mapping[str, Any],
    special: Mapping[str, Any],
) -> str:
    """A page from `<kind>.html` and `<kind>.js`: what all pages of runs show, the embedded data, and what is special.

    Raises:
        ResultError: no run has measured a cycle yet.
    """
    shown = measured(results)
    drawn = [frame.HERE / name for name in ("charts.js", *(["surface.js"] if kind == "run" else []))]
    return frame.rendered(
        HERE / f"{kind}.html",
        {
            "name": shown[0].name,
            "fidelity": shown[0].fidelity,
            "sentences": sentences,
            "complete": all(result.status == "complete" for result in results),
            "health": health(shown),
            "study": [wording.settings_rows(result.study) for result in shown],
            "settings": [wording.settings_rows(result.settings) for result in shown],
            "data": frame.embedded(data),
            "script": frame.script(*drawn, HERE / "fretting_log.js", HERE / "slider.js", HERE / f"{kind}.js"),
            **special,
        },
    )


def write_page(results: Sequence[RunResult], folder: Path) -> Path:
    """Write the page of runs, all of one study, as report.html into a folder and return its path.

    Raises:
        ResultError: no run has measured a cycle yet, or the page cannot be written.
    """
    text = line_page(results) if results[0].length_mm else run_page(results)
    with writing(ResultError, f"cannot write the page to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return write_text(folder / PAGE_NAME, text)
