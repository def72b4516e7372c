"""What the sensors read of a true loop, and the drive that holds its amplitude on what they read."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.independent.loop import ForceTable, TrueLoop, closed_loop
from studies.blind.generators.independent.world import World
from studies.blind.generators.signals import Signals, after_play, bent, read_by

Array = NDArray[np.float64]

DRIVE_STEPS, DRIVE_TOLERANCE = 12, 1e-6


@dataclass(frozen=True, eq=False)
class Reading:
    """Noise-free readings over a cycle at even times (n,): displacement [mm], forces [N]."""

    displacement_mm: Array
    tangential_force_N: Array
    normal_force_N: Array


def read(world: World, loop: TrueLoop, cycle: float) -> Reading:
    """Readings of a loop: gain, load coupling and lag of the displacement, crosstalk and curvature of the force."""
    sensors = world.sensors
    if world.instruments:
        loop = _instrumented(world, loop, cycle)
    force = loop.tangential_force_N + sensors.parallel_N_per_mm * loop.displacement_mm
    displacement = sensors.gain.at(cycle) * loop.displacement_mm
    displacement = displacement + bent(loop.displacement_mm, world.drive.amplitude_mm, sensors.displacement_cubic)
    displacement = displacement + sensors.linear_mm_per_N * force + sensors.quadratic_mm_per_N2 * force**2
    if sensors.displacement_play_mm:
        displacement = after_play(displacement, sensors.displacement_play_mm)
    if sensors.lag_s:
        displacement = _low_pass(displacement, 2.0 * np.pi * world.drive.frequency_Hz * sensors.lag_s)
    borne = after_play(force, sensors.force_play_N) if sensors.force_play_N else force
    borne = borne + sensors.force_asymmetry * np.abs(borne) + sensors.force_zero_N.at(cycle)
    tangential = borne + sensors.crosstalk * loop.normal_force_N - sensors.force_cubic_per_N2 * force**3
    return Reading(
        np.asarray(displacement + sensors.displacement_offset_mm),
        np.asarray(tangential + sensors.force_offset_N),
        np.asarray(loop.normal_force_N + sensors.crosstalk * force),
    )


def _instrumented(world: World, loop: TrueLoop, cycle: float) -> TrueLoop:
    """A loop as what stands between it and the sensors leaves it."""
    period = 1.0 / world.drive.frequency_Hz
    count = loop.displacement_mm.size
    time = np.asarray(np.arange(count) * (period / count), dtype=np.float64)
    true = Signals(time, period, 1e3 * loop.displacement_mm, loop.tangential_force_N, loop.normal_force_N)
    read_ = read_by(world.instruments, true, cycle)
    return replace(
        loop,
        displacement_mm=1e-3 * read_.displacement_um,
        tangential_force_N=read_.tangential_force_N,
        normal_force_N=read_.normal_force_N,
    )


def driven_loop(world: World, table: ForceTable, cycle: float) -> TrueLoop:
    """The loop under the drive, whose amplitude is held on the sensor's reading or on the true motion."""
    asked = world.drive.amplitude_mm * (1.0 + world.drive.amplitude_drift * cycle / world.drive.cycles)
    amplitude = asked
    for _ in range(DRIVE_STEPS):
        loop = closed_loop(world, table, amplitude)
        if not world.drive.held_on_sensor:
            return loop
        shown = read(world, loop, cycle).displacement_mm
        error = asked - 0.5 * float(shown.max() - shown.min())
        if abs(error) < DRIVE_TOLERANCE * asked:
            break
        amplitude += error
    return loop


def _low_pass(periodic: Array, reduced_time: float) -> Array:
    """A sensor of first order whose time constant is `reduced_time` radians of a cycle (n,)."""
    spectrum = np.fft.rfft(periodic)
    return np.fft.irfft(spectrum / (1.0 + 1j * reduced_time * np.arange(spectrum.size)), periodic.size)
