"""What a diagnosis came to in words: the verdict in a sentence, and what a reader of it has to know beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from wirewear.base import notebook
from wirewear.base.frame import figure
from wirewear.base.quantity import UNIT_SYMBOLS
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.full_sampling import Ripple
from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.recognised import ForceZero
from wirewear.diagnosis.infer.resembling import Resemblance
from wirewear.diagnosis.infer.search import Search
from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.diagnosis.infer.weighing import Weighed
from wirewear.diagnosis.infer.where import GapFinding, Relevance
from wirewear.diagnosis.model.candidates import effect_of, unforeseen
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.reduction import Observations
from wirewear.effects import all_effects
from wirewear.planar.tables import PlanarStudy
from wirewear.records import AnyRecord
from wirewear.study import Study
from wirewear.views.diagnosis_values import Cause, Diagnosis, Estimate, Partial, Verdict

if TYPE_CHECKING:
    pass

#: Parameters whose names end so carry these units.
_ENDINGS = {f"_{unit}": symbol for unit, symbol in UNIT_SYMBOLS.items()}


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosed:
    """A diagnosis with all that pictures of it need."""

    diagnosis: Diagnosis
    record: AnyRecord
    study: Study | PlanarStudy
    states: WearStates
    setup: Setup
    observed: Observations
    search: Search
    weighed: Weighed

    def __repr__(self) -> str:
        return f"<Diagnosis of {self.record.name!r}, {self.diagnosis.verdict}: {self.diagnosis.sentence}>"

    def _repr_html_(self) -> str:
        rows = {
            f"{plain(cause.effect)}, {cause.probability:.0%}": "; ".join(
                with_unit(name, estimate) for name, estimate in cause.parameters.items()
            )
            for cause in self.diagnosis.causes[:5]
        }
        note = " ".join(f"{remark[0].upper()}{remark[1:]}." for remark in self.diagnosis.notes)
        return notebook.table(f"{self.record.name}: {self.diagnosis.sentence}", rows, note=note)


def plain(name: str) -> str:
    """An effect's name for people, and in brackets what is chosen of it."""
    effect, _, chosen = name.partition(":")
    words = {"none": "no gap", "outside_library": "something outside the library"}.get(effect, effect.replace("_", " "))
    return f"{words} ({chosen})" if chosen else words


def told(cause: Cause) -> str:
    """A cause for people: sensor lag (force)."""
    chosen = ", ".join(cause.chosen.values())
    return f"{plain(cause.effect)} ({chosen})" if chosen else plain(cause.effect)


def with_unit(name: str, estimate: Estimate) -> str:
    """For example: stiffness 165 N/mm (158 to 173)."""
    for ending in sorted(_ENDINGS, key=len, reverse=True):
        if name.endswith(ending):
            words, unit = name.removesuffix(ending), _ENDINGS[ending]
            break
    else:
        words, unit = name, ""
    low, high = estimate.interval95
    return f"{words.replace('_', ' ')} {figure(estimate.value)}{unit} ({figure(low)} to {figure(high)})"


def sentence_of(
    verdict: Verdict,
    causes: Sequence[Cause],
    equivalent: Sequence[Sequence[str]],
    shrink: Shrink,
    where: Sequence[GapFinding],
    partial: Partial | None = None,
    resembles: Sequence[Resemblance] = (),
    relevance: Relevance | None = None,
    behind: Sequence[Cause] = (),
) -> str:
    """What a reader in a hurry needs to know; `behind` are causes of a difference that does not matter."""
    if verdict == "no_gap":
        return _agreement(relevance, behind[0] if behind else None)
    named = [cause for cause in causes if cause.effect not in ("none", "outside_library")]
    place = f" It lies mostly in the {where[0].place}." if where else ""
    like = f" {resembles[0].text}" if resembles else ""
    if partial is not None:
        return f"{_partly(partial, equivalent)}{like}"
    if verdict == "unexplained" or not named:
        return f"There is a gap that no known effect, and no pair of them, explains.{like or place}"
    leading = [cause for cause in named if cause.joint] if named[0].joint else named[:1]
    parts = [_one(cause, equivalent) for cause in leading[:2]]
    words = " together with ".join(parts)
    if verdict == "ambiguous":
        others = " or ".join(told(cause) for cause in named[1:3] if cause not in leading) or "other effects"
        return f"{_may_explain(causes[0], words, others)}{place}"
    if not shrink.shows_gap:
        unseen = "The cycles left out of the fit show no gap by which to check it."
        seen = f" It shows in the {where[0].place}." if where else ""
        return f"The gap is explained by {words}.{seen} {unseen}"
    left_out = "a scar" if shrink.scar_held_out else "cycles"
    return (
        f"The gap is explained by {words}: on {left_out} left out of the fit it shrinks from {shrink.before:.2g} to "
        f"{shrink.after:.2g} (floor {shrink.floor:.2g}, in scatters)."
    )


def _agreement(relevance: Relevance | None, like: Cause | None) -> str:
    if relevance is None or not relevance.detected or relevance.largest is None:
        return "The record and the model agree within the repeats' scatter and the numerical uncertainty."
    behaves = f" It looks like {_one(like, ())}." if like and like.effect not in ("none", "outside_library") else ""
    return (
        f"A difference of {100.0 * relevance.largest.relative:.2g} % is detected, within the record's tolerance: "
        f"{relevance.largest.text}.{behaves}"
    )


def first_sentence(text: str) -> tuple[str, str]:
    """The first sentence of a text, and the others."""
    first, dot, rest = text.partition(". ")
    return (f"{first}.", rest) if dot else (text, "")


def _may_explain(likeliest: Cause, words: str, others: str) -> str:
    if likeliest.effect == "none":
        return f"There may be a gap, though none is likeliest; {words} may explain it, and so may {others}."
    return f"There is a gap; {words} may explain it, but so may {others}."


def _partly(partial: Partial, equivalent: Sequence[Sequence[str]]) -> str:
    words = " together with ".join(_one(cause, equivalent) for cause in partial.causes)
    # Never a hundred of what something remains of.
    removed = min(100.0 * partial.misfit_removed, 99.0)
    text = f"{words[0].upper()}{words[1:]}, removes {removed:.0f} % of the misfit"
    if not partial.remains:
        return f"{text}; what remains stands out nowhere by itself, but no known effect explains it."
    return f"{text}; what remains is in the {partial.remains[0].text}, which no known effect explains."


def _one(cause: Cause, equivalent: Sequence[Sequence[str]]) -> str:
    values = ", ".join(with_unit(name, estimate) for name, estimate in cause.parameters.items())
    members = next((list(group) for group in equivalent if cause.effect in group), [])
    if members:
        names = ", ".join(plain(name) for name in members[:-1]) + " or " + plain(members[-1])
        return f"one of {names}, which this record cannot tell apart (as {told(cause)}: {values})"
    return f"{told(cause)}, {values}"


_KNOWN = constants("diagnose")

#: A wrong effect that shrinks the gap by this share of what the named one does deserves a note.
AS_MUCH = _KNOWN.number("as_much")


def of_hum(wave: Ripple | None) -> tuple[str, ...]:
    """What was taken for noise though it is none of the sensors'."""
    if wave is None or wave.along != "time":
        return ()
    size = f"{wave.amplitude_N:.2g} N at about {wave.length:.3g} Hz"
    return (f"the force swings by {size} while the contact slides, as hum or vibration does: it was taken for noise",)


def of_zero(zero: ForceZero) -> tuple[str, ...]:
    """A zero of the force that lies further off than is expected of any."""
    if not zero.stands_out:
        return ()
    size = f"{zero.value_N:+.2g} N, {abs(zero.deviations):.0f} times what is expected".replace("-", "−")
    return (f"the zero of the force lies at {size}: an unloaded stroke would tell it from what leans on the wires",)


def of_chance(beyond: float) -> tuple[str, ...]:
    """Where a record lies that has no gap."""
    return (f"of a hundred records without any gap, of other tests, {100.0 * beyond:.0f} leave more than this one",)


def of_scatter(contradicted: Sequence[str]) -> tuple[str, ...]:
    """Scatters that repeats contradict."""
    return tuple(
        f"the repeats scatter more in {plain(name)} than [scatter] states; both were pooled" for name in contradicted
    )


def of_the_record(
    record: AnyRecord, setup: Setup, observed: Observations, shrink: Shrink, wrong: Fit | None
) -> tuple[str, ...]:
    """What the record lacks, and what its answer cannot say for that."""
    notes = list(observed.notes[:5])
    placebo = shrink.best_wrong_effect
    if wrong is not None and placebo is not None and shrink.shows_gap and placebo > AS_MUCH * shrink.shrink:
        notes.append(
            f"on the cycles left out of the fit, {plain(wrong.names[0])} shrinks the gap as much: the shrink does not "
            "support the named cause, only the fit of all loops tells them apart"
        )
    unknown = unforeseen(setup)
    if unknown:
        notes.append(
            "effects of installed packages are not among the causes considered, as the fast model cannot foresee them: "
            f"{', '.join(unknown)}"
        )
    if len(observed.repeats) == 1:
        notes.append(
            "there is one repeat only: how much tests scatter is not known from it, so an expected scatter stands in"
        )
    elif len(observed.repeats) < 5:
        notes.append(
            f"{len(observed.repeats)} repeats tell the scatter between tests badly; it is pooled with an expected one"
        )
    if not record.loops:
        notes.append("there are no loops: what only these show cannot be seen")
    elif not shrink.held_out:
        notes.append("there are loops of one cycle only, so that no cycle could be left out of the fit")
    if setup.wear_um3_per_mJ == 0.0:
        notes.append(
            "the model does not wear, so that what a scar does to the loops counts as a gap: give it a wear "
            "coefficient, from the scars of both bodies (`wirewear fit` for wires) or from other tests of such bodies"
        )
    if not record.scars:
        notes.append("there are no scars: effects that only scars show cannot be seen")
    return tuple(notes)


def of_laws(causes: Sequence[Cause]) -> tuple[str, ...]:
    """A note for each cause whose law is not its source's."""
    notes = []
    for cause in causes:
        for name, estimate in cause.form.items():
            (low, high), described = estimate.interval95, all_effects()[cause.effect].forms()[name]
            if not low <= described.near_neutral <= high:
                unit = f" {described.quantity.unit}" if described.quantity.unit != "1" else ""
                notes.append(
                    f"{plain(cause.effect)} follows another law here than that of its source: {described.meaning} "
                    f"{figure(estimate.value)} ({figure(low)} to {figure(high)}){unit}"
                )
    return tuple(notes)


def of_unrecognised(failing: Sequence[str]) -> tuple[str, ...]:
    """A note for each candidate that fits best, but does not do within the record what it is named for."""
    return tuple(
        f"{plain(name)} fits best, but does not show what tells it from other causes "
        f"({all_effects()[effect_of(name)].signature}): it is not named"
        for name in failing
    )
