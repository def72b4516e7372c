"""Explanations that fit by what they are not named for, such as a rough layer that never wears in."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.weighing import Weighed
from wirewear.diagnosis.model.setup import Array


def unrecognised(fits: Iterable[Fit], cycles: Array) -> dict[tuple[str, ...], tuple[str, ...]]:
    """Those effects of each fit that do not do, within these cycles, what tells them from others.

    Loops of one cycle or of none show no course: of them there are none.
    """
    if np.unique(cycles).size < 2:
        return {}
    first, last = float(cycles.min()), float(cycles.max())
    found = {
        one.names: tuple(
            candidate.name
            for candidate, coordinates, _ in one.parts()
            if not candidate.effect(coordinates).recognised_between(first, last)
        )
        for one in fits
    }
    return {names: members for names, members in found.items() if members}


def without(weighed: Weighed, failing: Mapping[tuple[str, ...], Sequence[str]]) -> Weighed:
    """Probabilities with those of explanations that are not recognised given to a cause of no library.

    What such an explanation fits by is there, but it is not what it is named for. `failing` are its effects that do not
    do what they are named for. One that shares its class with an effect that does keeps its probability: the class
    stays right.
    """
    bare = {
        names
        for names, members in failing.items()
        if any(all((other,) in failing for other in weighed.class_of(one) if other != one) for one in members)
    }
    moved = sum(weighed.probabilities.get(names, 0.0) for names in bare)
    kept = {names: 0.0 if names in bare else probability for names, probability in weighed.probabilities.items()}
    return replace(weighed, probabilities=kept, outside=weighed.outside + moved)
