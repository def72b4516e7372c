"""The page of one run, or of the runs of a study's variants side by side, in one file: of wires or of line contacts."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from wirewear.errors import ResultError
from wirewear.files import write_text, writing
from wirewear.planar.results import PlanarResult
from wirewear.report.line_page import line_page
from wirewear.report.run_page import run_page
from wirewear.results import RunResult

PAGE_NAME = "report.html"


def write_page(results: Sequence[RunResult] | Sequence[PlanarResult], folder: Path) -> Path:
    """Write the page of runs, all of one study, as report.html into a folder and return its path.

    Raises:
        ResultError: no run has measured a cycle yet, or the page cannot be written.
    """
    lines = [one for one in results if isinstance(one, PlanarResult)]
    text = line_page(lines) if lines else run_page([one for one in results if isinstance(one, RunResult)])
    with writing(ResultError, f"cannot write the page to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return write_text(folder / PAGE_NAME, text)
