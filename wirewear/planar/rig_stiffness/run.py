"""A rig stiffness run: every case in both scenarios, cycled to frictional shakedown; no wear."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from solvers import ContactProblem, ContactState, CycleTrace, PlacedBody, SolverError, unloaded_state
from wirewear.errors import RunError
from wirewear.files.locks import occupied
from wirewear.loops import analyse_loop
from wirewear.planar.budget import require_affordable_meshes
from wirewear.planar.model import PlanarPlan, bodies, planar_problem
from wirewear.planar.rig_stiffness.model import SCENARIOS, Scenario, line_contact, plan_contact, rig_of
from wirewear.planar.rig_stiffness.results import RigStiffnessResult, RigStiffnessRun, write_rig_stiffness_result
from wirewear.planar.rig_stiffness.slip import slip_amplitude
from wirewear.planar.rig_stiffness.tables import ContactTable, RigStiffnessStudy
from wirewear.planar.tables import PlanarHolder
from wirewear.simulation.cycler import Cycler, Motion
from wirewear.simulation.tally import Counters, Tally

Array = NDArray[np.float64]

#: Change of the shear over a cycle, relative to friction times the peak pressure, at which the contact has shaken down.
SHAKEDOWN = 2e-3

#: Relative difference of K_t,m that still counts as equal, and how many springs are tried for it.
EQUAL = 2e-3
_MOST_TRIALS = 8

#: Contact, case from 1, scenario.
_Names = tuple[str, int, Scenario]

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
        StudyError: the study cannot be meshed, or asks for more memory than there is.
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
    for plan in plans.values():
        require_affordable_meshes(study.name, plan)
    cases = {name: len(contact.tangential_stiffness_N_per_mm2) for name, contact in study.contacts.items()}
    total = len(SCENARIOS) * sum(cases.values())
    runs: list[RigStiffnessRun] = []
    with threadpool_limits(limits=1, user_api="blas"):
        for name, plan in plans.items():
            tell(len(runs) / total, f"{name}: meshing and condensing")
            upright = line_contact(study, name, PlanarHolder(), fidelity)
            pad, specimen = bodies(upright, plan)
            for case in range(1, cases[name] + 1):
                for scenario in SCENARIOS:
                    names, done = (name, case, scenario), len(runs) / total
                    measured = partial(
                        _measured_on, study, fidelity, plan, (pad, specimen), names, partial(_part, tell, done, total)
                    )
                    try:
                        runs.append(_of_case(study.contacts[name], case, scenario, measured, runs[-1:]))
                    except SolverError as failure:
                        raise RunError(f"{_words(names)}: {failure}") from None
    return RigStiffnessResult(
        name=study.name,
        fidelity=fidelity,
        study=study.model_dump(mode="json", exclude_none=True),
        settings={name: plan.settings() for name, plan in plans.items()},
        runs=tuple(runs),
    )


def _words(names: _Names) -> str:
    return "{}, case {}, scenario {}".format(*names)


def _part(tell: Progress, done: float, total: int, share: float, names: _Names) -> None:
    """Tell how far a run has come that is one of so many."""
    tell(done + share / total, _words(names))


def _measured_on(
    study: RigStiffnessStudy,
    fidelity: str,
    plan: PlanarPlan,
    placed: tuple[PlacedBody, PlacedBody],
    names: _Names,
    tell: Callable[[float, _Names], None],
    stiffness: float,
) -> RigStiffnessRun:
    """The run of a case in a scenario on a spring of that stiffness."""
    name, _, scenario = names
    rig = rig_of(study.contacts[name], scenario, stiffness)
    posed = planar_problem(line_contact(study, name, rig, fidelity), *placed)
    tell(0.0, names)
    return _run_case(study, plan, posed, names, stiffness, lambda share: tell(share, names))


def _of_case(
    contact: ContactTable,
    case: int,
    scenario: Scenario,
    measured: Callable[[float], RigStiffnessRun],
    before: list[RigStiffnessRun],
) -> RigStiffnessRun:
    """The run of a case in a scenario; `before` holds that of scenario 1, whose stiffness may be to be met."""
    tangential = contact.tangential_stiffness_N_per_mm2[case - 1]
    if scenario == 1:
        return measured(tangential)
    if not isinstance(contact.rotational_stiffness_N_per_rad, str):
        return measured(contact.rotational_stiffness_N_per_rad[case - 1])
    return _equally_stiff(contact, tangential, measured, before[0].measured_stiffness_N_per_mm2)


def _equally_stiff(
    contact: ContactTable, tangential: float, measured: Callable[[float], RigStiffnessRun], wanted: float
) -> RigStiffnessRun:
    """The run on a rotational spring with which K_t,m is the wanted one, by the secant rule on both compliances.

    In series 1/K_t,m = 1/K_c + H²/(K_θ + K_r): in the springs' compliances it is nearly a straight line.

    Raises:
        RunError: no spring was found.
    """
    least = 1.01 * contact.normal_load_N_per_mm * contact.pivot_height_mm
    stiffness = max(tangential * contact.pivot_height_mm**2, least)
    tried: list[tuple[float, float]] = []
    for _ in range(_MOST_TRIALS):
        run = measured(stiffness)
        found = run.measured_stiffness_N_per_mm2
        if abs(found / wanted - 1.0) <= EQUAL:
            return run
        tried.append((1.0 / stiffness, 1.0 / found))
        if len(tried) == 1:
            # A spring alone: the contact's own compliance is left as it is.
            change = (1.0 / wanted - 1.0 / found) / contact.pivot_height_mm**2
        else:
            (x0, y0), (x1, y1) = tried[-2:]
            change = (1.0 / wanted - y1) * (x1 - x0) / (y1 - y0) if y1 != y0 else 0.0
        stiffness = 1.0 / min(max(1.0 / stiffness + change, 1e-3 / stiffness), 1.0 / least)
    raise RunError(
        f"no rotational stiffness was found with which K_t,m is {wanted:.4g} N/mm² in {_MOST_TRIALS} trials; the last, "
        f"{stiffness:.3g} N/rad, gave {found:.4g} N/mm²"
    )


def _unwatched(share: float, text: str) -> None:
    """Nobody looks."""


def _run_case(
    study: RigStiffnessStudy,
    plan: PlanarPlan,
    posed: ContactProblem,
    names: _Names,
    stiffness: float,
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
    return _measured(study, posed, names, stiffness, trace, (before, *trace.states), tally.counters, (done, change))


def _shear_change(friction: float, before: ContactState, after: ContactState) -> float:
    """Largest change of the shear over friction times the peak pressure."""
    change = np.abs(after.traction[:, 0] - before.traction[:, 0]).max()
    return float(change / max(friction * float(after.traction[:, 2].max()), 1e-300))


def _measured(
    study: RigStiffnessStudy,
    posed: ContactProblem,
    names: _Names,
    stiffness: float,
    trace: CycleTrace,
    states: tuple[ContactState, ...],
    counters: Counters,
    shakedown: tuple[int, float],
) -> RigStiffnessRun:
    """Loop and contact of a cycle, given the states before it and after each increment, and cycles and last change."""
    contact, case, scenario = names
    table, end = study.contacts[contact], states[-1]
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
        stiffness=stiffness,
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
