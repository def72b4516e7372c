"""Effects as candidates for the cause of a gap: the effects that the fast model knows, and their numbers to be
inferred.

A coordinate is the value of a parameter in standard deviations of its expected distribution, 0 being the middle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import product
from math import log
from typing import Any

import numpy as np

from geometry.arrays import Array
from wirewear.base import kinds
from wirewear.base.errors import StudyError
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.effects import AnyEffect, Chain, Parameter, Stated, all_effects

#: Where numerical freedoms lie on average, if not at their neutral value: a quick run sees a scar longer than the slip
#: and blunts its walls, so that the state that fits others' loops is one of less wear with steeper slopes.
EXPECTED: Mapping[str, Any] = constants("surrogate.candidates").all()


@dataclass(frozen=True)
class Candidate:
    """An effect of the library with the numbers that are to be inferred.

    kind: the effect's class. parameters: its numbers to be inferred, by name. held: numbers that stay at their middle,
    as no record distinguishes them from the others. chosen: its words, such as the channel that lags. forms: numbers of
    its law that differ between laws of one cause; they are inferred like parameters and follow them in coordinates
    (p,).
    """

    kind: type[AnyEffect]
    parameters: Mapping[str, Parameter]
    held: Mapping[str, Parameter]
    chosen: Mapping[str, str] = field(default_factory=dict)
    forms: Mapping[str, Parameter] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        kind: type[AnyEffect],
        stated: Stated,
        chosen: Mapping[str, str] | None = None,
        scales: Mapping[str, float] | None = None,
        contact: str = kinds.CROSSED_WIRES,
    ) -> Candidate:
        """The effect of this class as a candidate for a test, its parameters and forms as they are expected there.

        stated: values of the test, from which parameters may be scaled. chosen: words by their names; defaults if None.
        scales: by the unit of a parameter, as "N_per_mm", a factor on the sizes that are expected of it; 1 if missing.
        contact: kind of contact.
        """
        known = {
            name: described.beside(stated).scaled((scales or {}).get(described.quantity.unit, 1.0))
            for name, described in kind.parameters().items()
        }
        free, held = (
            {name: item for name, item in known.items() if (item.held_by is not None) is wanted}
            for wanted in (False, True)
        )
        return cls(kind, free, held, chosen or {}, kind.forms(contact))

    @property
    def name(self) -> str:
        """The effect's name and, after a colon each, words other than the default: "sensor_lag:force"."""
        usual = {name: words[0] for name, words in self.kind.choices().items()}
        return ":".join([self.kind.name, *(word for name, word in self.chosen.items() if word != usual[name])])

    def unknown_spread(self, name: str) -> float:
        """Largest standard deviation that held numbers add to the coordinate of the parameter `name`; 0 if none depends
        on it.
        """
        spreads = [0.0]
        for held in self.held.values():
            if held.held_by is not None and held.held_by[0] == name:
                own = self.parameters[name].interest
                ratios = log(held.interest[1] / held.interest[0]), log(own[1] / own[0])
                spreads.append(held.held_by[1] * ratios[0] / ratios[1])
        return max(spreads)

    @property
    def unknowns(self) -> dict[str, Parameter]:
        """Numbers to be inferred by name, in the order of coordinates: parameters, then forms."""
        return {**self.parameters, **self.forms}

    def values(self, coordinates: Array) -> dict[str, float]:
        """Values of parameters and forms at coordinates (p,), and of held numbers at their middle, by name."""
        found = {name: p.value(float(z)) for (name, p), z in zip(self.unknowns.items(), coordinates, strict=True)}
        return {**found, **{name: p.value(0.0) for name, p in self.held.items()}}

    def effect(self, coordinates: Array) -> AnyEffect:
        """The effect with the numbers that belong to coordinates (p,), and the candidate's choices."""
        return self.kind(**self.values(coordinates), **self.chosen)

    def applied(self, setup: SurrogateInputs, coordinates: Array) -> SurrogateInputs:
        """A copy of `setup` with the effect at coordinates (p,) added."""
        return setup.with_effect(self.effect(coordinates))

    def bounds(self) -> Array:
        """Lowest and highest coordinates (p, 2); beyond them a number stays at an end of its range."""
        return np.array([item.bounds() for item in self.unknowns.values()]).reshape(-1, 2)

    def starts(self) -> list[Array]:
        """Coordinates (p,) from which searches begin: forms at 0, first and last parameter on a grid, others at 0; for
        changes over time also small early, middle and late ones.
        """
        own = np.zeros(len(self.forms))
        if len(self.parameters) == 1:
            return [np.array([z, *own]) for z in (-1.6, -0.8, 0.0, 0.8, 1.6)]
        # The last parameter of several is how many cycles a change takes, or a second term.
        places = [(a, b) for a in (-1.2, -0.4, 0.4, 1.2) for b in (-0.8, 0.8)]
        starts = [np.zeros(len(self.parameters)) for _ in places]
        for start, (a, b) in zip(starts, places, strict=True):
            start[0], start[-1] = a, b
        return [np.concatenate([start, own]) for start in (*starts, *self._small_changes())]

    def _small_changes(self) -> list[Array]:
        """Small early, middle and late changes of what changes in time: far from them large ones hide the way there."""
        first, last = list(self.parameters.values())[:: len(self.parameters) - 1]
        if last.neutral is not None or not first.neutral or not np.isfinite(first.neutral):
            return []
        unchanged = [item.coordinate(item.neutral) if item.neutral else 0.0 for item in self.parameters.values()]
        starts = []
        for late in (-2.0, -1.2, -0.4, 0.4, 1.2):
            for size in (-0.15, 0.15):
                start = np.array(unchanged)
                start[0], start[-1] = unchanged[0] + size, late
                starts.append(start)
        return starts


def library(setup: SurrogateInputs) -> tuple[Candidate, ...]:
    """All effects, also of installed packages, that the fast model can predict for these inputs, one candidate for each
    choice of words.
    """
    return tuple(
        Candidate.of(
            kind, setup.stated, dict(zip(kind.choices(), words, strict=True)), setup.scales, setup.contact_kind
        )
        for kind in all_effects().values()
        if kind.considered_for(setup.contact_kind, setup.held) and _is_supported(kind, setup) and _may_show(kind, setup)
        for words in product(*kind.choices().values())
    )


def effect_of(name: str) -> str:
    """The name of the effect in a candidate's name: "sensor_lag" of "sensor_lag:force"."""
    return name.partition(":")[0]


def unsupported(setup: SurrogateInputs) -> tuple[str, ...]:
    """Names of the effects that a diagnosis of this kind of contact considers, but the fast model cannot predict."""
    return tuple(
        name
        for name, kind in all_effects().items()
        if kind.considered_for(setup.contact_kind, setup.held) and not _is_supported(kind, setup)
    )


def _is_supported(kind: type[AnyEffect], setup: SurrogateInputs) -> bool:
    try:
        _chain_with(kind, setup)
    except StudyError:
        return False
    return True


def _chain_with(kind: type[AnyEffect], setup: SurrogateInputs) -> Chain:
    return setup.with_effect(kind.sized("easy", setup.stated)).chain(1.0, 1.0, *np.ones((3, 1)))


def _may_show(kind: type[AnyEffect], setup: SurrogateInputs) -> bool:
    """False for a mass that swings so much faster than the drive that even ten times as much does nothing."""
    chain = _chain_with(kind, setup)
    swings = 1e-5 * chain.mass_kg * (2.0 * np.pi * setup.frequency_Hz) ** 2 * chain.compliance_um_per_N
    return not chain.mass_kg.any() or bool(swings.max() > 0.01)
