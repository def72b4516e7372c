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
    behind,
    between_ends,
    bump,
    cubic,
    displacement_after_play,
    displacement_behind,
    displacement_read,
    fast,
    force_after_play,
    force_beside,
    force_read,
    in_travel,
    later,
    loaded,
    on_the_rig,
    opening,
    resisting,
    since,
    stiffening,
    turning,
    yielding,
)
from wirewear.diagnosis.infer.shapes_in_time import averaged, giving_late, leaking, rattling, ringing, slewing
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.line_wear import EDGE
from wirewear.effects import Seam

MIDDLE_AND_FLANKS = "wear that differs between the middle of the scar and its flanks"

_KNOWN = constants("infer.families")

#: Lengths of what passes after a reversal, shares of the amplitude of which the contact has slid.
LENGTHS = _KNOWN.numbers("lengths")

#: Friction that creeps before it slides, as Dahl's does, resembles a holder that slips: by up to so much log evidence.
MICRO_SLIP = _KNOWN.number("micro_slip")

#: What solvers differ in beside the learned sizes resembles two families more than others: by up to so much of it.
SOLVERS = _KNOWN.number("solvers")

#: What a mesh's own walls lend to families that are odd in the place.
WALLS = _KNOWN.number("walls")

#: A charge leaks with a time constant of a cycle over 2π times this; a cell rings at such harmonics of the drive.
LEAK, RINGS, DAMPING = _KNOWN.number("leak"), _KNOWN.numbers("rings"), _KNOWN.number("damping")

#: Phases of the drive by which a joint gives way late.
LATE = _KNOWN.numbers("late")

#: Shares of the plateau force at which a holder lets go.
RELEASES = _KNOWN.numbers("releases")

#: Shares of a cycle over which a logger averages; shares of the force's own fastest turn that a channel follows.
AVERAGED, SLEWED = _KNOWN.numbers("averaged"), _KNOWN.numbers("slewed")

SPOTTED = "friction that differs at one place of the stroke"

#: Places of a spot along the stroke and its width, over the amplitude.
SPOTS, SPOT = _KNOWN.numbers("spots"), _KNOWN.number("spot")

#: A load rattles at such harmonics of the drive, and fades within this share of a cycle.
RATTLES, RATTLED = _KNOWN.numbers("rattles"), _KNOWN.number("rattled")

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
        allowed=SOLVERS,
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
    _holder("holder that slips, with hysteresis", tuple(yielding(at) for at in RELEASES), allowed=MICRO_SLIP),
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
        allowed=WALLS,
    ),
    _contact("friction that passes after each reversal", tuple(map(since, LENGTHS)), develops=True, allowed=SOLVERS),
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
        allowed=WALLS,
    ),
    Family(Seam.WEAR, "wear that goes faster and slower over the test", column="wear_um3_per_mJ"),
    _sensor("force channel that leaks, as charge does", (leaking(LEAK),), allowed=WALLS, counts=False),
    Family.one_of(Seam.SENSOR, "force channel that rings", (ringing(at, DAMPING) for at in RINGS), allowed=SOLVERS),
    _sensor(
        "displacement channel that gives way late under the force",
        tuple(map(giving_late, LATE)),
        allowed=SOLVERS,
        counts=False,
    ),
    _sensor(
        "displacement channel behind the motion, most in mid-stroke",
        (displacement_behind(behind),),
        allowed=SOLVERS,
        counts=False,
    ),
    _loading(
        "load that swings in time with the drive",
        (loaded(in_travel(2)), loaded(later), loaded(fast)),
        allowed=WALLS,
        counts=False,
    ),
    _loading(
        "load that is more in one direction of motion than in the other", tuple(map(turning, LENGTHS)), counts=False
    ),
    _sensor(
        "force that the cell bears beside the contact, as a spring or a mass makes it",
        (force_beside(in_travel(1)),),
        allowed=WALLS,
        counts=False,
    ),
    Family.one_of(
        Seam.SENSOR,
        "logger that averages over a time, so that corners are round",
        ((averaged(window),) for window in AVERAGED),
        allowed=SOLVERS,
        step=1.0,
    ),
    Family.one_of(
        Seam.SENSOR,
        "force channel that follows no faster than a rate",
        ((slewing(share),) for share in SLEWED),
        allowed=SOLVERS,
        step=1.0,
    ),
    Family.one_of(
        Seam.HOLDER, "holder that opens beyond a force, without hysteresis", ((opening(at),) for at in RELEASES)
    ),
    Family.one_of(Seam.CONTACT, SPOTTED, ((resisting(bump(at, SPOT)),) for at in SPOTS), develops=True, allowed=WALLS),
    Family.one_of(
        Seam.LOADING, "load that rattles after each reversal", (rattling(at, RATTLED) for at in RATTLES), allowed=WALLS
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
