"""A planar run: press, cycle with jumps, log closed loops and profiles; the solvers are those of the wires."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from solvers import (
    ContactProblem,
    ContactState,
    CycleTrace,
    Guide,
    IncrementReport,
    JumpController,
    closed_cycle,
    extrapolated,
    first_quarter,
    press,
    run_cycle,
    take_step,
    unloaded_state,
    wear_difference,
)
from wirewear.effects import Age, problem_with
from wirewear.files import prepared_folder
from wirewear.planar.model import plan, planar_problem
from wirewear.planar.results import PlanarLoop, PlanarProfile, PlanarResult, write_planar_result
from wirewear.planar.tables import PlanarStudy
from wirewear.simulation.measure import Counters

Array = NDArray[np.float64]

_QUALITY = ("force_balance", "penetration", "complementarity", "slip_direction_error_rad", "volume_against_energy")

#: Told the share of the run that is done and what it is doing.
Progress = Callable[[float, str], None]


def run_planar_study(
    study: PlanarStudy, *, fidelity: str = "standard", output: Path | None = None, progress: Progress | None = None
) -> PlanarResult:
    """Simulate a planar study; with `output`, leave result.h5, the CSV tables and the pictures there.

    Raises:
        StudyError: the study cannot be meshed.
        RunError: nothing can be written to `output`.
        SolverError: the contact did not converge, or left the fine patch.
    """
    from wirewear.planar.pictures import draw_planar_result

    if output is not None:
        prepared_folder(output)
    with threadpool_limits(limits=1, user_api="blas"):
        result = _PlanarRun(study, fidelity, progress or _unwatched).go()
    if output is not None:
        write_planar_result(output, result)
        draw_planar_result(output, result)
    return result


def _unwatched(share: float, text: str) -> None:
    """Nobody looks."""


class _PlanarRun:
    def __init__(self, study: PlanarStudy, fidelity: str, progress: Progress) -> None:
        self.study, self.fidelity, self.progress = study, fidelity, progress
        self.plan = plan(study, fidelity)
        self.amplitude = 1e-3 * study.conditions.displacement_amplitude_um
        self.end = float(study.conditions.cycles)
        self.milestones = tuple(float(c) for c in sorted({1, *study.log.loop_cycles, study.conditions.cycles}))
        self.counters = Counters()
        self.guide: Guide | None = None
        self.loops: list[PlanarLoop] = []
        self.profiles: list[PlanarProfile] = []
        self.rows: list[dict[str, float]] = []

    def go(self) -> PlanarResult:
        self.progress(0.0, "meshing and condensing")
        problem = planar_problem(self.study, self.plan)
        fresh = problem_with(problem, self.study.effects, Age.new())
        state, report = press(fresh, unloaded_state(fresh))
        self.counters.count(report)
        n = self.plan.increments_per_cycle
        state = first_quarter(fresh, state, self.amplitude, n, self._watch)
        state = self._log(problem, state, 1.0)
        self._cycle_on(problem, state)
        return PlanarResult(
            name=self.study.name,
            fidelity=self.fidelity,
            study=self.study.model_dump(mode="json", exclude_none=True),
            settings=self.plan.settings()
            | {"fresh_max_pressure_MPa": report.max_pressure, "simulated_cycles": self.counters.simulated_cycles},
            quality={name: self.counters.quality()[name] for name in _QUALITY},
            profiles=tuple(self.profiles),
            loops=tuple(self.loops),
            evolution={name: np.array([row[name] for row in self.rows]) for name in self.rows[0]},
        )

    def _cycle_on(self, problem: ContactProblem, state: ContactState) -> None:
        controller = JumpController(self.plan.jump_tolerance)
        done, jump = 1.0, controller.first_jump

        def cycle(start: ContactState, before: float, cycles: float) -> ContactState:
            n = self.plan.increments_per_cycle
            current = self._aged(problem, start, before + 0.5 * cycles)
            after, trace = run_cycle(current, start, self.amplitude, n, cycles, self._watch, self.guide)
            self.guide = trace.guide
            self.counters.simulated_cycles += 1
            return after

        while done < self.end:
            ahead = min(m for m in self.milestones if m > done)
            size = ahead - done
            if not problem.wear.none:
                step = take_step(
                    controller,
                    state,
                    jump,
                    done,
                    self.milestones,
                    self.end,
                    cycle,
                    lambda whole, halves: wear_difference(problem, whole, halves),
                    lambda whole, halves: extrapolated(problem, whole, halves),
                )
                state, jump, size = step.state, step.next_jump, step.jump
            reached = abs(ahead - done - size) < 1e-6 * ahead
            done = ahead if reached else done + size
            self.progress(float(np.log(done) / np.log(self.end)), f"cycle {done:,.0f} of {self.end:,.0f}")
            if reached:
                state = self._log(problem, state, done)

    def _aged(self, problem: ContactProblem, state: ContactState, cycles: float) -> ContactProblem:
        """The problem with the study's effects as they are at that cycle."""
        return problem_with(problem, self.study.effects, Age(cycles, 1e-3 * state.wear.energy_mJ))

    def _watch(self, _state: ContactState, report: IncrementReport) -> None:
        self.counters.count(report)

    def _log(self, problem: ContactProblem, state: ContactState, done: float) -> ContactState:
        n = self.plan.increments_per_cycle
        state, trace = closed_cycle(self._aged(problem, state, done), state, self.amplitude, n, self._watch, self.guide)
        self.guide = trace.guide
        self.counters.simulated_cycles += 1
        cycle = round(done)
        profiles = _profiles(problem, trace.middle, cycle)
        self.counters.volume_against_energy = max(
            self.counters.volume_against_energy, _area_mismatch(problem, state, profiles)
        )
        self.loops.append(_loop(self.study, trace, cycle))
        self.profiles.extend(profiles)
        self.rows.append(_evolution_row(state, trace, profiles, done))
        return state


def _profiles(problem: ContactProblem, state: ContactState, cycle: int) -> tuple[PlanarProfile, PlanarProfile]:
    wear = state.wear
    fields = (
        ("pad", problem.upper, wear.primary_depth, wear.primary_energy, state.primary_force),
        ("specimen", problem.lower, wear.secondary_depth, wear.secondary_energy, state.secondary_force),
    )
    pad, specimen = (
        PlanarProfile(
            cycle=cycle,
            body=name,
            x_um=1e3 * body.node_positions[:, 0],
            depth_um=1e3 * depth[:, 0],
            energy_density_mJ_per_mm2=energy[:, 0],
            pressure_MPa=force[:, 2] / body.patch.node_areas(),
        )
        for name, body, depth, energy, force in fields
    )
    return pad, specimen


def _area_mismatch(
    problem: ContactProblem, state: ContactState, profiles: tuple[PlanarProfile, PlanarProfile]
) -> float:
    """Largest relative difference of a body's worn cross-section and what the wear law has taken from it."""
    wear = state.wear
    volumes = (wear.primary_volume_mm3, wear.secondary_volume_mm3)
    taken = volumes if problem.primary_is_upper else volumes[::-1]
    pairs = zip(profiles, taken, strict=True)
    return max((abs(1e-6 * profile.area_um2 / area - 1.0) for profile, area in pairs if area > 0.0), default=0.0)


def _loop(study: PlanarStudy, trace: CycleTrace, cycle: int) -> PlanarLoop:
    drive = trace.drive
    rising = np.diff(drive, prepend=drive[-1]) > 0.0
    turn = -int(np.flatnonzero((drive == 0.0) & rising)[0])
    x = np.roll(drive, turn)
    phase = np.arange(len(x)) / len(x)
    if study.conditions.motion == "triangular":
        # The increments are those of a sine; Coulomb friction and wear know no rate, only the time differs.
        phase = _triangular_phase(x / np.abs(x).max(), phase)
    return PlanarLoop(
        cycle=cycle,
        time_s=phase / study.conditions.frequency_Hz,
        displacement_um=1e3 * x,
        relative_displacement_um=1e3 * np.roll(drive - trace.holder_x, turn),
        tangential_force_N_per_mm=np.roll(trace.tangential_force, turn),
    )


def _triangular_phase(x: Array, sine_phase: Array) -> Array:
    """Share of the cycle passed when a triangular motion of amplitude 1 is where the sine is at that phase."""
    rise, fall = 0.25 * x, 0.5 - 0.25 * x
    return np.where(sine_phase <= 0.25, rise, np.where(sine_phase < 0.75, fall, 1.0 + rise))


def _evolution_row(
    state: ContactState, trace: CycleTrace, profiles: tuple[PlanarProfile, PlanarProfile], done: float
) -> dict[str, float]:
    row = {
        "cycle": done,
        "max_tangential_force_N_per_mm": float(np.abs(trace.tangential_force).max()),
        "dissipated_energy_mJ_per_mm": trace.friction_work,
        "accumulated_energy_J_per_mm": 1e-3 * state.wear.energy_mJ,
        "max_pressure_MPa": max(report.max_pressure for report in trace.reports),
        "contact_half_width_um": 1e3 * max(report.half_width_x for report in trace.reports),
    }
    for profile in profiles:
        left, right = profile.edges_um()
        row |= {
            f"{profile.body}_max_depth_um": float(profile.depth_um.max()),
            f"{profile.body}_worn_area_um2": profile.area_um2,
            f"{profile.body}_left_edge_um": left,
            f"{profile.body}_right_edge_um": right,
        }
    return row
