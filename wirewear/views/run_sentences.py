"""What runs came to, in sentences for the command and as JSON for programs: as on their page, with the same limits."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from wirewear.base.interchange import json_text
from wirewear.planar.results import PlanarResult
from wirewear.results import RunResult
from wirewear.results.quality import limit_of
from wirewear.views import run_wording as wording
from wirewear.views.line_page import sentence as sentence_of_line

AnyResult = RunResult | PlanarResult

_SENTENCES: dict[str, Callable[[Any], str]] = {"crossed-wires": wording.sentence, "line-contact": sentence_of_line}


def sentence_of(result: AnyResult) -> str:
    """What came out of a run of wires or of a line contact, as on its page."""
    return _SENTENCES[result.contact_kind](result)


def runs_json(results: Sequence[AnyResult]) -> str:
    """A list with an object for each run: its sentence, its last row of the evolution, its qualities and limits."""
    return json_text([_run(result) for result in results])


def _run(result: AnyResult) -> dict[str, object]:
    last = {name: float(column[-1]) for name, column in result.evolution.items() if len(column)}
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
