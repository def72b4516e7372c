"""Results of a run: loops, scars, evolution over the cycles, the record of how they were computed, and the result file.

A module of this package is imported when one of its names is first used.
"""

from typing import TYPE_CHECKING

from geometry.lazy import loaded_late
from wirewear.base.kinds import POSITIONS

if TYPE_CHECKING:
    from wirewear.base.files import RESULT_FILE_NAME
    from wirewear.results.contact_forces import ContactForces, largest_mean_pressure_MPa, largest_means
    from wirewear.results.evolution import (
        BULK_WORK,
        COLUMN_MEANINGS,
        EVOLUTION_COLUMNS,
        LATER_COLUMNS,
        OVER_YIELD,
        PLASTIC_VOLUME,
        PLASTIC_WORK,
        PRESSURE_LENGTH,
        Evolution,
    )
    from wirewear.results.hdf5 import read_result, read_results, write_result
    from wirewear.results.scar import BODIES, Scar
    from wirewear.results.values import (
        BORNE,
        BORNE_IS,
        ELASTIC_LAYERS,
        LAYERS_OF_BODIES,
        PLAY_TRAVEL,
        SPRING_TRAVEL,
        Loop,
        RunResult,
        age_at,
        read_loops,
        sensor_of,
    )

__all__ = [
    "BODIES", "BORNE", "BORNE_IS", "BULK_WORK", "COLUMN_MEANINGS", "ELASTIC_LAYERS", "EVOLUTION_COLUMNS",
    "LATER_COLUMNS", "LAYERS_OF_BODIES", "OVER_YIELD", "PLASTIC_VOLUME", "PLASTIC_WORK", "PLAY_TRAVEL", "POSITIONS",
    "PRESSURE_LENGTH", "RESULT_FILE_NAME", "SPRING_TRAVEL",
    "ContactForces", "Evolution", "Loop", "RunResult", "Scar", "age_at", "largest_mean_pressure_MPa",
    "largest_means", "read_loops", "read_result", "read_results", "sensor_of", "write_result",
]  # fmt: skip

__getattr__ = loaded_late(__name__)
