"""Families of distortions: low-rank spaces of what a cause outside the library may do at each seam.

The force channel, the displacement channel and the holder are the same throughout a test; what the contact, the load
and the surfaces do may change from cycle to cycle, by a Gaussian process over the logarithm of the cycles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.profile_shapes import MIDDLE_AND_FLANKS, aside, aside_third, middle, widened, worn
from wirewear.diagnosis.infer.shapes import (
    Branches,
    Shape,
    displacement_after_play,
    displacement_behind,
    displacement_read,
    force_after_play,
    force_read,
    loaded,
    resisting,
    stiffening,
    yielding,
)
from wirewear.diagnosis.infer.shapes_in_time import giving_late, leaking, ringing
from wirewear.diagnosis.model.setup import Array
from wirewear.effects import Seam

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


@dataclass(frozen=True, eq=False)
class Family:
    """Distortions of one kind at one seam.

    Attributes:
        seam: where they enter.
        name: what they are, for people.
        shapes: of a loop, each with a size of its own; empty for what changes in time.
        column: of the chain, where it changes in time; empty for shapes.
        scale: unit of what is added to the column: "" multiplies it, "compliance" is amplitude over plateau force,
            "force" that force.
        develops: whether its sizes may change over the cycles.
        allowed: log evidence that friction laws and solvers were seen to lend it beside known effects.
        instead: sets of shapes that it may have instead of these, each as likely.
        counts: whether it speaks for a cause outside the library; else it names one that others speak for, as nothing
            that solvers lend it was learned.
    """

    seam: Seam
    name: str
    shapes: tuple[Shape, ...] = ()
    column: str = ""
    scale: str = ""
    develops: bool = False
    allowed: float = 0.0
    instead: tuple[tuple[Shape, ...], ...] = ()
    counts: bool = True


def _odd(u: Array) -> Array:
    return np.asarray(u**3 - u)


def _cubic(u: Array) -> Array:
    return np.asarray(u**3)


def _odd_fifth(u: Array) -> Array:
    return np.asarray(u**5 - u**3)


def _even(u: Array) -> Array:
    return np.asarray(u**2 - 1.0)


def _even_fourth(u: Array) -> Array:
    return np.asarray(u**4 - u**2)


def _bowl(b: Branches) -> Array:
    return np.asarray(b.place**2 - 1.0 / 3.0)


def _bowl_fourth(b: Branches) -> Array:
    return np.asarray(b.place**4 - 0.2)


def _direction(b: Branches) -> Array:
    """+1 on the branch towards +x, −1 on the other."""
    return np.broadcast_to(np.array([1.0, -1.0])[None, :, None], b.place.shape)


#: Places fixed to the rig: x over the amplitude.
def _tilt(b: Branches) -> Array:
    return np.asarray(_direction(b) * b.place)


def _tilt_third(b: Branches) -> Array:
    return np.asarray(_direction(b) * b.place**3)


def _uphill(b: Branches) -> Array:
    return b.place


def _uphill_third(b: Branches) -> Array:
    return np.asarray(b.place**3)


def _uphill_fifth(b: Branches) -> Array:
    return np.asarray(b.place**5)


def _sided(b: Branches) -> Array:
    return np.asarray(_direction(b) * b.place**2)


def _later(b: Branches) -> Array:
    """The sine of twice the phase of a harmonic drive: more in the second half of either stroke."""
    return np.asarray(b.place * np.sqrt(np.maximum(1.0 - b.place**2, 0.0)))


def _fast(b: Branches) -> Array:
    """The speed of a harmonic drive over its largest, with its sign."""
    return np.asarray(_direction(b) * np.sqrt(np.maximum(1.0 - b.place**2, 0.0)))


def _behind(u: Branches) -> Array:
    return np.asarray(-np.maximum(1.0 - u.place**2, 0.0))


def _since(length: float) -> Shape:
    return resisting(lambda b: np.asarray(np.exp(-b.slid / length)))


def _turning(length: float) -> Shape:
    return loaded(lambda b: np.asarray(_direction(b) * (1.0 - 2.0 * np.exp(-b.slid / length))))


#: All of them. What the library holds (a gain, a compliance, an offset of friction) lies in none.
FAMILIES: tuple[Family, ...] = (
    Family(
        Seam.SENSOR,
        "distortion of the force channel, odd in Q",
        (force_read(_odd), force_read(_odd_fifth)),
        # A cell that saturates is right at small forces: it reads plateaus lower, stick branches bent, and nothing else
        # of a lower friction. Shapes that leave the plateaus where they are see a small part of that.
        instead=((force_read(_cubic),),),
    ),
    Family(Seam.SENSOR, "distortion of the force channel, even in Q", (force_read(_even), force_read(_even_fourth))),
    Family(
        Seam.SENSOR,
        "distortion of the displacement channel, odd in the displacement",
        (displacement_read(_odd), displacement_read(_odd_fifth)),
        allowed=SOLVERS,
    ),
    Family(
        Seam.SENSOR,
        "distortion of the displacement channel, even in the displacement",
        (displacement_read(_even), displacement_read(_even_fourth)),
    ),
    Family(Seam.SENSOR, "force channel that comes after the force by a play", (force_after_play(),)),
    Family(
        Seam.SENSOR,
        "displacement channel that comes after the motion by a play",
        (displacement_after_play(held=True), displacement_after_play(held=False)),
    ),
    Family(Seam.SENSOR, "gain of the displacement channel that changes over the test", column="gain"),
    Family(Seam.SENSOR, "zero of the force channel that changes over the test", column="force_zero_N", scale="force"),
    Family(
        Seam.HOLDER,
        "holder that slips, with hysteresis",
        tuple(yielding(at) for at in RELEASES),
        allowed=MICRO_SLIP,
    ),
    Family(
        Seam.HOLDER,
        "holder that stiffens or softens under the force, alike in both directions",
        (stiffening(),),
    ),
    Family(
        Seam.HOLDER,
        "holder whose compliance changes over the test",
        column="compliance_um_per_N",
        scale="compliance",
    ),
    Family(
        Seam.CONTACT,
        "friction that differs along the stroke, alike on both sides of its middle",
        (resisting(_bowl), resisting(_bowl_fourth)),
        develops=True,
    ),
    Family(
        Seam.CONTACT,
        "friction that differs along the stroke from one side to the other",
        (resisting(_tilt), resisting(_tilt_third)),
        develops=True,
        allowed=WALLS,
    ),
    Family(
        Seam.CONTACT,
        "friction that passes after each reversal",
        tuple(map(_since, LENGTHS)),
        develops=True,
        allowed=SOLVERS,
    ),
    Family(Seam.CONTACT, "friction that changes over the test", column="friction"),
    Family(
        Seam.LOADING,
        "load that differs along the stroke, alike on both sides of its middle",
        (loaded(_bowl), loaded(_bowl_fourth)),
    ),
    Family(
        Seam.LOADING,
        "load that differs along the stroke from one side to the other",
        (loaded(_tilt), loaded(_tilt_third)),
    ),
    Family(Seam.LOADING, "load that changes over the test", column="load_N"),
    Family(
        Seam.SPECIMENS,
        "force that follows the place, as slopes of a surface make it",
        (resisting(_uphill), resisting(_uphill_third), resisting(_uphill_fifth), resisting(_sided)),
        develops=True,
        allowed=WALLS,
    ),
    Family(Seam.WEAR, "wear that goes faster and slower over the test", column="wear_um3_per_mJ"),
    Family(
        Seam.SENSOR,
        "force channel that leaks, as charge does",
        (leaking(LEAK),),
        allowed=WALLS,
        counts=False,
    ),
    Family(
        Seam.SENSOR,
        "force channel that rings",
        ringing(RINGS[0], DAMPING),
        instead=tuple(ringing(at, DAMPING) for at in RINGS[1:]),
        allowed=SOLVERS,
        counts=False,
    ),
    Family(
        Seam.SENSOR,
        "displacement channel that gives way late under the force",
        tuple(map(giving_late, LATE)),
        allowed=SOLVERS,
        counts=False,
    ),
    Family(
        Seam.SENSOR,
        "displacement channel behind the motion, most in mid-stroke",
        (displacement_behind(_behind),),
        allowed=SOLVERS,
        counts=False,
    ),
    Family(
        Seam.LOADING,
        "load that swings in time with the drive",
        (loaded(_bowl), loaded(_later), loaded(_fast)),
        allowed=WALLS,
        counts=False,
    ),
    Family(
        Seam.LOADING,
        "load that is more in one direction of motion than in the other",
        tuple(map(_turning, LENGTHS)),
        counts=False,
    ),
)


#: Those of the profiles that line contacts leave.
PROFILE_FAMILIES: tuple[Family, ...] = (
    Family(Seam.WEAR, MIDDLE_AND_FLANKS, (worn(middle(0.4)), worn(middle(0.2)))),
    Family(Seam.WEAR, "wear that differs from one side of the scar to the other", (worn(aside), worn(aside_third))),
    Family(Seam.SPECIMENS, "scar of another width than the worn material makes", (widened,)),
)
