"""Counters of a run (increments, cycles, time, worst residuals) and its qualities, from measured loops.

Qualities are explained in `wirewear.results.health`.
"""

import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from math import isnan, nan

import numpy as np

from solvers import ContactProblem, CycleTrace, IncrementReport, mirror_error, symmetry_of
from wirewear.base.course import enclosed_energy
from wirewear.loops.sensor import enclosed_area
from wirewear.results import BULK_WORK
from wirewear.results.health import ENERGIES_AGREE
from wirewear.simulation.measures import slip_mismatch

QUALITY = (
    "force_balance", "penetration", "complementarity", "slip_direction_error_rad", "elastic_slip",
    "loop_area_against_friction_work", "volume_against_energy", "first_cycle_against_loop", "energy_against_loops",
    "mirror_error", "slip_against_loops",
    "depth_between_nodes", "slip_between_nodes",
)  # fmt: skip

_ROUND_OFF = 1e-9  # What nodes that all but stick dissipate, over the rectangles around the loops.
#: A cycle, the friction work per cycle there and the friction energy so far, mJ.
Energies = tuple[float, float, float]


@dataclass
class Counters:
    """Counts of a run, and the worst value so far of each quality; NaN where it is not defined."""

    increments: float = 0.0
    iterations: float = 0.0
    simulated_cycles: float = 0.0
    cycling_s: float = 0.0
    force_balance: float = 0.0
    penetration: float = 0.0
    complementarity: float = 0.0
    slip_direction_error_rad: float = 0.0
    elastic_slip: float = 0.0
    loop_area_against_friction_work: float = 0.0
    volume_against_energy: float = 0.0
    first_cycle_against_loop: float = nan
    energy_against_loops: float = 0.0
    slip_against_loops: float = nan
    mirror_error: float = nan
    depth_between_nodes: float = nan  #: At the latest measured cycle.
    slip_between_nodes: float = nan

    def count(self, report: IncrementReport) -> None:
        """Count one increment and its iterations, and keep each residual that exceeds the largest so far."""
        self.increments += 1
        self.iterations += report.iterations
        self.worst("force_balance", report.force_error)
        self.worst("penetration", report.penetration)
        self.worst("complementarity", report.complementarity)
        self.worst("slip_direction_error_rad", report.slip_direction_error)
        self.worst("elastic_slip", report.elastic_slip)

    def worst(self, name: str, value: float) -> None:
        """Keep the larger of `value` and the value of the quality `name`; NaN is ignored."""
        setattr(self, name, float(np.fmax(getattr(self, name), value)))

    def quality(self) -> dict[str, float]:
        """The worst value of each quality, by name, without those that are NaN."""
        found = {name: getattr(self, name) for name in QUALITY}
        return {name: value for name, value in found.items() if not isnan(value)}


@dataclass
class Tally:
    """A run's counters, its clock, and values of the contact under the normal load alone (`fresh`, by name)."""

    counters: Counters = field(default_factory=Counters)
    fresh: dict[str, float] = field(default_factory=dict)
    preparation_s: float = 0.0
    _started: float = 0.0

    def start_cycling(self) -> None:
        """Start the clock of cycling; call it once meshes are prepared."""
        self._started = time.perf_counter()

    @property
    def cycling_s(self) -> float:
        """Seconds of cycling so far, including those before the run was resumed."""
        return self.counters.cycling_s + time.perf_counter() - self._started

    def for_checkpoint(self) -> dict[str, float]:
        """All counters, times and fresh values by name, from which `restore` goes on."""
        times = {"preparation_s": self.preparation_s, "cycling_s": self.cycling_s}
        return asdict(self.counters) | times | self.fresh

    def restore(self, counted: Mapping[str, float]) -> None:
        """Set counters and fresh values to what `for_checkpoint` of an interrupted run gave."""
        names = {item.name for item in fields(Counters)}
        self.counters = Counters(**{name: value for name, value in counted.items() if name in names})
        self.fresh = {name: value for name, value in counted.items() if name.startswith("fresh_")}


def judge(counters: Counters, trace: CycleTrace, rows: Sequence[Mapping[str, float]]) -> None:
    """Update the qualities in `counters` by the latest measured cycle. rows: the evolution's, up to that cycle."""
    counters.worst("loop_area_against_friction_work", area_mismatch(trace, rows[-1].get(BULK_WORK, 0.0)))
    counters.worst("mirror_error", rows[-1]["mirror_error"])
    counters.worst("slip_against_loops", slip_mismatch(trace))
    cycles = [row["cycle"] for row in rows]
    energies, accumulated_mJ = [friction_work_mJ(row) for row in rows], 1e3 * rows[-1]["accumulated_energy_J"]
    around_mJ = max(4e-3 * row["displacement_amplitude_um"] * row["max_tangential_force_N"] for row in rows)
    worn = accumulated_mJ > _ROUND_OFF * cycles[-1] * around_mJ
    counters.energy_against_loops = energy_mismatch(cycles, energies, accumulated_mJ) if worn else 0.0
    if worn and cycles == [1.0]:
        counters.first_cycle_against_loop = counters.energy_against_loops


def friction_work_mJ(row: Mapping[str, float]) -> float:
    """Friction work of the cycle of a row of the evolution, in mJ; a bulk stress may work on the contact as well."""
    return row["dissipated_energy_mJ"] - row.get(BULK_WORK, 0.0)


def area_mismatch(trace: CycleTrace, bulk_work_mJ: float = 0.0) -> float:
    """Relative difference of a loop's area from its friction work plus the work of bulk stresses; 0 if it encloses less
    than 0.1 % of the rectangle around it.
    """
    drive, force, work = trace.drive, trace.tangential_force, trace.friction_work + bulk_work_mJ
    area = abs(enclosed_area(drive, force))
    # A loop that encloses less than this share of the rectangle around it has no area worth comparing.
    if work <= 0.0 or area < 1e-3 * np.ptp(drive) * np.ptp(force):
        return 0.0
    return abs(area / work - 1.0)


def mirrored_mismatch(problem: ContactProblem, trace: CycleTrace) -> float:
    """Difference of a closed cycle's pressures from their mirror image on the way back, 0 to 1
    (`solvers.mirror_error`).
    NaN if bodies, rig or effects have no mirror that maps the way out onto the way back.
    """
    error = mirror_error(problem, (trace.start, *trace.states), symmetry_of(problem))
    return nan if error is None else error


def energy_mismatch(cycles: Sequence[float], per_cycle_mJ: Sequence[float], accumulated_mJ: float) -> float:
    """Relative difference of the friction energy by measured loops from `accumulated_mJ`, both from the test's start to
    the last loop.

    cycles, per_cycle_mJ: of the loops, increasing. Up to the first loop the energy per cycle is taken to be the first
    loop's, between two loops a power of the cycles. 0 before any wear. NaN if the result is beyond the limit, but
    linear interpolation would err to the other side: the loops are then too few to tell.
    """
    if accumulated_mJ <= 0.0:
        return 0.0
    first = cycles[0] * per_cycle_mJ[0]
    by_powers = first + enclosed_energy(cycles, per_cycle_mJ)
    by_lines = first + float(np.trapezoid(per_cycle_mJ, cycles))
    mismatch = abs(by_powers / accumulated_mJ - 1.0)
    certain = mismatch <= ENERGIES_AGREE or not min(by_powers, by_lines) < accumulated_mJ < max(by_powers, by_lines)
    return mismatch if certain else nan


def bends(before: Energies, now: Energies, allowed: float = 2e-3) -> bool:
    """True if the friction energy between two cycles differs from what interpolation of loops there gives by over
    `allowed` of that so far. before, now: (cycle, friction work per cycle, friction energy so far in mJ) of each.
    """
    (start, per_cycle, worn), (end, later, total) = before, now
    expected = enclosed_energy((start, end), (per_cycle, later))
    return abs(expected - (total - worn)) > allowed * total
