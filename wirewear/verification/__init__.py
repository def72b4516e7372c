"""Reference problems with closed-form solutions, solved one after another by ``wirewear verify``.

A family is a group of problems. Each function ..._rows solves one at a level (meshes and tolerances) and returns rows,
each of which compares one computed quantity with its closed form.
"""

from collections.abc import Callable

from wirewear.verification.conforming import pin_rows, taper_rows
from wirewear.verification.hertz import ellipse_rows, hertz_rows
from wirewear.verification.interior import interior_rows, surface_rows
from wirewear.verification.line_contact import bulk_rows, line_contact_rows, line_surface_rows, stuck_line_rows
from wirewear.verification.metals import metal_rows
from wirewear.verification.near_zone import near_zone_rows
from wirewear.verification.partial_slip import partial_slip_rows, partial_slip_wear_rows, worn_pressure_rows
from wirewear.verification.partial_slip_run import block_rows, held_force_rows, partial_slip_run_rows
from wirewear.verification.rows import FULL, QUICK, Level, Row, table, write_json
from wirewear.verification.sliding import book_keeping_rows, limit_rows, rig_loop_rows
from wirewear.verification.yielding import yielding_rows

__all__ = ["FULL", "QUICK", "Level", "Row", "table", "verify", "write_json"]

#: A family of problems: what it is called, and its rows at a level.
Family = tuple[str, Callable[[Level], tuple[Row, ...]]]

FAMILIES: tuple[Family, ...] = (
    ("Hertz contact on three meshes", hertz_rows),
    ("elliptic contact", ellipse_rows),
    ("balls, barrels and crossed cylinders", block_rows),
    ("line contact in plane strain", line_contact_rows),
    ("stuck line contact in plane strain", stuck_line_rows),
    ("a pin in a bore", pin_rows),
    ("a taper pushed into its hub", taper_rows),
    ("stresses inside the bodies", interior_rows),
    ("tension at the contact's edge", surface_rows),
    ("tension at a line contact's edge", line_surface_rows),
    ("bulk stress under a line contact", bulk_rows),
    ("partial slip", partial_slip_rows),
    ("wear under partial slip", partial_slip_wear_rows),
    ("a whole run in partial slip", partial_slip_run_rows),
    ("a run under a held force in partial slip", held_force_rows),
    ("loop behind the rig's spring", rig_loop_rows),
    ("wear and energy book-keeping", book_keeping_rows),
    ("pressures of a worn line contact", worn_pressure_rows),
    ("bodies that yield", yielding_rows),
    ("bars, a beam and a sphere of metal that flows", metal_rows),
    ("metal that flows beneath a contact", near_zone_rows),
    ("limits, symmetries and units", limit_rows),
)


def _unwatched(title: str, done: int, of: int) -> None:
    """Ignore the progress."""


def verify(
    level: Level, started: Callable[[str, int, int], None] = _unwatched, families: tuple[Family, ...] | None = None
) -> tuple[Row, ...]:
    """The rows of the given families at a level; None for all families. started: called before each family with its
    title, the number of families done and their total number. Raises SolverError if a problem cannot be solved.
    """
    chosen = FAMILIES if families is None else families
    rows: list[Row] = []
    for done, (title, solve) in enumerate(chosen):
        started(title, done, len(chosen))
        rows += solve(level)
    return tuple(rows)
