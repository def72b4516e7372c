"""What amplifiers, stages, guides and loading trains make of a loop's channels, the same for all forward models.

Each is a cause that no library holds. Those that act on true forces are of first order: they leave out what further
force bends the holder, and wear, whose work over a whole cycle they do not change.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from wirewear.base.course import Course

Array = NDArray[np.float64]
Transfer = Callable[[Array], NDArray[np.complex128]]

#: Spacings of samples that differ by less than this share are even; uneven ones are filtered on a grid so much finer.
EVEN, FINER = 1e-6, 8


@dataclass(frozen=True, eq=False)
class Signals:
    """A cycle's channels (n,), periodic, from mid-stroke: times within the cycle, displacement, both forces."""

    time_s: Array
    period_s: float
    displacement_um: Array
    tangential_force_N: Array
    normal_force_N: Array


class Instrument(Protocol):
    """Anything that makes other channels of those it is given."""

    def read(self, signals: Signals, cycle: float) -> Signals:
        """The channels as changed at a cycle."""
        ...


def read_by(instruments: tuple[Instrument, ...], signals: Signals, cycle: float) -> Signals:
    """The channels after all instruments, one behind the other."""
    for instrument in instruments:
        signals = instrument.read(signals, cycle)
    return signals


def after_play(periodic: Array, play: float) -> Array:
    """What follows a periodic channel (n,) with a play: it moves once half of it is taken up, in either direction."""
    followed, at = np.empty_like(periodic), float(periodic[0])
    for _ in range(2):  # The second cycle repeats itself.
        for i, value in enumerate(periodic.tolist()):
            at = min(max(at, value - 0.5 * play), value + 0.5 * play)
            followed[i] = at
    return followed


def turned(displacement: Array, over: float) -> Array:
    """Direction of motion, from −1 to 1 (n,): after a reversal it turns evenly while so much displacement passes."""
    return np.asarray((displacement - after_play(displacement, over)) / (0.5 * over))


def bent(displacement: Array, amplitude: float, bend: float) -> Array:
    """What a bent sensor adds to a displacement (n,): nothing at both ends and in the middle of ±amplitude."""
    place = displacement / amplitude
    return np.asarray(bend * amplitude * (place**3 - place))


@dataclass(frozen=True)
class LeakingCharge:
    """A piezo-electric force cell's charge leaks through damp cables, so that no force is held: plateaus sag to zero.

    A high pass of first order, iωτ/(1 + iωτ) (Bendat & Piersol, Random Data, 4th ed., section 2.3).
    """

    time_s: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force without what leaked."""

        def passed(frequency_Hz: Array) -> NDArray[np.complex128]:
            turn = 2j * np.pi * frequency_Hz * self.time_s
            return np.asarray(turn / (1.0 + turn))

        return replace(signals, tangential_force_N=filtered(signals, signals.tangential_force_N, passed))


@dataclass(frozen=True)
class RingingForceCell:
    """A heavy holder on a soft force cell rings whenever friction turns: an oscillator of one degree of freedom.

    1/(1 − r² + 2iζr) with r the frequency over the natural one (den Hartog, Mechanical Vibrations, section 2.9).
    """

    natural_frequency_Hz: float
    damping: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force with its ringing."""

        def passed(frequency_Hz: Array) -> NDArray[np.complex128]:
            ratio = frequency_Hz / self.natural_frequency_Hz
            return np.asarray(1.0 / (1.0 - ratio**2 + 2j * self.damping * ratio))

        return replace(signals, tangential_force_N=filtered(signals, signals.tangential_force_N, passed))


@dataclass(frozen=True)
class HystereticDisplacement:
    """A piezo stage or an inductive core has a hysteresis of its own: it lags on both branches, most in mid-stroke.

    Rayleigh's loop, δ ∓ share (A² − δ²)/A (Rayleigh, Philosophical Magazine 23 (1887) 225), at the cycle's amplitude A.
    """

    share: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The displacement behind itself."""
        place, half = place_in_stroke(signals)
        direction = np.sign(np.roll(place, -1) - np.roll(place, 1))
        lag = self.share * half * np.maximum(1.0 - place**2, 0.0) * direction
        return replace(signals, displacement_um=signals.displacement_um - lag)


@dataclass(frozen=True)
class FadingSupply:
    """The voltage that feeds both bridges of the force cell fades, so that both forces read ever less, or more."""

    gain: Course

    def read(self, signals: Signals, cycle: float) -> Signals:
        """Both forces times the gain of that cycle."""
        return loaded(signals, np.full(signals.time_s.size, self.gain.at(cycle)))


@dataclass(frozen=True)
class CreepingJoint:
    """A glued joint between wire and sensor target gives way late: a Kelvin–Voigt solid under the tangential force."""

    um_per_N: float
    time_s: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The displacement with what the joint gives."""

        def passed(frequency_Hz: Array) -> NDArray[np.complex128]:
            return np.asarray(1.0 / (1.0 + 2j * np.pi * frequency_Hz * self.time_s))

        given = self.um_per_N * filtered(signals, signals.tangential_force_N, passed)
        return replace(signals, displacement_um=signals.displacement_um + given)


@dataclass(frozen=True)
class DraggingGuide:
    """A bearing of the stage drags behind the force cell, which bears its dry friction beside that of the wires."""

    force_N: float
    over_um: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force with the drag."""
        drag = self.force_N * turned(signals.displacement_um, self.over_um)
        return replace(signals, tangential_force_N=signals.tangential_force_N + drag)


@dataclass(frozen=True)
class StickingLever:
    """The lever of the dead weights sticks in its pivot, so that the load is more one way than the other."""

    share: float
    over_um: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """Both forces times what the load has become."""
        return loaded(signals, 1.0 + self.share * turned(signals.displacement_um, self.over_um))


@dataclass(frozen=True)
class BouncingWeight:
    """Dead weights on a springy lever bounce as the guide shakes them twice a cycle, with the phase of a resonance."""

    share: float
    phase_rad: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """Both forces times what the load has become."""
        turn = 4.0 * np.pi * signals.time_s / signals.period_s
        return loaded(signals, 1.0 + self.share * np.cos(turn - self.phase_rad))


@dataclass(frozen=True)
class HookedFriction:
    """Each wire runs up the far rim of the other's scar, so that friction rises towards the end of either stroke.

    Mulvihill et al., Wear 271 (2011) 1071, found such hooks in gross slip: Q (1 + h q (δ/A)³), q the force over its
    largest, at the cycle's amplitude A.
    """

    rise: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force with its hooks."""
        place, _ = place_in_stroke(signals)
        force = signals.tangential_force_N
        mobilised = force / max(float(np.abs(force).max()), 1e-12)
        return replace(signals, tangential_force_N=force * (1.0 + self.rise * mobilised * place**3))


@dataclass(frozen=True)
class ForceCellHysteresis:
    """The force cell comes after the force by a play, as a glued or worn flexure does."""

    play_N: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force behind its play."""
        return replace(signals, tangential_force_N=after_play(signals.tangential_force_N, self.play_N))


@dataclass(frozen=True)
class CreepingForceZero:
    """The zero of the force creeps, as that of a charge amplifier does."""

    zero_N: Course

    def read(self, signals: Signals, cycle: float) -> Signals:
        """The tangential force with the zero of that cycle."""
        return replace(signals, tangential_force_N=signals.tangential_force_N + self.zero_N.at(cycle))


@dataclass(frozen=True)
class BentDisplacementSensor:
    """The displacement sensor is not straight: right at both ends and the middle of the asked stroke."""

    bend: float
    amplitude_um: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The displacement with its bend."""
        added = bent(signals.displacement_um, self.amplitude_um, self.bend)
        return replace(signals, displacement_um=signals.displacement_um + added)


#: Those of the unseen set, by name, from their parameters.
UNSEEN: Mapping[str, Callable[[Mapping[str, float]], Instrument]] = {
    "leaking_charge": lambda p: LeakingCharge(p["time_s"]),
    "ringing_force_cell": lambda p: RingingForceCell(p["natural_frequency_Hz"], p["damping"]),
    "hysteretic_displacement": lambda p: HystereticDisplacement(p["share"]),
    "fading_supply": lambda p: FadingSupply(Course(1.0, 1.0 + p["change"], p["cycles"])),
    "creeping_joint": lambda p: CreepingJoint(p["um_per_N"], p["time_s"]),
    "dragging_guide": lambda p: DraggingGuide(p["force_N"], p["over_um"]),
    "sticking_lever": lambda p: StickingLever(p["share"], p["over_um"]),
    "bouncing_weight": lambda p: BouncingWeight(p["share"], p["phase_rad"]),
    "hooked_friction": lambda p: HookedFriction(p["rise"]),
}


def place_in_stroke(signals: Signals) -> tuple[Array, float]:
    """Place within the stroke, from −1 to 1 (n,), and half of the stroke [µm]."""
    read = signals.displacement_um
    middle, half = 0.5 * float(read.max() + read.min()), 0.5 * float(np.ptp(read))
    return np.asarray((read - middle) / half), half


def beyond(place: Array, side: float, begins: float) -> Array:
    """How far a place has come from `begins` to the end on a side's sign, 0 to 1 (n,)."""
    return np.asarray(np.maximum(np.sign(side) * place - begins, 0.0) / (1.0 - begins))


def loaded(signals: Signals, factor: Array) -> Signals:
    """Both forces times a factor (n,), as under another load."""
    return replace(
        signals, tangential_force_N=signals.tangential_force_N * factor, normal_force_N=signals.normal_force_N * factor
    )


def filtered(signals: Signals, values: Array, passed: Transfer) -> Array:
    """A periodic channel (n,) through a linear filter; uneven samples are joined by straight lines."""
    count, period = values.size, signals.period_s
    if np.ptp(np.diff(signals.time_s)) < EVEN * period / count:
        return _on_even_grid(values, period, passed)
    even = np.arange(FINER * count) * (period / (FINER * count))
    fine = np.interp(even, signals.time_s, values, period=period)
    return np.asarray(np.interp(signals.time_s, even, _on_even_grid(fine, period, passed), period=period))


def _on_even_grid(values: Array, period_s: float, passed: Transfer) -> Array:
    frequency = np.asarray(np.fft.rfftfreq(values.size, period_s / values.size))
    return np.asarray(np.fft.irfft(passed(frequency) * np.fft.rfft(values), values.size))
