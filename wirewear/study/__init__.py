"""What a study's TOML file may hold, and how it is read."""

from wirewear.study.fidelity import FIDELITIES
from wirewear.study.reading import load_study, parse_study, study_from_tables
from wirewear.study.study import Study, Wire
from wirewear.study.tables import FidelitySettings

__all__ = [
    "FIDELITIES",
    "FidelitySettings",
    "Study",
    "Wire",
    "load_study",
    "parse_study",
    "study_from_tables",
]
