"""The true stroke of a rig whose drive holds the asked amplitude on the sensor's reading."""

from collections.abc import Callable
from dataclasses import dataclass

from wirewear.base.errors import SensorError
from wirewear.loops.sensor import Sensor
from wirewear.loops.signals import LoopSignals


@dataclass(frozen=True, eq=False)
class HeldStroke:
    """The true amplitude that was found, its loop and what the sensor reads of it; `evaluations` of the loop."""

    amplitude_um: float
    truth: LoopSignals
    readings: LoopSignals
    evaluations: int


def sensor_held_stroke(
    sensor: Sensor,
    asked_um: float,
    loop_at: Callable[[float], LoopSignals],
    *,
    first_guess_um: float | None = None,
    tolerance: float = 1e-6,
    most_evaluations: int = 30,
) -> HeldStroke:
    """Find the true displacement amplitude whose noise-free reading has the asked amplitude.

    a ← a + (asked − read(a)), a fixed-point iteration; from the second step on divided by the secant's slope
    (Steffensen's device), as a load-coupled sensor on a sticking contact reads several micrometres for each.

    Args:
        sensor: as the drive's control reads it.
        asked_um: amplitude to be held on the reading.
        loop_at: the true loop under a true amplitude in µm.
        first_guess_um: true amplitude to begin with, such as that of the cycle before; the asked one by default.
        tolerance: largest |read − asked| / asked.
        most_evaluations: of `loop_at`.

    Raises:
        SensorError: the asked amplitude is not positive, or no true amplitude was found.
    """
    if not asked_um > 0.0:
        raise SensorError(f"the amplitude to be held on the sensor's reading is {asked_um} um, but must be positive")
    amplitude = asked_um if first_guess_um is None else first_guess_um
    before: tuple[float, float] | None = None
    read = float("nan")
    for evaluation in range(1, most_evaluations + 1):
        truth = loop_at(amplitude)
        readings = sensor.read(truth)
        read = readings.displacement_amplitude_um
        if abs(read - asked_um) <= tolerance * asked_um:
            return HeldStroke(amplitude, truth, readings, evaluation)
        slope = 1.0 if before is None else (read - before[1]) / (amplitude - before[0])
        before = amplitude, read
        # A reading that hardly follows the stroke would throw the next guess far away.
        step = (asked_um - read) / max(slope, 0.1)
        amplitude = max(amplitude + step, 0.5 * amplitude)
    raise SensorError(
        f"no true stroke was found whose reading has an amplitude of {asked_um:g} um: after {most_evaluations} loops, "
        f"{before[0] if before else amplitude:g} um are read as {read:g} um"
    )
