"""Crossed-wire fretting tests in 3D finite elements: contact, friction, wear and the compliance of the rig.

This package is the only one to import: ``geometry`` and ``solvers`` beneath it are its parts. What it offers is loaded
when it is first asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from wirewear.base.siblings import require_own_siblings

require_own_siblings()

if TYPE_CHECKING:
    from wirewear import effects, reference
    from wirewear.base.errors import RecordError, ResultError, RunError, SensorError, StudyError, WirewearError
    from wirewear.faces.life import lives
    from wirewear.faces.looking import Run, read_result, read_results
    from wirewear.faces.running import Record, load, read_record, run, run_variants
    from wirewear.loops.sensor import LoopSignals, Sensor, SensorNoise, sensor_held_stroke
    from wirewear.records import ExperimentRecord, check_record, record_of_result, write_record
    from wirewear.results import Evolution, Loop, RunResult, Scar, largest_mean_pressure_MPa, write_result
    from wirewear.simulation import run_study
    from wirewear.study import Study, load_study, parse_study

    __version__: str

__all__ = [
    "Evolution", "ExperimentRecord", "Loop", "LoopSignals", "Record", "RecordError", "ResultError", "Run", "RunError",
    "RunResult", "Scar", "Sensor", "SensorError", "SensorNoise", "Study", "StudyError", "WirewearError", "__version__",
    "check_record", "effects", "largest_mean_pressure_MPa", "lives", "load", "load_study", "parse_study", "read_record",
    "read_result", "read_results", "record_of_result", "reference", "run", "run_study", "run_variants",
    "sensor_held_stroke", "write_record", "write_result",
]  # fmt: skip

_loaded = import_module("geometry.late").loaded_late(__name__)  # Only now is it known whose `geometry` that is.


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("wirewear")
    return _loaded(name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
