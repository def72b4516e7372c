"""The generator of each tier."""

from __future__ import annotations

from wirewear.blind.generator import TIERS, Generator
from wirewear.errors import BlindError


def generator_of(tier: str, *, law: str = "dahl") -> Generator:
    """The forward model of a tier; `law` is the friction law of T2.

    Raises:
        BlindError: there is no such tier or law.
    """
    if tier == "T2":
        from wirewear.blind.independent.friction import LAWS
        from wirewear.blind.independent.model import IndependentModel

        if law not in LAWS:
            raise BlindError(f"there is no friction law {law!r}: choose one of {', '.join(LAWS)}.")
        return IndependentModel(law)
    if tier in TIERS:
        from wirewear.blind.finite_element.model import FiniteElementModel

        return FiniteElementModel(tier)
    raise BlindError(f"there is no generator for the tier {tier!r}: choose one of {', '.join(TIERS)}.")
