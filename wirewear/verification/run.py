"""All reference problems in turn.

A ball on a flat, pressed and in partial slip, and a barrel on a flat: blocks held at their backs and sides.

What their size makes of approach and displacement is read from their compliances, as of wires.
"""

from collections.abc import Callable

from geometry import BlockGeometry
from solvers import Holder
from wirewear import reference
from wirewear.verification import hertz, partial_slip
from wirewear.verification.interior import interior_rows
from wirewear.verification.limits import limit_rows
from wirewear.verification.line_contact import line_contact_rows, stuck_line_rows
from wirewear.verification.line_surface import line_surface_rows
from wirewear.verification.partial_slip_run import partial_slip_run_rows
from wirewear.verification.rows import Level, Row
from wirewear.verification.sliding import book_keeping_rows, rig_loop_rows
from wirewear.verification.surface import surface_rows

#: A barrel's radius along its axis over that across; its contact is 2.4 times as long as wide.
_LONGER = 4.0
_SHARE = 0.7
_FLAT = (0.0, 0.0)


def _block(curvatures_per_mm: tuple[float, float], resolution: float) -> BlockGeometry:
    wire, flat = hertz.wire_geometry(resolution), curvatures_per_mm == _FLAT
    width, height = (4.0 * hertz.RADIUS_mm, 4.0 * hertz.RADIUS_mm) if flat else (0.6 * hertz.RADIUS_mm, hertz.RADIUS_mm)
    size, patch = (width, width, height), (wire.axial, wire.transverse)
    return BlockGeometry(*curvatures_per_mm, *size, *patch, 0.2 * width, None, wire.layering)


def block_rows(level: Level) -> tuple[Row, ...]:
    """Peak pressure, approach and semi-axes of both; compliance, stick radius and energy of the ball's."""
    resolution, load = level.hertz_resolutions[-1], hertz.LOAD_N * level.enlarged**3
    ball_shape, barrel_shape = (1.0 / hertz.RADIUS_mm,) * 2, (1.0 / (_LONGER * hertz.RADIUS_mm), 1.0 / hertz.RADIUS_mm)
    flat = hertz.condensed(_block(_FLAT, resolution))
    rows: list[Row] = []
    for name, shape, share in (("Ball on flat", ball_shape, 1.0), ("Barrel on flat", barrel_shape, 0.4)):
        body = hertz.condensed(_block(shape, resolution))
        exact = reference.hertz_bodies(share * load, _FLAT, shape, 0.0, first=hertz.STEEL, second=hertz.STEEL)
        rows += hertz.pressed_rows(name, flat, body, exact, 0.0, level)
    ball = hertz.condensed(_block(ball_shape, resolution))
    bulk = sum(hertz.bulk_compliance(body, 0, hertz.CONTACT_RADIUS_mm * level.enlarged) for body in (flat, ball))
    modulus = reference.tangential_contact_modulus(hertz.STEEL, hertz.STEEL)
    slip = reference.partial_slip_point(load, partial_slip.FRICTION, hertz.CONTACT_RADIUS_mm * level.enlarged, modulus)
    problem = hertz.crossed(flat, ball, Holder(load), friction=partial_slip.FRICTION, angle_deg=0.0)
    return (
        *rows,
        *partial_slip.sliding_rows(problem, slip, bulk, ball, level, (_SHARE,), "Ball on flat, partial slip"),
    )


#: A family of problems: what it is called, and its rows at a level.
Family = tuple[str, Callable[[Level], tuple[Row, ...]]]

FAMILIES: tuple[Family, ...] = (
    ("Hertz contact on three meshes", hertz.hertz_rows),
    ("elliptic contact", hertz.ellipse_rows),
    ("ball and barrel on flat", block_rows),
    ("line contact in plane strain", line_contact_rows),
    ("stuck line contact in plane strain", stuck_line_rows),
    ("stresses inside the bodies", interior_rows),
    ("tension at the contact's edge", surface_rows),
    ("tension at a line contact's edge", line_surface_rows),
    ("partial slip", partial_slip.partial_slip_rows),
    ("wear under partial slip", partial_slip.partial_slip_wear_rows),
    ("a whole run in partial slip", partial_slip_run_rows),
    ("loop behind the rig's spring", rig_loop_rows),
    ("wear and energy book-keeping", book_keeping_rows),
    ("pressures of a worn line contact", partial_slip.worn_pressure_rows),
    ("limits, symmetries and units", limit_rows),
)


def _unwatched(title: str, done: int, of: int) -> None:
    """Nobody looks."""


def verify(
    level: Level, started: Callable[[str, int, int], None] = _unwatched, families: tuple[Family, ...] | None = None
) -> tuple[Row, ...]:
    """Rows of the families, all of them by default.

    `started` is told a family's title, how many are done and how many there are.

    Raises:
        SolverError: a problem could not be solved at all.
    """
    chosen = FAMILIES if families is None else families
    rows: list[Row] = []
    for done, (title, solve) in enumerate(chosen):
        started(title, done, len(chosen))
        rows += solve(level)
    return tuple(rows)
