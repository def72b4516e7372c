"""One run of a sweep: what it is asked, and the row that it leaves."""

from __future__ import annotations

import resource
import time
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from wirewear.base.errors import WirewearError
from wirewear.base.folders import prepared_folder
from wirewear.results import PRESSURE_LENGTH, RESULT_FILE_NAME, RunResult, write_result
from wirewear.simulation import simulate
from wirewear.study import Study
from wirewear.sweeps.sweep import varied

#: Columns of the evolution that a row holds of the last cycle, and with FIRST before it of the first.
AT_END = (
    "max_tangential_force_N",
    "dissipated_energy_mJ",
    "slip_amplitude_um",
    "accumulated_energy_J",
    "max_depth_moving_um",
    "max_depth_fixed_um",
    "contact_half_width_um",
    "max_pressure_MPa",
    "mid_stroke_pressure_MPa",
    "max_mean_pressure_MPa",
    "mid_stroke_mean_pressure_MPa",
)
AT_START = ("max_tangential_force_N", "dissipated_energy_mJ", "slip_amplitude_um", "max_pressure_MPa")
FIRST = "first_"
VOLUME = "worn_volume_mm3"
QUALITY = ("mirror_error", "energy_against_loops")

#: Figures that tell how a run was made and measured, and not what came out.
TECHNICAL = (*QUALITY, PRESSURE_LENGTH)

#: All figures of a row, in the table's order.
FIGURES = (*AT_END, VOLUME, *(f"{FIRST}{name}" for name in AT_START), *TECHNICAL)


@dataclass(frozen=True)
class SweepRow:
    """A run that came to its end: its figures, or the sentence that says why there are none.

    `cpu_s` and `peak_bytes` are what it took; they differ from machine to machine.
    """

    number: int
    figures: dict[str, float | None] | None
    failure: str = ""
    cpu_s: float = 0.0
    peak_bytes: int = 0

    @property
    def failed(self) -> bool:
        """Whether it left no figures."""
        return self.figures is None

    def to_json(self) -> dict[str, Any]:
        """The row as plain values."""
        return dict(vars(self))


def run_case(study: Study, values: Mapping[str, float], fidelity: str, number: int, results: Path | None) -> SweepRow:
    """Simulate the study with these values of its keys; with `results`, the result file is left there in a folder.

    What goes wrong with the study or its simulation is in the row.
    """
    begun = time.process_time()
    figures, failure = None, ""
    try:
        result = simulate(varied(study, values), fidelity=fidelity)
        figures = figures_of(result)
        if results is not None:
            write_result(prepared_folder(results / f"{number:06d}") / RESULT_FILE_NAME, result)
    except WirewearError as problem:
        failure = str(problem)
    except MemoryError:
        failure = "there was not enough memory"
    peak = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return SweepRow(number, figures, failure, time.process_time() - begun, peak)


def figures_of(result: RunResult) -> dict[str, float | None]:
    """The figures of a finished run; None for what it does not have."""
    evolution = result.evolution
    last = {name: float(evolution[name][-1]) for name in AT_END}
    first = {f"{FIRST}{name}": float(evolution[name][0]) for name in AT_START}
    volume = sum(float(evolution[f"worn_volume_{wire}_mm3"][-1]) for wire in ("moving", "fixed"))
    quality = {name: float(result.quality.get(name, float("nan"))) for name in QUALITY}
    length = {PRESSURE_LENGTH: float(result.settings[PRESSURE_LENGTH])}
    found = {**last, VOLUME: volume, **first, **quality, **length}
    return {name: found[name] if isfinite(found[name]) else None for name in FIGURES}
