"""Tests as studies state them: the tables of keys of a study's TOML file, how they are read and checked, and studies as
values.

A module of this package is imported when one of its names is first used.
"""

from typing import TYPE_CHECKING

from geometry.lazy import loaded_late
from wirewear.test.fidelity import FIDELITIES

if TYPE_CHECKING:
    from wirewear.test.any_study import AnyStudy
    from wirewear.test.bodies import Body
    from wirewear.test.conditions import FidelitySettings
    from wirewear.test.study import LineStudy, Study, load_study, parse_study, study_from_tables

__all__ = [
    "FIDELITIES", "AnyStudy", "Body", "FidelitySettings", "LineStudy", "Study", "load_study", "parse_study",
    "study_from_tables",
]  # fmt: skip

__getattr__ = loaded_late(__name__)
