"""The record of a run: loops, scars, rows of the evolution, contact forces and qualities, and the result from them.

A trace is a simulated cycle, closed and without wear. Bodies come as (driven, held), the driven one below. The primary
body's nodes carry the contact tractions.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from math import isnan, nan
from typing import Any

import numpy as np

from geometry import Arc
from solvers import ContactProblem, ContactState, CycleTrace, IncrementReport, SolverError, bulk_work, measured_holder
from solvers.contact_extent import areas, half_widths
from wirewear.base.cache import installed
from wirewear.base.course import enclosed_energy
from wirewear.results import (
    BORNE,
    BULK_WORK,
    ELASTIC_LAYERS,
    LAYERS_OF_BODIES,
    OVER_YIELD,
    PLASTIC_VOLUME,
    PLASTIC_WORK,
    PLAY_TRAVEL,
    SPRING_TRAVEL,
    ContactForces,
    Evolution,
    Loop,
    RunResult,
    Scar,
)
from wirewear.results.evolution import DEBRIS_LEFT, DEBRIS_THICKNESS, DEBRIS_VOLUME, LARGEST_RISE, MEAN_RISE
from wirewear.results.values import FLOW_ENERGY
from wirewear.simulation.control import HeldFigure
from wirewear.simulation.expected_contact import borne_settings, law_error
from wirewear.simulation.measures import dissipated_energy_mJ, slip_amplitude_mm, unresolved_slip
from wirewear.simulation.meshes import MeshHistory
from wirewear.simulation.problem import worn_depths
from wirewear.simulation.statistics import Tally, friction_work_mJ, judge, mirrored_mismatch
from wirewear.simulation.traced_bodies import depth_spread, pressure_figures, volume_mismatch
from wirewear.simulation.yielding import STRAIN, limit_settings
from wirewear.test import AnyStudy
from wirewear.test.conditions import held_keys

_LAW_ERROR = "fresh_law_error"
#: Qualities of the fresh contact, and their names among its values.
_OF_FRESH = {"indentation_strain": STRAIN, "flow_energy": FLOW_ENERGY, "law_between_nodes": _LAW_ERROR}

MEASURED = "measured_"  #: Beginning of the names of a holder's measured elements.

_PROGRAMS = ("wirewear", "numpy", "scipy", "scikit-fem", "gmsh", "h5py")  #: Packages whose versions a result records.


def loop_of(trace: CycleTrace, cycle: int, frequency_Hz: float) -> Loop:
    """A simulated cycle as the loop of cycle number `cycle`, which starts at mid-stroke moving towards +x."""
    rising = np.diff(trace.drive, prepend=trace.drive[-1]) > 0.0
    turn = -int(np.flatnonzero((trace.drive == 0.0) & rising)[0])
    # Of a cosine and of what is as symmetric, mid-stroke comes three quarters of a cycle after +amplitude.
    time = np.roll((trace.time - trace.time[-turn]) % 1.0, turn)
    return Loop(
        cycle=cycle,
        time_s=time / frequency_Hz,
        displacement_um=1e3 * np.roll(trace.drive, turn),
        relative_displacement_um=1e3 * np.roll(trace.drive - trace.holder_x, turn),
        tangential_force_N=np.roll(trace.tangential_force, turn),
        normal_force_N=np.roll(trace.normal_force, turn),
        friction_work_mJ=np.cumsum(np.roll(trace.work, turn)),
        tilt_deg=np.roll(np.degrees([state.holder_tilt for state in trace.states]), turn),
    )


def evolution_row(
    problem: ContactProblem,
    state: ContactState,
    trace: CycleTrace,
    scars: tuple[Scar, Scar],
    pressures: Mapping[str, float],
    done: float,
    jump: float,
) -> dict[str, float]:
    """One row of the evolution, by column, from a closed loop after `done` cycles, the last `jump` of them in one jump.
    state: at the loop's end. scars: of the driven and the held body. pressures: the loop's, from `pressure_figures`.
    """
    touching = [report.footprint for report in trace.reports if report.footprint is not None]
    return {
        "cycle": done,
        "displacement_amplitude_um": 1e3 * 0.5 * float(np.ptp(trace.drive)),
        "slip_amplitude_um": 1e3 * slip_amplitude_mm(trace),
        "max_tangential_force_N": float(np.abs(trace.tangential_force).max()),
        "dissipated_energy_mJ": dissipated_energy_mJ(trace),
        "normal_force_N": float(trace.normal_force.mean()),
        "accumulated_energy_J": 1e-3 * state.wear.energy_mJ,
        **{f"worn_volume_{scar.body}_mm3": scar.volume_mm3 for scar in scars},
        **{f"max_depth_{scar.body}_um": scar.max_depth_um for scar in scars},
        "contact_half_width_um": 1e3 * float(half_widths(touching)[:, 0].max(initial=0.0)),
        **pressures,
        **yielded(problem, state, trace, scars),
        **covered(problem, state),
        **warmed(problem, state),
        "mirror_error": mirrored_mismatch(problem, trace),
        "jump_cycles": jump,
    }


def yielded(
    problem: ContactProblem, state: ContactState, trace: CycleTrace, scars: tuple[Scar, Scar]
) -> dict[str, float]:
    """Columns of the evolution's row for bodies that yield (see `COLUMN_MEANINGS`); empty for elastic bodies."""
    if problem.limit is None:
        return {}
    touching = [report for report in trace.reports if report.footprint is not None]
    within = areas([report.footprint for report in touching if report.footprint is not None])
    pressures = [report.normal_force / area for report, area in zip(touching, within, strict=True) if area > 0.0]
    bodies, prints = (problem.primary, problem.secondary), state.wear.prints
    volumes = (
        float(body.node_areas @ np.maximum(depth, 0.0).ravel())
        for body, depth in zip(bodies, prints, strict=True)
        if depth is not None
    )
    return {
        **{f"print_{scar.body}_um": float(scar.print_um.max()) for scar in scars if scar.print_um is not None},
        PLASTIC_VOLUME: sum(volumes),
        PLASTIC_WORK: state.wear.plastic_mJ,
        OVER_YIELD: max(pressures, default=0.0) / problem.limit.yield_stress_MPa,
    }


def covered(problem: ContactProblem, state: ContactState) -> dict[str, float]:
    """Columns of the evolution's row for debris that may leave (see `COLUMN_MEANINGS`); empty if none can."""
    if problem.debris is None:
        return {}
    (own, other), worn = state.wear.debris(problem.retained), state.wear
    volume = float(problem.primary.node_areas @ own.ravel() + problem.secondary.node_areas @ other.ravel())
    return {
        DEBRIS_VOLUME: volume,
        DEBRIS_LEFT: worn.debris_left_mm3,
        DEBRIS_THICKNESS: 1e3 * float(own.max() + other.max()),
    }


def warmed(problem: ContactProblem, state: ContactState) -> dict[str, float]:
    """Columns of the evolution's row for surfaces that friction warms (see `COLUMN_MEANINGS`); empty if none are."""
    if problem.wear.heat is None:
        return {}
    largest = max(float(rise.max()) for rise in state.wear.rises or (np.zeros(1),))
    return {MEAN_RISE: state.wear.rise_K, LARGEST_RISE: largest}


def layer_settings(study: AnyStudy) -> dict[str, object]:
    """Settings of a result with coatings: [thickness in µm, wear factor] of each, by body, and [Young's modulus in MPa,
    Poisson's ratio] where these are not the body's; empty without any.
    """
    layers = study.layers
    stated = {body: [[one.thickness_um, one.wear_factor] for one in own] for body, own in layers.items() if own}
    elastic = {
        body: [[material.youngs_modulus_MPa, material.poissons_ratio] for _, material in coating.layers]
        for body, coating in zip(layers, study.tables.coatings, strict=True)
        if coating is not None
    }
    found: dict[str, object] = {LAYERS_OF_BODIES: stated} if stated else {}
    return found | {ELASTIC_LAYERS: elastic} if elastic else found


def holder_settings(problem: ContactProblem, trace: CycleTrace) -> dict[str, float | str]:
    """Settings of a result with the holder's stiffnesses and play as a closed loop shows them; "rigid" for infinite
    ones. Empty if the loop has no force in one direction.
    """
    try:
        found = measured_holder(problem, trace.states)
    except SolverError:
        return {}
    stiffnesses = {
        "measured_tangential_stiffness_N_per_mm": found.tangential_stiffness_N_per_mm,
        "measured_rotational_stiffness_N_mm_per_rad": found.rotational_stiffness_N_mm_per_rad,
        "measured_stiffness_at_contact_N_per_mm": found.contact_stiffness_N_per_mm,
    }
    named: dict[str, float | str] = {key: "rigid" if np.isinf(k) else k for key, k in stiffnesses.items()}
    return {**named, "measured_free_play_um": 1e3 * found.play_mm}


def travels(problem: ContactProblem) -> dict[str, float]:
    """The rig's travel to either side before the bodies slide, in µm by key: by its springs, and by its play."""
    holder = problem.holder
    by_springs = problem.friction * holder.normal_load_N * holder.compliance_at_contact_mm_per_N
    return {SPRING_TRAVEL: 1e3 * by_springs, PLAY_TRAVEL: 500.0 * holder.play_mm}


class Recorded(ABC):
    """The record of one run: loops, scars, evolution, contact forces, qualities. Result and checkpoint hold everything
    that a resumed run needs of it.
    """

    contact_kind: str
    bodies: tuple[str, str]
    length_mm: float | None
    ends = False  #: True if the loop measured next is the run's last, because a stop ends the test.

    def __init__(self, study: Any, fidelity: str, pressure_length_mm: float) -> None:
        """An empty record of a study without variants, whose mean pressures are over `pressure_length_mm`."""
        self._study, self._fidelity, self._pressure_length_mm = study, fidelity, pressure_length_mm
        self.schedule = study.schedule
        self.tally = Tally()
        self._loops: list[Loop] = []
        self._scars: list[Scar] = []
        self._forces: list[ContactForces] = []
        self._rows: list[dict[str, float]] = []
        self._holder: dict[str, float | str] = {}

    def restore(self, before: RunResult, done: float) -> None:
        """Take over what an interrupted run, whose result is `before`, had recorded up to cycle `done`."""
        self._loops = [loop for loop in before.loops if loop.cycle <= done]
        self._scars = [scar for scar in before.scars if scar.cycle <= done]
        self._forces = [forces for forces in before.contact_forces if forces.cycle <= done]
        evolution = before.evolution
        count = int((evolution["cycle"] <= done).sum())
        self._rows = [{name: float(column[i]) for name, column in evolution.items()} for i in range(count)]

    def record_pressed(self, problem: ContactProblem, state: ContactState, report: IncrementReport) -> None:
        """Record the fresh contact under the normal load alone: largest pressure, and figures of laws and yielding."""
        self.tally.fresh = {"fresh_max_pressure_MPa": report.max_pressure}
        if problem.limit is not None:
            self.tally.fresh |= limit_settings(problem, report, line=self.length_mm is not None)
        if not isnan(error := law_error(problem, state)):
            self.tally.fresh[_LAW_ERROR] = error

    def record_loop(
        self,
        problem: ContactProblem,
        state: ContactState,
        trace: CycleTrace,
        done: float,
        jump: float,
        held: HeldFigure | None,
    ) -> None:
        """Record a closed loop without wear after `done` cycles, with scars and forces where `logs` says so.

        jump: size in cycles of the latest jump. held: what the drive holds in place of its amplitude in this block,
        None for the amplitude.
        """
        self._holder = self.holder_of(problem, trace)
        block = self.schedule.at(done)
        cycle, conditions = round(done), block.study.conditions
        loop = loop_of(trace, cycle, conditions.frequency_Hz)
        scars = self.scars(problem, trace, cycle)
        pressures = pressure_figures(problem, trace, self._pressure_length_mm)
        row = evolution_row(problem, state, trace, scars, pressures, done, jump)
        row |= {BULK_WORK: bulk_work(problem, trace)} if self.schedule.pulled else {}
        if any(held_keys(own.study.conditions) for own in self.schedule.stretches):
            row["held_error"] = nan if held is None else held.error(trace)
        by_block = {"block": float(block.block)} if len(self.schedule.stretches) > 1 else {}
        if problem.unchanging:
            row["accumulated_energy_J"] = 1e-3 * self._energy_of_loops_mJ(row | by_block)
        self._rows.append(row | self.further_columns(loop, scars) | by_block)
        if len(self._rows) == 1:
            self.tally.fresh |= travels(problem)
        counters = self.tally.counters
        counters.worst("volume_against_energy", volume_mismatch(problem, state, scars))
        judge(counters, trace, self._rows)
        counters.depth_between_nodes = depth_spread(problem, state)
        counters.worst("slip_between_nodes", self._energy_error(unresolved_slip(problem.primary.patch, trace)))
        if isinstance(problem.primary.patch.profile, Arc):
            counters.slip_against_loops = nan  # A pin that climbs its bore slides further than it moves along x.
        if by_block:
            counters.energy_against_loops = nan  # loops of some blocks say nothing of the energy of others
        if self.logs(cycle, done):
            self._loops.append(loop)
            self._scars.extend(scars)
            self._forces.extend(self.forces(problem, trace, cycle))

    def _energy_of_loops_mJ(self, row: Mapping[str, float]) -> float:
        """Friction energy of all cycles up to that of the next row where nothing wears, by the loops of each block."""
        rows, end = [*self._rows, row], row["cycle"]
        start, before_mJ = (rows[-2]["cycle"], 1e3 * rows[-2]["accumulated_energy_J"]) if self._rows else (0.0, 0.0)
        if start and self.schedule.at(start) is self.schedule.at(end):
            return before_mJ + enclosed_energy([start, end], [friction_work_mJ(each) for each in rows[-2:]])
        latest = {each.get("block", 1.0): friction_work_mJ(each) for each in rows}
        passed = [own for own in self.schedule.stretches if own.start < end and own.end > start]
        return float(before_mJ + sum((min(own.end, end) - max(own.start, start)) * latest[own.block] for own in passed))

    def _energy_error(self, of_loop: float) -> float:
        """The latest loop's relative error scaled by its energy over the largest one of its block.

        Where all but the core has worn away, little slips, and the energy that a loop encloses is small.
        """
        now = self._rows[-1]
        of_block = [row["dissipated_energy_mJ"] for row in self._rows if row.get("block") == now.get("block")]
        return of_loop * now["dissipated_energy_mJ"] / max(of_block) if max(of_block) > 0.0 else of_loop

    def holder_of(self, _problem: ContactProblem, _trace: CycleTrace) -> dict[str, float | str]:
        """Settings with the holder's stiffnesses and play as a measured loop shows them, by key; empty by default."""
        return {}

    def follows(self, problem: ContactProblem, state: ContactState, done: float, _work_mJ: float) -> bool:
        """True if no loop is needed after `done` cycles: no coating has come to 90 % of being worn through since the
        latest one, and the energy has gone as interpolation between loops assumes. _work_mJ: friction work of the
        latest cycle.
        """
        block = self.schedule.at(done).block
        if problem.unchanging and all(row.get("block", 1.0) != block for row in self._rows):
            return False  # the energy of its cycles would not be known
        # Of the depth at which a layer ends: a loop is measured where it is that deep, so that its end is predicted
        # from near.
        return not any(
            self._rows[-1][f"max_depth_{body}_um"] < nearly <= 1e3 * float(depth.max())
            for body, depth in zip(self.bodies, worn_depths(problem, state), strict=True)
            for nearly in 0.9 * np.cumsum([layer.thickness_um for layer in self._study.layers[body]])
        )

    def logs(self, _cycle: int, _done: float) -> bool:
        """True if loop, scars and forces of a measured cycle are kept; by default of all."""
        return True

    def further_columns(self, _loop: Loop, _scars: tuple[Scar, Scar]) -> dict[str, float]:
        """Columns of the evolution's row that only this kind of contact has, by name; empty by default."""
        return {}

    @abstractmethod
    def scars(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[Scar, Scar]:
        """(driven, held): scars of both bodies from a traced cycle."""

    @abstractmethod
    def forces(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[ContactForces, ...]:
        """(driven, held): contact forces in a traced cycle; empty if the study asks for none."""

    @abstractmethod
    def tables(self) -> dict[str, object]:
        """The resolved study, as a result keeps it."""

    @abstractmethod
    def settings(self, history: MeshHistory) -> dict[str, object]:
        """Mesh sizes, steps and other values that followed from the study, by key."""

    def result(self, status: str, message: str, history: MeshHistory) -> RunResult:
        """The result so far. status, message: of the run; history: the meshes that it went through."""
        tally = self.tally
        cycling_s, evolution = tally.cycling_s, Evolution.from_rows(self._rows)
        borne = borne_settings(self._study)
        settings = self.settings(history) | layer_settings(self._study) | borne
        # Under bodies that yield Hertz' pressure never is.
        fresh = tally.fresh["fresh_max_pressure_MPa"] if STRAIN in tally.fresh else settings["hertz_pressure_MPa"]
        largest = float(np.fmax.reduce([fresh, *evolution["max_mean_pressure_MPa"]]))
        known = {"pressure_against_strength": largest / float(borne[BORNE])}
        known |= {name: tally.fresh[key] for name, key in _OF_FRESH.items() if key in tally.fresh}
        return RunResult(
            name=self._study.name,
            variant=self._study.variant_name,
            fidelity=self._fidelity,
            status=status,
            message=message,
            study=self.tables(),
            loops=tuple(self._loops),
            evolution=evolution,
            scars=tuple(self._scars),
            contact_forces=tuple(self._forces),
            settings=settings,
            quality=tally.counters.quality() | known,
            versions={program: installed(program) for program in _PROGRAMS},
            timings_s={
                "preparation": tally.preparation_s,
                "cycling": cycling_s,
                "total": tally.preparation_s + cycling_s,
            },
            contact_kind=self.contact_kind,
            bodies=self.bodies,
            length_mm=self.length_mm,
        )
