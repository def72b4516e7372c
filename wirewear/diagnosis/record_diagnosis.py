"""One record diagnosed from end to end: its nominal model and that model's run, what differs, and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace

from wirewear.base.errors import StudyError
from wirewear.base.frame import notebook_table
from wirewear.diagnosis.answer import Diagnosis, causes_of, causes_of_fit, partial_of
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.left_open import joined, masses, measurement_after, plausible, unseen
from wirewear.diagnosis.infer.resembling import Resemblance, resemblances
from wirewear.diagnosis.infer.search import Search, search, updated
from wirewear.diagnosis.infer.shrink import Shrink, shrink_of
from wirewear.diagnosis.infer.weighing import (
    LEAST_DISPERSION,
    NOTICEABLE,
    Weighed,
    classes_of,
    force_zero,
    leading_fit,
    relevant,
    remainder_of,
    weigh,
)
from wirewear.diagnosis.infer.where import (
    GapFinding,
    Place,
    Relevance,
    changes,
    findings,
    physical_gap,
    places,
    relevance_of,
)
from wirewear.diagnosis.notes import of_imitations, of_laws, of_remainder, of_scatter, of_the_record, of_zero, remaining
from wirewear.diagnosis.observe.reduction import Observations
from wirewear.diagnosis.preparation import PreparedRecord, prepared
from wirewear.diagnosis.surrogate.candidates import effect_of
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.nominal import ObserverOf, Stage
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.diagnosis.wording import in_words, parameters_in_words, sentence_of
from wirewear.effects import all_effects
from wirewear.records import AnyRecord
from wirewear.test import AnyStudy

_KNOWN = constants("record_diagnosis")

#: An explanation that leaves at most this share of a gap is one, and what it leaves a remainder of unknown cause; from
#: this share on it is named.
MOST_LEFT, LEAST_LEFT = _KNOWN.each("most_left", "least_left")


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosed:
    """A diagnosis with all that pictures of it need: the record, its nominal study, wear states and inputs, its
    observables, the search for causes and the probabilities.
    """

    diagnosis: Diagnosis
    record: AnyRecord
    study: AnyStudy
    states: WearStates
    setup: SurrogateInputs
    observed: Observations
    search: Search
    weighed: Weighed

    def __repr__(self) -> str:
        return f"<Diagnosis of {self.record.name!r}, {self.diagnosis.verdict}: {self.diagnosis.sentence}>"

    def _repr_html_(self) -> str:
        rows = {
            f"{in_words(cause)}, {cause.probability:.0%}": parameters_in_words(cause)
            for cause in self.diagnosis.causes[:5]
        }
        note = " ".join(f"{remark[0].upper()}{remark[1:]}." for remark in self.diagnosis.notes)
        return notebook_table(f"{self.record.name}: {self.diagnosis.sentence}", rows, note=note)


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
    records = prepared(record, model, further)
    return diagnose_prepared(records, observer_of=observer_of, left_out=left_out, stage=stage)


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
        found = search(first.states, first.setup, first.observed, (*left_out, *first.unfit))
        for other in others:
            found = updated(found, other.states, other.setup, other.observed)
        read = [other.record for other in others]
        diagnosed = judged(first.record, first.study, first.states, first.observed, found, read)
    problems = tuple(remark.text for remark in first.checked if remark.level == "problem")
    answer = replace(diagnosed.diagnosis, notes=(*problems, *diagnosed.diagnosis.notes), checked=first.checked)
    return replace(diagnosed, diagnosis=answer)


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
    gap = _located(found, record)
    weighing = _weighed(found, gap)
    checked = _checked(found, gap, weighing, states, observed)
    # Further records are not left out: they speak for what this one hardly shows.
    if not (checked.shrink.borne_out or further):
        considered, names = weighing.considered, weighing.best.names
        # What chance does not leave is a gap, be its cause none that is known.
        chance = remainder_of(found.problem, found.none).log_surprise < NOTICEABLE
        weighing = _judged_by(found, gap, considered.withdrawn(names) if chance else considered.refuted(names))
        checked = _checked(found, gap, weighing, states, observed)
    diagnosis = _stated(found, gap, weighing, checked, record, study, observed, further)
    return Diagnosed(diagnosis, record, study, states, found.problem.setup, observed, found, checked.weighed)


@dataclass(frozen=True, eq=False)
class _Gap:
    """Where record and nominal model differ. left: where they do under each of the likeliest explanations, by its
    effects' names. tolerance: relative differences that count as equal, by the names of `[tolerance]`.
    """

    places: list[Place]
    left: Mapping[tuple[str, ...], list[Place]]
    tolerance: Mapping[str, float]

    def leaves(self, names: tuple[str, ...]) -> bool:
        """Whether what an explanation leaves matters, as a gap does: if not, it hints at no other cause beside it."""
        return relevance_of(self.left[names], self.tolerance, detected=True).relevant


def _located(found: Search, record: AnyRecord) -> _Gap:
    """In which cycles and zones record and predictions differ."""
    fits = {one.names: one for one in (*(distortion.beside for distortion in found.distortions), found.best)}
    left = {names: places(found.problem, found.covariance, one.setup) for names, one in fits.items()}
    nominal = places(found.problem, found.covariance, found.problem.setup)
    return _Gap(nominal, left, record.tables.tolerance.model_dump())


@dataclass(frozen=True, eq=False)
class _Weighing:
    """The causes by their evidence. best: the leading explanation, or the one without effects for a gap that does not
    matter; finding: the zones that it is known by; own: names of its effects and of those that resemble them.
    """

    considered: Weighed
    finding: tuple[GapFinding, ...]
    relevance: Relevance
    best: Fit
    own: set[str]

    @property
    def negligible(self) -> bool:
        """True for a gap that is there and does not matter."""
        return self.relevance.detected and not self.relevance.relevant


def _weighed(found: Search, gap: _Gap) -> _Weighing:
    """The causes weighed by all cycles."""
    near = [*relevant(found.singles), *found.pairs]
    classes = classes_of(near, found.apart(near))
    counted = [one for one in found.distortions if one.family.counts and gap.leaves(one.beside.names)]
    gains = {one.beside.names: [own.gain for own in counted if own.beside is one.beside] for one in counted}
    surprise = found.remainder.log_surprise if gap.leaves(found.best.names) else 0.0
    misfit = max(found.remainder.misfit, LEAST_DISPERSION)
    return _judged_by(found, gap, weigh(found.none, found.singles, found.pairs, classes, misfit, surprise, gains))


def _judged_by(found: Search, gap: _Gap, considered: Weighed) -> _Weighing:
    """What probabilities say of a gap: its best explanation, whether it matters, and where it shows."""
    explained = leading_fit(considered, found.none, (*found.singles, *found.pairs))

    # What is detected by an explanation is as large as that makes it: specimens and noise may hide it place by place.
    made = changes(found.problem, found.covariance, explained.setup)
    named = considered.verdict in ("explained", "ambiguous")
    detected = considered.verdict != "no_gap"
    relevance = relevance_of(made if named else gap.places, gap.tolerance, detected=detected)
    best = explained if relevance.relevant else found.none
    own = {member for name in best.names for member in considered.class_of(name)}
    return _Weighing(considered, tuple(findings(gap.places) or findings(made)), relevance, best, own)


@dataclass(frozen=True, eq=False)
class _Checked:
    """The causes after the test on cycles that were not fitted. wrong: the likeliest effect that the leading
    explanation excludes, refitted for comparison, None without one. left: share of the gap that the best explanation
    leaves; remains: True if that is a remainder of unknown cause.
    """

    weighed: Weighed
    shrink: Shrink
    physical: Mapping[str, tuple[float, float]]
    wrong: Fit | None
    left: float
    remains: bool


def _checked(found: Search, gap: _Gap, weighing: _Weighing, states: WearStates, observed: Observations) -> _Checked:
    """The leading explanation tested on cycles that were not fitted; refuted if it does not hold there."""
    best, considered = weighing.best, weighing.considered
    others = (one for one in found.singles if one.names[0] not in weighing.own)
    wrong = max(others, key=lambda one: one.merit, default=None)
    shrink = shrink_of(found.problem, found.covariance, observed, best, wrong, 20200715)
    physical = physical_gap(states, observed, found.problem.setup, best.setup, shrink.held_out)

    left, remains = found.left(best), False
    weighed = considered.without_gap() if weighing.negligible else considered
    if best.names and not shrink.supports:
        weighed = weighed.refuted(best.names)
    elif best.names and left <= MOST_LEFT and shrink.leaves_little(MOST_LEFT):
        weighed, alone = weighed.with_remainder(best.names), weighed
        remains = weighed.outside < alone.outside and gap.leaves(found.best.names) and left > LEAST_LEFT
    return _Checked(weighed, shrink, physical, wrong, left, remains)


def _stated(
    found: Search,
    gap: _Gap,
    weighing: _Weighing,
    checked: _Checked,
    record: AnyRecord,
    study: AnyStudy,
    observed: Observations,
    further: Sequence[AnyRecord],
) -> Diagnosis:
    """What is left open, and the answer in words."""
    best, considered, weighed = weighing.best, weighing.considered, checked.weighed
    fits, verdict = (*found.singles, *found.pairs), weighed.verdict
    zero = force_zero(found.problem, found.covariance, best, len(observed.repeats))
    blocks = [other.block for other in further if other.block is not None and other.name == record.name]
    others = tuple(dict.fromkeys(other.name for other in further if other.name != record.name or other.block is None))

    dispersion = max(found.remainder.misfit, 1.0)
    behind, causes = (causes_of(fits, one, dispersion) for one in (considered, weighed))
    partial = partial_of(found, weighed, dispersion, gap.left[found.best.names]) if verdict == "unexplained" else None
    resembles: tuple[Resemblance, ...] = ()
    if verdict == "unexplained":
        resembles = resemblances(found.problem, found.distortions, found.best.log_evidence)

    groups = [tuple(dict.fromkeys(map(effect_of, members))) for members in considered.classes]
    equivalent = tuple(members for members in groups if len(members) > 1 and verdict != "no_gap")
    set90 = plausible(masses(((one.effect, one.probability) for one in causes), equivalent))
    if weighing.negligible:
        # A difference that does not matter has a cause, too.
        set90 = joined(set90, plausible(masses(((one.effect, one.probability) for one in behind), groups)))
    asked = measurement_after((record, *further), weighed, equivalent)

    finding, relevance, shrink = weighing.finding, weighing.relevance, checked.shrink
    # Where an unknown cause is likelier than the explanation, its numbers are those of an imitation.
    holds = checked.remains and verdict != "unexplained"
    remainder = remaining(checked.left, findings(gap.left[found.best.names])) if holds else None
    alike = found.imitated(best) if best.names and verdict in ("explained", "ambiguous") else ()
    return Diagnosis(
        record=record.name,
        model=study.name,
        verdict=verdict,
        sentence=sentence_of(verdict, causes, equivalent, shrink, finding, partial, resembles, relevance, behind, asked)
        + of_remainder(remainder)
        + of_imitations(alike),
        shrink=shrink,
        physical=checked.physical,
        confirmed=None,
        where=() if verdict == "no_gap" else finding,
        causes=causes,
        equivalent=equivalent,
        undetectable=unseen(found, weighing.own),
        next_measurement=asked,
        updated_by=others,
        notes=(
            *(f"the further record {name!r} is taken in" for name in others),
            *(f"block {block} of the programme is taken in" for block in blocks),
            *of_zero(zero),
            *of_scatter(found.covariance.contradicted),
            *of_laws(causes_of_fit(best, 1.0, dispersion)),
            *of_the_record(record, found.problem.setup, observed, shrink, checked.wrong),
        ),
        resembles=resembles,
        equivalent_unknown=alike,
        partial=partial,
        remainder=remainder,
        plausible=set90,
        relevance=relevance,
    )
