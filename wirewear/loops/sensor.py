"""Model of a rig's displacement and force sensors, from true signals to readings and back, and of a drive they control.

A channel is one recorded signal, such as displacement or tangential force.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from math import isfinite, sqrt
from typing import Literal

import numpy as np

from geometry.arrays import Array, ComplexArray
from wirewear.base.errors import SensorError

_EVEN = 1e-6  # Spacings that differ by less than this share count as even.

LEAST_PASSED = 0.01  #: A filter that lets less than this share of the fastest oscillation through cannot be undone.

#: Damping of a rig that swings, as a share of the critical one; of bolted steel structures 1 to 3 % (Beards, Structural
#: Vibration, 1996, section 5.1).
DAMPING = 0.02

# Uneven samples are carried over to an even grid this many times as fine.
_REFINEMENT = 4
_LAGS = ("first-order", "delay")


@dataclass(frozen=True, eq=False)
class LoopSignals:
    """Signals of one cycle of a periodic loop, (n,) each; normal_force_N is None where unknown.

    time_s counts within the cycle; the last sample does not repeat the first. period_s may be None where the samples
    are evenly spread over the cycle. Raises SensorError for channels that differ in length or hold fewer than two
    samples.
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
        """Half of the displacement's range."""
        return 0.5 * float(np.ptp(self.displacement_um))

    @property
    def spacing_s(self) -> Array:
        """(n,) time from each sample to the next; the last entry reaches the first sample of the next cycle.

        Raises SensorError for times that do not rise, or a period that is needed but neither given nor evident.
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
        """True if the times between samples, the step into the next cycle included, differ by at most 10⁻⁶ of their
        mean. Raises SensorError as `spacing_s` does.
        """
        spacing = self.spacing_s
        return bool(np.ptp(spacing) <= _EVEN * spacing.mean())


def enclosed_area(x: Array, y: Array) -> float:
    """Area of a closed loop (n,) of samples joined by straight lines; positive if it turns clockwise (dissipates)."""
    return float(enclosed_areas(x[None], y[None])[0])


def enclosed_areas(x: Array, y: Array) -> Array:
    """(m,) area of each of m closed loops (m, n), positive where it turns clockwise."""
    # About its own middle, a loop far from the origin loses no digits.
    x, y = x - x.mean(axis=1, keepdims=True), y - y.mean(axis=1, keepdims=True)
    after_x, after_y = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    return 0.5 * np.asarray(np.einsum("ij,ij->i", after_x, y) - np.einsum("ij,ij->i", x, after_y))


LagKind = Literal["first-order", "delay"]

Transfer = Callable[[Array], ComplexArray]  #: Factors (n,) of the oscillations of given frequencies in Hz.


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviation of one sample of each channel, and the correlation ρ of neighbouring samples.

    The noise is a stationary autoregression of first order, e' = ρ e + √(1−ρ²) σ w with white w (Box & Jenkins, Time
    Series Analysis, section 3.2); ρ = 0 is white noise. Each loop gets independent noise.
    Raises SensorError for a negative deviation, or a correlation outside [0, 1).
    """

    displacement_um: float = 0.0
    tangential_force_N: float = 0.0
    normal_force_N: float = 0.0
    correlation: float = 0.0

    def __post_init__(self) -> None:
        for name in ("displacement_um", "tangential_force_N", "normal_force_N"):
            value = getattr(self, name)
            if not (isfinite(value) and value >= 0.0):
                raise SensorError(f"the noise of {name} is {value}, but must be a number that is not negative")
        if not 0.0 <= self.correlation < 1.0:
            raise SensorError(f"the noise's correlation is {self.correlation}, but must be at least 0 and below 1")

    def on(self, values: Array, deviation: float, random: np.random.Generator) -> Array:
        """Samples (n,) plus random noise of this standard deviation; 0 returns the samples themselves."""
        if deviation == 0.0:
            return values
        white = random.standard_normal(values.size)
        if self.correlation == 0.0:
            return values + deviation * white

        from scipy.signal import lfilter

        # The first sample already has the process's full deviation.
        white[1:] *= sqrt(1.0 - self.correlation**2)
        return np.asarray(values + deviation * lfilter([1.0], [1.0, -self.correlation], white))


def lagged(signals: LoopSignals, values: Array, time_s: float, kind: LagKind) -> Array:
    """The channel `values` (n,) of a periodic loop, delayed by a lag of `time_s` seconds.

    signals: the loop, for its times. A delay gives x(t − τ), a first-order lag the periodic solution of τ y' + y = x,
    both as products of the Fourier series with exp(−iωτ) and 1/(1 + iωτ) (e.g. Bendat & Piersol, Random Data, 4th ed.,
    section 2.3). Raises SensorError for values that are not finite, or times without a period.
    """
    return _filtered(signals, values, lambda frequency: _transfer(frequency, time_s, kind))


def advanced(signals: LoopSignals, values: Array, time_s: float, kind: LagKind) -> Array:
    """Inverse of `lagged`: the channel (n,) before a lag of `time_s` seconds, to round-off for evenly spread samples.
    Raises SensorError as `lagged` does, or for a filter so slow that undoing it would raise the noise a hundredfold.
    """

    def inverse(frequency: Array) -> ComplexArray:
        transfer = _transfer(frequency, time_s, kind)
        if np.abs(transfer).min() < LEAST_PASSED:
            raise SensorError(
                f"a first-order lag of {time_s:g} s cannot be undone on samples {1.0 / (2.0 * frequency[-1]):.3g} s "
                f"apart: it lets less than {LEAST_PASSED:.0%} of the fastest oscillation through"
            )
        return np.asarray(1.0 / transfer)

    return _filtered(signals, values, inverse)


def _transfer(frequency: Array, time_s: float, kind: LagKind) -> ComplexArray:
    angle = 2.0 * np.pi * frequency * time_s
    return np.asarray(np.exp(-1j * angle) if kind == "delay" else 1.0 / (1.0 + 1j * angle))


def swinging(signals: LoopSignals, force_N: Array, swing_s2: float, power: int = -1) -> Array:
    """Force u/C (n,) in N of the spring behind a mass m on which the periodic force Q (n,), `force_N`, acts, by m ü + c
    u̇ + u/C = Q (Den Hartog, Trans. ASME 53 (1931) APM-107).

    power: −1; with 1 the other way round, `force_N` is the spring's force and Q is returned. u is the mass's
    displacement, C the spring's compliance. swing_s2: m C in s², the inverse square of the mass's own angular
    frequency. The damping c is `DAMPING` of the critical one. Raises SensorError as `lagged` does.
    """

    def transfer(frequency: Array) -> ComplexArray:
        turns = 2.0 * np.pi * frequency * sqrt(swing_s2)
        return np.asarray((1.0 - turns**2 + 2j * DAMPING * turns) ** float(power))

    return _filtered(signals, force_N, transfer)


def _filtered(signals: LoopSignals, values: Array, transfer: Transfer) -> Array:
    if not np.isfinite(values).all():
        raise SensorError("a lag needs a loop without missing samples")
    spacing = signals.spacing_s
    period = float(spacing.sum())
    if signals.evenly_spread:
        return _on_even_grid(values, period, transfer)
    time = signals.time_s - signals.time_s[0]
    even = np.arange(_REFINEMENT * values.size, dtype=np.float64) * (period / (_REFINEMENT * values.size))
    filtered = _on_even_grid(_interpolated(time, values, period, even), period, transfer)
    return _interpolated(even, filtered, period, time)


def _on_even_grid(values: Array, period_s: float, transfer: Transfer) -> Array:
    n = values.size
    factors = transfer(np.asarray(np.fft.rfftfreq(n, period_s / n), dtype=np.float64))
    if n % 2 == 0:
        # The fastest oscillation on the grid has no phase of its own; its size alone can change, and back.
        factors[-1] = np.abs(factors[-1])
    return np.asarray(np.fft.irfft(factors * np.fft.rfft(values), n), dtype=np.float64)


def _interpolated(time: Array, values: Array, period_s: float, at: Array) -> Array:
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(np.append(time, period_s), np.append(values, values[0]), bc_type="periodic")
    return np.asarray(spline(at), dtype=np.float64)


_QUIET = SensorNoise()


@dataclass(frozen=True)
class Sensor:
    """Model of displacement sensor and force cell; with its default values it reads the true signals.

    With δ, Q, P the true displacement, tangential and normal force of a loop, it reads

        δ' = lag[gain · (δ + remote · Q) + linear · Q + quadratic · Q²] + noise
        Q' = lag_Q[gain_Q · (Q + crosstalk · P)] + noise,    P' = gain_P · (P + crosstalk · Q) + noise

    The remote compliance and the polynomial in the load follow Infante-García et al., Sensors 20 (2020) 4152, section
    2.1: the bodies yield between the measured point and the contact. Neither changes a loop's energy, as ∮Q df(Q) = 0.
    Raises SensorError for a number outside its range.

    Attributes:
        remote_compliance_um_per_N: of the driven side between the measured point and the point where δ is defined.
        displacement_gain: read over true displacement.
        linear_um_per_N, quadratic_um_per_N2: displacement read per tangential force, and per its square.
        tangential_force_gain, normal_force_gain: read over true force.
        force_crosstalk: share of each force that the other force channel reads too.
        lag_s: lag of the displacement behind the forces; if negative (delay only), the forces lag instead.
        lag_kind: kind of both lags, "first-order" (a low-pass filter's time constant) or "delay".
        force_lag_s: lag of the tangential force behind the other channels.
        swing_s2: mass of the holder between contact and force cell times the holder's compliance, see `swinging`.
        noise: noise of one sample of each channel.
    """

    remote_compliance_um_per_N: float = 0.0
    displacement_gain: float = 1.0
    linear_um_per_N: float = 0.0
    quadratic_um_per_N2: float = 0.0
    tangential_force_gain: float = 1.0
    normal_force_gain: float = 1.0
    force_crosstalk: float = 0.0
    lag_s: float = 0.0
    lag_kind: LagKind = "first-order"
    force_lag_s: float = 0.0
    swing_s2: float = 0.0
    noise: SensorNoise = _QUIET

    def __post_init__(self) -> None:
        for name in NUMBERS:
            value = getattr(self, name)
            if not isfinite(value):
                raise SensorError(f"the sensor's {name} is {value}, but must be a finite number")
            if name.endswith("_gain") and value <= 0.0:
                raise SensorError(f"the sensor's {name} is {value}, but must be positive")
        if (remote := self.remote_compliance_um_per_N) < 0.0:
            raise SensorError(f"the sensor's remote_compliance_um_per_N is {remote}, but must not be negative")
        if abs(self.force_crosstalk) >= 1.0:
            raise SensorError(f"the sensor's force_crosstalk is {self.force_crosstalk}, but must lie between -1 and 1")
        if self.lag_kind not in _LAGS:
            raise SensorError(f"the sensor's lag_kind is {self.lag_kind!r}, but must be one of {', '.join(_LAGS)}")
        for name in ("lag_s", "force_lag_s"):
            if (lag := getattr(self, name)) < 0.0 and self.lag_kind == "first-order":
                raise SensorError(f"the sensor's {name} is {lag}, but must not be negative unless it is a delay")

    def read(self, truth: LoopSignals, random: np.random.Generator | None = None) -> LoopSignals:
        """Readings of a loop with these true signals; random: adds noise, None: none is added.

        Raises SensorError for crosstalk without a normal force, or a lag of samples without a period.
        """
        displacement = self.displacement_gain * truth.displacement_um
        if load_coupling := self._load_coupling(truth.tangential_force_N):
            displacement = displacement + sum(load_coupling)
        if self.lag_s != 0.0:
            displacement = lagged(truth, displacement, self.lag_s, self.lag_kind)
        tangential = truth.tangential_force_N
        if self.swing_s2 > 0.0:
            tangential = swinging(truth, tangential, self.swing_s2)
        tangential, normal = self._mixed(tangential, truth.normal_force_N)
        tangential = self.tangential_force_gain * tangential
        if self.force_lag_s != 0.0:
            tangential = lagged(truth, tangential, self.force_lag_s, self.lag_kind)
        normal = None if normal is None else self.normal_force_gain * normal
        if random is not None:
            noise = self.noise
            displacement = noise.on(displacement, noise.displacement_um, random)
            tangential = noise.on(tangential, noise.tangential_force_N, random)
            normal = None if normal is None else noise.on(normal, noise.normal_force_N, random)
        return replace(truth, displacement_um=displacement, tangential_force_N=tangential, normal_force_N=normal)

    def corrected(self, readings: LoopSignals) -> LoopSignals:
        """True signals behind readings, which keep their noise; exact to round-off for noise-free, evenly spread
        readings.

        Raises SensorError for crosstalk without a normal force, a lag of samples without a period, or too slow a
        filter.
        """
        displacement = readings.displacement_um
        if self.lag_s != 0.0:
            displacement = advanced(readings, displacement, self.lag_s, self.lag_kind)
        tangential = readings.tangential_force_N
        if self.force_lag_s != 0.0:
            tangential = advanced(readings, tangential, self.force_lag_s, self.lag_kind)
        tangential = tangential / self.tangential_force_gain
        normal = readings.normal_force_N
        tangential, normal = self._unmixed(tangential, None if normal is None else normal / self.normal_force_gain)
        if self.swing_s2 > 0.0:
            tangential = swinging(readings, tangential, self.swing_s2, 1)
        if load_coupling := self._load_coupling(tangential):
            displacement = displacement - sum(load_coupling)
        return replace(
            readings,
            displacement_um=displacement / self.displacement_gain,
            tangential_force_N=tangential,
            normal_force_N=normal,
        )

    def _load_coupling(self, force_N: Array) -> list[Array]:
        """Terms (n,) in µm that the tangential force adds to the displacement before its lag; an empty list if there
        are none.
        """
        linear = self.linear_um_per_N + self.displacement_gain * self.remote_compliance_um_per_N
        terms = ((linear, 1), (self.quadratic_um_per_N2, 2))
        return [factor * force_N**power for factor, power in terms if factor != 0.0]

    def _mixed(self, tangential: Array, normal: Array | None) -> tuple[Array, Array | None]:
        if self.force_crosstalk == 0.0:
            return tangential, normal
        known = self._required(normal)
        return tangential + self.force_crosstalk * known, known + self.force_crosstalk * tangential

    def _unmixed(self, tangential: Array, normal: Array | None) -> tuple[Array, Array | None]:
        if self.force_crosstalk == 0.0:
            return tangential, normal
        known, c = self._required(normal), self.force_crosstalk
        return (tangential - c * known) / (1.0 - c**2), (known - c * tangential) / (1.0 - c**2)

    def _required(self, normal: Array | None) -> Array:
        if normal is None:
            raise SensorError("crosstalk between the forces needs the normal force, which this loop does not have")
        return normal


#: Names of the sensor's numbers, each neutral by default, and those of them that are no gains.
NUMBERS = tuple(field.name for field in fields(Sensor) if field.name not in {"lag_kind", "noise"})
OTHER_NUMBERS = tuple(name for name in NUMBERS if not name.endswith("_gain"))
