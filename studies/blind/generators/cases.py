"""Which records a batch holds: gap-free ones, single effects, pairs, effects of no library, effects left out of it."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from studies.blind.generators.nominal import Nominal, drawn_nominals
from studies.blind.generators.nuisances import Nuisances, drawn_nuisances
from studies.blind.generators.sizes import drawn_parameters

#: Share of the cases of each kind; "left_out" are singles whose effect the diagnosis has to do without.
KINDS = {"none": 0.2, "single": 0.47, "pair": 0.1, "outside": 0.13, "left_out": 0.1}
#: Of simulators by others.
KINDS_OF_OTHERS = {"none": 0.2, "single": 0.45, "pair": 0.15, "outside": 0.15, "left_out": 0.05}
#: Of the other cases, this share leaves out an effect that is not there, so that leaving out says nothing.
DECOYS = 0.25
#: Effects that no record of wires distinguishes, as one class.
EXACT_CLASSES = (frozenset({"tangential_compliance", "rotational_compliance"}),)
#: Nominal tests in a batch unless asked otherwise, and the least share of the article's among the cases.
NOMINALS, REFERENCE_SHARE = 10, 0.1


@dataclass(frozen=True)
class TrueEffect:
    """An effect of the contract, or from outside the library, and its parameters in the contract's units."""

    effect: str
    parameters: dict[str, float]


@dataclass(frozen=True)
class Case:
    """One record to be made: everything of it that is drawn beforehand.

    `nominal` is of the kind that its generator draws.
    """

    name: str
    kind: str
    ease: str | None
    effects: tuple[TrueEffect, ...]
    left_out: tuple[str, ...]
    nominal: Nominal
    nuisances: Nuisances
    seed: int


def exact_class(effect: str) -> frozenset[str]:
    """The effects that cannot be distinguished from this one, itself among them."""
    return next((members for members in EXACT_CLASSES if effect in members), frozenset({effect}))


def planned_cases(
    number: int,
    seed: int,
    library: Sequence[str],
    outside: Sequence[str],
    tests: int = NOMINALS,
    nominals_of: Callable[[int, np.random.Generator], Sequence[Nominal]] = drawn_nominals,
    reference_share: float = REFERENCE_SHARE,
    shares: Mapping[str, float] = KINDS,
) -> tuple[Case, ...]:
    """The cases of a batch in an order that says nothing; the same for the same arguments.

    `tests` is the number of different nominal tests, the article's among them; `nominals_of` draws them. The article's
    has `reference_share` of the cases at least. `shares` are those of the kinds.

    Effects take turns, so that each comes as often as any other of its kind, easy and hard alike. Nominal test,
    nuisances and seed of a case depend on the batch's seed and the case's place alone.
    """
    conditions, plan, *children = np.random.SeedSequence(seed).spawn(number + 2)
    nominals = nominals_of(tests, np.random.default_rng(conditions))
    random = np.random.default_rng(plan)
    kinds = _kinds(number, bool(outside), shares)
    turns = {kind: _RoundRobin(outside if kind == "outside" else library, random) for kind in KINDS}
    drawn = []
    for place, kind in enumerate(kinds):
        chosen = _effects(kind, turns, random)
        ease = None if kind == "none" else ("easy", "hard")[place % 2]
        drawn.append((kind, ease, chosen))
    order = random.permutation(number)
    width = max(3, len(str(number)))
    cases = []
    for place, child in enumerate(children):
        kind, ease, chosen = drawn[order[place]]
        # What the record looks like comes from a stream of its own, so that no effect can leave a trace in it.
        looks, own = (np.random.default_rng(stream) for stream in child.spawn(2))
        nominal = nominals[0] if looks.random() < reference_share else nominals[int(looks.integers(len(nominals)))]
        nuisances, made_from = drawn_nuisances(nominal, looks), int(looks.integers(2**63))
        effects = tuple(TrueEffect(e, drawn_parameters(e, ease, nominal, own)) for e in chosen) if ease else ()
        cases.append(
            Case(
                name=f"case_{place + 1:0{width}d}",
                kind=kind,
                ease=ease,
                effects=effects,
                left_out=_left_out(kind, chosen, library, own),
                nominal=nominal,
                nuisances=nuisances,
                seed=made_from,
            )
        )
    return tuple(cases)


def _kinds(number: int, has_outside: bool, of_kinds: Mapping[str, float]) -> list[str]:
    """Kinds of the cases in their shares, the remainder singles."""
    drawn = {kind: share for kind, share in of_kinds.items() if has_outside or kind != "outside"}
    shares = {kind: share for kind, share in drawn.items() if kind != "single"}
    counts = {kind: round(share * number) for kind, share in shares.items()}
    kinds = [kind for kind, count in counts.items() for _ in range(count)]
    return kinds + ["single"] * (number - len(kinds))


class _RoundRobin:
    """Effects in a drawn order, one after the other and round again; each comes easy and hard in turn."""

    def __init__(self, effects: Sequence[str], random: np.random.Generator) -> None:
        self.effects, self.next = [effects[i] for i in random.permutation(len(effects))], 0

    def take(self) -> str:
        """The next effect."""
        effect: str = self.effects[self.next % len(self.effects)]
        self.next += 1
        return effect


def _effects(kind: str, turns: dict[str, _RoundRobin], random: np.random.Generator) -> tuple[str, ...]:
    if kind == "none":
        return ()
    first = turns[kind].take()
    if kind != "pair":
        return (first,)
    others = [effect for effect in turns[kind].effects if not _related(effect, first)]
    return first, others[random.integers(len(others))]


def _related(one: str, other: str) -> bool:
    """Effects of one class, or that set the same thing twice, make no pair."""
    same_seam = ({"friction_offset", "friction_evolution"}, {"wear_rate_offset", "wear_rate_evolution"})
    return other in exact_class(one) or any(one in seam and other in seam for seam in same_seam)


def _left_out(kind: str, chosen: Sequence[str], library: Sequence[str], random: np.random.Generator) -> tuple[str, ...]:
    if kind == "left_out":
        return tuple(sorted(exact_class(chosen[0])))
    absent = [effect for effect in library if not any(_related(effect, own) for own in chosen)]
    decoy = absent[random.integers(len(absent))]
    return tuple(sorted(exact_class(decoy))) if random.random() < DECOYS else ()
