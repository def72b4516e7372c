"""Levels of fidelity, from quick to fine: element sizes and steps of a run where its study states none."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

from wirewear.base.errors import StudyError

Level = TypeVar("Level")

FIDELITIES = ("quick", "standard", "fine")


def level_of(levels: Mapping[str, Level], name: str) -> Level:
    """The entry of `levels` (by name of the level) called `name`; StudyError if there is none."""
    if name not in levels:
        raise StudyError(f"there is no fidelity {name!r}: choose one of {', '.join(levels)}.")
    return levels[name]


@dataclass(frozen=True)
class WireLevel:
    """Resolution in space and time of a contact at a point at one level of fidelity.

    Elements per radius of the fresh contact (per_contact_radius; per_sticking_radius where its middle sticks), per
    half-width of the scar (along_motion, across_motion), and from the middle to the rim of a contact that sticks
    (to_rim; to_rim_worn where its annulus wears). increments_per_cycle: of a loop; wear_increments: positions of a
    cycle at which surfaces wear, as a share of these. most_unknowns: displacements of a patch beyond which elements are
    made larger. loop_spacing: least ratio to every logged cycle at which a cycle of 1, 2, 5, 10, … is measured, too.
    jump_tolerance: of what two stages of a jump differ by.
    """

    per_contact_radius: float

    #: Elements per radius where the middle sticks for good and the annulus around it wears until it carries nothing: an
    #: error of 1 % of the stick radius is one of 10 % of the worn volume (studies/atlas/partial_slip).
    per_sticking_radius: float
    #: Elements per half-width of the scar. The worn wires touch in a band across the motion that travels over the whole
    #: scar and is narrowest at its edges, so elements along the motion are the shorter ones. Neither direction is
    #: meshed finer than the fresh contact.
    along_motion: float
    across_motion: float
    #: Elements from the middle to the rim of a contact that sticks in its middle, smaller towards the rim: its patch
    #: need hold little beside it, and the annulus that slips is narrow (docs/partial_slip.md).
    to_rim: float
    to_rim_worn: float  #: The same where the annulus wears: many cycles are followed, on lines that fit the core.

    #: The `share` of `RimGradedAxis`, by which element sizes fall towards the rim. Since whole nodes slip, it is chosen
    #: so that the area of the nodes within a circle is nearest to the circle's (docs/partial_slip.md).
    rim_share: float
    increments_per_cycle: int
    wear_increments: float
    jump_tolerance: float
    most_unknowns: int
    loop_spacing: float
    #: Whether nodes are moved into the worn surface whenever a mesh for a larger scar begins.
    move_nodes_at_stages: bool = False
    #: Whether the middle of the contact sticks for good. Equal wires at right angles then get equal mesh lines: nodes
    #: that stick face nodes that stick.
    sticking: bool = False

    def for_sticking(self, *, wears: bool, steady: bool) -> "WireLevel":
        """A copy for a contact whose middle sticks for good, with fewer positions a cycle under a steady load. wears:
        the test wears.
        """
        return replace(
            self,
            to_rim=self.to_rim_worn if wears else self.to_rim,
            rim_share=0.6 if wears else self.rim_share,
            per_contact_radius=self.per_sticking_radius,
            # Around a middle that sticks for good, eight do; under a changing load the energy would be 7 % too high.
            wear_increments=min(self.wear_increments, 8 / self.increments_per_cycle)
            if steady
            else self.wear_increments,
            sticking=True,
        )

    def coarser(self, factor: float) -> "WireLevel":
        """A copy with elements `factor` times as large."""
        return replace(
            self,
            per_contact_radius=self.per_contact_radius / factor,
            per_sticking_radius=self.per_sticking_radius / factor,
            along_motion=self.along_motion / factor,
            across_motion=self.across_motion / factor,
            to_rim=self.to_rim / factor,
            to_rim_worn=self.to_rim_worn / factor,
        )


WIRE_LEVELS = {
    "quick": WireLevel(
        per_contact_radius=2.05,
        per_sticking_radius=4.0,
        along_motion=18.0,
        across_motion=6.3,
        to_rim=12.0,
        to_rim_worn=8.0,
        rim_share=0.6,
        increments_per_cycle=32,
        wear_increments=1.0,
        jump_tolerance=0.1,
        most_unknowns=9_000,
        loop_spacing=4.0,
    ),
    "standard": WireLevel(
        per_contact_radius=3.5,
        per_sticking_radius=8.0,
        along_motion=30.0,
        across_motion=8.0,
        to_rim=18.0,
        to_rim_worn=12.0,
        rim_share=0.55,
        increments_per_cycle=40,
        wear_increments=1.0,
        jump_tolerance=0.05,
        most_unknowns=15_000,
        loop_spacing=1.6,
    ),
    "fine": WireLevel(
        per_contact_radius=5.0,
        per_sticking_radius=10.0,
        along_motion=42.0,
        across_motion=11.0,
        to_rim=24.0,
        to_rim_worn=18.0,
        rim_share=0.65,
        increments_per_cycle=64,
        wear_increments=1.0,
        jump_tolerance=0.02,
        most_unknowns=20_000,
        loop_spacing=1.6,
        move_nodes_at_stages=True,
    ),
}


@dataclass(frozen=True)
class LineLevel:
    """Resolution of a line contact at one level of fidelity: elements per half-width of the fresh contact (per_contact;
    to_rim where its middle sticks, to_rim_worn where its annulus wears, too) and of the scar (per_scar), time steps,
    and the relative error allowed to a cycle jump.

    That tolerance keeps pressures at the edges of a growing scar; depths alone would allow ten times as much.
    """

    per_contact: float
    per_scar: float
    to_rim: float
    to_rim_worn: float
    increments_per_cycle: int
    jump_tolerance: float


LINE_LEVELS = {
    "quick": LineLevel(8.0, 80.0, 40.0, 40.0, 32, 0.005),
    "standard": LineLevel(12.0, 120.0, 84.0, 56.0, 48, 0.005),
    "fine": LineLevel(18.0, 180.0, 120.0, 80.0, 64, 0.0025),
}
