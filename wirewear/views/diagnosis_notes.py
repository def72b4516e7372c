"""What a reader of an answer has to know beside it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from wirewear.base.frame import figure
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.full_sampling import Ripple
from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.recognised import ForceZero
from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.diagnosis.model.candidates import effect_of, unforeseen
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.observe.reduction import Observations
from wirewear.effects import all_effects
from wirewear.records import AnyRecord
from wirewear.views.diagnosis_values import Cause
from wirewear.views.diagnosis_wording import plain

if TYPE_CHECKING:
    pass

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
