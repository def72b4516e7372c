"""Crossed-wire fretting tests in 3D finite elements: contact, friction, wear and the compliance of the rig.

This package is the only one to import: ``geometry`` and ``solvers`` beneath it are its parts.
"""

from wirewear._siblings import require_own_siblings

require_own_siblings()

from importlib.metadata import version  # noqa: E402

from wirewear import effects, reference  # noqa: E402
from wirewear.errors import RecordError, ResultError, RunError, SensorError, StudyError, WirewearError  # noqa: E402
from wirewear.records import ExperimentRecord, check_record, read_record, record_of_result, write_record  # noqa: E402
from wirewear.results import Evolution, Loop, RunResult, Scar, read_result, read_results, write_result  # noqa: E402
from wirewear.sensor import LoopSignals, Sensor, SensorNoise, sensor_held_stroke  # noqa: E402
from wirewear.simulation import run_study  # noqa: E402
from wirewear.study import Study, load_study, parse_study  # noqa: E402

__version__ = version("wirewear")

__all__ = [
    "Evolution",
    "ExperimentRecord",
    "Loop",
    "LoopSignals",
    "RecordError",
    "ResultError",
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
    "load_study",
    "parse_study",
    "read_record",
    "read_result",
    "read_results",
    "record_of_result",
    "reference",
    "run_study",
    "sensor_held_stroke",
    "write_record",
    "write_result",
]
