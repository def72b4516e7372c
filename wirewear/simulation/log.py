"""What a run records as it goes: loops, scars, the evolution, what it counts, and the result that they make."""

from __future__ import annotations

import time
from dataclasses import fields
from importlib.metadata import version

import numpy as np

from solvers import ContactProblem, ContactState, CycleTrace, IncrementReport
from wirewear.results import Evolution, Loop, RunResult, Scar
from wirewear.simulation.checkpoint import Checkpoint
from wirewear.simulation.measure import Counters, area_mismatch, evolution_row, holder_settings, volume_mismatch
from wirewear.simulation.meshes import MeshHistory
from wirewear.simulation.plan import RunPlan
from wirewear.simulation.problem import loop_of, scars_of

#: Packages whose versions a result records.
_PROGRAMS = ("wirewear", "numpy", "scipy", "scikit-fem", "gmsh", "h5py")


class RunLog:
    """The record of one run; everything that a resumed run needs of it is in the result and the checkpoint."""

    def __init__(self, plan: RunPlan) -> None:
        """Empty, before the run."""
        self.plan = plan
        self.counters = Counters()
        self.preparation_s = 0.0
        self._loops: list[Loop] = []
        self._scars: list[Scar] = []
        self._rows: list[dict[str, float]] = []
        self._pressed: dict[str, float] = {}
        self._holder: dict[str, float | str] = {}
        self._cycling_started = 0.0

    def restore(self, checkpoint: Checkpoint, before: RunResult) -> None:
        """Take over what the interrupted run had recorded up to its checkpoint."""
        self._loops = [loop for loop in before.loops if loop.cycle <= checkpoint.done]
        self._scars = [scar for scar in before.scars if scar.cycle <= checkpoint.done]
        evolution = before.evolution
        self._rows = [
            {name: float(column[i]) for name, column in evolution.items()}
            for i in range(len(evolution["cycle"]))
            if evolution["cycle"][i] <= checkpoint.done
        ]
        counted = {field.name for field in fields(Counters)}
        self.counters = Counters(**{name: x for name, x in checkpoint.counters.items() if name in counted})
        self._pressed = {name: value for name, value in checkpoint.counters.items() if name.startswith("fresh_")}

    def start_cycling(self) -> None:
        """The meshes are prepared; time counts as cycling from now on."""
        self._cycling_started = time.perf_counter()

    @property
    def cycling_s(self) -> float:
        """Seconds of cycling so far, those before a resumption included."""
        return self.counters.cycling_s + time.perf_counter() - self._cycling_started

    def pressed(self, state: ContactState, report: IncrementReport) -> None:
        """Record the fresh contact under the normal load alone."""
        self.counters.count(report)
        self._pressed = {
            "fresh_max_pressure_MPa": report.max_pressure,
            "fresh_approach_um": -1e3 * state.holder_z,
            "fresh_contact_radius_um": 1e3 * (report.contact_area / np.pi) ** 0.5,
        }

    def measured(
        self, problem: ContactProblem, state: ContactState, trace: CycleTrace, done: float, jump: float
    ) -> None:
        """Record a closed loop with the wear frozen, with the scars where the study asks for it."""
        study, cycle = self.plan.study, round(done)
        self.counters.simulated_cycles += 1
        loop = loop_of(trace, cycle, study.conditions.frequency_Hz)
        scars = scars_of(problem, trace, cycle, study)
        self._holder = holder_settings(problem, trace)
        counters = self.counters
        counters.loop_area_against_friction_work = max(
            counters.loop_area_against_friction_work, area_mismatch(loop, trace.friction_work)
        )
        counters.volume_against_energy = max(counters.volume_against_energy, volume_mismatch(problem, state, scars))
        self._rows.append(evolution_row(state, trace, loop, scars, done, jump))
        if cycle in self.plan.logged_cycles or done >= self.plan.cycles:
            self._loops.append(loop)
            self._scars.extend(scars)

    def for_checkpoint(self) -> dict[str, float]:
        """What `restore` needs beside the result."""
        return {
            **self.counters.__dict__,
            "preparation_s": self.preparation_s,
            "cycling_s": self.cycling_s,
            **self._pressed,
        }

    def result(self, status: str, message: str, history: MeshHistory) -> RunResult:
        """The result so far."""
        plan, counters, cycling = self.plan, self.counters, self.cycling_s
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
            settings={
                **plan.discretisation.settings(),
                **self._pressed,
                **self._holder,
                "mesh_changes": list(history.changes),
                "mesh_stages": [1e3 * stage.to_half_width_mm for stage in plan.meshes.stages],
                "increments": counters.increments,
                "simulated_cycles": counters.simulated_cycles,
                "mean_iterations_per_increment": counters.iterations / max(counters.increments, 1.0),
                "identity": plan.identity,
            },
            quality=counters.quality(),
            versions={program: version(program) for program in _PROGRAMS},
            timings_s={
                "preparation": self.preparation_s,
                "cycling": cycling,
                "total": self.preparation_s + cycling,
            },
        )
