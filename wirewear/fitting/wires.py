"""Tests of crossed wires as a fit sees them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import brentq

from wirewear.diagnosis.model.candidates import nominal_setup
from wirewear.diagnosis.model.nominal import ObserverOf, limits_of, nominal_run, nominal_study
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.fitting.subject import Volumes, Worn
from wirewear.fitting.values import FittedParameter
from wirewear.loops.branches import remaining_force
from wirewear.records.exporting import true_loop
from wirewear.records.values import MeasuredLoop
from wirewear.reference import Elastic, hertz_crossed_cylinders, mindlin_stiffness, tangential_contact_modulus
from wirewear.study import study_from_tables

if TYPE_CHECKING:
    from wirewear.diagnosis.model.setup import Setup
    from wirewear.records import ExperimentRecord
    from wirewear.results import RunResult
    from wirewear.study import Study

#: Displacement to full slip is this multiple of force over initial stiffness (Mindlin).
FULL_SLIP = 1.5

COEFFICIENT = "energy_wear_coefficient_mm3_per_J"


def contact_stiffness_N_per_um(record: ExperimentRecord) -> float:
    """Mindlin's 2G*a of the unworn wires under the record's load."""
    wires = record.tables.wires
    radius = 0.5 * wires.diameter_mm
    body = Elastic(wires.youngs_modulus_MPa, wires.poissons_ratio)
    load, angle = record.tables.conditions.normal_load_N, wires.crossing_angle_deg
    hertz = hertz_crossed_cylinders(load, radius, radius, angle, first=body, second=body)
    return 1e-3 * mindlin_stiffness(tangential_contact_modulus(body, body), hertz.contact_radius_mm)


def loop_stiffness(contact_N_per_um: float, rig_um_per_N: float) -> float:
    """K_t,m of a contact and a rig in series, by the definition of the loops' analysis: a line over half the region."""
    contact = FULL_SLIP / contact_N_per_um
    travel = np.linspace(0.0, 0.5, 101)
    slope = np.polyfit(travel, remaining_force(travel, contact / (contact + rig_um_per_N)), 1)[0]
    return float(-slope / (contact + rig_um_per_N))


def rig_compliance(measured_N_per_um: float, contact_N_per_um: float) -> float:
    """Compliance of the rig in µm/N, 1/K_rig = 1/K_t,m − 1/K_c; 0 where the contact takes all of it."""
    if loop_stiffness(contact_N_per_um, 0.0) <= measured_N_per_um:
        return 0.0
    most = 2.0 / measured_N_per_um
    return float(brentq(lambda c: loop_stiffness(contact_N_per_um, c) - measured_N_per_um, 0.0, most))


@dataclass(frozen=True, eq=False)
class WiresTestFit:
    """A test of crossed wires; see `Subject`."""

    record: ExperimentRecord
    #: Stiffer than the contact of any wire.
    rigid_N_per_mm: float = 1e6
    where_volumes: str = "measure both scars ([scars.moving] and [scars.fixed] of the mapping)"

    def worn(self, volumes: Volumes, energies_J: Mapping[int, float]) -> Worn:
        """The coefficient of both wires, and the moving one's share."""
        moving_scars, fixed_scars = volumes["moving"], volumes["fixed"]
        both = sorted(set(energies_J) & set(moving_scars) & set(fixed_scars))
        if both:
            moving, fixed = (np.array([own[repeat] for repeat in both]) for own in (moving_scars, fixed_scars))
            coefficient = (moving + fixed) / np.array([energies_J[repeat] for repeat in both])
            fitted = {
                COEFFICIENT: FittedParameter.of_repeats(coefficient, "mm3_per_J"),
                "moving_share": FittedParameter.of_repeats(moving / (moving + fixed), "1"),
            }
            return fitted, []
        alone = next((wire for wire, own in volumes.items() if set(own) & set(energies_J)), None)
        if alone is None:
            return {}, []
        repeats = sorted(set(volumes[alone]) & set(energies_J))
        stated = self.record.tables.stated.moving_share
        share = stated if alone == "moving" else 1.0 - stated
        own = np.array([volumes[alone][repeat] / energies_J[repeat] for repeat in repeats])
        note = (
            f"only the {alone} wire's scar is known: the wear coefficient of both takes its share of {share:g} for "
            "granted; measure the other wire's scar, too"
        )
        return {COEFFICIENT: FittedParameter.of_repeats(own / share, "mm3_per_J")}, [note]

    def parted(self, total: FittedParameter) -> Worn:
        """As it is."""
        return {COEFFICIENT: total}, []

    def total_of(self, parameters: Mapping[str, FittedParameter]) -> float | None:
        """The coefficient."""
        return parameters[COEFFICIENT].value if COEFFICIENT in parameters else None

    def stated_wear(self) -> str | None:
        """The coefficient."""
        stated = self.record.tables.stated.energy_wear_coefficient_mm3_per_J
        return None if stated is None else f"{stated:.3g} mm³/J"

    def contact_stiffness_N_per_um(self, friction: float) -> float:  # noqa: ARG002
        """Mindlin's."""
        return contact_stiffness_N_per_um(self.record)

    def rig_compliance(self, measured_N_per_um: float, contact_N_per_um: float) -> float:
        """By Mindlin's micro-slip in series with a spring."""
        return rig_compliance(measured_N_per_um, contact_N_per_um)

    def study(self, stated: Mapping[str, Any], effects: list[dict[str, Any]], cycles: list[int]) -> Study:
        """As the record states it with these keys."""
        record = self.record
        believed = record.tables.stated.model_copy(update={"friction_evolution": None, **stated})
        known = believed.energy_wear_coefficient_mm3_per_J is not None
        if not known:
            believed = believed.model_copy(update={COEFFICIENT: 0.0})
        study = nominal_study(replace(record, tables=record.tables.model_copy(update={"stated": believed})))
        data = study.given()
        if not known:
            data.pop("wear")
        all_effects = [*data.get("effects", ()), *effects]
        more = {"log": {"loop_cycles": cycles}} | ({"effects": all_effects} if all_effects else {})
        return study_from_tables(data | more, f"the fit of {record.name!r}")

    def states(self, study: Study, observer_of: ObserverOf | None) -> tuple[WearStates, tuple[str, ...]]:
        """Those of the nominal run."""
        return wear_states(study, observer_of)

    def run(
        self, study: Study, output: Path, fidelity: str, observer_of: ObserverOf
    ) -> tuple[RunResult, dict[int, MeasuredLoop]]:
        """Loops as they are logged."""
        from wirewear.simulation import run_study

        result = run_study(study, fidelity=fidelity, output=output, observer_of=observer_of)[0]
        return result, {loop.cycle: true_loop(loop) for loop in result.loops}

    def setup(self, study: Study) -> Setup:
        """The nominal one."""
        return nominal_setup(study, self.record.tables.conditions.drive)


def wear_states(study: Study, observer_of: ObserverOf | None) -> tuple[WearStates, tuple[str, ...]]:
    """Wear states of a finite element run of the study, and what that run says against them."""
    nominal = nominal_run(study, observer_of)
    return WearStates.of_run(nominal), limits_of(nominal)
