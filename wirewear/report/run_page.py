"""What stands on the page of a run of crossed wires."""

from __future__ import annotations

from collections.abc import Sequence

from wirewear.report import wording
from wirewear.report.data import page_data
from wirewear.report.maps import TRANSITION
from wirewear.report.shared import measured, page_of
from wirewear.results import RunResult


def run_page(results: Sequence[RunResult]) -> str:
    """The page of runs, all of one study.

    Raises:
        ResultError: none has measured a cycle yet.
    """
    shown = measured(results)
    special = {"results": shown, "balance": [wording.balance(result) for result in shown], "transition": TRANSITION}
    return page_of("run", results, [wording.sentence(result) for result in results], page_data(shown), special)
