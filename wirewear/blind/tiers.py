"""The generator of each tier."""

from __future__ import annotations

from wirewear.blind.generator import TIERS, Generator
from wirewear.errors import BlindError

#: The friction law of T2 where none is asked for: the one for development.
DEFAULT_LAW = "dahl"


def generator_of(tier: str, *, law: str | None = None) -> Generator:
    """The forward model of a tier; `law` is the friction law of T2, `DEFAULT_LAW` unless given.

    Raises:
        BlindError: there is no such tier or law, or a law is given to a tier that slides by Coulomb's.
    """
    if tier == "T2":
        from wirewear.blind.independent.friction import LAWS
        from wirewear.blind.independent.model import IndependentModel

        law = law or DEFAULT_LAW
        if law not in LAWS:
            raise BlindError(f"there is no friction law {law!r}: choose one of {', '.join(LAWS)}.")
        return IndependentModel(law)
    if tier in TIERS and law is not None:
        raise BlindError(f"the tier {tier} slides by Coulomb's law: leave out the friction law {law!r}, or take T2.")
    if tier in TIERS:
        from wirewear.blind.finite_element.model import FiniteElementModel

        return FiniteElementModel(tier)
    raise BlindError(f"there is no generator for the tier {tier!r}: choose one of {', '.join(TIERS)}.")
