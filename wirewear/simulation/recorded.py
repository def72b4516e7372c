"""What a run records of its closed loops, and the result that they make, whatever the kind of contact."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from typing import Any

from solvers import ContactProblem, ContactState, CycleTrace, IncrementReport
from wirewear.results import ContactForces, Evolution, Loop, RunResult, Scar
from wirewear.simulation.checkpoint import MeshHistory
from wirewear.simulation.contact_forces import pressure_figures
from wirewear.simulation.measure import evolution_row, loop_of, rows_until, travels, volume_mismatch
from wirewear.simulation.tally import Tally, judge

#: Packages whose versions a result records.
_PROGRAMS = ("wirewear", "numpy", "scipy", "scikit-fem", "gmsh", "h5py")


@cache
def _versions() -> Mapping[str, str]:
    """Of the packages; each is read from a file of its own."""
    return {program: version(program) for program in _PROGRAMS}


class Recorded(ABC):
    """The record of one run; everything that a resumed run needs of it is in the result and the checkpoint."""

    contact_kind: str
    bodies: tuple[str, str]
    length_mm: float | None

    def __init__(self, study: Any, fidelity: str, pressure_length_mm: float) -> None:
        """Empty, before the run of a study of one variant."""
        self._study, self._fidelity, self._pressure_length_mm = study, fidelity, pressure_length_mm
        self.tally = Tally()
        self._loops: list[Loop] = []
        self._scars: list[Scar] = []
        self._forces: list[ContactForces] = []
        self._rows: list[dict[str, float]] = []

    def restore(self, before: RunResult, done: float) -> None:
        """Take over what the interrupted run had recorded up to that cycle."""
        self._loops = [loop for loop in before.loops if loop.cycle <= done]
        self._scars = [scar for scar in before.scars if scar.cycle <= done]
        self._forces = [forces for forces in before.contact_forces if forces.cycle <= done]
        self._rows = rows_until(before.evolution, done)

    def pressed(self, _state: ContactState, report: IncrementReport) -> None:
        """Record the fresh contact under the normal load alone."""
        self.tally.fresh = {"fresh_max_pressure_MPa": report.max_pressure}

    def measured(
        self, problem: ContactProblem, state: ContactState, trace: CycleTrace, done: float, jump: float
    ) -> None:
        """Record a closed loop with the wear frozen, with the scars where the study asks for it."""
        cycle, conditions = round(done), self._study.conditions
        loop = loop_of(trace, cycle, conditions.frequency_Hz, getattr(conditions, "motion", "sinusoidal"))
        scars = self.scars(problem, trace, cycle)
        pressures = pressure_figures(problem, trace, self._pressure_length_mm)
        row = evolution_row(problem, state, trace, scars, pressures, done, jump)
        self._rows.append(row | self.further_columns(loop, scars))
        if len(self._rows) == 1:
            self.tally.fresh |= travels(problem)
        counters = self.tally.counters
        counters.worst("volume_against_energy", volume_mismatch(problem, state, scars))
        judge(counters, trace, self._rows, state.wear.energy_mJ)
        if self.logs(cycle, done):
            self._loops.append(loop)
            self._scars.extend(scars)
            self._forces.extend(self.forces(problem, trace, cycle))

    def follows(self, _state: ContactState, _done: float, _work_mJ: float) -> bool:
        """Whether the energy since the latest loop has gone as between two loops it is taken to."""
        return True

    def logs(self, _cycle: int, _done: float) -> bool:
        """Whether loop and scars of a measured cycle are kept."""
        return True

    def further_columns(self, _loop: Loop, _scars: tuple[Scar, Scar]) -> dict[str, float]:
        """What else a row of the evolution holds."""
        return {}

    @abstractmethod
    def scars(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[Scar, Scar]:
        """Scars of the driven body and of the other."""

    @abstractmethod
    def forces(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[ContactForces, ...]:
        """Forces on both bodies, nothing where the study asks for none."""

    @abstractmethod
    def tables(self) -> dict[str, Any]:
        """The study as a result keeps it."""

    @abstractmethod
    def settings(self, history: MeshHistory) -> dict[str, Any]:
        """What the discretisation came to."""

    def result(self, status: str, message: str, history: MeshHistory) -> RunResult:
        """The result so far."""
        tally = self.tally
        cycling_s = tally.cycling_s
        return RunResult(
            name=self._study.name,
            variant=self._study.variant_name,
            fidelity=self._fidelity,
            status=status,
            message=message,
            study=self.tables(),
            loops=tuple(self._loops),
            evolution=Evolution.from_rows(self._rows),
            scars=tuple(self._scars),
            contact_forces=tuple(self._forces),
            settings=self.settings(history),
            quality=tally.counters.quality(),
            versions=dict(_versions()),
            timings_s={
                "preparation": tally.preparation_s,
                "cycling": cycling_s,
                "total": tally.preparation_s + cycling_s,
            },
            contact_kind=self.contact_kind,
            bodies=self.bodies,
            length_mm=self.length_mm,
        )
