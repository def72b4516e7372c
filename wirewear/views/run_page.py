"""The page of one run, or of the runs of a study's variants side by side, in one file: of wires or of line contacts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from wirewear.base.errors import ResultError
from wirewear.base.writing import json_text, write_text, writing
from wirewear.results import RunResult
from wirewear.results.flat import named_for_users
from wirewear.results.quality import limit_of
from wirewear.views import run_wording as wording
from wirewear.views.line_page import line_page
from wirewear.views.line_page import sentence as sentence_of_line
from wirewear.views.run_data import page_data
from wirewear.views.run_maps import TRANSITION
from wirewear.views.run_shared import measured, page_of

_SENTENCES: dict[str, Callable[[Any], str]] = {"crossed-wires": wording.sentence, "line-contact": sentence_of_line}


def sentence_of(result: RunResult) -> str:
    """What came out of a run of wires or of a line contact, as on its page."""
    return _SENTENCES[result.contact_kind](result)


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
        "sentence": sentence_of(result),
        "last": last,
        "quality": {
            name: {"worst": worst, "limit": limit_of(name), "sound": worst <= limit_of(name)}
            for name, worst in result.quality.items()
        },
    }


PAGE_NAME = "report.html"


def run_page(results: Sequence[RunResult]) -> str:
    """The page of runs, all of one study.

    Raises:
        ResultError: none has measured a cycle yet.
    """
    shown = measured(results)
    special = {"results": shown, "balance": [wording.balance(result) for result in shown], "transition": TRANSITION}
    return page_of("run", results, [wording.sentence(result) for result in results], page_data(shown), special)


#: Pages by the kind of contact.
_PAGES: dict[str, Callable[[Any], str]] = {"crossed-wires": run_page, "line-contact": line_page}


def write_page(results: Sequence[RunResult], folder: Path) -> Path:
    """Write the page of runs, all of one study, as report.html into a folder and return its path.

    Raises:
        ResultError: no run has measured a cycle yet, or the page cannot be written.
    """
    text = _PAGES[results[0].contact_kind](results)
    with writing(ResultError, f"cannot write the page to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return write_text(folder / PAGE_NAME, text)
