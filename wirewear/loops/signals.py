"""The channels of one loop, true or read, and the area that a closed loop encloses: the energy that it dissipates."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from wirewear.base.errors import SensorError

_EVEN = 1e-6  # Spacings that differ by less than this share count as even.


@dataclass(frozen=True, eq=False)
class LoopSignals:
    """One cycle of a periodic loop; arrays (n,), `normal_force_N` None where it is not known.

    `time_s` counts within the cycle; the last sample does not repeat the first. `period_s` may be left out where the
    samples are evenly spread over the cycle.
    Raises SensorError for channels that differ in length or hold fewer than two samples.
    """

    time_s: Array
    displacement_um: Array
    tangential_force_N: Array
    normal_force_N: Array | None = None
    period_s: float | None = None

    def __post_init__(self) -> None:
        for name in ("time_s", "displacement_um", "tangential_force_N", "normal_force_N"):
            values = getattr(self, name)
            if values is not None:
                object.__setattr__(self, name, np.asarray(values, dtype=float))
                if np.shape(values) != np.shape(self.time_s) or np.ndim(values) != 1 or np.size(values) < 2:
                    raise SensorError(
                        f"{name} has the shape {np.shape(values)}, but every channel of a loop must be one row of as "
                        f"many samples as time_s, at least two"
                    )

    @property
    def displacement_amplitude_um(self) -> float:
        """Half of the displacement's range, which is what a drive holds."""
        return 0.5 * float(np.ptp(self.displacement_um))

    @property
    def spacing_s(self) -> Array:
        """Times from each sample to the next, the last to the first of the next cycle (n,).
        Raises SensorError for times that do not rise, or whose period is needed and neither given nor evident.
        """
        steps = np.diff(self.time_s)
        if not (steps > 0.0).all():
            raise SensorError("time_s must rise from sample to sample for a lag to have a meaning")
        if self.period_s is None:
            if np.ptp(steps) > _EVEN * steps.mean():
                raise SensorError("the samples are not evenly spread over the cycle, so the loop's period_s is needed")
            return np.append(steps, steps.mean())
        last = self.period_s - float(self.time_s[-1] - self.time_s[0])
        if last <= 0.0:
            raise SensorError(f"the samples span more than the period of {self.period_s:g} s that is given")
        return np.append(steps, last)

    @property
    def evenly_spread(self) -> bool:
        """Whether all spacings are equal."""
        spacing = self.spacing_s
        return bool(np.ptp(spacing) <= _EVEN * spacing.mean())


def enclosed_area(x: Array, y: Array) -> float:
    """Area of a closed loop (n,) of samples joined by straight lines, the last one with the first.

    Positive when it turns clockwise, as a loop that dissipates does.
    """
    return float(enclosed_areas(x[None], y[None])[0])


def enclosed_areas(x: Array, y: Array) -> Array:
    """Areas (m,) of closed loops (m, n)."""
    # About its own middle, a loop far from the origin loses no digits.
    x, y = x - x.mean(axis=1, keepdims=True), y - y.mean(axis=1, keepdims=True)
    after_x, after_y = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    return 0.5 * np.asarray(np.einsum("ij,ij->i", after_x, y) - np.einsum("ij,ij->i", x, after_y))
