"""What a drive may hold in place of its own amplitude: slip, force, energy or a reading; each measured on a loop."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, cast

import numpy as np

from geometry.arrays import Array, IntArray
from solvers import ContactState, CycleTrace, SolverError
from wirewear.effects import Age, Seam, applied
from wirewear.loops.sensor import LoopSignals, Sensor, enclosed_area
from wirewear.study import AnyStudy
from wirewear.study.programme import held_by

WITHIN = 1e-3  #: A drive is corrected until what it holds is met within this share.
MOST_CORRECTIONS = 12
_LEAST, _MOST = 0.3, 3.0  # Of an amplitude: those to be tried next.
_PROBED = 2e-4  # Of the amplitude: how well the place of the mean force is sought.
_INSIDE = 0.1  # Of the interval in which the amplitude lies: no guess comes nearer to its ends.


def dissipated_energy_mJ(trace: CycleTrace) -> float:
    """The area of a closed loop; without friction what is left of it is round-off to either side of 0."""
    return max(enclosed_area(trace.drive, trace.tangential_force), 0.0)


def slip_amplitude_mm(trace: CycleTrace) -> float:
    """Half the width of a closed loop at its mean force, from 0 to half the stroke, mm; also of half a cycle whose
    other half is its mirror image.

    A branch meets that force before all nodes slide, or else it does so by the slope of a worn scar, which may carry
    more than friction: then it is where all of them come to slide.
    """
    if not any(distance.any() for distance in trace.slid):
        # Where all floats in free play the force that the loop would be judged by is round-off.
        return 0.0
    force, drive, falling = trace.tangential_force, trace.drive, trace.phase <= 0.5
    # Number of sticking nodes at the end of each increment (n,), which may have been taken in pieces.
    reports = iter(trace.reports)
    sticking = np.array([next(one.sticking for one in reports if one.drive == state.drive) for state in trace.states])
    mean, met = _mean_force(trace), 0.0
    if _is_half(trace):
        start = np.append(trace.start.drive, drive), np.append(-force[-1], force)
        return max(abs(trace.start.drive) - _travel(*start, sticking, float(np.sign(drive[-1])), mean), 0.0)
    for own, sign in ((falling, -1.0), (~falling, 1.0)):
        stroke = np.flatnonzero(own)
        points = np.append(stroke[0] - 1, stroke)
        met += _travel(drive[points], force[points], sticking[stroke], sign, mean)
    return max(0.5 * float(np.ptp(drive)) - 0.5 * met, 0.0)


def _is_half(trace: CycleTrace) -> bool:
    falling = trace.phase <= 0.5
    return bool(falling.all() or not falling.any())


def _mean_force(trace: CycleTrace) -> float:
    """Mean over the way of a closed loop, N; 0 of half of one whose other half is its mirror image."""
    if _is_half(trace):
        return 0.0
    step = np.abs(np.diff(trace.drive, prepend=trace.drive[-1]))
    return float(step @ (trace.tangential_force + np.roll(trace.tangential_force, 1))) / (2.0 * float(step.sum()))


def _travel(drive: Array, force: Array, sticking: IntArray, sign: float, mean: float) -> float:
    """Travel along a stroke (n + 1,) in one direction until it meets the mean force or all nodes (n,) slide."""
    travel = np.abs(drive - drive[0])
    below = sign * (mean - force)
    slides = np.flatnonzero(sticking == 0)
    met = float(travel[slides[0] + 1]) if slides.size else float(travel[-1])
    passed = np.flatnonzero(below <= 0.0)
    if passed.size and (after := int(passed[0])):
        share = below[after - 1] / (below[after - 1] - below[after])
        return min(met, float(travel[after - 1] + share * (travel[after] - travel[after - 1])))
    return 0.0 if passed.size else met


#: The force after one increment from a state to a place of the drive in mm, N.
Probe = Callable[[ContactState, float], float]


def probed_slip_mm(trace: CycleTrace, probe: Probe) -> float:
    """The slip amplitude of a cycle, or of half of one, whose increments are too long to show where it begins.

    From each end of the stroke an increment is sought that meets the mean force.
    """
    from scipy.optimize import brentq

    force, drive = trace.tangential_force, trace.drive
    strokes = [(trace.start, slice(None), -force[-1])]
    mean, met = _mean_force(trace), 0.0
    if not _is_half(trace):
        turn = int(np.argmax(np.abs(drive - trace.start.drive)))
        strokes = [(trace.start, slice(turn + 1), force[-1]), (trace.states[turn], slice(turn + 1, None), force[turn])]
    for start, own, begins in strokes:
        travel = np.append(0.0, np.abs(drive[own] - start.drive))
        sign = float(np.sign(begins - mean))
        above = sign * (np.append(begins, force[own]) - mean)
        passed = int(np.argmax(above <= 0.0))
        if passed == 0:
            met += float(travel[-1])
            continue
        known = dict(zip(travel.tolist(), above.tolist(), strict=True))

        def force_above(way: float, start: ContactState, known: dict[float, float], sign: float) -> float:
            if way in known:
                return known[way]
            place = start.drive - np.sign(start.drive) * way
            return float(sign * (probe(start, place) - mean))

        within = _PROBED * abs(trace.start.drive)
        met += float(brentq(force_above, *travel[passed - 1 : passed + 1], (start, known, sign), within))
    return max(abs(trace.start.drive) - met / len(strokes), 0.0)


#: A figure of a cycle, or of half of one whose other half is its mirror image; a probe where increments are long.
Measure = Callable[[CycleTrace, Probe | None], float]


@dataclass(frozen=True)
class HeldFigure:
    """A figure of the loop that a drive holds by its amplitude, with which the figure grows."""

    key: str  #: Of the study, which states `target`, in `unit`.
    target: float
    unit: str
    largest_mm: float  #: Amplitude that the drive has at most.
    measure: Measure
    #: How much it is expected to grow by a longer stroke, per mm, where the bodies slide; None where it grows in
    #: proportion.
    slope: Callable[[CycleTrace], float] | None
    first_mm: float  #: Amplitude to begin with.

    def error(self, trace: CycleTrace) -> float:
        """Relative difference of a measured loop's figure from what is to be held."""
        return self.measure(trace, None) / self.target - 1.0


@dataclass
class AmplitudeSearch:
    """Looks for the amplitude that holds a figure: one too small, one too large, and the latest with its figure."""

    held: HeldFigure
    small_mm: float = 0.0
    large_mm: float = field(default=np.inf)
    _latest: tuple[float, float] | None = None
    _tries: int = 0

    def following(self, amplitude_mm: float, trace: CycleTrace, probe: Probe | None = None) -> float | None:
        """The amplitude to try after this one, None where it holds the figure.

        probe: for a trace whose increments are long.
        Raises SolverError where none that the drive has does.
        """
        held, found = self.held, self.held.measure(trace, probe)
        lacking, self._tries = held.target - found, self._tries + 1
        if abs(lacking) <= WITHIN * held.target:
            return None
        if self._tries > MOST_CORRECTIONS:
            raise SolverError(
                f"no amplitude was found at which the drive holds {held.key} = {held.target:g}: at "
                f"{1e3 * amplitude_mm:.4g} um it comes to {found:.4g} {held.unit}"
            )
        if self.large_mm - self.small_mm <= WITHIN * amplitude_mm:
            return None  # steps of the figure, where nodes come to slide, are larger than what is wanted
        if lacking > 0.0:
            self.small_mm = max(self.small_mm, amplitude_mm)
        else:
            self.large_mm = min(self.large_mm, amplitude_mm)
        if lacking > 0.0 and amplitude_mm >= held.largest_mm:
            raise SolverError(
                f"the drive cannot hold {held.key} = {held.target:g}: at its largest amplitude, "
                f"{1e3 * held.largest_mm:g} um, it comes to {found:.4g} {held.unit}, with a tangential force of "
                f"{float(np.abs(trace.tangential_force).max()):.4g} N; hold less, or give a larger "
                "displacement_amplitude_um"
            )
        before, self._latest = self._latest, (amplitude_mm, found)
        if before is not None and (found - before[1]) * (amplitude_mm - before[0]) > 0.0:
            wanted = amplitude_mm + lacking * (amplitude_mm - before[0]) / (found - before[1])
        elif held.slope is not None:
            wanted = amplitude_mm + lacking / held.slope(trace)
        else:
            wanted = amplitude_mm * held.target / max(found, 1e-9 * held.target)
        high = min(self.large_mm, _MOST * amplitude_mm)
        low = max(self.small_mm, _LEAST * amplitude_mm)
        margin = _INSIDE * (high - low) if np.isfinite(self.large_mm) and self.small_mm else 0.0
        return float(min(np.clip(wanted, low + margin, high - margin), held.largest_mm))


def _slip_um(trace: CycleTrace, probe: Probe | None) -> float:
    return 1e3 * (slip_amplitude_mm(trace) if probe is None else probed_slip_mm(trace, probe))


def _apart_um(trace: CycleTrace, _: Probe | None) -> float:
    """Amplitude of the bodies' motion against each other where they are held, half of its range."""
    return 500.0 * float(np.ptp([state.drive - state.holder_x for state in (trace.start, *trace.states)]))


def _largest_force_N(trace: CycleTrace, _: Probe | None = None) -> float:
    return float(np.abs(trace.tangential_force).max())


def _energy_mJ(trace: CycleTrace, _: Probe | None) -> float:
    return (2.0 if _is_half(trace) else 1.0) * trace.friction_work


def _read_um(sensor: Sensor, trace: CycleTrace, _: Probe | None) -> float:
    """Amplitude that a sensor at the drive reads, but for its lag."""
    drive, force, normal = 1e3 * trace.drive, trace.tangential_force, trace.normal_force
    if _is_half(trace):
        drive, force, normal = np.append(drive, -drive), np.append(force, -force), np.append(normal, normal)
    return 0.5 * float(
        np.ptp(sensor.read(LoopSignals(np.arange(float(drive.size)), drive, force, normal)).displacement_um)
    )


def held_of(study: AnyStudy[Any]) -> HeldFigure | None:
    """What a study's drive holds in place of its amplitude, None where it holds that."""
    stated, largest_um = held_by(study.conditions), study.conditions.displacement_amplitude_um
    if stated is None:
        return None
    holder = study.tables.rig
    friction_N = study.contact.friction * holder.normal_load_N
    sensor = replace(applied(study.effects, Seam.SENSOR, Sensor(), Age.new()), lag_s=0.0)
    unit, per_mm = "um", cast("Callable[[CycleTrace], float] | None", lambda _: 1e3)
    measure: Measure
    match stated.figure:
        case "slip":
            measure = _slip_um
        case "motion":
            measure = _apart_um
        case "reading":
            measure = partial(_read_um, sensor)
        case "energy":
            measure, unit, per_mm = _energy_mJ, "mJ", lambda trace: 4.0 * _largest_force_N(trace)
        case _:
            measure, unit, per_mm = _largest_force_N, "N", None
    carried_um = 1e3 * friction_N * holder.compliance_at_contact_mm_per_N
    first_mm = 1e-3 * stated.first_um(friction_N, carried_um, largest_um)
    return HeldFigure(stated.key, stated.value, unit, 1e-3 * largest_um, measure, per_mm, first_mm)
