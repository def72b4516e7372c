"""Loggers and profilometers by others: rates, noise, converters' steps, filters, zeros and tilt."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from studies.blind.generators.nuisances import Nuisances, Scatter
from studies.blind.generators.other_simulators.pair import Array
from studies.blind.generators.other_simulators.tests_drawn import LineTest, Test
from studies.blind.generators.waveform import Waveform
from wirewear.records import MeasuredEvolution, MeasuredLoop, MeasuredProfile, MeasuredScar

Channels = tuple[Array, Array, Array]  #: Displacement [µm], tangential and normal force [N] over a cycle (n,).
SNAPSHOTS, KEPT = 18, 0.55  #: Cycles at which a test's loops are computed, and which part of them a logger keeps.
LINES = 24  #: Lines of a scar's map along half of its width.


@dataclass(frozen=True)
class Logger(Nuisances):
    """What a record looks like whatever its effect."""

    steps: tuple[float, float] = (0.0, 0.0)
    filter_s: float = 0.0
    starts_at: float = 0.0
    scar_noise_um: float = 0.05
    tilt_um: float = 0.0
    states_scatter: bool = False


def drawn_logger(test: Test, random: np.random.Generator) -> Logger:
    """A record's logger, drawn without a look at its effect: a third have one repeat, a third no evolution."""
    repeats = int(random.choice([1, 2, 3, 4], p=[0.34, 0.2, 0.32, 0.14]))
    peak, period = test.friction * test.load_N, 1.0 / test.frequency_Hz
    snapshots = np.round(np.geomspace(max(10.0, test.cycles / 2000.0), test.cycles, SNAPSHOTS)).astype(int)
    snapshots = np.unique([*snapshots, *test.ends])
    kept = (random.random(snapshots.size) < KEPT) | np.isin(snapshots, test.ends)
    kept[[0, -1]] = True
    depth_um = (
        250.0 * test.expected_scar_mm**2 / (test.radius_mm if isinstance(test, LineTest) else 0.5 * test.diameter_mm)
    )
    noise = random.uniform(0.001, 0.005) * test.amplitude_um, random.uniform(0.003, 0.015) * peak
    return Logger(
        repeats=repeats,
        scatter=Scatter(random.uniform(0.004, 0.02), random.uniform(0.002, 0.01), random.uniform(0.02, 0.08), 0.0),
        displacement_noise_um=float(f"{noise[0]:.2g}"),
        force_noise_N=float(f"{noise[1]:.2g}"),
        correlation=0.0,
        outlier_share=0.0 if random.random() < 0.6 else 0.001,
        waveform=Waveform(0.0, 0.0),
        amplitude_drift=0.0,
        drive="stroke" if random.random() < 0.5 else "sensor",
        samples=int(random.choice([100, 180, 250, 360, 500])),
        has_normal_force=bool(random.random() < 0.65),
        # Tables of energies have five digits, of which those of partial slip use one or two.
        has_evolution=bool(random.random() < 0.67) and test.slides,
        has_scars=bool(random.random() < 0.75) and test.wears,
        loop_cycles=(tuple(snapshots[kept].tolist()),) * repeats,
        evolution_cycles=tuple(snapshots.tolist()),
        steps=(noise[0] * random.uniform(0.05, 2.0), noise[1] * random.uniform(0.05, 2.0)),
        filter_s=period * random.uniform(0.0, 0.002),
        starts_at=float(random.choice([0.0, -0.25])),
        scar_noise_um=min(depth_um * random.uniform(0.01, 0.04), 0.1),
        tilt_um=depth_um * random.uniform(0.0, 0.04),
        states_scatter=bool(random.random() < 0.33),
    )


def logged_loop(
    logger: Logger, test: Test, where: tuple[int, int], clean: Channels, random: np.random.Generator
) -> MeasuredLoop:
    """A cycle of a repeat as logged: filtered alike in all channels, noisy, in the converter's steps."""
    time = np.arange(logger.samples) / (logger.samples * test.frequency_Hz)
    read = []
    for place, channel in enumerate(clean):
        size, step = (
            (logger.force_noise_N, logger.steps[1]) if place else (logger.displacement_noise_um, logger.steps[0])
        )
        turns = np.fft.rfftfreq(channel.size, 1.0 / channel.size)
        passed = 1.0 / (1.0 + 2j * np.pi * turns * test.frequency_Hz * logger.filter_s)
        smooth = np.fft.irfft(passed * np.fft.rfft(channel), channel.size)
        phase = (np.arange(logger.samples) / logger.samples + logger.starts_at) * channel.size
        noisy = np.interp(phase, np.arange(channel.size), smooth, period=channel.size)
        noisy = noisy + size * random.standard_normal(logger.samples)
        hit = random.random(logger.samples) < logger.outlier_share
        noisy = noisy + hit * random.uniform(-0.5, 0.5, logger.samples) * np.abs(channel).max()
        read.append(step * np.round(noisy / step))
    normal = read[2] if logger.has_normal_force else None
    return MeasuredLoop(*where, time, read[0], read[1], normal)


def figures(clean: Channels) -> dict[str, float]:
    """Figures of a cycle as a rig's software takes them [µm, N, mJ]."""
    place, force, _ = clean
    top = int(place.argmax())
    place, force = np.roll(place, -top), np.roll(force, -top)
    low, middle = int(place.argmin()), 0.5 * float(force.max() + force.min())
    back = float(np.interp(-middle, -force[:low], place[:low]))
    forth = float(np.interp(middle, force[low:], place[low:]))
    return {
        "displacement_amplitude_um": 0.5 * float(np.ptp(place)),
        "slip_amplitude_um": 0.5 * abs(back - forth),
        "max_tangential_force_N": float(np.abs(force).max()),
        "dissipated_energy_mJ": 1e-3 * abs(float(np.trapezoid(np.r_[force, force[0]], np.r_[place, place[0]]))),
    }


def logged_evolution(
    logger: Logger, repeat: int, clean: Mapping[int, Channels], random: np.random.Generator
) -> MeasuredEvolution:
    """One repeat's rows, each the mean of some cycles."""
    rows = [{"cycle": float(cycle), **figures(channels)} for cycle, channels in clean.items()]
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    share = 1.0 / np.sqrt(logger.samples)
    for name, size in (
        ("displacement_amplitude_um", logger.displacement_noise_um),
        ("slip_amplitude_um", logger.displacement_noise_um),
        ("max_tangential_force_N", logger.force_noise_N),
    ):
        columns[name] = columns[name] + 2.0 * share * size * random.standard_normal(len(rows))
    return MeasuredEvolution(repeat, columns)


def scar_lines_um(test: Test, *, long: bool) -> Array:
    """Lines of a map from its middle, along or across; from what is expected of the test alone."""
    half = 1300.0 * test.expected_scar_mm * test.elongation
    step = max(round(half / LINES, 1), 0.1)
    count = int(np.ceil((half + (1.1 * test.amplitude_um if long else 0.0)) / step))
    return np.asarray(step * np.arange(-count, count + 1))


def _levelled(depth_um: Array, logger: Logger, random: np.random.Generator) -> Array:
    """A map or profile (n_x, n_y) with the noise of the instrument and what levelling has left of the tilt."""
    along = random.standard_normal() * np.linspace(-1.0, 1.0, depth_um.shape[0])[:, None]
    across = random.standard_normal() * np.linspace(-1.0, 1.0, depth_um.shape[1])
    tilt = logger.tilt_um * (along + across) / 2.0
    return np.asarray(depth_um + tilt + logger.scar_noise_um * random.standard_normal(depth_um.shape))


def logged_scars(
    logger: Logger, test: Test, repeat: int, worn: Sequence[tuple[Array, Array, Array]], random: np.random.Generator
) -> tuple[MeasuredScar | MeasuredProfile, ...]:
    """Scars of the near and the far body, cleaned of debris, given as lines along and across [mm] and depths [mm]."""
    found: list[MeasuredScar | MeasuredProfile] = []
    for (x, y, depth), long in zip(worn, (False, True), strict=True):
        lines = scar_lines_um(test, long=long)
        along = np.array([np.interp(1e-3 * lines, x, column, 0.0, 0.0) for column in depth.T])
        if isinstance(test, LineTest):
            read = _levelled(1e3 * along.T[:, :1], logger, random)[:, 0]
            found.append(MeasuredProfile(repeat, "specimen" if long else "pad", lines, read))
        else:
            across = scar_lines_um(test, long=False)
            both = np.array([np.interp(1e-3 * across, y, row, 0.0, 0.0) for row in along.T])
            read = _levelled(1e3 * both, logger, random)
            found.append(MeasuredScar(repeat, "moving" if long else "fixed", lines, across, read))
    return tuple(found)
