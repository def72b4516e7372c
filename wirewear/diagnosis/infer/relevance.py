"""Detected is not relevant: how large a difference is beside what the owner takes for practically equal."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from wirewear.diagnosis.infer.where import Place, text_of
from wirewear.records.tables import Tolerance


@dataclass(frozen=True)
class Largest:
    """The difference that lies farthest beyond its tolerance, or nearest to it; `relative` to the whole quantity."""

    observable: str
    relative: float
    text: str


@dataclass(frozen=True)
class Relevance:
    """Whether there is a difference beyond chance, and whether it matters in practice."""

    detected: bool
    relevant: bool
    largest: Largest | None


def relevance_of(places: Sequence[Place], tolerance: Tolerance, *, detected: bool) -> Relevance:
    """Judged by the places that stand out of chance, or by all where none does by itself."""
    judged = [place for place in places if place.flagged] or places
    if not judged:
        return Relevance(detected, detected, None)
    beyond = [_relative_to_tolerance(place, tolerance) for place in judged]
    largest = judged[beyond.index(max(beyond))]
    known = Largest(largest.observable.words, round(largest.relative, 4), text_of(largest))
    return Relevance(detected, detected and max(beyond) > 1.0, known)


def _relative_to_tolerance(place: Place, tolerance: Tolerance) -> float:
    # A scar that is askew by an angle has its ends off by that share of half its length.
    of_scars = {"rad": tolerance.displacement}
    of_loops = {"N": tolerance.force, "um": tolerance.displacement, "mJ": tolerance.energy}
    known = of_scars if place.observable.of_scars else of_loops
    return place.relative / max(known.get(place.observable.unit, tolerance.volume), 1e-12)
