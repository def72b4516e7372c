"""A rig stiffness run: every case in both scenarios, cycled to frictional shakedown; no wear."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from solvers import ContactProblem, ContactState, CycleTrace, SolverError, unloaded_state
from wirewear.errors import RunError
from wirewear.files.locks import occupied
from wirewear.loops import analyse_loop
from wirewear.planar.rig_stiffness.model import SCENARIOS, ContactPlan, Scenario, bodies, plan_contact, problem
from wirewear.planar.rig_stiffness.results import RigStiffnessResult, RigStiffnessRun, write_rig_stiffness_result
from wirewear.planar.rig_stiffness.slip import slip_amplitude
from wirewear.planar.rig_stiffness.tables import RigStiffnessStudy
from wirewear.simulation.cycler import Cycler, Motion
from wirewear.simulation.tally import Counters, Tally

Array = NDArray[np.float64]

#: Change of the shear over a cycle, relative to friction times the peak pressure, at which the contact has shaken down.
SHAKEDOWN = 2e-3

#: Told the share of the run that is done and what it is doing.
Progress = Callable[[float, str], None]


def run_rig_stiffness_study(
    study: RigStiffnessStudy,
    *,
    fidelity: str = "standard",
    output: Path | None = None,
    progress: Progress | None = None,
) -> RigStiffnessResult:
    """Simulate a rig stiffness study; with `output`, leave result.h5, the CSV tables and the pictures there.

    Raises:
        StudyError: the study cannot be meshed.
        RunError: a contact did not converge, or left the fine patch; or nothing can be written to `output`.
    """
    from wirewear.planar.rig_stiffness.pictures import draw_rig_stiffness_result

    if output is not None:
        with occupied(output, study.name):
            result = _run(study, fidelity, progress or _unwatched)
            write_rig_stiffness_result(output, result)
            draw_rig_stiffness_result(output, result)
            return result
    return _run(study, fidelity, progress or _unwatched)


def _run(study: RigStiffnessStudy, fidelity: str, tell: Progress) -> RigStiffnessResult:
    plans = {name: plan_contact(study, name, fidelity) for name in study.contacts}
    cases = {name: len(contact.tangential_stiffness_N_per_mm2) for name, contact in study.contacts.items()}
    total = len(SCENARIOS) * sum(cases.values())
    runs: list[RigStiffnessRun] = []
    with threadpool_limits(limits=1, user_api="blas"):
        for name, plan in plans.items():
            tell(len(runs) / total, f"{name}: meshing and condensing")
            pad, specimen = bodies(study, plan)
            for case in range(1, cases[name] + 1):
                for scenario in SCENARIOS:
                    posed = problem(study, name, case, scenario, pad, specimen)
                    done, text = len(runs) / total, f"{name}, case {case}, scenario {scenario}"
                    tell(done, text)
                    try:
                        runs.append(
                            _run_case(
                                study,
                                plan,
                                posed,
                                (name, case, scenario),
                                lambda share, done=done, text=text: tell(done + share / total, text),  # type: ignore[misc]
                            )
                        )
                    except SolverError as failure:
                        raise RunError(f"{text}: {failure}") from None
    return RigStiffnessResult(
        name=study.name,
        fidelity=fidelity,
        study=study.model_dump(mode="json", exclude_none=True),
        settings={name: plan.settings() for name, plan in plans.items()},
        runs=tuple(runs),
    )


def _unwatched(share: float, text: str) -> None:
    """Nobody looks."""


def _run_case(
    study: RigStiffnessStudy,
    plan: ContactPlan,
    posed: ContactProblem,
    names: tuple[str, int, Scenario],
    tell: Callable[[float], None],
) -> RigStiffnessRun:
    n, cycles, tally = plan.increments_per_cycle, study.conditions.most_cycles, Tally()
    motion = Motion(
        amplitude_mm=1e-3 * study.conditions.displacement_amplitude_um,
        increments=n,
        wear_increments=n,
        follows_force=False,
        fresh=unloaded_state,
        aged=lambda problem, _: problem,
    )
    cycler = Cycler(motion, tally, lambda *_: tell(tally.counters.increments / (n * (cycles + 0.25))))
    pressed, _ = cycler.pressed(posed)
    state = cycler.moved_out(posed, pressed)
    done, change = 0, float("inf")
    while change > SHAKEDOWN and done < cycles:
        before = state
        state, trace = cycler.cycled(posed, before, float(done), 0.0)
        done, change = done + 1, _shear_change(posed.friction, before, state)
    return _measured(study, posed, names, trace, (before, *trace.states), tally.counters, (done, change))


def _shear_change(friction: float, before: ContactState, after: ContactState) -> float:
    """Largest change of the shear over friction times the peak pressure."""
    change = np.abs(after.traction[:, 0] - before.traction[:, 0]).max()
    return float(change / max(friction * float(after.traction[:, 2].max()), 1e-300))


def _measured(
    study: RigStiffnessStudy,
    posed: ContactProblem,
    names: tuple[str, int, Scenario],
    trace: CycleTrace,
    states: tuple[ContactState, ...],
    counters: Counters,
    shakedown: tuple[int, float],
) -> RigStiffnessRun:
    """Loop and contact of a cycle, given the states before it and after each increment, and cycles and last change."""
    contact, case, scenario = names
    table, end = study.contacts[contact], states[-1]
    stiffnesses = (table.tangential_stiffness_N_per_mm2, table.rotational_stiffness_N_per_rad)
    pressure, shear = end.traction[:, 2], end.traction[:, 0]
    areas, x = posed.surface.areas, posed.upper.node_positions[:, 0]
    figures = analyse_loop(1e3 * trace.drive, trace.tangential_force, table.normal_load_N_per_mm)
    if figures.measured_stiffness_N_per_um is None:
        raise RunError(
            f"{contact}, case {case}, scenario {scenario}: no increment lies on the micro-slip branches, so K_t,m "
            "cannot be measured; give more increments_per_cycle"
        )
    tilts = np.array([state.holder_tilt for state in states[1:]])
    return RigStiffnessRun(
        contact=contact,
        case=case,
        scenario=scenario,
        stiffness=stiffnesses[scenario - 1][case - 1],
        regime="gross slip" if min(report.sticking for report in trace.reports) == 0 else "partial slip",
        measured_stiffness_N_per_mm2=1e3 * figures.measured_stiffness_N_per_um.value,
        largest_tilt_deg=float(np.degrees(np.abs(tilts).max())),
        largest_force_N_per_mm=float(np.abs(trace.tangential_force).max()),
        slip_amplitude_of_loop_um=figures.slip_amplitude_um.value,
        dissipated_energy_mJ_per_mm=trace.friction_work,
        pressure_centre_um=1e3 * float((areas * pressure) @ x / (areas @ pressure)),
        pressed_width_um=1e3 * float(areas[pressure > 0.0].sum()),
        max_pressure_MPa=float(pressure.max()),
        cycles=shakedown[0],
        shakedown_change=shakedown[1],
        force_balance=counters.force_balance,
        penetration=counters.penetration,
        complementarity=counters.complementarity,
        displacement_um=1e3 * trace.drive,
        tangential_force_N_per_mm=trace.tangential_force,
        tilt_deg=np.degrees(tilts),
        x_um=1e3 * x,
        pressure_MPa=pressure,
        shear_MPa=shear,
        slip_amplitude_um=1e3 * slip_amplitude(posed, states),
    )
