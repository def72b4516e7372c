"""Friction, rig stiffness, play and wear coefficients of a record with intervals, and the study that they make."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import t as students_t

from wirewear.diagnosis.model.candidates import nominal_setup
from wirewear.diagnosis.model.nominal import ObserverOf, limits_of, nominal_run, nominal_study
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.errors import RecordError
from wirewear.fitting.energies import accumulated_energy_J
from wirewear.fitting.fast_fit import FastFit, fast_fit
from wirewear.fitting.loops_of_tests import FITTED, LoopsOfTests, loops_of_tests
from wirewear.fitting.rig import contact_stiffness_N_per_um, rig_compliance
from wirewear.fitting.values import FittedTest, Parameter
from wirewear.records.checking import problems_told
from wirewear.study import study_from_tables

if TYPE_CHECKING:
    from wirewear.records import ExperimentRecord
    from wirewear.study import Study

#: A rig as stiff as this, in N/mm, is one that takes nothing: stiffer than the contact of any wire.
RIGID = 1e6

#: Play is taken over where this share of the loops shows it.
SHARE_WITH_PLAY = 0.5

#: Relative deviation of plays read from loops: those of 4 and 5 µm of two other codes are read 2 and 4 % too small.
PLAY_DEVIATION = 0.03

#: Wear coefficient with which wear states are made where the record does not tell it: that of steel on steel.
ANY_WEAR_mm3_per_J = 3e-5

Stage = Callable[[str], AbstractContextManager[object]]


@dataclass(frozen=True)
class GivenWear:
    """What is known of wear without a measured scar: its coefficient, or the volume that both wires lost in a test."""

    coefficient_mm3_per_J: float | None = None
    volume_mm3: float | None = None


def fit_record(
    record: ExperimentRecord,
    *,
    given: GivenWear | None = None,
    observer_of: ObserverOf | None = None,
    stage: Stage = nullcontext,
) -> FittedTest:
    """Fit the parameters of a test of crossed wires to its record.

    First estimates come from the loops themselves; the fast model, on the wear states of one finite element run with
    these, then fits friction and rig to the loops of all cycles. The wear coefficient is the worn volume over the
    friction energy of the whole test, or what is given of it in place of scars.

    Raises:
        RecordError: the record is unsound, or none of its loops slides as a whole; a worn volume is given, and neither
            loops nor evolution tell the energy.
        StudyError, SolverError: the nominal run of the fast model fails.
    """
    with stage("checking the record"):
        told = problems_told(record)
    with stage("measuring the loops"):
        tests = loops_of_tests(record)
        worn, found, notes = _worn(record)
        if given is not None:
            worn, notes = _given(given, worn, found)
        found |= _stiffnesses(record, tests)
    rough = _rough_study(record, tests, worn)
    states, limits = wear_states(rough, observer_of)
    with stage("fitting all cycles"):
        fitted = fast_fit(states, nominal_setup(rough, record.tables.conditions.drive), tests)
    parameters = _of_fit(fitted, len(tests.repeats), record) | _play(tests) | worn
    study = fitted_study(record, parameters)
    missing = _missing(record, parameters, tests)
    return FittedTest(record, study, parameters, found, (*told, *limits, *notes, *missing))


def wear_states(study: Study, observer_of: ObserverOf | None) -> tuple[WearStates, tuple[str, ...]]:
    """Wear states of a finite element run of the study, and what that run says against them."""
    nominal = nominal_run(study, observer_of)
    return WearStates.of_run(nominal), limits_of(nominal)


def fitted_study(record: ExperimentRecord, parameters: dict[str, Parameter]) -> Study:
    """The record's test with fitted parameters; what was not fitted is as the record states it."""
    stated = stated_by(parameters)
    friction = stated.pop("friction")
    course = stated.pop("friction_evolution", None)
    play = parameters.get("free_play_um")
    believed = record.tables.stated.model_copy(update={"friction": friction, **stated, "friction_evolution": None})
    known = believed.energy_wear_coefficient_mm3_per_J is not None
    if not known:
        believed = believed.model_copy(update={"energy_wear_coefficient_mm3_per_J": 0.0})
    study = nominal_study(replace(record, tables=record.tables.model_copy(update={"stated": believed})))
    data = study.tables.model_dump(mode="json", exclude_none=True, exclude_unset=True)
    data["log"] = {"loop_cycles": [cycle for cycle in record.cycles if 1 <= cycle <= study.conditions.cycles]}
    if not known:
        data.pop("wear")
    effects = list(data.get("effects", ()))
    effects += [{"name": "friction_evolution", **course}] if course is not None else []
    effects += [{"name": "free_play", "gap_um": float(f"{play.value:.4g}")}] if play is not None else []
    return study_from_tables(data | ({"effects": effects} if effects else {}), f"the fit of {record.name!r}")


def stated_by(parameters: dict[str, Parameter]) -> dict[str, Any]:
    """The keys of `[stated]` that parameters give, to four digits: more than their intervals tell."""
    parameters = {name: replace(found, value=float(f"{found.value:.4g}")) for name, found in parameters.items()}
    stated: dict[str, Any] = {}
    if "friction_initial" in parameters:
        initial, final, cycles = (parameters[f"friction_{key}"].value for key in ("initial", "final", "cycles"))
        stated["friction"] = final
        stated["friction_evolution"] = {"initial": initial, "final": final, "cycles": cycles}
    else:
        stated["friction"] = parameters["friction"].value
    stiffness = parameters["tangential_stiffness_N_per_mm"].value
    stated["tangential_stiffness_N_per_mm"] = stiffness if stiffness < RIGID else "rigid"
    for key in ("energy_wear_coefficient_mm3_per_J", "moving_share"):
        if key in parameters:
            stated[key] = parameters[key].value
    return stated


def _rough_study(record: ExperimentRecord, tests: LoopsOfTests, worn: dict[str, Parameter]) -> Study:
    """The test with what loops and scars say by themselves."""
    friction = float(np.nanmean(tests.figures[:, :, 0]))
    stiffness = 1e3 / max(_first_compliance(record, tests), 1e3 / RIGID)
    rough = {
        "friction": Parameter(round(friction, 3), (friction, friction), "1", 1),
        "tangential_stiffness_N_per_mm": Parameter(float(f"{stiffness:.3g}"), (stiffness, stiffness), "N_per_mm", 1),
    }
    coefficient = worn.get("energy_wear_coefficient_mm3_per_J")
    rough |= _play(tests)
    stated = record.tables.stated.energy_wear_coefficient_mm3_per_J
    value = float(f"{coefficient.value:.2g}") if coefficient is not None else stated or ANY_WEAR_mm3_per_J
    rough["energy_wear_coefficient_mm3_per_J"] = Parameter(value, (value, value), "mm3_per_J", 1)
    study = fitted_study(record, rough)
    return study.changed({"log": {"loop_cycles": ()}})


def _first_compliance(record: ExperimentRecord, tests: LoopsOfTests) -> float:
    stiffness = tests.figures[:, :, list(FITTED).index("measured_stiffness_N_per_um")]
    known = stiffness[np.isfinite(stiffness)]
    if not known.size:
        return 0.0
    # Of the earliest cycle that shows it: the contact is as Mindlin's only while little has worn.
    first = next(column[np.isfinite(column)] for column in stiffness.T if np.isfinite(column).any())
    return rig_compliance(float(first.mean()), contact_stiffness_N_per_um(record))


def _stiffnesses(record: ExperimentRecord, tests: LoopsOfTests) -> dict[str, Parameter]:
    """K_t,m of the first loops, K_c by Mindlin, and K_rig by 1/K_rig = 1/K_t,m − 1/K_c."""
    contact = contact_stiffness_N_per_um(record)
    place = list(FITTED).index("measured_stiffness_N_per_um")
    columns = [(j, column[np.isfinite(column)]) for j, column in enumerate(tests.figures[:, :, place].T)]
    first = next(((j, column) for j, column in columns if column.size), None)
    found = {"contact_stiffness_N_per_mm": Parameter(1e3 * contact, (1e3 * contact, 1e3 * contact), "N_per_mm", 0)}
    if first is None:
        return found
    deviation = float(tests.deviations[first[0], place]) / np.sqrt(first[1].size)
    measured = Parameter.of_repeats(1e3 * first[1], "N_per_mm", 1e3 * deviation)
    compliance = [rig_compliance(1e-3 * k, contact) for k in (measured.value, *reversed(measured.interval95))]
    rigs = [1e3 / max(c, 1e3 / RIGID) for c in compliance]
    found["measured_stiffness_N_per_mm"] = measured
    found["rig_stiffness_of_first_loops_N_per_mm"] = Parameter(
        rigs[0], (min(rigs[1:]), max(rigs[1:])), "N_per_mm", first[1].size
    )
    return found


def _worn(record: ExperimentRecord) -> tuple[dict[str, Parameter], dict[str, Parameter], list[str]]:
    """Wear coefficient and share of the moving wire, energies and volumes, and what is missing."""
    energies = {repeat: accumulated_energy_J(record, repeat) for repeat in record.repeats}
    known = {repeat: energy for repeat, energy in energies.items() if energy}
    volumes = {wire: {scar.repeat: scar.volume_mm3 for scar in record.scars_of(wire)} for wire in ("moving", "fixed")}
    found = {
        f"worn_volume_{wire}_mm3": Parameter.of_repeats([*own.values()], "mm3") for wire, own in volumes.items() if own
    }
    if known:
        found["accumulated_energy_J"] = Parameter.of_repeats([*known.values()], "J")
    both = sorted(set(known) & set(volumes["moving"]) & set(volumes["fixed"]))
    if both:
        moving, fixed = (np.array([volumes[wire][repeat] for repeat in both]) for wire in ("moving", "fixed"))
        coefficient = (moving + fixed) / np.array([known[repeat] for repeat in both])
        fitted = {
            "energy_wear_coefficient_mm3_per_J": Parameter.of_repeats(coefficient, "mm3_per_J"),
            "moving_share": Parameter.of_repeats(moving / (moving + fixed), "1"),
        }
        return fitted, found, []
    alone = next((wire for wire, own in volumes.items() if set(own) & set(known)), None)
    if alone is None:
        return {}, found, []
    repeats = sorted(set(volumes[alone]) & set(known))
    share = record.tables.stated.moving_share if alone == "moving" else 1.0 - record.tables.stated.moving_share
    own = np.array([volumes[alone][repeat] / known[repeat] for repeat in repeats])
    note = (
        f"only the {alone} wire's scar is known: the wear coefficient of both takes its share of {share:g} for "
        "granted; measure the other wire's scar, too"
    )
    return {"energy_wear_coefficient_mm3_per_J": Parameter.of_repeats(own / share, "mm3_per_J")}, found, [note]


def _given(
    given: GivenWear, worn: dict[str, Parameter], found: dict[str, Parameter]
) -> tuple[dict[str, Parameter], list[str]]:
    """Wear as given; what scars say of it no longer counts but for the moving wire's share."""
    energy = found.get("accumulated_energy_J")
    if given.coefficient_mm3_per_J is not None:
        value = given.coefficient_mm3_per_J
        coefficient = Parameter(value, (value, value), "mm3_per_J", 0)
        source = "the wear coefficient is the given one, not a fitted one"
    elif given.volume_mm3 is not None and energy is not None:
        # The volume is one number; only the energies of the tests differ.
        low, high = (given.volume_mm3 / end for end in reversed(energy.interval95))
        coefficient = Parameter(given.volume_mm3 / energy.value, (low, high), "mm3_per_J", energy.repeats)
        source = f"the wear coefficient is the given volume of {given.volume_mm3:g} mm³ over the tests' energy"
    else:
        raise RecordError("a worn volume is given, but neither loops nor an evolution tell the energy that wore it.")
    measured = worn.get("energy_wear_coefficient_mm3_per_J")
    beside = "" if measured is None else f"; the scars of the record say {measured.value:.3g} mm³/J"
    return worn | {"energy_wear_coefficient_mm3_per_J": coefficient}, [source + beside]


def _of_fit(fitted: FastFit, repeats: int, record: ExperimentRecord) -> dict[str, Parameter]:
    deviations = np.sqrt(np.diag(fitted.covariance) * max(fitted.misfit / max(fitted.points - 2, 1), 1.0))
    # What the model errs by, it errs by in all loops.
    model = np.full(deviations.size, FITTED["friction_geometry_independent"])
    model[-1] = FITTED["measured_stiffness_N_per_um"] * fitted.compliance_um_per_N
    deviations = np.hypot(deviations, model)
    if repeats > 1:
        # Friction of one specimen is the same in all of its loops: tests count, not loops.
        scatter = fitted.repeats.std(axis=0, ddof=1) / np.sqrt(repeats)
        deviations = np.hypot(deviations, float(students_t.ppf(0.975, repeats - 1)) / 1.96 * scatter)
    low, high = fitted.coordinates - 1.96 * deviations, fitted.coordinates + 1.96 * deviations
    names = ("friction_initial", "friction_final", "friction_cycles") if fitted.runs_in else ("friction",)
    parameters = {}
    for place, name in enumerate(names):
        value, ends = np.exp(fitted.coordinates[place]), np.exp([low[place], high[place]])
        unit = "cycles" if name == "friction_cycles" else "1"
        parameters[name] = Parameter(float(value), (float(ends[0]), float(ends[1])), unit, repeats)
    rotation = _rotation_um_per_N(record)
    stiffness = [float(1e3 / max(c - rotation, 1e3 / RIGID)) for c in (fitted.compliance_um_per_N, high[-1], low[-1])]
    parameters["tangential_stiffness_N_per_mm"] = Parameter(
        stiffness[0], (stiffness[1], stiffness[2]), "N_per_mm", repeats
    )
    return parameters


def _rotation_um_per_N(record: ExperimentRecord) -> float:
    """What a stated rotation of the holder gives way along the motion."""
    stated = record.tables.stated
    if isinstance(stated.rotational_stiffness_N_mm_per_rad, str) or stated.pivot_height_mm is None:
        return 0.0
    return 1e3 * stated.pivot_height_mm**2 / stated.rotational_stiffness_N_mm_per_rad


def _play(tests: LoopsOfTests) -> dict[str, Parameter]:
    seen = np.isfinite(tests.plays[:, :, 0])
    if seen.sum() < SHARE_WITH_PLAY * np.isfinite(tests.figures[:, :, 0]).sum():
        return {}
    own = [float(plays[there, 0].mean()) for plays, there in zip(tests.plays, seen, strict=True) if there.any()]
    # What the analysis of a loop errs by, it errs by in all loops of a kind.
    deviation = np.hypot(np.median(tests.plays[seen][:, 1]), PLAY_DEVIATION * np.mean(own))
    return {"free_play_um": Parameter.of_repeats(own, "um", float(deviation))}


def _missing(record: ExperimentRecord, parameters: dict[str, Parameter], tests: LoopsOfTests) -> list[str]:
    """What the record does not tell, and where to get it."""
    notes = []
    if "energy_wear_coefficient_mm3_per_J" not in parameters:
        stated = record.tables.stated.energy_wear_coefficient_mm3_per_J
        wears = f"takes the stated {stated:.3g} mm³/J" if stated is not None else "does not wear"
        notes.append(
            f"no wear coefficient was fitted, and the study {wears}: loops tell the energy, not the volume; measure "
            "both scars ([scars.moving] and [scars.fixed] of the mapping), or give --worn-volume or --wear-coefficient"
        )
        if stated is None:
            notes.append(
                "friction and rig were fitted as if the wires wore like steel on steel, by "
                f"{1e5 * ANY_WEAR_mm3_per_J:g}·10⁻⁵ mm³/J"
            )
    if len(tests.repeats) == 1:
        notes.append(
            "one test alone: the intervals hold its noise and an expected scatter, not how far tests on fresh "
            "specimens differ; repeat it at least twice"
        )
    if not np.isfinite(tests.figures[:, :, list(FITTED).index("measured_stiffness_N_per_um")]).any():
        notes.append(
            "no loop shows a stiffness: log more samples after the reversals, or measure the rig by pressing on its "
            "holder with a dial gauge"
        )
    if all(loop.normal_force_N is None for loop in record.loops):
        notes.append("the normal force was not measured: friction takes the asked load for granted")
    return notes
