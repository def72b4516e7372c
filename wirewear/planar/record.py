"""What the run of a line contact records: loops, profiles of both bodies, the evolution, and the result they make."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solvers import ContactProblem, ContactState, CycleTrace, IncrementReport
from solvers.interior import forces_on_bodies
from wirewear.planar.results import PlanarForces, PlanarLoop, PlanarProfile, PlanarResult
from wirewear.planar.tables import PlanarStudy
from wirewear.results import PRESSURE_LENGTH
from wirewear.simulation.contact_forces import positions
from wirewear.simulation.health import judge, mirrored_mismatch
from wirewear.simulation.measure import rows_until, travels
from wirewear.simulation.mesh_history import MeshHistory
from wirewear.simulation.opening import dissipated_energy_mJ, slip_amplitude_mm
from wirewear.simulation.pressures import pressure_figures
from wirewear.simulation.tally import Tally

Array = NDArray[np.float64]


class PlanarRecord:
    """The record of one run at a fidelity; `settings` is what it was asked to do, with its identity."""

    def __init__(self, study: PlanarStudy, fidelity: str, settings: dict[str, Any]) -> None:
        """Empty, before the run."""
        self.study, self.fidelity, self.settings = study, fidelity, settings
        self.tally = Tally()
        self._loops: list[PlanarLoop] = []
        self._profiles: list[PlanarProfile] = []
        self._forces: list[PlanarForces] = []
        self._rows: list[dict[str, float]] = []

    def restore(self, before: PlanarResult, done: float) -> None:
        """Take over what the interrupted run had recorded up to that cycle."""
        self._loops = [loop for loop in before.loops if loop.cycle <= done]
        self._profiles = [profile for profile in before.profiles if profile.cycle <= done]
        self._forces = [forces for forces in before.forces if forces.cycle <= done]
        self._rows = rows_until(before.evolution, done)

    def pressed(self, _state: ContactState, report: IncrementReport) -> None:
        """Record the fresh contact under the normal load alone."""
        self.tally.fresh = {"fresh_max_pressure_MPa": report.max_pressure}

    def measured(
        self, problem: ContactProblem, state: ContactState, trace: CycleTrace, done: float, _jump: float
    ) -> None:
        """Record a closed loop with the wear frozen."""
        cycle = round(done)
        profiles = _profiles(problem, trace, cycle)
        loop = _loop(self.study, trace, cycle)
        self._loops.append(loop)
        self._profiles.extend(profiles)
        self._forces.extend(_forces(problem, trace, cycle, self.study.log.contact_states))
        pressures = pressure_figures(problem, trace, 1e-3 * self.settings[PRESSURE_LENGTH])
        self._rows.append(_evolution_row(problem, state, trace, loop, profiles, pressures, done))
        if len(self._rows) == 1:
            self.tally.fresh |= travels(problem)
        counters = self.tally.counters
        counters.worst("volume_against_energy", _volume_mismatch(problem, state, profiles))
        judge(counters, trace, self._rows, "dissipated_energy_mJ_per_mm", state.wear.energy_mJ)

    def follows(self, _state: ContactState, _done: float, _work_mJ: float) -> bool:
        """Line contacts record every loop that they measure: those that the study asks for."""
        return True

    def result(self, status: str, message: str, _history: MeshHistory) -> PlanarResult:
        """The result so far."""
        tally = self.tally
        return PlanarResult(
            name=self.study.name,
            variant=self.study.variant_name,
            fidelity=self.fidelity,
            status=status,
            message=message,
            study=self.study.model_dump(mode="json", exclude_none=True),
            settings=self.settings | tally.fresh | {"simulated_cycles": tally.counters.simulated_cycles},
            quality=tally.counters.quality(),
            profiles=tuple(self._profiles),
            loops=tuple(self._loops),
            forces=tuple(self._forces),
            evolution={
                name: np.array([row[name] for row in self._rows]) for name in (self._rows[-1] if self._rows else ())
            },
        )


def _profiles(problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[PlanarProfile, PlanarProfile]:
    state = trace.middle
    wear, (primary_slid, secondary_slid) = state.wear, trace.slid
    fields = (
        ("pad", problem.upper, wear.primary_depth, wear.primary_energy, state.primary_force, primary_slid),
        (
            "specimen",
            problem.lower,
            wear.secondary_depth,
            wear.secondary_energy,
            state.secondary_force,
            secondary_slid,
        ),
    )
    pad, specimen = (
        PlanarProfile(
            cycle=cycle,
            body=name,
            x_um=1e3 * body.node_positions[:, 0],
            depth_um=1e3 * depth[:, 0],
            energy_density_mJ_per_mm2=energy[:, 0],
            pressure_MPa=force[:, 2] / body.patch.node_areas(),
            slip_amplitude_um=250.0 * slid,
        )
        for name, body, depth, energy, force, slid in fields
    )
    return pad, specimen


def _forces(problem: ContactProblem, trace: CycleTrace, cycle: int, count: int) -> tuple[PlanarForces, ...]:
    """Forces on pad and specimen at so many positions; nothing for none."""
    if count == 0:
        return ()
    chosen = positions(trace, count)
    states = [trace.states[k] for k in chosen]
    of_bodies = zip(*(forces_on_bodies(problem, state) for state in states), strict=True)
    found = []
    for name, forces in zip(("pad", "specimen"), map(np.array, of_bodies), strict=True):
        nodes = np.flatnonzero((forces != 0.0).any(axis=(0, 2)))
        found.append(
            PlanarForces(
                cycle=cycle,
                body=name,
                phase=trace.phase[chosen],
                drive_um=1e3 * trace.drive[chosen],
                holder_x_um=np.array([1e3 * state.holder_x for state in states]),
                holder_z_um=np.array([1e3 * state.holder_z for state in states]),
                nodes=nodes.astype(float),
                force_N_per_mm=forces[:, nodes],
            )
        )
    return tuple(found)


def _volume_mismatch(
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
    phase = np.roll((trace.phase - 0.75) % 1.0, turn)
    if study.conditions.motion == "triangular":
        # The increments are those of a sine; Coulomb friction and wear know no rate, only the time differs.
        phase = _triangular_phase(x / np.abs(x).max(), phase)
    return PlanarLoop(
        cycle=cycle,
        time_s=phase / study.conditions.frequency_Hz,
        displacement_um=1e3 * x,
        relative_displacement_um=1e3 * np.roll(drive - trace.holder_x, turn),
        tangential_force_N_per_mm=np.roll(trace.tangential_force, turn),
        normal_force_N_per_mm=np.roll(trace.normal_force, turn),
        tilt_deg=np.roll(np.degrees([one.holder_tilt for one in trace.states]), turn),
    )


def _triangular_phase(x: Array, sine_phase: Array) -> Array:
    """Share of the cycle passed when a triangular motion of amplitude 1 is where the sine is at that phase."""
    rise, fall = 0.25 * x, 0.5 - 0.25 * x
    return np.where(sine_phase <= 0.25, rise, np.where(sine_phase < 0.75, fall, 1.0 + rise))


def _evolution_row(
    problem: ContactProblem,
    state: ContactState,
    trace: CycleTrace,
    loop: PlanarLoop,
    profiles: tuple[PlanarProfile, PlanarProfile],
    pressures: Mapping[str, float],
    done: float,
) -> dict[str, float]:
    row = {
        "cycle": done,
        "displacement_amplitude_um": 1e3 * 0.5 * float(np.ptp(trace.drive)),
        "slip_amplitude_um": 1e3 * slip_amplitude_mm(trace),
        "largest_tilt_deg": float(np.abs(loop.tilt_deg).max()),
        "normal_force_N_per_mm": float(trace.normal_force.mean()),
        "max_tangential_force_N_per_mm": float(np.abs(trace.tangential_force).max()),
        "dissipated_energy_mJ_per_mm": dissipated_energy_mJ(trace),
        "accumulated_energy_J_per_mm": 1e-3 * state.wear.energy_mJ,
        **pressures,
        "mirror_error": mirrored_mismatch(problem, trace),
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
