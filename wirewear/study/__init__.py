"""What a study's TOML file may hold, and how it is read.

What it offers is loaded when it is first asked for: the command line lists the levels of fidelity, and reads no study.
"""

from typing import TYPE_CHECKING

from geometry.late import loaded_late
from wirewear.study.fidelity import FIDELITIES

if TYPE_CHECKING:
    from wirewear.study.any_study import AnyStudy
    from wirewear.study.bodies import Body
    from wirewear.study.study import LineStudy, Study, load_study, parse_study, study_from_tables
    from wirewear.study.tables import FidelitySettings

__all__ = [
    "FIDELITIES", "AnyStudy", "Body", "FidelitySettings", "LineStudy", "Study", "load_study", "parse_study",
    "study_from_tables",
]  # fmt: skip

__getattr__ = loaded_late(__name__)
