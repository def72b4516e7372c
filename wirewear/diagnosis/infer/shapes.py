"""Shapes of distortions: how a computed course changes under one of unit size, seam by seam.

Branches are taken in their own direction: y is the displacement and p the force in the direction of travel, so that
both rise. A shape of unit size changes forces by the plateau force, displacements by the amplitude.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.loop_states import SINE, FastMotion
from wirewear.diagnosis.model.readings import KNEE, SLIDING
from wirewear.effects import Seam

#: +1 on the branch towards +x, −1 on the other.
_DIRECTIONS = np.array([1.0, -1.0])[None, :, None]


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
        allowed: log evidence that friction laws and solvers were seen to add to it beside known effects.
        instead: sets of shapes that it may have instead of these, each as likely.
        counts: whether it speaks for a cause outside the library; else it names one that others speak for, as nothing
            that solvers add to it was learned.
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


@dataclass(frozen=True, eq=False)
class Branches:
    """A course's loops by branch, (n, 2, m) each, the scales of a distortion (amplitude, plateau force), the drive."""

    course: LoopCourse
    y_um: Array
    p_N: Array
    amplitude_um: float
    force_N: float
    motion: FastMotion = SINE

    @classmethod
    def of(cls, course: LoopCourse, amplitude_um: float, force_N: float, motion: FastMotion = SINE) -> Branches:
        """Those of a computed course."""
        return cls(
            course,
            _DIRECTIONS * course.displacement_um,
            _DIRECTIONS * course.tangential_force_N,
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
        """Travel since the knee over the amplitude (n, 2, m), 0 while the contact sticks."""
        return np.maximum(self.y_um - self.y_um[:, :, KNEE, None], 0.0) / self.amplitude_um

    def read_with(self, displacement_um: Array, force_N: Array) -> LoopCourse:
        """The course with other readings of true loops (n, 2, m), centred between their tips as measured ones are."""
        tips = displacement_um.max(axis=(1, 2), keepdims=True) + displacement_um.min(axis=(1, 2), keepdims=True)
        return replace(self.course, displacement_um=displacement_um - 0.5 * tips, tangential_force_N=force_N)

    def sliding_under(self, added_N: Array, load_share: Array | None = None) -> LoopCourse:
        """The course when the sliding contact resists by so much more (n, 2, m), in the direction of travel.

        The stick branch begins where the other branch ends and rises to the new knee; its travel goes with its rise.
        load_share: relative change (n, 2, m) of the normal force that goes with it.
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
        course = self._along(y, p)
        if load_share is None:
            return course
        return replace(course, normal_force_N=course.normal_force_N * (1.0 + load_share))

    def held_with(self, given_um: Array) -> LoopCourse:
        """The course when the holder gives way by so much more (n, 2, m) while the contact sticks, from its start on.

        What slides is held by the drive: the same forces at the same places, but for the later knee.
        """
        y = self.y_um.copy()
        y[:, :, :SLIDING] += given_um[:, :, :SLIDING] - given_um[:, :, :1]
        return self._along(y, self.p_N)

    def _along(self, y_um: Array, p_N: Array) -> LoopCourse:
        # A later knee swallows the first places of the sliding part.
        forward = np.maximum.accumulate(y_um, axis=2)
        return replace(self.course, displacement_um=_DIRECTIONS * forward, tangential_force_N=_DIRECTIONS * p_N)


#: A distortion: the course of branches under so much of it.
Shape = Callable[[Branches, float], LoopCourse]


def force_read(power: Callable[[Array], Array]) -> Shape:
    """A force channel that reads Q + Q* f(Q/Q*)."""

    def shape(b: Branches, size: float) -> LoopCourse:
        true = b.course.tangential_force_N
        return b.read_with(b.course.displacement_um, true + size * b.force_N * power(true / b.force_N))

    return shape


def displacement_read(power: Callable[[Array], Array]) -> Shape:
    """A displacement channel that reads δ + δa f(δ/δa), f being 0 at both ends, as the drive holds them."""

    def shape(b: Branches, size: float) -> LoopCourse:
        true = b.course.displacement_um
        read = true + size * b.amplitude_um * power(true / b.amplitude_um)
        return b.read_with(read, b.course.tangential_force_N)

    return shape


def resisting(share: Callable[[Branches], Array]) -> Shape:
    """A contact that resists sliding by a share f of the plateau force more, f (n, 2, m)."""
    return lambda b, size: b.sliding_under(size * b.force_N * share(b))


def loaded(share: Callable[[Branches], Array]) -> Shape:
    """A load that is higher by a share f, f (n, 2, m): the resistance follows it."""
    return lambda b, size: b.sliding_under(size * b.p_N * share(b), size * share(b))


def yielding(released: float) -> Shape:
    """A holder that slips, with hysteresis, once the force has swung by twice a share of the plateau force."""

    def shape(b: Branches, size: float) -> LoopCourse:
        held = released * b.force_N
        start = b.p_N[:, :, :1]
        swung = np.maximum(b.p_N - held, start + held)
        return b.held_with(size * b.amplitude_um / b.force_N * np.maximum.accumulate(swung, axis=2))

    return shape


def stiffening() -> Shape:
    """A holder whose elastic give departs from the straight line by a cubic share, alike in both directions."""

    def shape(b: Branches, size: float) -> LoopCourse:
        return b.held_with(size * b.amplitude_um * (b.p_N / b.force_N) ** 3)

    return shape


def force_after_play() -> Shape:
    """A force channel that comes after the force by a play: a reading stays until it is taken up, then lags by half."""

    def shape(b: Branches, size: float) -> LoopCourse:
        half = size * b.force_N
        read = np.maximum(b.p_N - half, b.p_N[:, :, :1] + half)
        return b.read_with(b.course.displacement_um, _DIRECTIONS * read)

    return shape


def displacement_after_play(*, held: bool) -> Shape:
    """The same of the displacement channel; `held` if the drive makes up for what the reading loses at the tips."""

    def shape(b: Branches, size: float) -> LoopCourse:
        half = size * b.amplitude_um
        read = np.maximum(b.y_um - half, b.y_um[:, :, :1] + half)
        if held:
            read = read * b.amplitude_um / (b.amplitude_um - half)
        return b.read_with(_DIRECTIONS * read, b.course.tangential_force_N)

    return shape


Share = Callable[[Branches], Array]


def cubic(u: Array) -> Array:
    """A cubic that bends the ends alone."""
    return np.asarray(u**3)


def between_ends(power: int) -> Callable[[Array], Array]:
    """A power less the one two below it, which is 0 at both ends."""
    return lambda u: np.asarray(u**power - u ** (power - 2))


def in_travel(power: int) -> Share:
    """A power of x/A in the direction of travel, none of it in the mean: odd ones are against the motion at one end."""
    mean = 1.0 / (power + 1.0) if power % 2 == 0 else 0.0
    return lambda b: np.asarray(b.place**power - mean)


def on_the_rig(power: int) -> Share:
    """A power of x/A with the direction's sign: odd ones are more towards one end, even ones one way only."""
    return lambda b: np.asarray(_DIRECTIONS * b.place**power)


def later(b: Branches) -> Array:
    """The sine of twice the phase of a harmonic drive: more in the second half of either stroke."""
    return np.asarray(b.place * np.sqrt(np.maximum(1.0 - b.place**2, 0.0)))


def fast(b: Branches) -> Array:
    """The speed of a harmonic drive over its largest, with its sign."""
    return np.asarray(_DIRECTIONS * np.sqrt(np.maximum(1.0 - b.place**2, 0.0)))


def since(length: float) -> Shape:
    """Friction that passes over some way after each reversal."""
    return resisting(lambda b: np.asarray(np.exp(-b.slid / length)))
