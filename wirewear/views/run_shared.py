"""What the pages of all runs have in common: the files that they are made of, and what stands on each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.results import RunResult
from wirewear.results.quality import health
from wirewear.views import run_wording as wording

HERE = Path(__file__).parent


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
