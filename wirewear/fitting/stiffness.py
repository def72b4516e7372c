"""How stiff a contact and its rig are: 1/K_rig = 1/K_t,m − 1/K_c, with the micro-slip of contacts that have some."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq

from wirewear.fitting.fast_fit import figures_of_model
from wirewear.fitting.loops_of_tests import FITTED
from wirewear.kinds import kind_of
from wirewear.loops.branches import remaining_force
from wirewear.records import AnyRecord
from wirewear.records.believed import believed_tables

#: Displacement to full slip is this multiple of force over initial stiffness (Mindlin).
FULL_SLIP = 1.5

#: Cycles of the run on a rigid rig that tells the stiffness of the contact and its bodies.
_FIRST_CYCLES = 10


@dataclass(frozen=True)
class ContactStiffness:
    """Stiffness of an unworn contact and its bodies, and whether it slips within the stick branch as Mindlin's does."""

    N_per_um: float
    slips: bool

    def rig_um_per_N(self, measured_N_per_um: float) -> float:
        """Compliance of the rig behind a measured stiffness; 0 where the contact takes all of it."""
        if self.slips:
            return rig_compliance(measured_N_per_um, self.N_per_um)
        return max(1.0 / measured_N_per_um - 1.0 / self.N_per_um, 0.0)


def contact_stiffness(record: AnyRecord, friction: float, some_wear: Mapping[str, float]) -> ContactStiffness:
    """By closed form, or, where none tells it, of loops of a run on a rigid rig; `some_wear` is for that run."""
    kind, tables = kind_of(record), record.tables
    if tables.contact_stiffness_N_per_um is not None:
        return ContactStiffness(tables.contact_stiffness_N_per_um, slips=True)
    rigid_rig = dict.fromkeys(("tangential_stiffness_N_per_mm", "rotational_stiffness_N_mm_per_rad"), "rigid")
    data = fitted_tables(record, {"friction": friction, **rigid_rig, **some_wear}, [], [1])
    data["conditions"]["cycles"] = _FIRST_CYCLES
    study = kind.study_from_tables(data, f"the contact of {record.name!r}")
    states, _ = kind.states(study, tables, None)
    found = figures_of_model(states, kind.setup(study, tables), np.array([np.log(friction), 0.0]), np.ones(1))
    measured = float(found[0, list(FITTED).index("measured_stiffness_N_per_um")])
    # A loop that hardly slides shows no straight part: the stiffness at its reversal then stands in.
    stiffness = measured if np.isfinite(measured) else float(states.stiffness_N_per_um[0])
    return ContactStiffness(stiffness, slips=False)


def fitted_tables(
    record: AnyRecord, fitted: Mapping[str, Any], effects: list[dict[str, Any]], cycles: list[int]
) -> dict[str, Any]:
    """Tables of the record's study with these keys of `[stated]` in place of its own, and further effects."""
    stated = record.tables.stated.with_fitted(fitted)
    data = believed_tables(record.tables.model_copy(update={"stated": stated}), float(fitted["friction"]))
    all_effects = [*data.pop("effects", ()), *effects]
    return data | {"log": {"loop_cycles": cycles}} | ({"effects": all_effects} if all_effects else {})


def loop_stiffness(contact_N_per_um: float, rig_um_per_N: float) -> float:
    """K_t,m of a contact and a rig in series, by the definition of the loops' analysis: a line over half the region."""
    contact = FULL_SLIP / contact_N_per_um
    travel = np.linspace(0.0, 0.5, 101)
    slope = np.polyfit(travel, remaining_force(travel, contact / (contact + rig_um_per_N)), 1)[0]
    return float(-slope / (contact + rig_um_per_N))


def rig_compliance(measured_N_per_um: float, contact_N_per_um: float) -> float:
    """Compliance of the rig in µm/N by Mindlin's micro-slip in series with a spring."""
    if loop_stiffness(contact_N_per_um, 0.0) <= measured_N_per_um:
        return 0.0
    most = 2.0 / measured_N_per_um
    return float(brentq(lambda c: loop_stiffness(contact_N_per_um, c) - measured_N_per_um, 0.0, most))
