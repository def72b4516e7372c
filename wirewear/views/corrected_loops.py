"""Corrected loops as tables: what was measured beside what it is without drift, lag, play and compliance."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from geometry.arrays import Array
from wirewear.base.errors import ResultError
from wirewear.base.writing import write_csv, writing
from wirewear.loops import LoopError
from wirewear.loops.corrected import CorrectedLoop, corrected_loop
from wirewear.records.importing.loop_sources import SampledLoop
from wirewear.views.loops_report import AnalysedLoop

LOOPS, CORRECTIONS = "corrected_loops.csv", "corrections.csv"


def write_corrected(analysed: Sequence[AnalysedLoop], folder: Path) -> list[Path]:
    """Write corrected_loops.csv, a row a sample, and corrections.csv, a row a loop, into a folder, and return their
    paths. Loops that cannot be analysed are left out. Raises LoopError if that are all; ResultError if a file cannot be
    written.
    """
    known = [item.loop for item in analysed if item.figures is not None]
    if not known:
        raise LoopError("no loop can be analysed, so that there is none to correct")
    samples, corrections = list[dict[str, object]](), list[dict[str, object]]()
    for loop in known:
        found = corrected_loop(*_channels(loop), time_s=loop.time_s, cycle=loop.cycle if loop.numbered else None)
        samples += _samples(loop, found)
        corrections.append(_corrections(loop, found))
    with writing(ResultError, f"cannot write the corrected loops to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return [write_csv(folder / LOOPS, samples), write_csv(folder / CORRECTIONS, corrections)]


def _channels(loop: SampledLoop) -> tuple[Array, Array, Array | float | None]:
    return loop.displacement_um, loop.tangential_force_N, loop.normal_load_N


def _samples(loop: SampledLoop, found: CorrectedLoop) -> Iterator[dict[str, object]]:
    count = loop.displacement_um.size
    load = loop.normal_load_N
    columns = {
        "time_s": None if loop.time_s is None else loop.time_s,
        "displacement_um": loop.displacement_um,
        "tangential_force_N": loop.tangential_force_N,
        "normal_force_N": None if load is None else np.broadcast_to(load, count),
        "corrected_displacement_um": found.displacement_um,
        "corrected_force_N": found.force_N,
        "corrected_slip_um": found.slip_um,
    }
    for i in range(count):
        yield {
            "repeat": loop.repeat,
            "cycle": loop.cycle,
            "sample": i,
            **{name: None if own is None or np.isnan(own[i]) else float(own[i]) for name, own in columns.items()},
            **{f"gave_{name}": int(own[i]) for name, own in found.used.items()},
        }


def _corrections(loop: SampledLoop, found: CorrectedLoop) -> dict[str, object]:
    return {
        "repeat": loop.repeat,
        "cycle": loop.cycle,
        "drift_um": found.drift_um,
        "lag_samples": found.lag_samples,
        "sensor_lean_um_per_N": found.lean_um_per_N,
        "free_play_um": found.free_play_um,
        "compliance_um_per_N": found.compliance_um_per_N,
        "force_zero_N": found.force_zero_N,
        "left_out_samples": len(found.figures.outlier_samples),
    }
