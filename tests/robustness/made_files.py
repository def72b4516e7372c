"""Files that wirewear reads back, made again in a folder: results, a checkpoint, records, an answer and its log."""

from collections.abc import Mapping
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any

from studies.blind.scoring.history import logged_run
from tests.robustness.commands import FLAT, STUDY
from wirewear import parse_study, record_of_result, run_study, write_record
from wirewear.kinds import load_any_study
from wirewear.simulation import Moment, Observer
from wirewear.test import LineStudy

#: A diagnosis, as short as one can be.
ANSWER: Mapping[str, Any] = {
    "format": 1,
    "verdict": "explained",
    "gap": {"shrink": 0.9, "confirmed": {"shrink": 0.8}},
    "causes": [
        {"effect": "free_play", "probability": 0.9, "parameters": {"gap_um": {"value": 3.0, "interval95": [2.0, 4.0]}}}
    ],
    "equivalent": [["free_play", "none"]],
    "undetectable": [],
}


def made_runs(base: Path) -> None:
    """A result, a checkpoint of a run that was stopped, a planar result, and a record of each."""
    wires = parse_study(STUDY, "study.toml")

    class Stopping(Observer):
        def moved(self, _moment: Moment) -> None:
            if (base / "stopped" / "checkpoint.h5").exists():
                raise KeyboardInterrupt

    (result,) = run_study(wires, fidelity="quick", output=base / "result")
    with suppress(KeyboardInterrupt):
        run_study(wires, fidelity="quick", output=base / "stopped", observer_of=lambda _: nullcontext(Stopping()))
    (base / "flat.toml").write_text(FLAT, encoding="utf-8")
    flat = load_any_study(base / "flat.toml")
    if isinstance(flat, LineStudy):
        (line,) = run_study(flat, fidelity="quick", output=base / "planar")
        write_record(base / "line_record", record_of_result(line, 5.0, samples=100, repeats=2, seed=1))
    write_record(base / "record", record_of_result(result, samples=100, repeats=2, seed=1))


def scored(folder: Path) -> object:
    """The log of scored runs, appended to."""
    entry = logged_run(folder / "batch", folder / "diagnoses", {}, folder / "batch.key")
    return entry["run"], entry["previous_sha256"], entry["different_diagnoses_before"]
