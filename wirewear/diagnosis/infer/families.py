"""Families of distortions: low-rank spaces of what a cause outside the library may do at each seam.

The force channel, the displacement channel and the holder are the same throughout a test; what the contact, the load
and the surfaces do may change from cycle to cycle, by a Gaussian process over the logarithm of the cycles.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.shapes import (
    Branches,
    Family,
    Shape,
    between_ends,
    cubic,
    displacement_after_play,
    displacement_read,
    fast,
    force_after_play,
    force_read,
    in_travel,
    later,
    loaded,
    on_the_rig,
    resisting,
    since,
    stiffening,
    yielding,
)
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.line_wear import EDGE
from wirewear.effects import Seam

MIDDLE_AND_FLANKS = "wear that differs between the middle of the scar and its flanks"

_KNOWN = constants("infer.families")

#: Lengths of what passes after a reversal, shares of the amplitude of which the contact has slid.
LENGTHS = _KNOWN.numbers("lengths")

#: What friction laws and solvers add to families that resemble them, in log evidence.
ADDED = _KNOWN.number("added")

#: Shares of the plateau force at which a holder lets go.
RELEASES = _KNOWN.numbers("releases")

_sensor, _holder, _contact, _loading = (
    partial(Family, seam) for seam in (Seam.SENSOR, Seam.HOLDER, Seam.CONTACT, Seam.LOADING)
)

#: All of them. What the library holds (a gain, a compliance, an offset of friction) lies in none.
FAMILIES: tuple[Family, ...] = (
    _sensor(
        "distortion of the force channel, odd in Q",
        (force_read(between_ends(3)), force_read(between_ends(5))),
        # A cell that saturates is right at small forces: it reads plateaus lower, stick branches bent, and nothing else
        # of a lower friction. Shapes that leave the plateaus where they are see a small part of that.
        instead=((force_read(cubic),),),
    ),
    _sensor("distortion of the force channel, even in Q", (force_read(between_ends(2)), force_read(between_ends(4)))),
    _sensor(
        "distortion of the displacement channel, odd in the displacement",
        (displacement_read(between_ends(3)), displacement_read(between_ends(5))),
        allowed=ADDED,
    ),
    _sensor(
        "distortion of the displacement channel, even in the displacement",
        (displacement_read(between_ends(2)), displacement_read(between_ends(4))),
    ),
    _sensor("force channel that comes after the force by a play", (force_after_play(),)),
    _sensor(
        "displacement channel that comes after the motion by a play",
        (displacement_after_play(held=True), displacement_after_play(held=False)),
    ),
    _sensor("gain of the displacement channel that changes over the test", column="gain"),
    _sensor("zero of the force channel that changes over the test", column="force_zero_N", scale="force"),
    _holder("holder that slips, with hysteresis", tuple(yielding(at) for at in RELEASES), allowed=ADDED),
    _holder("holder that stiffens or softens under the force, alike in both directions", (stiffening(),)),
    _holder("holder whose compliance changes over the test", column="compliance_um_per_N", scale="compliance"),
    _contact(
        "friction that differs along the stroke, alike on both sides of its middle",
        (resisting(in_travel(2)), resisting(in_travel(4))),
        develops=True,
    ),
    _contact(
        "friction that differs along the stroke from one side to the other",
        (resisting(on_the_rig(1)), resisting(on_the_rig(3))),
        develops=True,
        allowed=ADDED,
    ),
    _contact("friction that passes after each reversal", tuple(map(since, LENGTHS)), develops=True, allowed=ADDED),
    _contact("friction that changes over the test", column="friction"),
    _loading(
        "load that differs along the stroke, alike on both sides of its middle",
        (loaded(in_travel(2)), loaded(in_travel(4))),
    ),
    _loading(
        "load that differs along the stroke from one side to the other", (loaded(on_the_rig(1)), loaded(on_the_rig(3)))
    ),
    _loading("load that changes over the test", column="load_N"),
    Family(
        Seam.SPECIMENS,
        "force that follows the place, as slopes of a surface make it",
        (resisting(in_travel(1)), resisting(in_travel(3)), resisting(in_travel(5)), resisting(on_the_rig(2))),
        develops=True,
        allowed=ADDED,
    ),
    Family(Seam.WEAR, "wear that goes faster and slower over the test", column="wear_um3_per_mJ"),
    _loading(
        "load that swings in time with the drive",
        (loaded(in_travel(2)), loaded(later), loaded(fast)),
        allowed=ADDED,
        counts=False,
    ),
)


def worn(share: Callable[[Array], Array]) -> Shape:
    """Bodies that wear by a share f(x/w) of the largest depth more, w the scar's half-width."""

    def shape(b: Branches, size: float) -> LoopCourse:
        changed = {
            body: (x, depth + size * float(depth.max()) * share(x / half_width(x, depth)))
            for body, (x, depth) in b.course.profiles.items()
        }
        return replace(b.course, profiles=changed)

    return shape


def middle(width: float) -> Callable[[Array], Array]:
    """A bump in the middle, so wide."""
    return lambda u: np.asarray(np.exp(-((u / width) ** 2)))


def aside(power: int) -> Callable[[Array], Array]:
    """More on one side than on the other, by an odd power of the place; nothing beyond the scar."""
    return lambda u: np.asarray(u**power * np.maximum(1.0 - u**2, 0.0))


def widened(b: Branches, size: float) -> LoopCourse:
    """Scars that are wider by a share, of the same area."""
    changed = {
        body: (x, np.interp(x / (1.0 + size), x, depth) / (1.0 + size))
        for body, (x, depth) in b.course.profiles.items()
    }
    return replace(b.course, profiles=changed)


def half_width(x_um: Array, depth_um: Array) -> float:
    """Of a profile about zero."""
    over = np.flatnonzero(depth_um > EDGE * depth_um.max(initial=0.0))
    return max(float(np.abs(x_um[over]).max(initial=0.0)), 1e-6)


#: Those of the profiles that line contacts leave.
PROFILE_FAMILIES: tuple[Family, ...] = (
    Family(Seam.WEAR, MIDDLE_AND_FLANKS, (worn(middle(0.4)), worn(middle(0.2)))),
    Family(Seam.WEAR, "wear that differs from one side of the scar to the other", (worn(aside(1)), worn(aside(3)))),
    Family(Seam.SPECIMENS, "scar of another width than the worn material makes", (widened,)),
)
