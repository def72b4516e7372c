"""Crossed-wire fretting tests in 3D finite elements: contact, friction, wear and the compliance of the rig.

This package is the only one to import: ``geometry`` and ``solvers`` beneath it are its parts. What it offers is loaded
when it is first asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from wirewear._siblings import require_own_siblings

require_own_siblings()

if TYPE_CHECKING:
    from wirewear import effects, reference
    from wirewear.errors import RecordError, ResultError, RunError, SensorError, StudyError, WirewearError
    from wirewear.interactive import (
        Record,
        RecordOfLines,
        Run,
        load,
        read_line_record,
        read_record,
        read_result,
        read_results,
        run,
        run_variants,
    )
    from wirewear.records import ExperimentRecord, check_record, record_of_result, write_record
    from wirewear.results import Evolution, Loop, RunResult, Scar, largest_mean_pressure_MPa, write_result
    from wirewear.sensor import LoopSignals, Sensor, SensorNoise, sensor_held_stroke
    from wirewear.simulation import run_study
    from wirewear.study import Study, load_study, parse_study

    __version__: str

#: The room of each name.
_HOMES = {
    "errors": ("RecordError", "ResultError", "RunError", "SensorError", "StudyError", "WirewearError"),
    "interactive": (
        "Record",
        "RecordOfLines",
        "Run",
        "load",
        "read_line_record",
        "read_record",
        "read_result",
        "read_results",
        "run",
        "run_variants",
    ),
    "records": ("ExperimentRecord", "check_record", "record_of_result", "write_record"),
    "results": ("Evolution", "Loop", "RunResult", "Scar", "largest_mean_pressure_MPa", "write_result"),
    "sensor": ("LoopSignals", "Sensor", "SensorNoise", "sensor_held_stroke"),
    "simulation": ("run_study",),
    "study": ("Study", "load_study", "parse_study"),
}

__all__ = [
    "Evolution",
    "ExperimentRecord",
    "Loop",
    "LoopSignals",
    "Record",
    "RecordError",
    "RecordOfLines",
    "ResultError",
    "Run",
    "RunError",
    "RunResult",
    "Scar",
    "Sensor",
    "SensorError",
    "SensorNoise",
    "Study",
    "StudyError",
    "WirewearError",
    "__version__",
    "check_record",
    "effects",
    "largest_mean_pressure_MPa",
    "load",
    "load_study",
    "parse_study",
    "read_line_record",
    "read_record",
    "read_result",
    "read_results",
    "record_of_result",
    "reference",
    "run",
    "run_study",
    "run_variants",
    "sensor_held_stroke",
    "write_record",
    "write_result",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("wirewear")
    if name in ("effects", "reference"):
        return import_module(f"wirewear.{name}")
    for room, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"wirewear.{room}"), name)
    raise AttributeError(f"module 'wirewear' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
