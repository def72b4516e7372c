"""Ways in which a sound rig differs from the one that a program expects, none of them a gap of its mechanics.

What the rig does itself is in `RIGS`, which make other nuisances before a record is made; what its channels do makes
another record of a record. Sizes are those of ordinary equipment, relative to the record's friction force and
displacement amplitude.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.nuisances import Nuisances
from studies.blind.generators.waveform import SAMPLES, Waveform
from wirewear import ExperimentRecord
from wirewear.records import MeasuredEvolution, MeasuredLoop

Array = NDArray[np.float64]
Oddity = Callable[[ExperimentRecord, np.random.Generator], ExperimentRecord]
Rig = Callable[[Nuisances], Nuisances]

#: Of the friction force: a charge amplifier's zero, mains hum, drift within a loop, a step of a 8-bit range of ±1.3.
ZERO, HUM, DRIFT, FORCE_STEP = 0.01, 0.02, 0.01, 0.01
PLACE_STEP = 0.01  #: Of the amplitude: a step of an encoder.
CUT_OFF, MAINS_Hz = 40.0, 50.0  #: Cut-off of an anti-aliasing filter in harmonics of the motion; hum in Hz.
#: Standard deviation of a sample's time in samples; share of a cycle that a drive stays at each end; third harmonic.
JITTER, DWELL, THIRD_HARMONIC = 0.2, 0.06, 0.03
FRICTION_SCATTER = 0.08  #: Standard deviation of friction from specimen to specimen.


@dataclass(frozen=True)
class Ramps(Waveform):
    """A drive of even speed that turns at once, or stays at each end for a share of the cycle."""

    dwell: float = 0.0

    def shape(self) -> Array:
        """The motion over a cycle from mid-stroke, between −1 and 1 (SAMPLES,)."""
        phase = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
        triangle = 2.0 / np.pi * np.arcsin(np.sin(phase))
        return np.clip(triangle / (1.0 - 2.0 * self.dwell), -1.0, 1.0)


def of_other_specimens(nuisances: Nuisances) -> Nuisances:
    """Three specimens whose friction scatters widely."""
    cycles = nuisances.loop_cycles
    three = (*cycles, *(cycles[:1] * 3))[:3]
    wide = replace(nuisances.scatter, friction=FRICTION_SCATTER)
    return replace(nuisances, repeats=3, loop_cycles=three, scatter=wide)


def driven_by(waveform: Waveform) -> Rig:
    """A rig with another drive."""
    return lambda nuisances: replace(nuisances, waveform=waveform)


def friction_force_N(record: ExperimentRecord) -> float:
    """Stated friction times load."""
    return (record.tables.stated.friction or 0.6) * record.tables.conditions.normal_load_N


def amplitude_um(record: ExperimentRecord) -> float:
    """The asked amplitude."""
    return record.tables.conditions.displacement_amplitude_um


def zeros_of_charge_amplifiers(record: ExperimentRecord, random: np.random.Generator) -> ExperimentRecord:
    """A force whose zero is off by another amount in each repeat."""
    zeros = {one: ZERO * friction_force_N(record) * random.standard_normal() for one in record.repeats}
    return _each(record, lambda loop: _forced(loop, loop.tangential_force_N + zeros[loop.repeat]))


def mains_hum(record: ExperimentRecord, random: np.random.Generator) -> ExperimentRecord:
    """Hum on the force, with another phase in each loop."""
    size = HUM * friction_force_N(record)

    def hummed(loop: MeasuredLoop) -> MeasuredLoop:
        phase = 2.0 * np.pi * (MAINS_Hz * loop.time_s + random.random())
        return _forced(loop, loop.tangential_force_N + size * np.sin(phase))

    return _each(record, hummed)


def pink_drift(record: ExperimentRecord, random: np.random.Generator) -> ExperimentRecord:
    """A force that wanders with a spectrum of 1/f."""
    size = DRIFT * friction_force_N(record)

    def wandering(loop: MeasuredLoop) -> MeasuredLoop:
        number = loop.time_s.size
        spectrum = np.fft.rfft(random.standard_normal(number))
        spectrum[1:] /= np.sqrt(np.arange(1, spectrum.size))
        spectrum[0] = 0.0
        wander = np.fft.irfft(spectrum, number)
        return _forced(loop, loop.tangential_force_N + size * wander / wander.std())

    return _each(record, wandering)


def coarse_steps(record: ExperimentRecord, _: np.random.Generator) -> ExperimentRecord:
    """An encoder of a hundred steps an amplitude, and a force of a hundred steps."""
    place, force = PLACE_STEP * amplitude_um(record), FORCE_STEP * friction_force_N(record)

    def stepped(loop: MeasuredLoop) -> MeasuredLoop:
        return replace(
            loop,
            displacement_um=place * np.round(loop.displacement_um / place),
            tangential_force_N=force * np.round(loop.tangential_force_N / force),
        )

    return _each(record, stepped)


def anti_aliasing(record: ExperimentRecord, _: np.random.Generator) -> ExperimentRecord:
    """Both channels behind the same second-order filter."""

    def filtered(values: Array) -> Array:
        spectrum = np.fft.rfft(values)
        ratio = 1j * np.arange(spectrum.size) / CUT_OFF
        return np.asarray(np.fft.irfft(spectrum / (1.0 + np.sqrt(2.0) * ratio + ratio**2), values.size))

    return _each(_whole(record), lambda loop: _read(loop, filtered))


def other_definitions(record: ExperimentRecord, _: np.random.Generator) -> ExperimentRecord:
    """An evolution whose force is that of the plateaus, E_d/4δ0, and whose slip is that of a rectangle, E_d/4Q."""

    def defined(one: MeasuredEvolution) -> MeasuredEvolution:
        columns = dict(one.columns)
        energy = columns["dissipated_energy_mJ"]
        slip, force = columns["slip_amplitude_um"], columns["max_tangential_force_N"]
        columns["max_tangential_force_N"] = energy / (4e-3 * slip)
        columns["slip_amplitude_um"] = energy / (4e-3 * force)
        return replace(one, columns=columns)

    return replace(record, evolution=tuple(map(defined, record.evolution)))


def triggered_at_a_reversal(record: ExperimentRecord, random: np.random.Generator) -> ExperimentRecord:
    """Loops that begin where the motion turns, each within a hundredth of a cycle."""

    def turned(loop: MeasuredLoop) -> MeasuredLoop:
        number = loop.time_s.size
        first = int(np.nanargmax(loop.displacement_um)) + round(0.01 * number * random.standard_normal())
        return _read(loop, lambda values: np.roll(values, -first))

    return _each(record, turned)


def few_samples(record: ExperimentRecord, _: np.random.Generator) -> ExperimentRecord:
    """Every fourth sample."""
    return _each(record, lambda loop: loop.taken(np.arange(loop.time_s.size) % 4 == 0))


def as_it_is(record: ExperimentRecord, _: np.random.Generator) -> ExperimentRecord:
    """What a rig itself does needs no other readings."""
    return record


def jittering(record: ExperimentRecord, random: np.random.Generator) -> ExperimentRecord:
    """Samples that are taken a little before or after the times that are written."""

    def taken(loop: MeasuredLoop) -> MeasuredLoop:
        number = loop.time_s.size
        late = JITTER * random.standard_normal(number)
        return _resampled(loop, (np.arange(number) + late) / number)

    return _each(record, taken)


#: What is odd about a rig, by its name in tables.
ODDITIES: Mapping[str, Oddity] = {
    "force zeros off by 1 %": zeros_of_charge_amplifiers,
    "friction scatters by 8 %": as_it_is,
    "mains hum of 2 %": mains_hum,
    "1/f drift of 1 %": pink_drift,
    "quantised channels": coarse_steps,
    "triangular drive": as_it_is,
    "anti-aliasing filter": anti_aliasing,
    "evolution defined otherwise": other_definitions,
    "loops from a reversal": triggered_at_a_reversal,
    "every fourth sample": few_samples,
}

#: Further ones, on tests of their own.
FURTHER: Mapping[str, Oddity] = {
    "trapezoidal drive": as_it_is,
    "third harmonic of 3 %": as_it_is,
    "sample clock that jitters": jittering,
}

#: What is odd about the rig itself, by the same names.
RIGS: Mapping[str, Rig] = {
    "friction scatters by 8 %": of_other_specimens,
    "triangular drive": driven_by(Ramps()),
    "trapezoidal drive": driven_by(Ramps(dwell=DWELL)),
    "third harmonic of 3 %": driven_by(Waveform(third_harmonic=THIRD_HARMONIC)),
}


def _each(record: ExperimentRecord, change: Callable[[MeasuredLoop], MeasuredLoop]) -> ExperimentRecord:
    return replace(record, loops=tuple(map(change, record.loops)))


def _forced(loop: MeasuredLoop, force_N: Array) -> MeasuredLoop:
    return replace(loop, tangential_force_N=force_N)


def _whole(record: ExperimentRecord) -> ExperimentRecord:
    """The record with its missing samples put in along straight lines."""
    return _each(record, lambda loop: _resampled(loop, np.arange(loop.time_s.size) / loop.time_s.size))


def _resampled(loop: MeasuredLoop, shares: Array) -> MeasuredLoop:
    """The loop at shares of its cycle, its times as they are."""
    at = np.arange(loop.time_s.size) / loop.time_s.size

    def read(values: Array) -> Array:
        known = np.isfinite(values)
        return np.interp(shares, at[known], values[known], period=1.0)

    return _read(loop, read)


def _read(loop: MeasuredLoop, change: Callable[[Array], Array]) -> MeasuredLoop:
    """The loop with every channel changed, its times as they are."""
    return replace(
        loop,
        displacement_um=change(loop.displacement_um),
        tangential_force_N=change(loop.tangential_force_N),
        normal_force_N=None if loop.normal_force_N is None else change(loop.normal_force_N),
    )
