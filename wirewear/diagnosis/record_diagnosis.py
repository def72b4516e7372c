"""One record diagnosed from end to end: its nominal model and that model's run, what differs, and why."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

from wirewear.base.errors import StudyError
from wirewear.diagnosis.answer import Cause, Diagnosis, Partial, Remaining, estimates, forms
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.distortions import gains_of
from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.search import (
    Classes,
    Search,
    joined,
    masses,
    next_measurement,
    plausible,
    search,
    updated,
)
from wirewear.diagnosis.infer.shrink import physical_gap, shrink_of
from wirewear.diagnosis.infer.weighing import Weighed, classes_of, force_zero, relevant, undetectable, weigh
from wirewear.diagnosis.infer.where import Place, Resemblance, changes, findings, places, relevance_of, resemblances
from wirewear.diagnosis.observe.reduction import Observations
from wirewear.diagnosis.preparation import PreparedRecord, ReducedRecord, prepared
from wirewear.diagnosis.surrogate.candidates import effect_of
from wirewear.diagnosis.surrogate.nominal import ObserverOf, Stage
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.diagnosis.wording import (
    Diagnosed,
    of_laws,
    of_remainder,
    of_scatter,
    of_the_record,
    of_zero,
    remaining,
    sentence_of,
)
from wirewear.effects import Seam, all_effects, measurements
from wirewear.records import AnyRecord
from wirewear.test import AnyStudy

_KNOWN = constants("record_diagnosis")

#: An explanation that fails, but takes this share of χ², is named as a part of one.
LEAST_REMOVED = _KNOWN.number("least_removed")

#: An explanation that leaves at most this share of a gap is one, and what it leaves a remainder of unknown cause; from
#: this share on it is named.
MOST_LEFT, LEAST_LEFT = _KNOWN.each("most_left", "least_left")

#: Evidence counts for more where less is left than is expected, down to this share of it.
LEAST_DISPERSION = _KNOWN.number("least_dispersion")

#: Explanations less probable than this are not listed.
LEAST_LISTED = _KNOWN.number("least_listed")


def diagnose(
    record: AnyRecord,
    *,
    model: AnyStudy | None = None,
    further: Sequence[AnyRecord] = (),
    observer_of: ObserverOf | None = None,
    left_out: Sequence[str] = (),
    stage: Stage = nullcontext,
) -> Diagnosed:
    """Diagnose a record against the model built from it, or against `model`.

    further: other records of the same rig, which update the answer to the first one. observer_of: makes the observer of
    a run from its name. left_out: names of effects that are not considered. stage: entered for each step of the work,
    with its name. Raises RecordError if a record states too little or has no loops that can be read, if the model is of
    another test, or if a further record is of another kind of contact or holds the first one's own loops; StudyError or
    SolverError if a nominal model cannot be run, or an effect left out is unknown.
    """
    return diagnose_prepared(prepared(record, model, further), observer_of=observer_of, left_out=left_out, stage=stage)


def diagnose_prepared(
    records: Sequence[PreparedRecord],
    *,
    observer_of: ObserverOf | None = None,
    left_out: Sequence[str] = (),
    stage: Stage = nullcontext,
) -> Diagnosed:
    """Diagnose the first of the records that `prepared` returns, the answer updated by the others; see `diagnose`."""
    known = all_effects()
    for name in left_out:
        if name not in known:
            raise StudyError(f"there is no effect {name!r} to be left out: the effects are {', '.join(known)}.")
    first, *others = (one.reduced(observer_of, stage) for one in records)
    with stage("searching for causes"):
        found = search(first.states, first.setup, first.observed, (*left_out, *_unfit(first)))
        for other in others:
            found = updated(found, other.states, other.setup, other.observed)
        read = [other.record for other in others]
        diagnosed = judged(first.record, first.study, first.states, first.observed, found, read)
    problems = tuple(remark.text for remark in first.checked if remark.level == "problem")
    answer = replace(diagnosed.diagnosis, notes=(*problems, *diagnosed.diagnosis.notes), checked=first.checked)
    return replace(diagnosed, diagnosis=answer)


def _unfit(prepared: ReducedRecord) -> tuple[str, ...]:
    """Names of the effects of specimens that a record's bodies cannot have, such as pads that are flattened."""
    found = []
    for name, kind in all_effects().items():
        if kind.seam is Seam.SPECIMENS:
            try:
                prepared.study.with_effects(kind.sized("easy", prepared.setup.stated))
            except StudyError:
                found.append(name)
    return tuple(found)


def judged(
    record: AnyRecord,
    study: AnyStudy,
    states: WearStates,
    observed: Observations,
    found: Search,
    further: Sequence[AnyRecord] = (),
) -> Diagnosed:
    """Diagnosis of a record from the result of a search. study, states, observed: of the record. further: the records
    that updated the search.
    """
    setup = found.problem.setup
    near = [*relevant(found.singles), *found.pairs]
    classes = classes_of(near, found.apart(near))
    tolerance = record.tables.tolerance.model_dump()
    # What an explanation leaves is judged as a gap is: what does not matter hints at no other cause.
    left_over = places(found.problem, found.covariance, found.best.setup)
    leaves = relevance_of(left_over, tolerance, detected=True).relevant
    surprise = found.remainder.log_surprise if leaves else 0.0
    gains = gains_of(found.distortions) if leaves else {}
    misfit = max(found.remainder.misfit, LEAST_DISPERSION)
    weighed = weigh(found.none, found.singles, found.pairs, classes, misfit, surprise, gains)
    where = places(found.problem, found.covariance, setup)
    explained = _leading(found, weighed)
    # What is detected by an explanation is as large as that makes it: specimens and noise may hide it place by place.
    made = changes(found.problem, found.covariance, explained.setup)
    finding = tuple(findings(where) or findings(made))
    named = weighed.verdict in ("explained", "ambiguous")
    relevance = relevance_of(made if named else where, tolerance, detected=weighed.verdict != "no_gap")
    dispersion = max(found.remainder.misfit, 1.0)
    behind = _causes(found, weighed, dispersion)
    groups = [tuple(dict.fromkeys(map(effect_of, members))) for members in weighed.classes]
    inside: Classes = ()
    if relevance.detected and not relevance.relevant:
        inside = plausible(masses(((one.effect, one.probability) for one in behind), groups))
        weighed = weighed.without_gap()
    best = explained if relevance.relevant else found.none
    own = {member for name in best.names for member in weighed.class_of(name)}
    wrong = max((one for one in found.singles if one.names[0] not in own), key=lambda one: one.merit, default=None)
    shrink = shrink_of(found.problem, found.covariance, observed, best, wrong, 20200715)
    remainder: Remaining | None = None
    if best.names and not shrink.supports:
        weighed = weighed.refuted(best.names)
    elif best.names and found.left(best) <= MOST_LEFT and shrink.leaves_little(MOST_LEFT):
        weighed, alone = weighed.with_remainder(best.names), weighed
        if weighed.outside < alone.outside and leaves and found.left(best) > LEAST_LEFT:
            remainder = remaining(found.left(best), findings(left_over))
    verdict = weighed.verdict
    causes = _causes(found, weighed, dispersion)
    equivalent = tuple(members for members in groups if len(members) > 1 and verdict != "no_gap")
    partial = _partial(found, weighed, dispersion, left_over) if verdict == "unexplained" else None
    resembles: tuple[Resemblance, ...] = ()
    if verdict == "unexplained":
        resembles = resemblances(found.problem, found.distortions, found.best.log_evidence)
    known = masses(((cause.effect, cause.probability) for cause in causes), equivalent)
    diagnosis = Diagnosis(
        record=record.name,
        model=study.name,
        verdict=verdict,
        sentence=sentence_of(verdict, causes, equivalent, shrink, finding, partial, resembles, relevance, behind)
        + of_remainder(remainder),
        shrink=shrink,
        physical=physical_gap(states, observed, setup, best.setup, shrink.held_out),
        confirmed=None,
        where=() if verdict == "no_gap" else finding,
        causes=causes,
        equivalent=equivalent,
        undetectable=_undetectable(found, own),
        next_measurement=_next((record, *further), weighed, equivalent),
        updated_by=tuple(other.name for other in further),
        notes=(
            *(f"the further record {other.name!r} is taken in" for other in further),
            *of_zero(force_zero(found.problem, found.covariance, best, len(observed.repeats))),
            *of_scatter(found.covariance.contradicted),
            *of_laws(_of_fit(best, 1.0, dispersion)),
            *of_the_record(record, setup, observed, shrink, wrong),
        ),
        resembles=resembles,
        partial=partial,
        remainder=remainder,
        # A difference that does not matter has a cause, too.
        plausible=joined(plausible(known), inside),
        relevance=relevance,
    )
    return Diagnosed(diagnosis, record, study, states, setup, observed, found, weighed)


def _undetectable(found: Search, own: set[str]) -> tuple[str, ...]:
    """Effects that would not be seen whatever is chosen of them."""
    others = [one.candidates[0] for one in found.singles if one.names[0] not in own]
    unseen = undetectable(found.problem, others)
    seen = {effect_of(one.name) for one in others if one.name not in unseen} | set(map(effect_of, own))
    return tuple(name for name in dict.fromkeys(map(effect_of, unseen)) if name not in seen)


def _leading(found: Search, weighed: Weighed) -> Fit:
    """The fit of the likeliest class of effects, or pair, that explains most."""
    fits = [one for one in (*found.singles, *found.pairs) if weighed.mass(one.names) == weighed.leading]
    return max(fits, key=lambda one: one.merit, default=found.none)


def _causes(found: Search, weighed: Weighed, dispersion: float) -> tuple[Cause, ...]:
    fits = {one.names: one for one in (*found.singles, *found.pairs)}
    causes = [Cause("none", weighed.probabilities[()], {}), Cause("outside_library", weighed.outside, {})]
    for names, probability in weighed.probabilities.items():
        if names:
            causes += _of_fit(fits[names], probability, dispersion)
    listed = [cause for cause in causes if cause.probability >= LEAST_LISTED]
    # Causes that are one to the model keep the order of the library.
    return tuple(sorted(listed, key=lambda cause: -round(cause.probability, 9)))


def _partial(found: Search, weighed: Weighed, dispersion: float, left_over: list[Place]) -> Partial | None:
    """The best explanation, where it removes most of a misfit without explaining it, and what it leaves where."""
    best = found.best
    if not best.candidates or found.removed < LEAST_REMOVED:
        return None
    probability = weighed.probabilities[best.names]
    return Partial(tuple(_of_fit(best, probability, dispersion)), found.removed, tuple(findings(left_over)))


def _of_fit(one: Fit, probability: float, dispersion: float) -> list[Cause]:
    causes = []
    for candidate, coordinates, deviations in one.parts():
        parameters = estimates(candidate, coordinates, deviations, dispersion)
        causes.append(
            Cause(
                candidate.kind.name,
                probability / len(one.candidates),
                parameters,
                joint=len(one.candidates) > 1,
                chosen=candidate.chosen,
                form=forms(candidate, coordinates, deviations, dispersion),
            )
        )
    return causes


def _next(records: Sequence[AnyRecord], weighed: Weighed, equivalent: Sequence[Sequence[str]]) -> dict[str, Any] | None:
    single: dict[str, float] = {}
    for names, probability in weighed.probabilities.items():
        for name in map(effect_of, names or ("none",)):
            single[name] = single.get(name, 0.0) + probability / max(len(names), 1)
    present = []
    if any(record.scars for record in records):
        present.append(measurements.SCAR_MAPS)
    if any(record.loops and all(loop.normal_force_N is not None for loop in record.loops) for record in records):
        present.append(measurements.NORMAL_FORCE)
    if any(record.tables.conditions.drive == "stroke" for record in records):
        present.append(measurements.ENCODER)
    chosen = next_measurement(single, equivalent, frozenset(present))
    if chosen is None:
        return None
    return {"what": chosen[0].what, "splits": list(chosen[1]), "why": chosen[0].why}
