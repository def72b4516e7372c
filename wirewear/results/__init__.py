"""What a run leaves: loops, scars, evolution and the record of how they were made, and the file that holds them."""

from wirewear.results.contact_forces import POSITIONS, ContactForces
from wirewear.results.hdf5 import RESULT_FILE_NAME, read_result, read_results, write_result
from wirewear.results.mean_pressure import largest_mean_pressure_MPa
from wirewear.results.readings import age_at, read_loops, sensor_of
from wirewear.results.scar import Scar
from wirewear.results.values import EVOLUTION_COLUMNS, LATER_COLUMNS, Evolution, Loop, RunResult

__all__ = [
    "EVOLUTION_COLUMNS",
    "LATER_COLUMNS",
    "POSITIONS",
    "RESULT_FILE_NAME",
    "ContactForces",
    "Evolution",
    "Loop",
    "RunResult",
    "Scar",
    "age_at",
    "largest_mean_pressure_MPa",
    "read_loops",
    "read_result",
    "read_results",
    "sensor_of",
    "write_result",
]
