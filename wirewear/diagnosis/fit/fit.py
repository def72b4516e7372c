"""Fit of friction, rig and wear to a record with intervals, the study with these values, and a run that checks it."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import stdtrit

from geometry.arrays import Array
from wirewear.base.errors import RecordError
from wirewear.diagnosis.fit import wear, without_plateau
from wirewear.diagnosis.fit.fast_fit import FITTED, FastFit, LoopsOfTests, fast_fit, loops_of_tests
from wirewear.diagnosis.fit.stiffness import SPRING, ContactStiffness, contact_stiffness, fitted_tables, with_spring
from wirewear.diagnosis.fit.values import CheckedRun, FittedParameter, FittedTest
from wirewear.diagnosis.surrogate.nominal import ObserverOf, Stage
from wirewear.diagnosis.surrogate.nominal_model import nominal_model
from wirewear.loops import LoopError
from wirewear.records import AnyRecord
from wirewear.records.checking import remarks_of
from wirewear.records.exporting import true_loop
from wirewear.records.values import stated_friction, stated_tables
from wirewear.results import read_loops
from wirewear.simulation import Observer, run_study
from wirewear.test import AnyStudy, study_from_tables
from wirewear.test.kinds import kind_of

#: Keys of `[stated]` that say how bodies wear.
WEAR_KEYS = (
    "energy_wear_coefficient_mm3_per_J", "moving_share", "pad_energy_wear_coefficient_mm3_per_J",
    "specimen_energy_wear_coefficient_mm3_per_J",
)  # fmt: skip
_STIFFNESS = list(FITTED).index("measured_stiffness_N_per_um")


def check_by_run(fitted: FittedTest, output: Path, fidelity: str, observer_of: ObserverOf | None = None) -> CheckedRun:
    """Run the fitted study in `output` with this fidelity, and compare its loops with those of the record.

    observer_of: makes the observer of a run from its name. Raises StudyError, SolverError or RunError if the run cannot
    be made or written.
    """
    tests = loops_of_tests(fitted.record, sliding=False)
    quiet = observer_of or (lambda _: nullcontext(Observer()))
    (result,) = run_study(fitted.study, fidelity=fidelity, output=output, observer_of=quiet)
    loops = {loop.cycle: true_loop(loop) for loop in read_loops(result)}
    simulated = np.full((tests.cycles.size, len(FITTED)), np.nan)
    for row, cycle in enumerate(tests.cycles):
        if (loop := loops.get(int(cycle))) is None:
            continue
        try:
            figures = loop.figures(fitted.record.tables.conditions.normal_load_N)
        except LoopError:
            continue
        values = (getattr(figures, name) for name in FITTED)
        simulated[row] = [np.nan if value is None else value.value for value in values]
    return CheckedRun(result, tests.cycles, tests.mean, simulated, tests.deviations)


def fit_record(
    record: AnyRecord,
    *,
    given: wear.GivenWear | None = None,
    observer_of: ObserverOf | None = None,
    stage: Stage = nullcontext,
) -> FittedTest:
    """Fit the parameters of a test to its record.

    given: wear that is known otherwise than from scars. observer_of: makes the observer of a run from its name. stage:
    entered for each step of the work. First estimates come from the loops themselves; the fast model, on the wear
    states of one finite element run with these, then fits friction and rig to the loops of all cycles. Wear
    coefficients are worn volumes over the friction energy of the whole test. If no loop slides as a whole, friction and
    rig are bounded by energy, stiffness and shape of single loops. Under a load that varies within the cycle, and in
    the scar of longer strokes, they are fitted as a diagnosis finds causes.
    Raises RecordError if the record is unsound, none of its loops bounds friction above, or a worn volume is given and
    neither loops nor evolution show the energy; StudyError or SolverError if a nominal run of the fast model fails.
    """
    record = record.of_block()
    rigid, tables = kind_of(record).rigid_N_per_mm, record.tables
    varies = tables.conditions.load_cycle is not None
    sticking = None if varies else without_plateau.fitted_sticking(record, rigid)
    if sticking is not None:
        worn, found, notes = wear.fitted_wear(record, given)
        return _without_fast_fit(record, sticking.parameters | worn, found, [sticking.note, *notes])
    if without_plateau.needs_search(record):
        return _of_search(record, given, observer_of, stage)
    with stage("checking the record"):
        odd = tuple(remark.text for remark in remarks_of(record))
    with stage("measuring the loops"):
        tests = loops_of_tests(record)
        worn, found, notes = wear.fitted_wear(record, given)
    with stage("the contact on a rigid rig"):
        some_wear = {} if wear.stated_wear(tables) else {key: one.value for key, one in _some_wear(tables)[0].items()}
        contact = contact_stiffness(record, tests.friction, some_wear)
        found |= _stiffnesses(contact, tests, rigid)
    sticking_too = without_plateau.left_out(record)
    if tables.fitted_by_loops:
        parameters = _of_loops(record, contact, tests) | _play(tests)
        study = fitted_study(record, parameters, record.cycles)
        return FittedTest(record, study, parameters, found, (*odd, *sticking_too, *_single(record)), rigid)
    rough = _rough_study(record, contact, tests, worn)
    model = nominal_model(rough)
    states, limits = model.states(tables, observer_of)
    setup = model.inputs(tables)
    with stage("fitting all cycles"):
        states, spring = with_spring(states, setup, record, tests)
        fitted = fast_fit(states, setup, tests)
    parameters = _of_fit(fitted, len(tests.repeats), record, contact.N_per_um) | spring | _play(tests) | worn
    study = fitted_study(record, parameters, record.cycles)
    notes = [*odd, *limits, *sticking_too, *_misfit(fitted), *notes, *_missing(record, parameters, tests)]
    return FittedTest(record, study, parameters, found, tuple(notes), rigid)


def _of_search(
    record: AnyRecord, given: wear.GivenWear | None, observer_of: ObserverOf | None, stage: Stage
) -> FittedTest:
    """Fit of a test whose loops show friction and rig only together with a model of the test."""
    worn, found, notes = wear.fitted_wear(record, given)
    friction = round(without_plateau.friction_of_forces(record), 3)
    rough = {"friction": FittedParameter(friction, (friction, friction), "1", 1), **worn}
    if wear.total_of(record.tables, worn) is None and wear.stated_wear(record.tables) is None:
        rough |= _some_wear(record.tables)[0]
    rigid = kind_of(record).rigid_N_per_mm
    rough["tangential_stiffness_N_per_mm"] = FittedParameter(rigid, (rigid, rigid), "N_per_mm", 1)
    study = fitted_study(record, rough, ())
    with stage("fitting all cycles"):
        parameters, energy_J, limits = without_plateau.fitted_by_search(record, study, observer_of)
    if energy_J is not None:
        worn, found, notes = wear.fitted_wear(record, given, energy_J)
    return _without_fast_fit(record, parameters | worn, found, [*limits, *notes])


def _without_fast_fit(
    record: AnyRecord, parameters: dict[str, FittedParameter], found: dict[str, FittedParameter], notes: list[str]
) -> FittedTest:
    """The test of a record whose parameters the fast model has not fitted to all of its loops."""
    odd = (remark.text for remark in remarks_of(record))
    notes = [*odd, *notes, *_missing_wear(record, parameters), *_single(record)]
    study = fitted_study(record, parameters, record.cycles)
    return FittedTest(record, study, parameters, found, tuple(notes), rigid_N_per_mm=kind_of(record).rigid_N_per_mm)


def tables_of_record(record: AnyRecord) -> dict[str, Any]:
    """Tables of a study of the record's test, with the friction of its loops if none is stated, logging the record's
    cycles. Raises RecordError if friction is neither stated nor shown by the loops.
    """
    friction = stated_friction(record.tables)
    friction = _friction_of_loops(record) if friction is None else friction
    last = record.tables.conditions.cycles
    cycles = [cycle for cycle in record.cycles if 1 <= cycle <= last]
    return stated_tables(record.tables, friction) | {"log": {"loop_cycles": cycles}}


def _friction_of_loops(record: AnyRecord) -> float:
    """Coefficient of friction from the loops. Raises RecordError if they do not show it."""
    if record.tables.conditions.load_cycle is not None:
        return round(without_plateau.friction_of_forces(record), 3)
    try:
        sticking = without_plateau.fitted_sticking(record, kind_of(record).rigid_N_per_mm)
        found = loops_of_tests(record).friction if sticking is None else sticking.parameters["friction"].value
        return round(found, 3)
    except RecordError as problem:
        raise RecordError(f"[stated] gives no friction, and {problem}") from None


def completed(record: AnyRecord) -> tuple[AnyRecord, dict[str, float]]:
    """Copy of the record with unstated friction and wear filled in from its loops and scars, and the relative standard
    deviations of these by the fast model's names; the record itself and {} if all is stated.

    If nothing shows the wear, bodies are taken to wear like steel on steel. Raises RecordError if friction is neither
    stated nor shown by the loops.
    """
    tables, stated, unknown = record.tables, dict[str, float](), dict[str, float]()
    if stated_friction(tables) is None:
        stated["friction"] = _friction_of_loops(record)
        unknown["friction"] = 1.0
    if len(tables.missing) > len(unknown):
        worn, _, _ = wear.fitted_wear(record)
        worn = worn if wear.total_of(tables, worn) is not None else _some_wear(tables)[0]
        stated |= {key: float(f"{worn[key].value:.3g}") for key in WEAR_KEYS if key in worn}
        unknown["wear"] = 1.0
    whole = tables.model_copy(update={"stated": tables.stated.model_copy(update=stated)})
    return (replace(record, tables=whole) if unknown else record), unknown


def fitted_study(record: AnyRecord, parameters: dict[str, FittedParameter], cycles: tuple[int, ...]) -> AnyStudy:
    """Study of the record's test with fitted parameters, and stated values for all others; it logs loops at
    `cycles`.
    """
    kind = kind_of(record)
    stated = stated_by(parameters, kind.rigid_N_per_mm)
    course, play = stated.pop("friction_evolution", None), parameters.get("free_play_um")
    effects: list[dict[str, object]] = []
    effects += [{"name": "friction_evolution", **course}] if isinstance(course, Mapping) else []
    effects += [{"name": "free_play", "gap_um": float(f"{play.value:.4g}")}] if play is not None else []
    last = record.tables.conditions.cycles
    data = fitted_tables(record, stated, effects, [cycle for cycle in cycles if 1 <= cycle <= last])
    study: AnyStudy = study_from_tables(data, f"the fit of {record.name!r}")
    return study


def stated_by(parameters: dict[str, FittedParameter], rigid_N_per_mm: float) -> dict[str, object]:
    """Values by key of `[stated]` from fitted parameters, rounded to four digits; a rig at least as stiff as
    `rigid_N_per_mm` becomes "rigid".
    """
    parameters = {name: replace(found, value=float(f"{found.value:.4g}")) for name, found in parameters.items()}
    stated: dict[str, object] = {}
    if "friction_initial" in parameters:
        initial, final, cycles = (parameters[f"friction_{key}"].value for key in ("initial", "final", "cycles"))
        stated["friction"] = final
        stated["friction_evolution"] = {"initial": initial, "final": final, "cycles": cycles}
    else:
        stated["friction"] = parameters["friction"].value
    if (rig := parameters.get("tangential_stiffness_N_per_mm")) is not None:
        stated["tangential_stiffness_N_per_mm"] = rig.value if rig.value < rigid_N_per_mm else "rigid"
    return stated | {key: parameters[key].value for key in (SPRING, *WEAR_KEYS) if key in parameters}


def _some_wear(tables: Any) -> wear.Worn:
    return wear.parted(tables, FittedParameter(wear.ANY_WEAR_mm3_per_J, (0.0, 0.0), "mm3_per_J", 1))


def _rough_study(
    record: AnyRecord, contact: ContactStiffness, tests: LoopsOfTests, worn: dict[str, FittedParameter]
) -> Any:
    friction, tables, first = tests.friction, record.tables, _first(tests)
    compliance = 0.0 if first is None else contact.rig_um_per_N(float(first[1].mean()))
    stiffness = 1e3 / max(compliance, 1e3 / kind_of(record).rigid_N_per_mm)
    rough = {
        "friction": FittedParameter(round(friction, 3), (friction, friction), "1", 1),
        "tangential_stiffness_N_per_mm": FittedParameter(
            float(f"{stiffness:.3g}"), (stiffness, stiffness), "N_per_mm", 1
        ),
    }
    rough |= _play(tests)
    if wear.total_of(tables, worn) is not None:
        rough |= {key: replace(worn[key], value=float(f"{worn[key].value:.2g}")) for key in tables.wear if key in worn}
    elif wear.stated_wear(tables) is None:
        rough |= _some_wear(tables)[0]
    return fitted_study(record, rough, ())


def _first(tests: LoopsOfTests) -> tuple[int, Any] | None:
    """Index of the earliest cycle with a measured stiffness, and its values; None if there is none."""
    columns = [(j, column[np.isfinite(column)]) for j, column in enumerate(tests.figures[:, :, _STIFFNESS].T)]
    return next(((j, column) for j, column in columns if column.size), None)


def _stiffnesses(contact: ContactStiffness, tests: LoopsOfTests, rigid_N_per_mm: float) -> dict[str, FittedParameter]:
    """K_t,m of the first loops, K_c of the contact, and K_rig from 1/K_rig = 1/K_t,m − 1/K_c, in N/mm by name."""
    own = 1e3 * contact.N_per_um
    found = {"contact_stiffness_N_per_mm": FittedParameter(own, (own, own), "N_per_mm", 0)}
    first = _first(tests)
    if first is None:
        return found
    deviation = float(tests.deviations[first[0], _STIFFNESS]) / np.sqrt(first[1].size)
    measured = FittedParameter.of_repeats(1e3 * first[1], "N_per_mm", 1e3 * deviation)
    ends = (measured.value, *reversed(measured.interval95))
    rigs = [1e3 / max(contact.rig_um_per_N(1e-3 * k), 1e3 / rigid_N_per_mm) for k in ends]
    found["measured_stiffness_N_per_mm"] = measured
    found["rig_stiffness_of_first_loops_N_per_mm"] = FittedParameter(
        rigs[0], (min(rigs[1:]), max(rigs[1:])), "N_per_mm", first[1].size
    )
    return found


def _of_fit(fitted: FastFit, repeats: int, record: AnyRecord, contact_N_per_um: float) -> dict[str, FittedParameter]:
    deviations = np.sqrt(np.diag(fitted.covariance) * max(fitted.misfit / max(fitted.points - 2, 1), 1.0))
    # What the model errs by, it errs by in all loops.
    model = np.full(deviations.size, FITTED["friction_geometry_independent"])
    yielding = np.hypot(fitted.compliance_um_per_N, 1.0 / contact_N_per_um)
    model[-1] = FITTED["measured_stiffness_N_per_um"] * yielding
    deviations = np.hypot(deviations, model)
    if repeats > 1:
        # Friction of one specimen is the same in all of its loops: tests count, not loops.
        scatter = fitted.repeats.std(axis=0, ddof=1) / np.sqrt(repeats)
        deviations = np.hypot(deviations, float(stdtrit(repeats - 1, 0.975)) / 1.96 * scatter)
    low, high = (
        np.clip(fitted.coordinates + side * 1.96 * deviations, fitted.low, fitted.high) for side in (-1.0, 1.0)
    )
    names = ("friction_initial", "friction_final", "friction_cycles") if fitted.runs_in else ("friction",)
    parameters = {}
    for place, name in enumerate(names):
        value, ends = np.exp(fitted.coordinates[place]), np.exp([low[place], high[place]])
        unit = "cycles" if name == "friction_cycles" else "1"
        parameters[name] = FittedParameter(float(value), (float(ends[0]), float(ends[1])), unit, repeats)
    rotation, least = _rotation_um_per_N(record), 1e3 / kind_of(record).rigid_N_per_mm
    stiffness = [float(1e3 / max(c - rotation, least)) for c in (fitted.compliance_um_per_N, high[-1], low[-1])]
    parameters["tangential_stiffness_N_per_mm"] = FittedParameter(
        stiffness[0], (stiffness[1], stiffness[2]), "N_per_mm", repeats
    )
    return parameters


def _of_loops(record: AnyRecord, contact: ContactStiffness, tests: LoopsOfTests) -> dict[str, FittedParameter]:
    """`friction` and, where loops have a stick branch, `tangential_stiffness_N_per_mm` of the rig, from the mean
    figures of each test's loops. contact: its compliance is taken off the measured one.
    """

    def of_tests(name: str) -> Array:
        own = tests.figures[:, :, list(FITTED).index(name)]
        return np.array([np.mean(row[np.isfinite(row)]) for row in own if np.isfinite(row).any()])

    def with_error(name: str, unit: str, factor: float = 1.0) -> FittedParameter:
        values = factor * of_tests(name)
        return FittedParameter.of_repeats(values, unit, FITTED[name] * float(values.mean()))

    found = {"friction": with_error("friction_geometry_independent", "1")}
    if of_tests("measured_stiffness_N_per_um").size:
        measured = with_error("measured_stiffness_N_per_um", "N_per_mm", 1e3)
        least = 1e3 / kind_of(record).rigid_N_per_mm
        rig, low, high = (
            1e3 / max(contact.rig_um_per_N(1e-3 * k), least) for k in (measured.value, *measured.interval95)
        )
        found["tangential_stiffness_N_per_mm"] = replace(measured, value=rig, interval95=(low, high))
    return found


def _rotation_um_per_N(record: AnyRecord) -> float:
    """Compliance along the motion by the holder's stated rotation."""
    stated = record.tables.stated
    if isinstance(stated.rotational_stiffness_N_mm_per_rad, str) or stated.pivot_height_mm is None:
        return 0.0
    return float(1e3 * stated.pivot_height_mm**2 / stated.rotational_stiffness_N_mm_per_rad)


def _play(tests: LoopsOfTests) -> dict[str, FittedParameter]:
    if not tests.has_play:
        return {}
    seen = np.isfinite(tests.plays[:, :, 0])
    own = [float(plays[there, 0].mean()) for plays, there in zip(tests.plays, seen, strict=True) if there.any()]
    # What the analysis of a loop errs by, it errs by in all loops of a kind.
    # Plays of 4 and 5 µm in loops of two other codes are read 2 and 4 % too small.
    deviation = np.hypot(np.median(tests.plays[seen][:, 1]), 0.03 * np.mean(own))
    return {"free_play_um": FittedParameter.of_repeats(own, "um", float(deviation))}


def _misfit(fitted: FastFit) -> list[str]:
    """Note that the fit does not describe the loops, if their misfit exceeds FAR_OFF scatters; else an empty list."""
    off = (fitted.misfit / max(fitted.points - fitted.coordinates.size, 1)) ** 0.5
    # Root mean square of what a fit leaves, in scatters, from which on it describes no test: chance leaves one.
    if off < 3.0:
        return []
    said = f"the loops are off those of the fitted test by {off:.2g} times what tests scatter"
    return [f"{said}: its values and intervals do not describe this record"]


def _missing(record: AnyRecord, parameters: dict[str, FittedParameter], tests: LoopsOfTests) -> list[str]:
    notes = _missing_wear(record, parameters)
    if notes and wear.stated_wear(record.tables) is None:
        notes.append(
            "friction and rig were fitted as if the bodies wore like steel on steel, by "
            f"{1e5 * wear.ANY_WEAR_mm3_per_J:g}·10⁻⁵ mm³/J"
        )
    notes += _single(record)
    if not np.isfinite(tests.figures[:, :, list(FITTED).index("measured_stiffness_N_per_um")]).any():
        notes.append(
            "no loop shows a stiffness: log more samples after the reversals, or measure the rig by pressing on its "
            "holder with a dial gauge"
        )
    return notes


def _missing_wear(record: AnyRecord, parameters: dict[str, FittedParameter]) -> list[str]:
    if not record.tables.wear or wear.total_of(record.tables, parameters) is not None:
        return []
    stated = wear.stated_wear(record.tables)
    wears = f"takes the stated {stated}" if stated is not None else "does not wear"
    said = f"no wear coefficient was fitted, and the study {wears}: loops show the energy, not the volume"
    return [f"{said}; {wear.where_volumes(record.tables)}, or give --worn-volume or --wear-coefficient"]


def _single(record: AnyRecord) -> list[str]:
    """Notes on a single test, and on a load that was not measured."""
    notes = []
    if len(record.repeats) == 1:
        notes.append(
            "one test alone: the intervals hold its noise and an expected scatter, not how far tests on fresh "
            "specimens differ; repeat it at least twice"
        )
    if all(loop.normal_force_N is None for loop in record.loops):
        notes.append("the normal force was not measured: friction takes the asked load for granted")
    return notes
