"""A family of distortions: what a cause outside the library may do at one seam."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from wirewear.diagnosis.infer.shapes import Shape
from wirewear.effects import Seam


@dataclass(frozen=True, eq=False)
class Family:
    """Distortions of one kind at one seam.

    Attributes:
        seam: where they enter.
        name: what they are, for people.
        shapes: of a loop, each with a size of its own; empty for what changes in time.
        column: of the chain, where it changes in time; empty for shapes.
        scale: unit of what is added to the column: "" multiplies it, "compliance" is amplitude over plateau force,
            "force" that force.
        develops: whether its sizes may change over the cycles.
        allowed: log evidence that friction laws and solvers were seen to lend it beside known effects.
        instead: sets of shapes that it may have instead of these, each as likely.
        step: share of unit size over which changes are taken; 0 for that of small ones. Rounded corners change readings
            by no straight law, so that they are taken as a whole.
        counts: whether it speaks for a cause outside the library; else it names one that others speak for, as nothing
            that solvers lend it was learned.
    """

    seam: Seam
    name: str
    shapes: tuple[Shape, ...] = ()
    column: str = ""
    scale: str = ""
    develops: bool = False
    allowed: float = 0.0
    instead: tuple[tuple[Shape, ...], ...] = ()
    step: float = 0.0
    counts: bool = True

    @classmethod
    def one_of(
        cls,
        seam: Seam,
        name: str,
        sets: Iterable[tuple[Shape, ...]],
        *,
        develops: bool = False,
        allowed: float = 0.0,
        step: float = 0.0,
    ) -> Family:
        """One that only names, of the first of these sets of shapes or any other."""
        first, *others = sets
        return cls(
            seam, name, first, develops=develops, allowed=allowed, instead=tuple(others), step=step, counts=False
        )
