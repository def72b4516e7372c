"""The generator of each tier."""

from studies.blind.errors import BlindError
from studies.blind.generators.generator import LINE_TIERS, OTHERS, POINT_TIERS, TIERS, Generator

DEFAULT_LAW = "dahl"  #: The friction law of T2 where none is asked for: the one for development.


def generator_of(
    tier: str, *, law: str | None = None, outside: str = "first", stated_scatter: float = 0.0
) -> Generator:
    """The forward model of a tier; `law` is the friction law of T2, `DEFAULT_LAW` unless given.

    Of T3 it names the simulators: those for development unless given, or those for scoring alone.

    `outside` names the causes of no library that are drawn: those of the first batches, the half for development, the
    half that was sealed until a diagnosis was frozen, or one of three sets written without a look at any. T2 knows all,
    T0 and T1 some of each but the half for development, line contacts the first. A share `stated_scatter` of the
    records of wires state the scatter between tests, as their owners estimate it.
    Raises BlindError if there is no such tier, law or set of causes, or the tier does not know it.
    """
    if stated_scatter > 0.0:
        from studies.blind.generators.owners import OwnersWhoKnow

        if tier in (*LINE_TIERS, OTHERS):
            raise BlindError(f"records of the tier {tier} state no scatter at will: leave it out, or take T2.")
        return OwnersWhoKnow(generator_of(tier, law=law, outside=outside), stated_scatter)
    if tier == "T2":
        from studies.blind.causes import SETS, causes_of
        from studies.blind.generators.independent.friction import LAWS
        from studies.blind.generators.independent.model import IndependentModel

        law = law or DEFAULT_LAW
        if law not in LAWS:
            raise BlindError(f"there is no friction law {law!r}: choose one of {', '.join(LAWS)}.")
        if outside not in SETS:
            raise BlindError(f"there is no set {outside!r} of causes: choose one of {', '.join(SETS)}.")
        return IndependentModel(law, outside=causes_of(outside))
    if tier == OTHERS:
        _require_set(tier, outside, ("first",))
        return _others(law or "development")
    if tier in (*TIERS, *POINT_TIERS) and law is not None:
        raise BlindError(f"the tier {tier} slides by Coulomb's law: leave out the friction law {law!r}, or take T2.")
    if tier in LINE_TIERS:
        _require_set(tier, outside, ("first",))
        from studies.blind.generators.lines.model import LineModel

        return LineModel()
    if tier in (*TIERS, *POINT_TIERS):
        from studies.blind.generators.finite_element.changes import DRAWN_SETS, outside_of
        from studies.blind.generators.finite_element.model import FiniteElementModel

        _require_set(tier, outside, DRAWN_SETS)
        return FiniteElementModel(tier, outside=outside_of(outside))
    raise BlindError(f"there is no generator for the tier {tier!r}: choose one of {', '.join(TIERS)}.")


def _others(chosen: str) -> Generator:
    from studies.blind.generators.other_simulators.model import OtherSimulators
    from studies.blind.generators.other_simulators.tests_drawn import SIMULATORS

    if chosen not in SIMULATORS:
        raise BlindError(f"there are no simulators {chosen!r}: choose {' or '.join(SIMULATORS)}.")
    return OtherSimulators(chosen)


def _require_set(tier: str, outside: str, known: tuple[str, ...]) -> None:
    if outside not in known:
        raise BlindError(
            f"the tier {tier} has no set {outside!r} of causes: choose one of {', '.join(known)}, or take T2."
        )
