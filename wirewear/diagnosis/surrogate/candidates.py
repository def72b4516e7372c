"""Effects as candidates for the cause of a gap: the effects that the fast model knows, and their numbers to be
inferred.

A coordinate is the value of a parameter in standard deviations of its expected distribution, 0 being the middle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from math import log
from typing import Any

import numpy as np

from geometry.arrays import Array
from wirewear.base import kinds
from wirewear.base.errors import StudyError
from wirewear.base.units import words_of
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.effects import AnyEffect, Chain, Parameter, Stated, all_effects

#: Where numerical freedoms lie on average, if not at their neutral value: a quick run sees a scar longer than the slip
#: and blunts its walls, so that the state that fits others' loops is one of less wear with steeper slopes.
EXPECTED: Mapping[str, Any] = constants("surrogate.candidates").all()


@dataclass(frozen=True)
class Candidate:
    """An effect of the library with the numbers that are to be inferred.

    kind: the effect's class. parameters: its numbers to be inferred, by name. held: numbers that stay at their middle,
    as no record distinguishes them from the others; what a study need not state stays at its default. chosen: its
    words, such as the channel that lags. forms: numbers of its law that differ between laws of one cause; they are
    inferred like parameters and follow them in coordinates (p,).
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
        instead: bool = False,
    ) -> Candidate:
        """The effect of this class as a candidate for a test, its parameters and forms as they are expected there.

        stated: values of the test, from which parameters may be scaled. chosen: words by their names; defaults if None.
        scales: by a parameter's name or unit, as "N_per_mm", a factor on the sizes that are expected of it; 1 if
        missing. contact: kind of contact. instead: True for the parameters that are inferred in place of the others.
        """
        known_by = scales or {}
        known = {
            name: described.beside(stated).scaled(known_by.get(name, known_by.get(described.quantity.unit, 1.0)))
            for name, described in kind.parameters().items()
            if described.instead == instead and described.default in (None, described.neutral)
        }
        free, held = (
            {name: item for name, item in known.items() if (item.held_by is not None) is wanted}
            for wanted in (False, True)
        )
        return cls(kind, free, held, chosen or {}, kind.forms(contact))

    @property
    def name(self) -> str:
        """The effect's name and, after a colon each, words other than the default, as "sensor_lag:force", or the
        parameter that is inferred in place of the others, as "plasticity:flattening".
        """
        usual = {name: words[0] for name, words in self.kind.choices().items()}
        words = [word for name, word in self.chosen.items() if word != usual[name]]
        return ":".join([self.kind.name, *words, *(words_of(name) for name, p in self.parameters.items() if p.instead)])

    def unknown_spread(self, name: str, coordinate: float) -> float:
        """Largest standard deviation that held numbers add to the parameter `name` at a coordinate; 0 if none depends
        on it.
        """
        spreads = [0.0]
        for held in self.held.values():
            if held.held_by is not None and held.held_by[0] in (name, "") and held.held_by[1]:
                own, ratio = self.parameters[name], log(held.interest[1] / held.interest[0])
                # Of a number on a linear scale, about 0, the ratio is uncertain.
                size = 1.0 / log(own.interest[1] / own.interest[0]) if own.logarithmic else abs(coordinate) / 3.92
                spreads.append(held.held_by[1] * ratio * size)
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


def library(setup: SurrogateInputs, states: WearStates | None = None) -> tuple[Candidate, ...]:
    """All effects, also of installed packages, that the fast model can predict for these inputs, one candidate for each
    choice of words.

    states: of the nominal run, from which those effects are known that do nothing in this test; None: in one cycle of a
    contact of 1 µm².
    """
    course = _Course.of(setup, states)
    # Bodies yield by Hertz's largest pressure, of 4 650 MPa between the wires for which effects state what one expects.
    scales = {**setup.scales, "yield_stress_MPa": 1.5e6 * setup.load_N / course.fresh_area_um2 / 4650.0}
    return tuple(
        Candidate.of(
            kind, setup.stated, dict(zip(kind.choices(), words, strict=True)), scales, setup.contact_kind, instead
        )
        for kind in all_effects().values()
        if kind.considered_for(setup.contact_kind, setup.held)
        and (chain := _chain(kind, setup, course)) is not None
        and _sized(kind, setup).may_show(chain)
        for words in product(*kind.choices().values())
        for instead in sorted({item.instead for item in kind.parameters().values()})
    )


def considered(setup: SurrogateInputs, states: WearStates, left_out: Sequence[str], *, scars: bool) -> list[Candidate]:
    """Candidates for a record. left_out: names of effects that are not considered. scars: False for a record without
    any, in which some effects never show.
    """
    return [
        one for one in library(setup, states) if one.kind.name not in left_out and (scars or not one.kind.needs_scars)
    ]


def effect_of(name: str) -> str:
    """The name of the effect in a candidate's name: "sensor_lag" of "sensor_lag:force"."""
    return name.partition(":")[0]


def unsupported(setup: SurrogateInputs) -> tuple[str, ...]:
    """Names of the effects that a diagnosis of this kind of contact considers, but the fast model cannot predict."""
    course = _Course.of(setup, None)
    return tuple(
        name
        for name, kind in all_effects().items()
        if kind.considered_for(setup.contact_kind, setup.held) and _chain(kind, setup, course) is None
    )


def _chain(kind: type[AnyEffect], setup: SurrogateInputs, course: _Course) -> Chain | None:
    """The test with the effect added; None if the fast model cannot predict it."""
    try:
        return course.chain(setup.with_effect(_sized(kind, setup)))
    except StudyError:
        return None


def _sized(kind: type[AnyEffect], setup: SurrogateInputs) -> AnyEffect:
    return kind.sized("easy", setup.stated)


@dataclass(frozen=True, eq=False)
class _Course:
    """Moments of the nominal test: radius and area of the fresh contact, cycles, friction energies and volumes."""

    radius_um: float
    fresh_area_um2: float
    cycles: Array
    energy_J: Array
    worn_um3: Array

    @classmethod
    def of(cls, setup: SurrogateInputs, states: WearStates | None) -> _Course:
        if states is None:
            return cls(1.0, 1.0, *np.ones((3, 1)))
        cycles = np.geomspace(1.0, max(setup.cycles, 10.0), 9)
        loops = simulate(states, setup, cycles)
        steps = 0.5 * (loops.energy_mJ + np.append(loops.energy_mJ[:1], loops.energy_mJ[:-1]))
        energy_J = 1e-3 * np.cumsum(steps * np.diff(cycles, prepend=0.0))
        return cls(states.spot_radius_um, states.fresh_area_um2, cycles, energy_J, loops.volume_um3)

    def chain(self, setup: SurrogateInputs) -> Chain:
        return setup.chain(self.radius_um, self.fresh_area_um2, self.cycles, self.energy_J, self.worn_um3)
