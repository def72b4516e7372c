"""Families of distortions: low-rank spaces of what a cause outside the library may do at each seam.

A seam is a place in the chain from drive to sensors. The force channel, the displacement channel and the holder are the
same throughout a test; contact, load and surfaces may change from cycle to cycle, by a Gaussian process over the
logarithm of the cycles. A shape is how computed loops change under a distortion of given size: a size of 1 changes
forces by the plateau force, displacements by the amplitude. Branches (n, 2, m) are taken in their own direction: y is
the displacement and p the force in the direction of travel, so that both rise; u is a force or displacement over
plateau force or amplitude.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.surrogate.forward import PredictedLoops
from wirewear.diagnosis.surrogate.line_wear import EDGE
from wirewear.diagnosis.surrogate.loop_states import SINE, FastMotion
from wirewear.diagnosis.surrogate.sensed_loops import KNEE, SLIDING
from wirewear.effects import Seam

#: +1 on the branch towards +x, −1 on the other.
_DIRECTIONS = np.array([1.0, -1.0])[None, :, None]

MIDDLE_AND_FLANKS = "wear that differs between the middle of the scar and its flanks"
_KNOWN = constants("infer.families")

#: Lengths of what passes after a reversal, shares of the amplitude of which the contact has slid.
LENGTHS = _KNOWN.numbers("lengths")

#: What friction laws and solvers add to families that resemble them, in log evidence.
ADDED = _KNOWN.number("added")

#: Shares of the plateau force at which a holder lets go.
RELEASES = _KNOWN.numbers("releases")


@dataclass(frozen=True, eq=False)
class Family:
    """Distortions of one kind at one seam: combinations of shapes of loops, or a change of one column of the chain over
    the test.
    """

    seam: Seam  #: Where they enter.
    name: str  #: Description for readers.
    shapes: tuple[Shape, ...] = ()  #: Shapes, each with a size of its own; empty for changes over the test.
    column: str = ""  #: Column of the chain that changes over the test; empty for shapes.
    #: Unit of what is added to the column: "compliance" for amplitude over plateau force, "force" for the plateau
    #: force; "" if the column is multiplied by 1 + change.
    scale: str = ""
    develops: bool = False  #: Whether its sizes may change over the cycles.
    allowed: float = 0.0  #: Log evidence that friction laws and solvers alone add for it, which is subtracted.
    instead: tuple[tuple[Shape, ...], ...] = ()  #: Other sets of shapes that it may have, each as likely as `shapes`.
    #: False if it is only named and does not count as evidence for a cause outside the library, as what solvers add to
    #: it was not learned.
    counts: bool = True


@dataclass(frozen=True, eq=False)
class Branches:
    """Computed loops as branches (n, 2, m), with the units of distortions.

    loops: those without distortion. y_um, p_N: displacement and tangential force in the direction of travel.
    amplitude_um, force_N: amplitude and plateau force, which a distortion of size 1 has. motion: displacement of the
    drive over time.
    """

    loops: PredictedLoops
    y_um: Array
    p_N: Array
    amplitude_um: float
    force_N: float
    motion: FastMotion = SINE

    @classmethod
    def of(cls, loops: PredictedLoops, amplitude_um: float, force_N: float, motion: FastMotion = SINE) -> Branches:
        """Branches of computed loops; amplitude in µm, plateau force in N."""
        return cls(
            loops,
            _DIRECTIONS * loops.displacement_um,
            _DIRECTIONS * loops.tangential_force_N,
            amplitude_um,
            force_N,
            motion,
        )

    @property
    def place(self) -> Array:
        """Displacement over the amplitude (n, 2, m), in the direction of travel."""
        return self.y_um / self.amplitude_um

    @property
    def slid(self) -> Array:
        """Travel since the onset of sliding over the amplitude (n, 2, m); 0 before it."""
        return np.maximum(self.y_um - self.y_um[:, :, KNEE, None], 0.0) / self.amplitude_um

    def read_with(self, displacement_um: Array, force_N: Array) -> PredictedLoops:
        """The n loops with other readings, (n, 2, m) for both branches at m places each; displacements are centred
        between both tips.
        """
        tips = displacement_um.max(axis=(1, 2), keepdims=True) + displacement_um.min(axis=(1, 2), keepdims=True)
        return replace(self.loops, displacement_um=displacement_um - 0.5 * tips, tangential_force_N=force_N)

    def sliding_under(self, added_N: Array, load_share: Array | None = None) -> PredictedLoops:
        """The loops of a contact that resists sliding by `added_N` (n, 2, m) more, in the direction of travel.

        load_share: relative change (n, 2, m) of the normal force along with it; None for no change. The stick branch
        then begins where the other branch ends, rises to the new onset of sliding, and travels in proportion to its
        rise.
        """
        start = -added_N[:, ::-1, -1:]
        share = np.linspace(0.0, 1.0, SLIDING)
        added = added_N.copy()
        added[:, :, :SLIDING] = start + (added_N[:, :, KNEE, None] - start) * share
        p = self.p_N + added
        rise = self.p_N[:, :, KNEE] - self.p_N[:, :, 0]
        stretched = (p[:, :, KNEE] - p[:, :, 0]) / np.where(np.abs(rise) > 1e-9, rise, 1.0)
        y = self.y_um.copy()
        y[:, :, :SLIDING] = y[:, :, :1] + (y[:, :, :SLIDING] - y[:, :, :1]) * np.maximum(stretched, 0.0)[:, :, None]
        loops = self._along(y, p)
        if load_share is None:
            return loops
        return replace(loops, normal_force_N=loops.normal_force_N * (1.0 + load_share))

    def held_with(self, given_um: Array) -> PredictedLoops:
        """The loops of a holder that gives way by `given_um` (n, 2, m) more while the contact sticks, counted from each
        branch's first point; once it slides, forces and displacements are as before.
        """
        y = self.y_um.copy()
        y[:, :, :SLIDING] += given_um[:, :, :SLIDING] - given_um[:, :, :1]
        return self._along(y, self.p_N)

    def _along(self, y_um: Array, p_N: Array) -> PredictedLoops:
        # A later knee swallows the first places of the sliding part.
        forward = np.maximum.accumulate(y_um, axis=2)
        return replace(self.loops, displacement_um=_DIRECTIONS * forward, tangential_force_N=_DIRECTIONS * p_N)


#: A distortion: the loops of branches under so much of it.
Shape = Callable[[Branches, float], PredictedLoops]


def force_read(power: Callable[[Array], Array]) -> Shape:
    """Shape of a force channel that reads Q + size · Q* power(Q/Q*), with Q* the plateau force."""

    def shape(b: Branches, size: float) -> PredictedLoops:
        true = b.loops.tangential_force_N
        return b.read_with(b.loops.displacement_um, true + size * b.force_N * power(true / b.force_N))

    return shape


def displacement_read(power: Callable[[Array], Array]) -> Shape:
    """Shape of a displacement channel that reads δ + size · δa power(δ/δa), with δa the amplitude; power is 0 at ±1, as
    the drive holds the ends.
    """

    def shape(b: Branches, size: float) -> PredictedLoops:
        true = b.loops.displacement_um
        read = true + size * b.amplitude_um * power(true / b.amplitude_um)
        return b.read_with(read, b.loops.tangential_force_N)

    return shape


def resisting(share: Callable[[Branches], Array]) -> Shape:
    """Shape of a contact that resists sliding by size · share (n, 2, m) of the plateau force more."""
    return lambda b, size: b.sliding_under(size * b.force_N * share(b))


def loaded(share: Callable[[Branches], Array]) -> Shape:
    """Shape of a normal load that is higher by size · share (n, 2, m) of itself, and the friction force with it."""
    return lambda b, size: b.sliding_under(size * b.p_N * share(b), size * share(b))


def yielding(released: float) -> Shape:
    """Shape of a holder that slips: after a reversal, once the force has changed by 2 `released` times the plateau
    force, it gives way by size · amplitude per further plateau force.
    """

    def shape(b: Branches, size: float) -> PredictedLoops:
        held = released * b.force_N
        start = b.p_N[:, :, :1]
        swung = np.maximum(b.p_N - held, start + held)
        return b.held_with(size * b.amplitude_um / b.force_N * np.maximum.accumulate(swung, axis=2))

    return shape


def stiffening() -> Shape:
    """Shape of a holder that gives way by size · amplitude · (p/plateau force)³ in addition, alike in both
    directions.
    """

    def shape(b: Branches, size: float) -> PredictedLoops:
        return b.held_with(size * b.amplitude_um * (b.p_N / b.force_N) ** 3)

    return shape


def force_after_play() -> Shape:
    """Shape of a force channel with free play: after each reversal its reading rests until the play is taken up. The
    size is half the play over the plateau force.
    """

    def shape(b: Branches, size: float) -> PredictedLoops:
        half = size * b.force_N
        read = np.maximum(b.p_N - half, b.p_N[:, :, :1] + half)
        return b.read_with(b.loops.displacement_um, _DIRECTIONS * read)

    return shape


def displacement_after_play(*, held: bool) -> Shape:
    """Shape of a displacement channel with free play; the size is half the play over the amplitude. held: True if the
    drive holds the amplitude that is read, so that the true one is larger by what the play takes.
    """

    def shape(b: Branches, size: float) -> PredictedLoops:
        half = size * b.amplitude_um
        read = np.maximum(b.y_um - half, b.y_um[:, :, :1] + half)
        if held:
            read = read * b.amplitude_um / (b.amplitude_um - half)
        return b.read_with(_DIRECTIONS * read, b.loops.tangential_force_N)

    return shape


Share = Callable[[Branches], Array]


def cubic(u: Array) -> Array:
    """The third power of u, which hardly changes the middle of a range."""
    return np.asarray(u**3)


def between_ends(power: int) -> Callable[[Array], Array]:
    """A function of u that gives u^power − u^(power − 2), which is 0 at both ends, u = ±1."""
    return lambda u: np.asarray(u**power - u ** (power - 2))


def in_travel(power: int) -> Share:
    """A function of branches that gives u^power less its mean over the stroke, (n, 2, m), with u = `Branches.place`
    from −1 to 1. As added friction, an odd power acts against the motion at one end of each stroke and with it at the
    other.
    """
    mean = 1.0 / (power + 1.0) if power % 2 == 0 else 0.0
    return lambda b: np.asarray(b.place**power - mean)


def on_the_rig(power: int) -> Share:
    """A function of branches that gives u^power on the branch towards +x and −u^power on the other (n, 2, m), u =
    y/amplitude. As added friction it acts along a direction fixed in the rig: an odd power depends on the place along
    the stroke alone, an even one has opposite signs on both branches.
    """
    return lambda b: np.asarray(_DIRECTIONS * b.place**power)


def later(b: Branches) -> Array:
    """Sine of twice the phase of a sinusoidal drive (n, 2, m), from −1 to 1 along a branch: as added friction, larger
    in the second half of a stroke.
    """
    return np.asarray(b.place * np.sqrt(np.maximum(1.0 - b.place**2, 0.0)))


def fast(b: Branches) -> Array:
    """Speed of a sinusoidal drive over its largest (n, 2, m), positive on the branch towards +x."""
    return np.asarray(_DIRECTIONS * np.sqrt(np.maximum(1.0 - b.place**2, 0.0)))


def since(length: float) -> Shape:
    """Shape of added friction that decays as exp(−slid/length) after a reversal; length: over the amplitude."""
    return resisting(lambda b: np.asarray(np.exp(-b.slid / length)))


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


def deeper_profiles(share: Callable[[Array], Array]) -> Shape:
    """Shape of worn profiles that are deeper by size · share(x/w) of their largest depth, w the scar's half-width."""

    def shape(b: Branches, size: float) -> PredictedLoops:
        changed = {
            body: (x, depth + size * float(depth.max()) * share(x / half_width(x, depth)))
            for body, (x, depth) in b.loops.profiles.items()
        }
        return replace(b.loops, profiles=changed)

    return shape


def bump(width: float) -> Callable[[Array], Array]:
    """A function of u that gives exp(−(u/width)²), a bump about u = 0."""
    return lambda u: np.asarray(np.exp(-((u / width) ** 2)))


def aside(power: int) -> Callable[[Array], Array]:
    """A function of u that gives u^power (1 − u²), 0 beyond |u| = 1; with an odd power of opposite sign on either
    side.
    """
    return lambda u: np.asarray(u**power * np.maximum(1.0 - u**2, 0.0))


def widened(b: Branches, size: float) -> PredictedLoops:
    """The loops with worn profiles wider by the share `size` of their width, with the same cross-section."""
    changed = {
        body: (x, np.interp(x / (1.0 + size), x, depth) / (1.0 + size)) for body, (x, depth) in b.loops.profiles.items()
    }
    return replace(b.loops, profiles=changed)


def half_width(x_um: Array, depth_um: Array) -> float:
    """Largest |x| in µm at which a profile is deeper than the share `EDGE` of its largest depth; at least 1e-6. x_um,
    depth_um: (m,), x counted from the profile's middle.
    """
    over = np.flatnonzero(depth_um > EDGE * depth_um.max(initial=0.0))
    return max(float(np.abs(x_um[over]).max(initial=0.0)), 1e-6)


#: Those of the profiles that line contacts leave.
PROFILE_FAMILIES: tuple[Family, ...] = (
    Family(Seam.WEAR, MIDDLE_AND_FLANKS, (deeper_profiles(bump(0.4)), deeper_profiles(bump(0.2)))),
    Family(
        Seam.WEAR,
        "wear that differs from one side of the scar to the other",
        (deeper_profiles(aside(1)), deeper_profiles(aside(3))),
    ),
    Family(Seam.SPECIMENS, "scar of another width than the worn material makes", (widened,)),
)
