"""What a run of crossed wires records as it goes: loops, scars, the evolution, and the result that they make."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.metadata import version

import numpy as np

from solvers import ContactProblem, ContactState, CycleTrace, IncrementReport
from wirewear.results import PRESSURE_LENGTH, ContactForces, Evolution, Loop, RunResult, Scar
from wirewear.simulation.contact_forces import forces_of
from wirewear.simulation.health import bends, judge
from wirewear.simulation.measure import (
    MEASURED,
    evolution_row,
    holder_settings,
    loop_of,
    rows_until,
    scars_of,
    travels,
    volume_mismatch,
)
from wirewear.simulation.mesh_history import MeshHistory
from wirewear.simulation.plan import RunPlan
from wirewear.simulation.pressures import pressure_figures
from wirewear.simulation.tally import Tally

#: Packages whose versions a result records.
_PROGRAMS = ("wirewear", "numpy", "scipy", "scikit-fem", "gmsh", "h5py")


@cache
def _versions() -> Mapping[str, str]:
    """Of the packages; each is read from a file of its own."""
    return {program: version(program) for program in _PROGRAMS}


class WireRecord:
    """The record of one run; everything that a resumed run needs of it is in the result and the checkpoint."""

    def __init__(self, plan: RunPlan) -> None:
        """Empty, before the run."""
        self.plan = plan
        self.tally = Tally()
        self._loops: list[Loop] = []
        self._scars: list[Scar] = []
        self._forces: list[ContactForces] = []
        self._rows: list[dict[str, float]] = []
        self._holder: dict[str, float | str] = {}

    def restore(self, before: RunResult, done: float) -> None:
        """Take over what the interrupted run had recorded up to that cycle."""
        self._loops = [loop for loop in before.loops if loop.cycle <= done]
        self._scars = [scar for scar in before.scars if scar.cycle <= done]
        self._forces = [forces for forces in before.contact_forces if forces.cycle <= done]
        self._rows = rows_until(before.evolution, done)
        # A run that had done its last cycle measures its holder no more.
        self._holder = {name: value for name, value in before.settings.items() if name.startswith(MEASURED)}

    def pressed(self, state: ContactState, report: IncrementReport) -> None:
        """Record the fresh contact under the normal load alone."""
        self.tally.fresh = {
            "fresh_max_pressure_MPa": report.max_pressure,
            "fresh_approach_um": -1e3 * state.holder_z,
            "fresh_contact_radius_um": 1e3 * (report.contact_area / np.pi) ** 0.5,
        }

    def measured(
        self, problem: ContactProblem, state: ContactState, trace: CycleTrace, done: float, jump: float
    ) -> None:
        """Record a closed loop with the wear frozen, with the scars where the study asks for it."""
        study, cycle = self.plan.study, round(done)
        loop = loop_of(trace, cycle, study.conditions.frequency_Hz)
        scars = scars_of(problem, trace, cycle, study)
        self._holder = holder_settings(problem, trace)
        pressures = pressure_figures(problem, trace, self.plan.pressure_length_mm)
        self._rows.append(evolution_row(problem, state, trace, scars, pressures, done, jump))
        if len(self._rows) == 1:
            self.tally.fresh |= travels(problem)
        counters = self.tally.counters
        counters.worst("volume_against_energy", volume_mismatch(problem, state, scars))
        judge(counters, trace, self._rows, "dissipated_energy_mJ", state.wear.energy_mJ)
        if cycle in self.plan.logged_cycles or done >= self.plan.study.conditions.cycles:
            self._loops.append(loop)
            self._scars.extend(scars)
            self._forces.extend(forces_of(problem, trace, cycle, self.plan))

    def follows(self, state: ContactState, done: float, work_mJ: float) -> bool:
        """Whether the energy since the latest loop has gone as between two loops it is taken to."""
        last = self._rows[-1]
        since = (last["cycle"], last["dissipated_energy_mJ"], 1e3 * last["accumulated_energy_J"])
        return not bends(since, (done, work_mJ, state.wear.energy_mJ))

    def result(self, status: str, message: str, history: MeshHistory) -> RunResult:
        """The result so far."""
        plan, tally = self.plan, self.tally
        counters, cycling_s = tally.counters, tally.cycling_s
        return RunResult(
            name=plan.study.name,
            variant=plan.study.variant_name,
            fidelity=plan.fidelity,
            status=status,
            message=message,
            study=plan.study.resolved(),
            loops=tuple(self._loops),
            evolution=Evolution.from_rows(self._rows),
            scars=tuple(self._scars),
            contact_forces=tuple(self._forces),
            settings={
                **plan.discretisation.settings(),
                PRESSURE_LENGTH: 1e3 * plan.pressure_length_mm,
                **tally.fresh,
                **self._holder,
                "mesh_changes": list(history.changes),
                "mesh_stages": [1e3 * stage.to_half_width_mm for stage in plan.meshes.stages],
                "increments": counters.increments,
                "simulated_cycles": counters.simulated_cycles,
                "mean_iterations_per_increment": counters.iterations / max(counters.increments, 1.0),
                "identity": str(plan.identity),
            },
            quality=counters.quality(),
            versions=dict(_versions()),
            timings_s={
                "preparation": tally.preparation_s,
                "cycling": cycling_s,
                "total": tally.preparation_s + cycling_s,
            },
        )
