"""Amplifiers, loggers, lumps, ridges, grease and loose weights of the withheld set, the same for all forward models.

As those of `instruments`, they change channels that were read without them. What acts on true forces is of first order.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.ageing import Growth
from studies.blind.generators.instruments import Array, Instrument, Signals, beyond, filtered, loaded, place_in_stroke


@dataclass(frozen=True)
class OverloadedCell:
    """A force cell is overloaded at some cycle: its gauges yield, read less ever after, and no longer return to zero.

    Q before, (1 − loss) Q + zero after it; makers of cells name both as the signs of an overload.
    """

    loss: float
    zero_N: float
    cycle: float

    def read(self, signals: Signals, cycle: float) -> Signals:
        """The tangential force as the cell reads it at a cycle."""
        if cycle < self.cycle:
            return signals
        return replace(signals, tangential_force_N=(1.0 - self.loss) * signals.tangential_force_N + self.zero_N)


@dataclass(frozen=True)
class LoosePlug:
    """A plug of the bridge has a bad contact, whose resistance unbalances it now and then: the zero jumps and returns.

    Q + zero between the first and second, and again between the third and fourth of four cycles.
    """

    zero_N: float
    cycles: tuple[float, float, float, float]

    def read(self, signals: Signals, cycle: float) -> Signals:
        """The tangential force with the zero of that cycle."""
        first, second, third, fourth = self.cycles
        if not (first <= cycle < second or third <= cycle < fourth):
            return signals
        return replace(signals, tangential_force_N=signals.tangential_force_N + self.zero_N)


@dataclass(frozen=True)
class SlewLimitedAmplifier:
    """An amplifier of the force follows no faster than its slew rate: |dQ/dt| ≤ S, so that steep flanks lean.

    Plateaus are right. Horowitz & Hill, The Art of Electronics, 3rd ed., section 4.4.
    """

    N_per_s: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force as far as the amplifier follows."""
        force = signals.tangential_force_N
        steps = np.diff(signals.time_s, prepend=signals.time_s[-1] - signals.period_s)
        most = (self.N_per_s * steps).tolist()
        followed, at = np.empty_like(force), float(force[-1])
        for _ in range(2):  # The second cycle repeats itself.
            for i, value in enumerate(force.tolist()):
                at = min(max(value, at - most[i]), at + most[i])
                followed[i] = at
        return replace(signals, tangential_force_N=followed)


@dataclass(frozen=True)
class CrossoverDistortion:
    """The output stage of the force amplifier has lost its bias: nothing comes out within a band about zero.

    sign(Q) max(|Q| − b, 0); Horowitz & Hill, The Art of Electronics, 3rd ed., section 2.4.
    """

    band_N: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force without its band about zero."""
        force = signals.tangential_force_N
        return replace(signals, tangential_force_N=force - np.clip(force, -self.band_N, self.band_N))


@dataclass(frozen=True)
class AveragingLogger:
    """A logger averages every channel over a window about each sample, so that corners are round on both sides.

    The transfer function of an average over a time w is sin(π f w)/(π f w), without a lag.
    """

    time_s: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """All channels, averaged."""

        def passed(frequency_Hz: Array) -> NDArray[np.complex128]:
            return np.asarray(np.sinc(frequency_Hz * self.time_s), dtype=np.complex128)

        return replace(
            signals,
            displacement_um=filtered(signals, signals.displacement_um, passed),
            tangential_force_N=filtered(signals, signals.tangential_force_N, passed),
            normal_force_N=filtered(signals, signals.normal_force_N, passed),
        )


@dataclass(frozen=True)
class HardSpot:
    """An inclusion or a lump of debris pressed into the track: friction differs where the wires pass over it.

    Q (1 + r exp(−((δ/A − p)/w)²)), at the same place p on the way there and back.
    """

    rise: float
    place: float
    width: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force with the spot's share."""
        place, _ = place_in_stroke(signals)
        factor = 1.0 + self.rise * np.exp(-(((place - self.place) / self.width) ** 2))
        return replace(signals, tangential_force_N=np.asarray(signals.tangential_force_N * factor))


@dataclass(frozen=True)
class DebrisRidge:
    """Debris is swept to one end of the stroke, where a ridge grows that the wire runs against and is pushed back by.

    It bears R max(s δ/A − b, 0)/(1 − b) against the motion to its end s = ±1, elastically; R grows with the worn
    volume, hence evenly with the cycles, to `force_N` at `cycles`. A negative force puts it at the other end.
    """

    force_N: float
    begins: float
    cycles: float

    def read(self, signals: Signals, cycle: float) -> Signals:
        """The tangential force with the push of the ridge as it is by that cycle."""
        place, _ = place_in_stroke(signals)
        push = Growth(self.force_N, self.cycles).at(cycle) * beyond(place, self.force_N, self.begins)
        return replace(signals, tangential_force_N=np.asarray(signals.tangential_force_N + push))


@dataclass(frozen=True)
class ThinningGrease:
    """Grease that drawing left between the wires drags by its viscosity and is squeezed out over the cycles.

    F v/v_max exp(−n/n_c), Newton's law at a film of constant thickness; v_max that of a sine of the same amplitude.
    """

    force_N: float
    cycles: float

    def read(self, signals: Signals, cycle: float) -> Signals:
        """The tangential force with what is left of the drag."""
        _, half = place_in_stroke(signals)
        time, period = signals.time_s, signals.period_s
        passed = np.roll(signals.displacement_um, -1) - np.roll(signals.displacement_um, 1)
        taken = (np.roll(time, -1) - np.roll(time, 1)) % period
        speed = passed / taken / (2.0 * np.pi * half / period)
        drag = self.force_N * np.exp(-cycle / self.cycles) * speed
        return replace(signals, tangential_force_N=np.asarray(signals.tangential_force_N + drag))


@dataclass(frozen=True)
class RattlingWeight:
    """The dead weight hangs loose and rattles after the knock of each reversal until its swing has died away.

    P (1 + s exp(−t/τ) sin(2π f t)), t since the last reversal: the answer of a damped oscillator to a blow (den
    Hartog, Mechanical Vibrations, chapter 2).
    """

    share: float
    frequency_Hz: float
    time_s: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """Both forces times what the load has become."""
        ends = (int(signals.displacement_um.argmax()), int(signals.displacement_um.argmin()))
        since = np.min([(signals.time_s - signals.time_s[end]) % signals.period_s for end in ends], axis=0)
        swing = np.exp(-since / self.time_s) * np.sin(2.0 * np.pi * self.frequency_Hz * since)
        return loaded(signals, np.asarray(1.0 + self.share * swing))


#: Those of the withheld set, by name, from their parameters.
WITHHELD: Mapping[str, Callable[[Mapping[str, float]], Instrument]] = {
    "overloaded_cell": lambda p: OverloadedCell(p["loss"], p["zero_N"], p["cycle"]),
    "loose_plug": lambda p: LoosePlug(p["zero_N"], (p["cycle_1"], p["cycle_2"], p["cycle_3"], p["cycle_4"])),
    "slew_limited_amplifier": lambda p: SlewLimitedAmplifier(p["N_per_s"]),
    "crossover_distortion": lambda p: CrossoverDistortion(p["band_N"]),
    "averaging_logger": lambda p: AveragingLogger(p["time_s"]),
    "hard_spot": lambda p: HardSpot(p["rise"], p["place"], p["width"]),
    "debris_ridge": lambda p: DebrisRidge(p["force_N"], p["begins"], p["cycles"]),
    "thinning_grease": lambda p: ThinningGrease(p["force_N"], p["cycles"]),
    "rattling_weight": lambda p: RattlingWeight(p["share"], p["frequency_Hz"], p["time_s"]),
}
