"""Friction and rig of tests whose loops have no plateau of their own.

Single loops in partial slip leave them intervals. Under a load that varies within the cycle, and in a scar of longer
strokes, the search of a diagnosis corrects the test's nominal run, with a friction near that of its loops and a rigid
rig, by another friction and a spring.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import stdtrit

from wirewear.base.errors import RecordError
from wirewear.base.words import counted
from wirewear.diagnosis.answer import estimates
from wirewear.diagnosis.fit.values import FittedParameter
from wirewear.diagnosis.infer.inference import fit, problem_around
from wirewear.diagnosis.observe.observed_record import repaired
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.surrogate.candidates import Candidate
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.nominal_model import nominal_model
from wirewear.effects import effect_named
from wirewear.loops import LoopError, LoopFigures, Measured
from wirewear.loops.figures import Sticking, regime_of
from wirewear.loops.sensor import enclosed_areas
from wirewear.records import AnyRecord
from wirewear.records.values import MeasuredLoop

if TYPE_CHECKING:
    from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
    from wirewear.diagnosis.surrogate.nominal import ObserverOf
    from wirewear.diagnosis.surrogate.wear_states import WearStates
    from wirewear.test import AnyStudy

CONTACT = 0.1  #: Relative standard deviation of an unworn contact's compliance by closed form.

#: Share of the stated load from which the ratio of both forces is read, and the percentile of it that is friction.
_PRESSED, _SLIDES = 0.3, 90.0

#: Cycles at which the friction energy is asked for; areas of loops stand for it if they are so near.
_CYCLES, _AREA_ERROR = 12, 0.05


@dataclass(frozen=True)
class StickingFit:
    """Fitted friction and rig stiffness by name, and a sentence on what they are based on."""

    parameters: dict[str, FittedParameter]
    note: str


def fitted_sticking(record: AnyRecord, rigid_N_per_mm: float) -> StickingFit | None:
    """Friction and rig of a test none of whose loops slides as a whole; None if one does, or none can be analysed.

    rigid_N_per_mm: stiffness from which a rig counts as rigid. The compliance of the unworn contact, if it has a closed
    form, is taken as known in the first logged cycle. Raises RecordError if no loop bounds friction above.
    """
    loops = _loops(record)
    if not loops:
        return None
    cycles = sorted({cycle for _, cycle in loops})
    own = None if record.within_longer_strokes else record.tables.contact_stiffness_N_per_um
    if own is not None:
        loops |= {key: loop.given(1.0 / own, CONTACT) for key, loop in loops.items() if key[1] == cycles[0]}
    frictions = {key: one for key, loop in loops.items() if (one := loop.friction) is not None}
    bounded = {key: one for key, one in frictions.items() if np.isfinite(one.interval95[1])}
    if not bounded:
        least = max((one.interval95[0] for one in frictions.values()), default=None)
        raise RecordError(
            f"no loop of the record {record.name!r} slides as a whole, and none bounds friction above"
            + ("" if least is None else f": it is at least {least:.3g}")
            + ", so that neither friction nor wear can be fitted. One stroke that slides shows friction."
        )
    _, cycle = min(bounded, key=lambda key: _width(bounded[key]))
    keys = [key for key in bounded if key[1] == cycle]
    friction = _of_tests([bounded[key] for key in keys], "1")
    rig = _of_tests([_stiffness(loops[key].rig, rigid_N_per_mm) for key in keys], "N_per_mm")
    known = "" if own is None or cycle != cycles[0] else ", the unworn contact's stiffness taken as known within 10 %"
    note = (
        "no loop slides as a whole: friction and rig are those that energy, stiffness and shape of the loops of cycle "
        f"{counted(cycle)} leave{known}, and no course of friction is fitted"
    )
    return StickingFit({"friction": friction, "tangential_stiffness_N_per_mm": rig}, note)


def left_out(record: AnyRecord) -> list[str]:
    """A sentence on the loops in partial slip of a mixed test, which a fit to sliding loops leaves out; empty for other
    tests.
    """
    known = [figures for loop in record.loops if (figures := _figures(loop, record)) is not None]
    if regime_of(known) != "mixed":
        return []
    sticking = [figures for figures in known if figures.regime == "partial slip"]
    frictions = [one for figures in sticking if (one := figures.friction_partial_slip) is not None]
    bounded = [one.interval95 for one in frictions if np.isfinite(one.interval95[1])]
    said = f"a mixed test: {len(sticking)} of {len(known)} loops are in partial slip, and were not fitted"
    if bounded:
        low, high = min(bounded, key=lambda one: one[1] / max(one[0], 1e-300))
        said += f"; by themselves they leave friction from {low:.2g} to {high:.2g}, at best"
    return [said]


def _figures(loop: MeasuredLoop, record: AnyRecord) -> LoopFigures | None:
    try:
        return loop.figures(record.tables.conditions.normal_load_N)
    except LoopError:
        return None


def _loops(record: AnyRecord) -> dict[tuple[int, int], Sticking]:
    """Contacts in partial slip by repeat and cycle; empty if a loop of the record has a plateau."""
    found = {}
    for loop in record.loops:
        figures = _figures(loop, record)
        if figures is None:
            continue
        if figures.friction_geometry_independent is not None:
            return {}
        if figures.sticking is not None and loop.cycle > 0:
            found[loop.repeat, loop.cycle] = figures.sticking
    return found


def _width(friction: Measured) -> float:
    low, high = friction.interval95
    return high / max(low, 1e-300)


def _stiffness(rig_um_per_N: Measured, rigid_N_per_mm: float) -> Measured:
    """Stiffness in N/mm from a compliance, at most that of a rigid rig."""
    least = 1e3 / rigid_N_per_mm
    value, high, low = (1e3 / max(one, least) for one in (rig_um_per_N.value, *rig_um_per_N.interval95))
    return Measured(value, (low, high))


def _of_tests(found: Sequence[Measured], unit: str) -> FittedParameter:
    """Geometric mean of values, or of the ends where these are only bounds, with the scatter between tests added by
    Student's t.

    The width of the single intervals does not shrink with the number of tests, as it is a common error.
    """
    logs = np.log([(one.value, *one.interval95) for one in found])
    logs[:, 0] = np.where(np.isnan(logs[:, 0]), logs[:, 1:].mean(axis=1), logs[:, 0])
    value, low, high = logs.mean(axis=0)
    count = len(found)
    scatter = float(stdtrit(count - 1, 0.975) * logs[:, 0].std(ddof=1) / np.sqrt(count)) if count > 1 else 0.0
    ends = value - np.hypot(value - low, scatter), value + np.hypot(high - value, scatter)
    return FittedParameter(float(np.exp(value)), (float(np.exp(ends[0])), float(np.exp(ends[1]))), unit, count)


def needs_search(record: AnyRecord) -> bool:
    """True if no single loop of a record shows friction and stiffness, wherever it slides."""
    return record.tables.conditions.load_cycle is not None or record.within_longer_strokes


def friction_of_forces(record: AnyRecord) -> float:
    """Tangential force over normal force where a record's loops slide, about their coefficient of friction.

    Raises RecordError if no loop has both, or none that presses.
    """
    load_N = record.tables.conditions.normal_load_N
    found = [ratio for loop in record.loops if np.isfinite(ratio := _ratio(loop, load_N))]
    if not found:
        raise RecordError(f"no loop of the record {record.name!r} has a tangential force under load.")
    return float(np.median(found))


def _ratio(loop: MeasuredLoop, load_N: float) -> float:
    whole = loop.complete
    force = whole.tangential_force_N - 0.5 * (whole.tangential_force_N.max() + whole.tangential_force_N.min())
    load = np.full(force.size, load_N) if whole.normal_force_N is None else whole.normal_force_N
    pressed = load > _PRESSED * load_N
    return float(np.percentile(np.abs(force[pressed] / load[pressed]), _SLIDES)) if pressed.any() else np.nan


def fitted_by_search(
    record: AnyRecord, study: AnyStudy, observer_of: ObserverOf | None
) -> tuple[dict[str, FittedParameter], float | None, list[str]]:
    """Friction and rig stiffness by name, the friction energy of the test in J where areas of loops do not show it, and
    sentences on what limits them.

    study: of the record's test, with about its friction and a rigid rig. Raises as `PreparedRecord.reduced` does.
    """
    model = nominal_model(study)
    states, limits = model.states(record.tables, observer_of)
    whole, notes = repaired(record)
    observed = reduce(whole)
    setup = replace(model.inputs(record.tables), motion=observed.motion)
    candidates = [
        Candidate.of(effect_named(name), setup.stated, scales=setup.scales, contact=setup.contact_kind)
        for name in ("friction_offset", "tangential_compliance")
    ]
    problem, _ = problem_around(states, setup, setup, observed)
    rough = fit(problem, candidates)
    problem, _ = problem_around(states, setup, rough.setup, observed, candidates, problem)
    best = fit(problem, candidates, [rough.coordinates])
    dispersion = max(best.distance2 / problem.mean.size, 1.0)
    parameters = {}
    names = {"friction": "friction", "stiffness_N_per_mm": "tangential_stiffness_N_per_mm"}
    for part in best.parts():
        for key, one in estimates(*part, dispersion).items():
            unit = part[0].parameters[key].quantity.unit
            parameters[names[key]] = FittedParameter(one.value, one.interval95, unit, len(record.repeats))
    return parameters, _friction_energy_J(states, best.setup), [*limits, *notes, *observed.notes]


def _friction_energy_J(states: WearStates, setup: SurrogateInputs) -> float | None:
    """Friction energy of the whole test, if it is not that of the loops' areas: a load that varies adds to these."""
    cycles = np.unique(np.round(np.geomspace(1.0, setup.cycles, _CYCLES)))
    found = simulate(states, setup, cycles)
    loops = (one.reshape(cycles.size, -1) for one in (found.displacement_um, found.tangential_force_N))
    area_mJ = 1e-3 * enclosed_areas(*loops)
    if np.abs(area_mJ - found.energy_mJ).max() < _AREA_ERROR * found.energy_mJ.max():
        return None
    wearing = np.append(0.0, setup.wearing_cycles(cycles))
    return 1e-3 * float(np.trapezoid(np.append(found.energy_mJ[:1], found.energy_mJ), wearing))
