"""The stroke of a drive whose amplitude is held on a sensor's reading."""

from collections.abc import Callable
from dataclasses import dataclass

from wirewear.base.errors import SensorError
from wirewear.loops.sensor import LoopSignals, Sensor


@dataclass(frozen=True, eq=False)
class HeldStroke:
    """A stroke for which the sensor reads the asked amplitude: the true amplitude, the true loop and its readings."""

    amplitude_um: float
    truth: LoopSignals
    readings: LoopSignals


def sensor_held_stroke(
    sensor: Sensor,
    asked_um: float,
    loop_at: Callable[[float], LoopSignals],
    *,
    first_guess_um: float | None = None,
    tolerance: float = 1e-6,
    most_evaluations: int = 30,
) -> HeldStroke:
    """The true displacement amplitude whose noise-free reading has the amplitude `asked_um`, with its loop.

    sensor: the one that controls the drive. loop_at: gives the true loop for a true amplitude in µm. first_guess_um:
    true amplitude to begin with; None: the asked one. tolerance: largest |read − asked| / asked. most_evaluations: of
    `loop_at`. Iterates a ← a + (asked − read(a)), from the second step on divided by the secant's slope (Steffensen's
    device). Raises SensorError if the asked amplitude is not positive, or no true amplitude is found.
    """
    if not asked_um > 0.0:
        raise SensorError(f"the amplitude to be held on the sensor's reading is {asked_um} um, but must be positive")
    amplitude = asked_um if first_guess_um is None else first_guess_um
    before: tuple[float, float] | None = None
    read = float("nan")
    for _ in range(most_evaluations):
        truth = loop_at(amplitude)
        readings = sensor.read(truth)
        read = readings.displacement_amplitude_um
        if abs(read - asked_um) <= tolerance * asked_um:
            return HeldStroke(amplitude, truth, readings)
        slope = 1.0 if before is None else (read - before[1]) / (amplitude - before[0])
        before = amplitude, read
        # A reading that hardly follows the stroke would throw the next guess far away.
        step = (asked_um - read) / max(slope, 0.1)
        amplitude = max(amplitude + step, 0.5 * amplitude)
    raise SensorError(
        f"no true stroke was found whose reading has an amplitude of {asked_um:g} um: after {most_evaluations} loops, "
        f"{before[0] if before else amplitude:g} um are read as {read:g} um"
    )
