"""Friction and rig of a test whose loops have no plateau or slope of their own, by the search of a diagnosis.

That is so under a load that varies within the cycle, and in a scar of longer strokes. The test's nominal run, with a
friction near that of its loops and a rigid rig, is corrected by another friction and a spring.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from wirewear.base.errors import RecordError
from wirewear.diagnosis.answer import estimates
from wirewear.diagnosis.fit.values import FittedParameter
from wirewear.diagnosis.infer.inference import fit
from wirewear.diagnosis.infer.search import problem_around
from wirewear.diagnosis.observe.observed_record import repaired
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.surrogate.candidates import Candidate
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.nominal_model import nominal_model
from wirewear.effects import effect_named
from wirewear.loops.sensor import enclosed_areas

if TYPE_CHECKING:
    from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
    from wirewear.diagnosis.surrogate.nominal import ObserverOf
    from wirewear.diagnosis.surrogate.wear_states import WearStates
    from wirewear.records import AnyRecord
    from wirewear.records.values import MeasuredLoop
    from wirewear.test import AnyStudy

#: Share of the stated load from which the ratio of both forces is read, and the percentile of it that is friction.
_PRESSED, _SLIDES = 0.3, 90.0

#: Cycles at which the friction energy is asked for; areas of loops stand for it if they are so near.
_CYCLES, _AREA_ERROR = 12, 0.05


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
