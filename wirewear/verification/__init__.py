"""Reference problems with closed forms, run through the solver: ``wirewear verify``."""

from wirewear.verification.rows import FULL, QUICK, Level, Row, table, write_json
from wirewear.verification.run import verify

__all__ = ["FULL", "QUICK", "Level", "Row", "table", "verify", "write_json"]
