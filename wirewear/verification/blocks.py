"""A ball on a flat, pressed and in partial slip, and a barrel on a flat: blocks held at their backs and sides.

What their size makes of approach and displacement is read from their compliances, as of wires.
"""

from geometry import BlockGeometry
from solvers import Holder
from wirewear import reference
from wirewear.verification.hertz import pressed_rows
from wirewear.verification.partial_slip import FRICTION, sliding_rows
from wirewear.verification.rows import Level, Row
from wirewear.verification.wires import (
    LOAD_N,
    STEEL,
    CONTACT_RADIUS_mm,
    RADIUS_mm,
    bulk_compliance,
    condensed,
    crossed,
    wire_geometry,
)

#: A barrel's radius along its axis over that across; its contact is 2.4 times as long as wide.
_LONGER = 4.0
_SHARE = 0.7
_FLAT = (0.0, 0.0)


def _block(curvatures_per_mm: tuple[float, float], resolution: float) -> BlockGeometry:
    wire, flat = wire_geometry(resolution), curvatures_per_mm == _FLAT
    width, height = (4.0 * RADIUS_mm, 4.0 * RADIUS_mm) if flat else (0.6 * RADIUS_mm, RADIUS_mm)
    size, patch = (width, width, height), (wire.axial, wire.transverse)
    return BlockGeometry(*curvatures_per_mm, *size, *patch, 0.2 * width, None, wire.layering)


def block_rows(level: Level) -> tuple[Row, ...]:
    """Peak pressure, approach and semi-axes of both; compliance, stick radius and energy of the ball's."""
    resolution, load = level.hertz_resolutions[-1], LOAD_N * level.enlarged**3
    ball_shape, barrel_shape = (1.0 / RADIUS_mm,) * 2, (1.0 / (_LONGER * RADIUS_mm), 1.0 / RADIUS_mm)
    flat = condensed(_block(_FLAT, resolution))
    rows: list[Row] = []
    for name, shape, share in (("Ball on flat", ball_shape, 1.0), ("Barrel on flat", barrel_shape, 0.4)):
        body = condensed(_block(shape, resolution))
        exact = reference.hertz_bodies(share * load, _FLAT, shape, 0.0, first=STEEL, second=STEEL)
        rows += pressed_rows(name, flat, body, exact, 0.0, level)
    ball = condensed(_block(ball_shape, resolution))
    bulk = sum(bulk_compliance(body, 0, CONTACT_RADIUS_mm * level.enlarged) for body in (flat, ball))
    modulus = reference.tangential_contact_modulus(STEEL, STEEL)
    slip = reference.partial_slip_point(load, FRICTION, CONTACT_RADIUS_mm * level.enlarged, modulus)
    problem = crossed(flat, ball, Holder(load), friction=FRICTION, angle_deg=0.0)
    return (*rows, *sliding_rows(problem, slip, bulk, ball, level, (_SHARE,), "Ball on flat, partial slip"))
