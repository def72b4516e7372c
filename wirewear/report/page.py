"""The page of one run, or of the runs of a study's variants side by side, in one file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from wirewear.errors import ResultError
from wirewear.files import write_text, writing
from wirewear.page import frame
from wirewear.report import wording
from wirewear.report.data import page_data
from wirewear.report.maps import TRANSITION
from wirewear.results import RunResult

HERE = Path(__file__).parent
PAGE_NAME = "report.html"

#: What the pages of all runs share.
RUN_SCRIPTS = (HERE / "fretting_log.js", HERE / "slider.js")


def write_page(results: Sequence[RunResult], folder: Path) -> Path:
    """Write the page of runs as report.html into a folder and return its path.

    Raises:
        ResultError: no run has measured a cycle yet, or the page cannot be written.
    """
    text = run_page(results)
    with writing(ResultError, f"cannot write the page to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return write_text(folder / PAGE_NAME, text)


def run_page(results: Sequence[RunResult]) -> str:
    """The page of runs, all of one study.

    Raises:
        ResultError: none has measured a cycle yet.
    """
    shown = [result for result in results if result.evolution["cycle"].size]
    if not shown:
        raise ResultError("nothing is measured yet, so there is nothing to report")
    return frame.rendered(
        HERE / "run.html",
        {
            "name": shown[0].name,
            "fidelity": shown[0].fidelity,
            "results": shown,
            "sentences": [wording.sentence(result) for result in results],
            "complete": all(result.status == "complete" for result in results),
            "health": wording.health(shown),
            "balance": [wording.balance(result) for result in shown],
            "study": [wording.settings_rows(result.study) for result in shown],
            "settings": [wording.settings_rows(result.settings) for result in shown],
            "transition": TRANSITION,
            "data": frame.embedded(page_data(shown)),
            "script": frame.script(frame.HERE / "charts.js", frame.HERE / "surface.js", *RUN_SCRIPTS, HERE / "run.js"),
        },
    )
