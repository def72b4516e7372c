"""Notes on a diagnosis: what it leaves open, and what limits the answer."""

from __future__ import annotations

from collections.abc import Sequence

from wirewear.base.frame import figure
from wirewear.diagnosis.answer import Cause, Remaining
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.resembling import Imitation
from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.diagnosis.infer.weighing import ForceZero
from wirewear.diagnosis.infer.where import GapFinding
from wirewear.diagnosis.observe.reduction import Observations
from wirewear.diagnosis.surrogate.candidates import unsupported
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.wording import plain, share
from wirewear.effects import all_effects
from wirewear.records import AnyRecord

#: A wrong effect that shrinks the gap by this share of what the named one does deserves a note.
AS_MUCH = constants("notes").number("as_much")


def remaining(left: float, where: Sequence[GapFinding]) -> Remaining:
    """The gap that an explanation leaves, in words: `left` is its share of the whole gap, `where` the zones, largest
    first.
    """
    size = f"{share(left)} of the gap is not explained"
    if not where:
        return Remaining(left, "", f"{size}; it stands out nowhere by itself")
    return Remaining(left, where[0].place, f"{size}; it lies in the {where[0].text}")


def of_remainder(remainder: Remaining | None) -> str:
    """Sentence on the gap that is left, to follow the answer; "" for None."""
    return f" These numbers hold, though {remainder.text}." if remainder else ""


def of_imitations(found: Sequence[Imitation]) -> str:
    """Sentence on causes of no library that would look the same, and on what would tell, to follow the answer; "" for
    none.
    """
    causes = ", or from ".join(dict.fromkeys(f"{one.causes} ({one.measurement} would tell)" for one in found))
    return f" The record cannot tell this from {causes}." if found else ""


def of_zero(zero: ForceZero) -> tuple[str, ...]:
    """A sentence on the zero error of the force channel if it is larger than expected; else empty."""
    if not zero.stands_out:
        return ()
    size = f"{figure(zero.value_N, 2, sign=True)} N, {abs(zero.deviations):.0f} times what is expected"
    distinguished = "an unloaded stroke would distinguish it from what leans on the wires"
    return (f"the zero of the force lies at {size}: {distinguished}",)


def of_scatter(contradicted: Sequence[str]) -> tuple[str, ...]:
    """A sentence for each of the scatters named, that are stated and contradicted by the repeats."""
    return tuple(
        f"the repeats scatter more in {plain(name)} than [scatter] states; both were pooled" for name in contradicted
    )


def of_the_record(
    record: AnyRecord, setup: SurrogateInputs, observed: Observations, shrink: Shrink, wrong: Fit | None
) -> tuple[str, ...]:
    """Sentences on what the record lacks, and on what the answer therefore cannot say. wrong: fit of the best effect of
    another class; None if there is none.
    """
    notes = list(observed.notes[:5])
    placebo = shrink.best_wrong_effect
    if wrong is not None and placebo is not None and placebo > AS_MUCH * shrink.shrink > 0.0:
        notes.append(
            f"on the cycles left out of the fit, {plain(wrong.names[0])} shrinks the gap as much: the shrink does not "
            "support the named cause, only the fit of all loops distinguishes them"
        )
    unknown = unsupported(setup)
    if unknown:
        notes.append(
            "effects of installed packages are not among the causes considered, as the fast model cannot cover them: "
            f"{', '.join(unknown)}"
        )
    if len(observed.repeats) == 1:
        notes.append(
            "there is one repeat only: how much tests scatter is not known from it, so an expected scatter stands in"
        )
    elif len(observed.repeats) < 5:
        notes.append(
            f"{len(observed.repeats)} repeats show the scatter between tests badly; it is pooled with an expected one"
        )
    if not record.loops:
        notes.append("there are no loops: what only these show cannot be seen")
    elif not shrink.held_out:
        notes.append("there are loops of one cycle only, so that no cycle could be left out of the fit")
    if record.tables.body_names and setup.wear_um3_per_mJ == 0.0:
        notes.append(
            "the model does not wear, so that what a scar does to the loops counts as a gap: give it a wear "
            "coefficient, from the scars of both bodies (`wirewear fit` for wires) or from other tests of such bodies"
        )
    if record.tables.body_names and not record.scars:
        notes.append("there are no scars: effects that only scars show cannot be seen")
    return tuple(notes)


def of_laws(causes: Sequence[Cause]) -> tuple[str, ...]:
    """A sentence for each cause whose fitted law differs from that of its literature source."""
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
