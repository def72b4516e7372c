"""Observables of whole channels: amplitude, normal force along the stroke, and columns of the evolution.

The normal force shows errors of the load's guide; wear hardly changes it. The evolution holds dissipated energy, slip
amplitude and largest force of loops over the cycles, as another program has read them. A shelf is a stretch of a loop
at zero force, by free play.
"""

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from geometry.arrays import Array, BoolArray
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.observe.local_lines import CHORD_ERROR, OUTLYING
from wirewear.diagnosis.observe.measured_loops import LEAST_NOISE, ReducedLoop, load_varies, mean_load
from wirewear.diagnosis.observe.observable import (
    FORCE_ERROR,
    SLOPE_SHARE,
    ModelLoops,
    Observable,
    OfLoops,
    Site,
    Sites,
    SolverSize,
    Zone,
    rows_of,
)
from wirewear.diagnosis.observe.observed_record import Reading, spread_cycles
from wirewear.diagnosis.surrogate.forward import PredictedLoops
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.sensed_loops import SLIDING, read_along
from wirewear.loops.noise import median_in_steps
from wirewear.loops.sensor import enclosed_areas

_KNOWN = constants("observe.channels.normal_along")

#: The middle of the stroke reaches so far, its ends begin there, as shares of the amplitude.
MIDDLE, OUTER = _KNOWN.each("middle", "outer")

#: Samples that a part of the stroke has at least.
FEWEST = _KNOWN.count("fewest")

_OF_EVOLUTION = constants("observe.channels.evolution")

#: Cycles that are used at most; they lie further than this ratio from all logged loops, which would count them twice.
MOST_CYCLES, FAR = _OF_EVOLUTION.count("most_cycles"), _OF_EVOLUTION.number("far")

#: The largest of some hundred noisy samples lies this many standard deviations too high, if another program took it.
PEAK_BIAS = _OF_EVOLUTION.number("peak_bias")

#: A column shows its own noise by at least so many figures.
FEWEST_FIGURES = _OF_EVOLUTION.count("fewest")

#: By how much, relative, the program that read an evolution may define a figure otherwise.
ERROR = _OF_EVOLUTION.number("figure_error")


class _OfNormalForce(OfLoops):
    """Observable that is read where the normal force was measured."""

    simulated = True

    def sites(self, reading: Reading) -> list[Site]:
        return [Site(cycle) for cycle in reading.cycles if any(loop.normal_N for loop in reading.at(cycle))]

    def whole(self, setup: SurrogateInputs, predicted: Array) -> Array:
        return np.full(predicted.size, setup.load_N)


def _loads_of(predicted: PredictedLoops) -> Array:
    """Mean normal forces (n, 2) of both branches while sliding, over all of the displacement if the load varies; over
    its later half where a contact sticks.
    """
    x, p = predicted.displacement_um, predicted.normal_force_N
    sliding = mean_load(x, p) if load_varies(p) else p[:, :, SLIDING:].mean(axis=2)
    return np.where(predicted.slip_um[:, None] == 0.0, mean_load(x, p, late=True), sliding)


class NormalForce(_OfNormalForce):
    """Mean normal force in N over both branches while sliding; NaN if it was not measured."""

    name = "normal"
    words, unit = "normal force", "N"
    zones = (Zone("normal", "normal force"),)

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:  # noqa: ARG002
        if loop.normal_N is None:
            return np.nan, np.nan
        return float(np.mean(loop.normal_N)), loop.normal_error_N / float(np.sqrt(2.0))

    def predict(self, predicted: PredictedLoops, sites: Sites) -> Array:
        return np.asarray(_loads_of(predicted).mean(axis=1)[rows_of(predicted, sites)])


class NormalForceByDirection(_OfNormalForce):
    """Mean normal force in N of the branch towards +x less that of the other, while sliding; NaN if it was not
    measured.
    """

    name = "normal_direction"
    words, unit = "normal force, forward less backward", "N"
    zones = (Zone("normal_direction", "normal force by direction"),)

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:  # noqa: ARG002
        if loop.normal_N is None:
            return np.nan, np.nan
        return loop.normal_N[0] - loop.normal_N[1], loop.normal_error_N * float(np.sqrt(2.0))

    def predict(self, predicted: PredictedLoops, sites: Sites) -> Array:
        forward, backward = _loads_of(predicted).T
        return np.asarray(forward - backward)[rows_of(predicted, sites)]


class _AlongStroke(OfLoops):
    """Normal force in one part of the stroke less that in another, mean of both branches."""

    unit = "N"

    @abstractmethod
    def parts(self, place: Array) -> tuple[BoolArray, BoolArray]:
        """Marks of the samples in one part and in the other; `place` is displacement over amplitude."""

    def sites(self, reading: Reading) -> list[Site]:
        return [
            Site(cycle)
            for cycle in reading.cycles
            if any(branch.normal_N is not None for loop in reading.at(cycle) for branch in loop.branches)
        ]

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:  # noqa: ARG002
        """Mean over both branches of the difference of medians in N, and its noise."""
        values, variances = [], []
        for branch in loop.branches:
            if branch.normal_N is None:
                return np.nan, np.nan
            slides = np.arange(branch.displacement_um.size) > branch.knee
            place = branch.sign * branch.displacement_um / loop.amplitude_um
            one, other = (branch.normal_N[slides & part] for part in self.parts(place))
            if min(one.size, other.size) < FEWEST:
                return np.nan, np.nan
            values.append(median_in_steps(one) - median_in_steps(other))
            # The mean of a branch has this error, of all its samples together.
            variances.append(loop.normal_error_N**2 * np.count_nonzero(slides) * (1.0 / one.size + 1.0 / other.size))
        # A median of normal deviates scatters by a factor √(π/2) more than their mean.
        return 0.5 * sum(values), float(0.5 * np.sqrt(0.5 * np.pi * sum(variances)))

    def predict(self, predicted: PredictedLoops, sites: Sites) -> Array:
        x, load = predicted.displacement_um, predicted.normal_force_N[..., SLIDING:]
        place = x[..., SLIDING:] / (0.5 * np.ptp(x, axis=(1, 2)))[:, None, None]
        one, other = (_medians(load, part) for part in self.parts(place))
        both = np.isfinite(one) & np.isfinite(other)
        found: Array = 0.5 * np.subtract(one, other, out=np.zeros_like(one), where=both).sum(axis=1)
        return found[rows_of(predicted, sites)]


def _medians(values: Array, chosen: BoolArray) -> Array:
    """Medians (...) of the chosen values (..., m), infinite where none is chosen."""
    ordered = np.sort(np.where(chosen, values, np.inf), axis=-1)
    count = np.count_nonzero(chosen, axis=-1)[..., None]
    low, high = (np.take_along_axis(ordered, np.maximum(at, 0), axis=-1) for at in ((count - 1) // 2, count // 2))
    medians: Array = 0.5 * (low + high)[..., 0]
    return medians


class NormalForceAtEnds(_AlongStroke):
    """Median normal force in N at both ends of the stroke less that in its middle, while sliding; mean of both
    branches.
    """

    name = "normal_ends"
    words = "normal force, ends of the stroke less its middle"
    zones = (Zone("normal_ends", "normal force at the ends"),)

    def parts(self, place: Array) -> tuple[BoolArray, BoolArray]:
        return np.abs(place) > OUTER, np.abs(place) < MIDDLE


class NormalForceBySides(_AlongStroke):
    """Median normal force in N on the +x side of the stroke less that on its −x side, while sliding; mean of both
    branches.
    """

    name = "normal_sides"
    words = "normal force, one side of the stroke less the other"
    zones = (Zone("normal_sides", "normal force by side"),)

    def parts(self, place: Array) -> tuple[BoolArray, BoolArray]:
        return place > MIDDLE, place < -MIDDLE


class Amplitude(OfLoops):
    """Displacement amplitude in µm: half of a loop's extent."""

    name = "amplitude"
    words, unit = "displacement amplitude", "um"
    zones = (Zone("amplitude", "displacement amplitude"),)

    def sites(self, reading: Reading) -> list[Site]:
        return [Site(cycle) for cycle in reading.cycles]

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:  # noqa: ARG002
        return loop.amplitude_um, loop.amplitude_error_um

    def predict(self, predicted: PredictedLoops, sites: Sites) -> Array:
        x = predicted.displacement_um
        return np.asarray(0.5 * (x.max(axis=(1, 2)) - x.min(axis=(1, 2))))[rows_of(predicted, sites)]


class EvolutionFigure(Observable):
    """One column of the evolution; its noise is estimated from its scatter over the cycles."""

    column: ClassVar[str]

    @abstractmethod
    def of_loops(self, displacement_um: Array, force_N: Array) -> Array:
        """The column's value (n,) for computed loops (n, 2, m)."""

    def sites(self, reading: Reading) -> list[Site]:
        """Sites at cycles of the evolution that differ by more than the factor `FAR` from all logged loops', at most
        `MOST_CYCLES`.
        """
        logged = np.array(reading.cycles, dtype=float)
        known = sorted({int(cycle) for part in reading.evolution for cycle in part.columns["cycle"] if cycle > 0})
        far = [cycle for cycle in known if np.all(np.abs(np.log(cycle / logged)) > np.log(FAR))]
        return [Site(cycle) for cycle in spread_cycles(far, MOST_CYCLES)]

    def measure(self, reading: Reading, repeat: int, sites: Sites) -> tuple[Array, Array]:
        values, share = np.full(len(sites), np.nan), None
        for part in reading.evolution:
            if part.repeat == repeat and self.column in part.columns:
                figures = part.columns[self.column]
                share, sound = own_noise(part.columns["cycle"], figures)
                for place, cycle in enumerate(sites.cycle):
                    here = np.flatnonzero(sound & (part.columns["cycle"] == cycle))
                    values[place] = figures[here[0]] if here.size else np.nan
        noise = (ERROR if share is None else share) * np.abs(values)
        return values, np.hypot(noise, np.sqrt(0.5) * self.missed(reading))

    def common_error(self, reading: Reading, sites: Sites) -> Array:
        """Standard deviation (n,) of the error that all repeats share, in the column's unit.

        Its parts: another definition of the figure by another program (`ERROR` of its usual size), and half the
        variance of `missed`, whose other half is taken to differ from repeat to repeat.
        """
        defined = ERROR * _usual_figures(reading, self.column, sites)
        return np.asarray(np.hypot(defined, np.sqrt(0.5) * self.missed(reading)))

    def missed(self, reading: Reading) -> float:  # noqa: ARG002
        """Standard deviation, in the column's unit, of the error by straight lines between the few samples of a loop;
        by default 0.
        """
        return 0.0

    def predict(self, predicted: PredictedLoops, sites: Sites) -> Array:
        return self.of_loops(predicted.displacement_um, predicted.tangential_force_N)[rows_of(predicted, sites)]


class Energy(EvolutionFigure):
    """Dissipated energy in mJ from the evolution: the area of the loop."""

    name = "energy"
    words, unit = "dissipated energy", "mJ"
    zones = (Zone("energy", "energy (evolution)"),)
    column = "dissipated_energy_mJ"

    def of_loops(self, displacement_um: Array, force_N: Array) -> Array:
        return loop_area(displacement_um, force_N)

    def missed(self, reading: Reading) -> float:
        """Energy in mJ between both stick branches and the straight lines that join their samples."""
        return 2e-3 * reading.force_N * _chord_error_um(reading)


class SlipAmplitude(EvolutionFigure):
    """Slip amplitude in µm from the evolution: half of the loop's width."""

    name = "slip"
    words, unit = "slip amplitude", "um"
    zones = (Zone("slip", "slip amplitude (evolution)"),)
    column = "slip_amplitude_um"

    def of_loops(self, displacement_um: Array, force_N: Array) -> Array:
        return half_width(displacement_um, force_N)

    def missed(self, reading: Reading) -> float:
        return _chord_error_um(reading)

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:
        """Solver differences in µm of the crossing of zero force, which is uncertain on a shelf, but alike on all
        shelves.
        """
        crossing = loops.travel_um(sites, FORCE_ERROR * loops.scale.force_N) / np.sqrt(12.0)
        return SolverSize(np.zeros(len(sites)), own=crossing / np.sqrt(2.0), common=crossing)


class LargestForce(EvolutionFigure):
    """Largest |Q| in N from the evolution."""

    name = "force"
    words, unit = "largest tangential force", "N"
    zones = (Zone("force", "largest force (evolution)"),)
    column = "max_tangential_force_N"

    def of_loops(self, displacement_um: Array, force_N: Array) -> Array:  # noqa: ARG002
        return np.asarray(np.abs(force_N).max(axis=(1, 2)))

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:
        """Solver differences: the share `SLOPE_SHARE` of the force that slopes add at the end of the stroke."""
        return SolverSize(SLOPE_SHARE * loops.rise_N(sites))

    def common_error(self, reading: Reading, sites: Sites) -> Array:
        """Standard deviation (n,) in N of the error that all repeats share, including the bias of taking the largest
        noisy sample.
        """
        return np.hypot(PEAK_BIAS * reading.sample_noise_N, super().common_error(reading, sites))


def own_noise(cycles: Array, figures: Array) -> tuple[float | None, BoolArray]:
    """Relative noise of figures (n,), and marks (n,) of those that are sound: positive and near the line between their
    neighbours over log cycle; the noise is None if there are too few. A figure far off that line is unsound, as a
    loop's largest force may be an outlying sample.
    """
    sound = np.isfinite(figures) & (figures > 0.0) & (cycles > 0.0)
    places = np.flatnonzero(sound)
    time, logs = np.log(cycles[places]), np.log(figures[places])
    if time.size < FEWEST_FIGURES or np.any(np.diff(time) <= 0.0):
        return None, sound
    for _ in range(places.size // 5):
        # From the line between both neighbours, scaled to the standard deviation of one value.
        share = (time[1:-1] - time[:-2]) / (time[2:] - time[:-2])
        away = logs[1:-1] - (1.0 - share) * logs[:-2] - share * logs[2:]
        away /= np.sqrt(1.0 + share**2 + (1.0 - share) ** 2)
        noise = max(1.4826 * float(np.median(np.abs(away))), LEAST_NOISE)
        worst = int(np.argmax(np.abs(away)))
        if np.abs(away[worst]) <= OUTLYING * noise or time.size <= FEWEST_FIGURES:
            break
        sound[places[worst + 1]] = False
        places, time, logs = (np.delete(values, worst + 1) for values in (places, time, logs))
    return noise, sound


def _chord_error_um(reading: Reading) -> float:
    """Median error in µm of half a loop's width at zero force, by straight lines between samples."""
    steps = [branch.step_at_zero_um for loop in reading.loops for branch in loop.branches]
    return CHORD_ERROR * float(np.median(steps)) if steps else 0.0


def _usual_figures(reading: Reading, column: str, sites: Sites) -> Array:
    """Mean figure (n,) of all repeats at the cycle nearest to each site's; 0 if the evolution lacks the column."""
    parts = [part.columns for part in reading.evolution if column in part.columns]
    if not parts:
        return np.zeros(len(sites))
    cycles, figures = (np.concatenate([np.asarray(one[name]) for one in parts]) for name in ("cycle", column))
    away = np.abs(np.log(np.maximum(cycles, 1.0)) - np.log(np.maximum(sites.cycle, 1.0))[:, None])
    near = (away <= away.min(axis=1, keepdims=True)) & np.isfinite(figures)
    count = near.sum(axis=1)
    return np.asarray(np.where(near, np.nan_to_num(figures), 0.0).sum(axis=1) / np.maximum(count, 1))


def loop_area(x: Array, q: Array) -> Array:
    """Areas (n,) in mJ of loops (n, 2, m): displacements in µm and forces in N."""
    return 1e-3 * enclosed_areas(x.reshape(len(x), -1), q.reshape(len(q), -1))


def half_width(x: Array, q: Array) -> Array:
    """Half the width (n,) of loops (n, 2, m) at their mean force, in the unit of x."""
    middle = 0.5 * (q.max(axis=(1, 2)) + q.min(axis=(1, 2)))
    each = np.arange(len(x))
    back, there = (
        read_along(np.maximum.accumulate(sign * q[:, side], axis=1), x[:, side], each, sign * middle)
        for side, sign in ((1, -1.0), (0, 1.0))
    )
    return 0.5 * (back - there)
