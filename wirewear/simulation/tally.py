"""What a run counts: increments and cycles, the worst residuals that it met, and the time that it took."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from math import isnan, nan

import numpy as np

from solvers import IncrementReport

QUALITY = (
    "force_balance",
    "penetration",
    "complementarity",
    "slip_direction_error_rad",
    "elastic_slip",
    "loop_area_against_friction_work",
    "volume_against_energy",
    "energy_against_loops",
    "mirror_error",
)


@dataclass
class Counters:
    """What a run counts and the worst it met; restored on resumption, so that a resumed run reports the same."""

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
    energy_against_loops: float = 0.0
    mirror_error: float = nan

    def count(self, report: IncrementReport) -> None:
        """Take in one increment."""
        self.increments += 1
        self.iterations += report.iterations
        self.worst("force_balance", report.force_error)
        self.worst("penetration", report.penetration)
        self.worst("complementarity", report.complementarity)
        self.worst("slip_direction_error_rad", report.slip_direction_error)
        self.worst("elastic_slip", report.elastic_slip)

    def worst(self, name: str, value: float) -> None:
        """Take in one more value of a quality, of which the largest counts; NaN is none."""
        setattr(self, name, float(np.fmax(getattr(self, name), value)))

    def quality(self) -> dict[str, float]:
        """The worst residuals and closures, by name; without those that the run does not define."""
        found = {name: getattr(self, name) for name in QUALITY}
        return {name: value for name, value in found.items() if not isnan(value)}


@dataclass
class Tally:
    """A run's counters, its clock, and what it found under the normal load alone (`fresh`, by name)."""

    counters: Counters = field(default_factory=Counters)
    fresh: dict[str, float] = field(default_factory=dict)
    preparation_s: float = 0.0
    _started: float = 0.0

    def start_cycling(self) -> None:
        """The meshes are prepared; time counts as cycling from now on."""
        self._started = time.perf_counter()

    @property
    def cycling_s(self) -> float:
        """Seconds of cycling so far, those before a resumption included."""
        return self.counters.cycling_s + time.perf_counter() - self._started

    def for_checkpoint(self) -> dict[str, float]:
        """What `restore` needs."""
        times = {"preparation_s": self.preparation_s, "cycling_s": self.cycling_s}
        return asdict(self.counters) | times | self.fresh

    def restore(self, counted: Mapping[str, float]) -> None:
        """Go on from what an interrupted run had counted."""
        names = {item.name for item in fields(Counters)}
        self.counters = Counters(**{name: value for name, value in counted.items() if name in names})
        self.fresh = {name: value for name, value in counted.items() if name.startswith("fresh_")}
