"""Reference problems with closed forms, run through the solver: ``wirewear verify``."""

from wirewear.verification.level import FULL, QUICK, Level
from wirewear.verification.rows import Row
from wirewear.verification.run import verify
from wirewear.verification.table import table, write_json

__all__ = ["FULL", "QUICK", "Level", "Row", "table", "verify", "write_json"]
