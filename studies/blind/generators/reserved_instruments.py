"""Sensors, tracks and loads of the reserved set, the same for all forward models.

As those of `instruments`, they change channels that were read without them. What acts on true forces is of first order.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from studies.blind.generators.ageing import Growth
from studies.blind.generators.instruments import Array, Instrument, Signals, beyond, loaded, place_in_stroke
from studies.blind.generators.reserved_holders import HOLDERS
from studies.blind.generators.strokes import since_reversal

GLAZE_EDGE = 0.06  #: Edge of a glaze over half of the stroke.
JAMMING = 10.0  #: Power with which the rolls of debris jam over their way.


@dataclass(frozen=True)
class CyclicEncoder:
    """The reading head of an encoder is badly set: its error comes again with every line of the scale.

    δ + e (sin(2π δ/p + φ) − sin φ); shifted quadrature signals err so (Heydemann, Applied Optics 20 (1981) 3382).
    """

    error_um: float
    pitch_um: float
    phase_rad: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The displacement with the error of its place."""
        turn = 2.0 * np.pi * signals.displacement_um / self.pitch_um + self.phase_rad
        error = self.error_um * (np.sin(turn) - np.sin(self.phase_rad))
        return replace(signals, displacement_um=np.asarray(signals.displacement_um + error))


@dataclass(frozen=True)
class CoarseConverter:
    """The range of the force's converter is set far too wide, so that the force is read in coarse steps.

    s round(Q/s); its error is spread evenly over ±s/2 (Bennett, Bell System Technical Journal 27 (1948) 446).
    """

    step_N: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force in steps."""
        steps = np.round(signals.tangential_force_N / self.step_N)
        return replace(signals, tangential_force_N=np.asarray(self.step_N * steps))


@dataclass(frozen=True)
class LaserOutOfRange:
    """The laser was mounted too near or too far: it reads no further than its range, which ends within the stroke.

    min(δ, l) where the limit l is positive, max(δ, l) where it is negative.
    """

    limit_um: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The displacement, cut off at one end."""
        least, most = (-np.inf, self.limit_um) if self.limit_um > 0.0 else (self.limit_um, np.inf)
        return replace(signals, displacement_um=np.clip(signals.displacement_um, least, most))


@dataclass(frozen=True)
class HaltingLogger:
    """The force's logger is triggered at one end of the stroke, stores the cycle before, and repeats its last sample.

    The force stands for so long from the upper reversal on, then jumps to what it is by then.
    """

    time_s: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force with its halt."""
        top = int(signals.displacement_um.argmax())
        since = (signals.time_s - signals.time_s[top]) % signals.period_s
        force = np.where(since < self.time_s, signals.tangential_force_N[top], signals.tangential_force_N)
        return replace(signals, tangential_force_N=force)


@dataclass(frozen=True)
class StickSlip:
    """The wires stick and slip along each stroke: the force builds up evenly and drops at once, so many times.

    Bowden & Leben, Proc. R. Soc. A 169 (1939) 371. The first stick of a stroke is its flank; each slip takes a share.
    """

    share: float
    per_stroke: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force as a saw along either stroke."""
        passed, _ = since_reversal(signals)
        _, half = place_in_stroke(signals)
        sticks = self.per_stroke * passed / (2.0 * half)
        lost = np.where(sticks < 1.0, 0.0, self.share * (1.0 - sticks % 1.0))
        return replace(signals, tangential_force_N=np.asarray(signals.tangential_force_N * (1.0 - lost)))


@dataclass(frozen=True)
class RollingDebris:
    """Rolls of debris between the wires roll back after each reversal, at less friction, until they jam.

    Cylindrical debris lowers friction while it rolls (Zanoria et al., Tribology Transactions 38 (1995) 721). The share
    of rolls that still roll after a way d is 1/(1 + (d/l)^k), with l a share of the stroke.
    """

    loss: float
    over: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force, less on the first part of either stroke."""
        passed, direction = since_reversal(signals)
        _, half = place_in_stroke(signals)
        force = signals.tangential_force_N
        rolling = 1.0 / (1.0 + (passed / (2.0 * half * self.over)) ** JAMMING)
        mobilised = np.maximum(direction * force, 0.0) / max(float(np.abs(force).max()), 1e-12)
        return replace(signals, tangential_force_N=np.asarray(force * (1.0 - self.loss * rolling * mobilised)))


@dataclass(frozen=True)
class SpreadingGlaze:
    """Oxide is pressed to a glaze at one end of the track, which spreads over it and rubs otherwise than the rest.

    Its edge comes from one end to the other as √n, the parabolic growth of oxides (Stott, Tribology Int. 31 (1998) 61),
    and is there at `cycles`. A negative share rubs more; `end` is the end where it begins, ±1.
    """

    share: float
    end: float
    cycles: float

    def read(self, signals: Signals, cycle: float) -> Signals:
        """The tangential force on the glaze as far as it has spread by that cycle."""
        place, _ = place_in_stroke(signals)
        spread = Growth(2.0 + 4.0 * GLAZE_EDGE, self.cycles, 0.5).at(cycle) - 2.0 * GLAZE_EDGE
        glazed = 0.5 * (1.0 - np.tanh((1.0 - self.end * place - spread) / GLAZE_EDGE))
        return replace(signals, tangential_force_N=np.asarray(signals.tangential_force_N * (1.0 - self.share * glazed)))


@dataclass(frozen=True)
class HuntingServo:
    """The controller of the load is set too sharp and hunts about it, in no time with the stroke.

    P (1 + s sin 2πft), t from the start of the test on: a limit cycle (Franklin, Powell & Emami-Naeini, Feedback
    Control of Dynamic Systems, chapter 9).
    """

    share: float
    frequency_Hz: float

    def read(self, signals: Signals, cycle: float) -> Signals:
        """Both forces times what the load has become."""
        time = cycle * signals.period_s + signals.time_s
        return loaded(signals, np.asarray(1.0 + self.share * np.sin(2.0 * np.pi * self.frequency_Hz * time)))


@dataclass(frozen=True)
class TouchingStop:
    """The arm of the load comes to touch a stop before one end of the stroke, which bears a part of the load.

    P (1 − s max(δ/A − b, 0)/(1 − b)), both ways; a negative share puts the stop at the low end.
    """

    share: float
    begins: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """Both forces times what the stop leaves of the load."""
        place, _ = place_in_stroke(signals)
        borne: Array = abs(self.share) * beyond(place, self.share, self.begins)
        return loaded(signals, 1.0 - borne)


#: Those of the reserved set, by name, from their parameters.
RESERVED: Mapping[str, Callable[[Mapping[str, float]], Instrument]] = {
    "cyclic_encoder": lambda p: CyclicEncoder(p["error_um"], p["pitch_um"], p["phase_rad"]),
    "coarse_converter": lambda p: CoarseConverter(p["step_N"]),
    "laser_out_of_range": lambda p: LaserOutOfRange(p["limit_um"]),
    "halting_logger": lambda p: HaltingLogger(p["time_s"]),
    "stick_slip": lambda p: StickSlip(p["share"], p["per_stroke"]),
    "rolling_debris": lambda p: RollingDebris(p["loss"], p["over"]),
    "spreading_glaze": lambda p: SpreadingGlaze(p["share"], p["end"], p["cycles"]),
    "hunting_servo": lambda p: HuntingServo(p["share"], p["frequency_Hz"]),
    "touching_stop": lambda p: TouchingStop(p["share"], p["begins"]),
    **HOLDERS,
}
