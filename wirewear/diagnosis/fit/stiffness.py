"""Stiffness of a contact, of its rig and of the spring that presses it.

1/K_rig = 1/K_t,m − 1/K_c, with K_t,m the measured stiffness and K_c the contact's, including micro-slip. The spring's
stiffness follows from the fall of the measured normal force as the bodies wear.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq
from scipy.special import stdtrit

from geometry.arrays import Array
from wirewear.base.files import table_of
from wirewear.diagnosis.fit.fast_fit import EVIDENCE, FITTED, LoopsOfTests, figures_of_model
from wirewear.diagnosis.fit.values import FittedParameter
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.nominal_model import nominal_model
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.loops.branches import remaining_force
from wirewear.records import AnyRecord
from wirewear.records.normal_force import median_load_N
from wirewear.records.values import stated_tables
from wirewear.test import study_from_tables

SPRING = "normal_spring_stiffness_N_per_mm"

FULL_SLIP = 1.5  #: Displacement to full slip is this multiple of force over initial stiffness (Mindlin).


def with_spring(
    states: WearStates, setup: SurrogateInputs, record: AnyRecord, tests: LoopsOfTests
) -> tuple[WearStates, dict[str, FittedParameter]]:
    """Wear states whose load falls as the record's does, and the stiffness of the spring that presses the bodies, by
    name; the states as they were and {} if no spring is seen.

    The bodies approach by the sum of both largest depths. As a load may also drift with the cycles, the spring must fit
    better than that by `EVIDENCE`, with an interval above zero.
    """
    ends = [simulate(states, replace(setup, cycles=cycle), np.array([cycle])) for cycle in tests.cycles]
    profiles = [sum(float(depth.max()) for _, depth in one.profiles.values()) for one in ends]
    descent_um = np.array([one.scars[:, 1].sum() for one in ends]) + profiles
    loads = np.full((len(tests.repeats), tests.cycles.size), np.nan)
    for loop in record.loops:
        loads[tests.repeats.index(loop.repeat), tests.cycles == loop.cycle] = median_load_N(loop)
    spring = spring_of_loads(loads, descent_um, tests.cycles)
    if spring is None:
        return states, {}
    worn_um3 = np.array([one.volume_um3[-1] for one in ends])
    drop = 1e-3 * spring.value * np.interp(states.volume_um3, np.append(0.0, worn_um3), np.append(0.0, descent_um))
    return replace(states, load_drop_N=drop), {SPRING: spring}


def spring_of_loads(loads_N: Array, descent_um: Array, cycles: Array) -> FittedParameter | None:
    """Stiffness at which loads (repeats, cycles) in N, NaN where not measured, fall with the bodies' descent (cycles,)
    in µm; None if a drift over `cycles` fits as well, or the interval includes zero.
    """
    slope, left, deviation, free = _common_slope(loads_N, descent_um)
    beside = _common_slope(loads_N, cycles)[1]
    floor = 1e-12 * float(np.nansum(loads_N**2))
    count = int(np.isfinite(loads_N).sum())
    if free < 1 or count * np.log((beside + floor) / (left + floor)) < EVIDENCE:
        return None
    # By how much worn depths miss the way that bodies come together, beyond the first 10 µm of the article's run:
    # growing contacts give back up to 0.7 of 0.9 µm of approach.
    half = float(np.hypot(float(stdtrit(free, 0.975)) * deviation, 1.96 * 0.03 * slope))
    low, value, high = (-1e3 * (slope + side * half) for side in (1.0, 0.0, -1.0))
    if not low > 0.0:
        return None
    return FittedParameter(value, (low, high), "N_per_mm", int(np.isfinite(loads_N).any(axis=1).sum()))


def _common_slope(values: Array, at: Array) -> tuple[float, float, float, int]:
    """Common slope of rows of values over places (m,), each row with its own level.

    Returns the slope, the sum of squares left, the slope's standard deviation, and the degrees of freedom.
    """
    rows, columns = np.nonzero(np.isfinite(values))
    levels = rows[:, None] == np.unique(rows)
    design, wanted = np.column_stack([levels, at[columns]]), values[rows, columns]
    found = np.linalg.lstsq(design, wanted, rcond=None)[0]
    left = float(((wanted - design @ found) ** 2).sum())
    free = wanted.size - np.linalg.matrix_rank(design)
    spread = float(np.linalg.pinv(design.T @ design)[-1, -1])
    return float(found[-1]), left, float(np.sqrt(spread * left / max(free, 1))), int(free)


@dataclass(frozen=True)
class ContactStiffness:
    """Stiffness of an unworn contact and its bodies; `slips` is True if it has Mindlin's micro-slip."""

    N_per_um: float
    slips: bool

    def rig_um_per_N(self, measured_N_per_um: float) -> float:
        """Compliance of the rig behind a measured stiffness in N/µm; 0 if the contact alone explains it."""
        if self.slips:
            return rig_compliance(measured_N_per_um, self.N_per_um)
        return max(1.0 / measured_N_per_um - 1.0 / self.N_per_um, 0.0)


def contact_stiffness(record: AnyRecord, friction: float, some_wear: Mapping[str, float]) -> ContactStiffness:
    """Stiffness of the unworn contact by closed form or else from a simulated loop on a rigid rig. friction, some_wear:
    coefficient and wear coefficients by key for that simulation.
    """
    tables = record.tables
    if tables.contact_stiffness_N_per_um is not None:
        return ContactStiffness(tables.contact_stiffness_N_per_um, tables.contact_slips)
    rigid_rig = dict.fromkeys(("tangential_stiffness_N_per_mm", "rotational_stiffness_N_mm_per_rad"), "rigid")
    data = fitted_tables(record, {"friction": friction, **rigid_rig, **some_wear}, [], [1])
    # Cycles of the run on a rigid rig that shows the stiffness of the contact and its bodies.
    data["conditions"] = {**table_of(data, "conditions"), "cycles": 10}
    model = nominal_model(study_from_tables(data, f"the contact of {record.name!r}"))
    states, _ = model.states(tables, None)
    found = figures_of_model(states, model.inputs(tables), np.array([np.log(friction), 0.0]), np.ones(1))
    measured = float(found[0, list(FITTED).index("measured_stiffness_N_per_um")])
    # A loop that hardly slides shows no straight part: the stiffness at its reversal then stands in.
    stiffness = measured if np.isfinite(measured) else float(states.stiffness_N_per_um[0])
    return ContactStiffness(stiffness, slips=False)


def fitted_tables(
    record: AnyRecord, fitted: Mapping[str, object], effects: list[dict[str, object]], cycles: list[int]
) -> dict[str, object]:
    """Tables of the record's study with fitted keys in place of stated ones, further effects, and these logged
    cycles.
    """
    stated = record.tables.stated.with_fitted(fitted)
    data = stated_tables(record.tables.model_copy(update={"stated": stated}), stated.friction)
    known = data.pop("effects", None)
    all_effects = [*(known if isinstance(known, list) else ()), *effects]
    return data | {"log": {"loop_cycles": cycles}} | ({"effects": all_effects} if all_effects else {})


def loop_stiffness(contact_N_per_um: float, rig_um_per_N: float) -> float:
    """K_t,m in N/µm of a contact and a rig in series, as loops define it: slope of a line over the first half of the
    travel of micro-slip.
    """
    contact = FULL_SLIP / contact_N_per_um
    travel = np.linspace(0.0, 0.5, 101)
    slope = np.polyfit(travel, remaining_force(travel, contact / (contact + rig_um_per_N)), 1)[0]
    return float(-slope / (contact + rig_um_per_N))


def rig_compliance(measured_N_per_um: float, contact_N_per_um: float) -> float:
    """Compliance of the rig in µm/N, from measured and contact stiffness in N/µm, by Mindlin's micro-slip behind a
    spring; 0 if the contact alone is as soft.
    """
    if loop_stiffness(contact_N_per_um, 0.0) <= measured_N_per_um:
        return 0.0
    most = 2.0 / measured_N_per_um
    return float(brentq(lambda c: loop_stiffness(contact_N_per_um, c) - measured_N_per_um, 0.0, most))
