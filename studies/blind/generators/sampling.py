"""From noise-free periodic readings to what a logger writes: samples, noise, outliers, figures of the evolution."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.cases import Case
from studies.blind.generators.files import record_tables
from studies.blind.generators.nuisances import Nuisances
from wirewear.records import AnyRecord, ExperimentRecord, MeasuredEvolution, MeasuredLoop, MeasuredScar
from wirewear.records.tables import PointRecordTables

Array = NDArray[np.float64]
Channels = tuple[Array, Array, Array]  #: Displacement in µm, tangential and normal force in N over a cycle (n,).
OUTLIER_REACH = 0.5  #: An outlier lies so many times the channel's largest value away, at most.
#: Forces up to this share of the amplitude count as about zero.
NEAR_ZERO = 0.1
PROFILOMETER_NOISE_um = 0.05


@dataclass(frozen=True, eq=False)
class LoggedTest:
    """What was recorded of one repeat."""

    loops: Sequence[MeasuredLoop]
    evolution: Sequence[MeasuredEvolution]
    scars: Sequence[MeasuredScar]


def record_of(case: Case, tests: Sequence[LoggedTest]) -> AnyRecord:
    """The record of a case: what it states, and all its repeats."""
    return ExperimentRecord[PointRecordTables, MeasuredScar](
        record_tables(case),
        tuple(loop for test in tests for loop in test.loops),
        tuple(rows for test in tests for rows in test.evolution),
        tuple(scar for test in tests for scar in test.scars),
    )


def logged_channels(
    readings: Iterable[tuple[int, Channels]],
    case: Case,
    repeat: int,
    random: np.random.Generator,
    time_s: Array | None = None,
) -> tuple[list[MeasuredLoop], list[MeasuredEvolution]]:
    """Loops and evolution of one repeat, from the noise-free readings at every cycle of which anything is recorded.

    The readings are logged as they are if their times (n,) are given; without them they are a fine grid of even times,
    of which the logger takes fewer.
    """
    nuisances, frequency = case.nuisances, case.nominal.frequency_Hz
    wanted = set(nuisances.loop_cycles[repeat - 1])
    loops: list[MeasuredLoop] = []
    rows: list[dict[str, float]] = []
    for cycle, channels in readings:
        loop = logged_loop(repeat, cycle, frequency, channels, nuisances, random, time_s)
        if cycle in wanted:
            loops.append(loop)
        if cycle in nuisances.evolution_cycles:
            figures = loop_figures(despiked(loop.displacement_um), despiked(loop.tangential_force_N))
            rows.append({"cycle": float(cycle), **figures})
    if not nuisances.has_evolution:
        return loops, []
    return loops, [MeasuredEvolution(repeat, {name: np.array([row[name] for row in rows]) for name in rows[0]})]


def logged_scar(
    repeat: int, wire: str, lines_um: tuple[Array, Array], depth_um: Array, random: np.random.Generator
) -> MeasuredScar:
    """A scar as a profilometer maps it, noise on its true depth (n_x, n_y)."""
    noisy = depth_um + PROFILOMETER_NOISE_um * random.standard_normal(depth_um.shape)
    return MeasuredScar(repeat, wire, lines_um[0], lines_um[1], noisy)


def logged_loop(
    repeat: int,
    cycle: int,
    frequency_Hz: float,
    channels_um_N: Channels,
    nuisances: Nuisances,
    random: np.random.Generator,
    time_s: Array | None = None,
) -> MeasuredLoop:
    """A cycle as logged: noisy, with outliers, from periodic channels in µm and N.

    The channels are sampled at even times, or logged whole if those of their samples are given (n,).
    """
    if time_s is None:
        count = nuisances.samples
        time_s = np.arange(count) / (count * frequency_Hz)
        size = channels_um_N[0].size
        phase = np.arange(count) * size / count
        one, two, three = (np.interp(phase, np.arange(size), channel, period=size) for channel in channels_um_N)
        channels_um_N = one, two, three
    noise = (nuisances.displacement_noise_um, nuisances.force_noise_N, nuisances.force_noise_N)
    read = []
    for channel, deviation in zip(channels_um_N, noise, strict=True):
        noisy = channel + deviation * _noise(time_s.size, nuisances.correlation, random)
        hit = random.random(noisy.size) < nuisances.outlier_share
        reach = OUTLIER_REACH * float(np.abs(noisy).max())
        read.append(noisy + hit * random.uniform(-reach, reach, noisy.size))
    return MeasuredLoop(repeat, cycle, time_s, read[0], read[1], read[2] if nuisances.has_normal_force else None)


def _noise(count: int, correlation: float, random: np.random.Generator) -> Array:
    """Noise of standard deviation 1, each sample correlated with the one before (count,)."""
    from scipy.signal import lfilter

    white = random.standard_normal(count)
    white[1:] *= np.sqrt(1.0 - correlation**2)
    return np.asarray(lfilter([1.0], [1.0, -correlation], white))


def loop_figures(displacement_um: Array, force_N: Array) -> Mapping[str, float]:
    """Figures as a rig's software takes them from the channels: amplitudes [µm], largest force [N], area [mJ]."""
    following, next_force = np.roll(displacement_um, -1), np.roll(force_N, -1)
    return {
        "displacement_amplitude_um": 0.5 * float(np.ptp(displacement_um)),
        "slip_amplitude_um": 0.5 * _width(displacement_um, force_N),
        "max_tangential_force_N": 0.5 * float(np.ptp(force_N)),
        "dissipated_energy_mJ": 1e-3 * abs(float(np.sum(0.5 * (force_N + next_force) * (following - displacement_um)))),
    }


def _width(displacement_um: Array, force_N: Array) -> float:
    """Width of a loop at zero force [µm], 0 where the force does not reverse.

    Each stroke's zero is the middle between two small forces: where a free play leaves no force, noise alone decides
    where zero is crossed.
    """
    count = force_N.size
    phase = 2.0 * np.pi * np.arange(count) / count
    top = round(float(np.angle(displacement_um @ np.exp(1j * phase))) / (2.0 * np.pi) * count)
    place, force = np.roll(displacement_um, -top), np.roll(force_N, -top)
    level = NEAR_ZERO * 0.5 * float(np.ptp(force_N))
    half = count // 2
    back = _middle(place[:half], force[:half], level)
    forth = _middle(place[half:], -force[half:], level)
    return 0.0 if back is None or forth is None else abs(back - forth)


def _middle(place_um: Array, falling_N: Array, level_N: float) -> float | None:
    """Middle between the places at which a falling force passes a small level and its negative."""
    passed = []
    for wanted in (level_N, -level_N):
        after = int((falling_N < wanted).argmax())
        if after == 0:
            return None
        share = (falling_N[after - 1] - wanted) / (falling_N[after - 1] - falling_N[after])
        passed.append(float(place_um[after - 1] + share * (place_um[after] - place_um[after - 1])))
    return 0.5 * sum(passed)


def despiked(values: Array, reach: int = 2) -> Array:
    """A periodic channel whose samples that stand far out of their neighbours' median take its place (n,).

    Further than half of what the neighbours span, too: the tip of a coarse loop is no spike.
    """
    shifts = [shift for shift in range(-reach, reach + 1) if shift]
    near = np.stack([np.roll(values, shift) for shift in shifts])
    median = np.median(np.vstack([near, values]), axis=0)
    departure = np.abs(values - median)
    spike = (departure > 8.0 * (np.median(departure) + 1e-12)) & (departure > 0.5 * np.ptp(near, axis=0))
    return np.where(spike, median, values)
