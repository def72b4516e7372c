"""Kinds of tests, such as crossed wires or a line contact, and the data by which one differs from another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from wirewear.base import kinds
from wirewear.test.bodies import StatedBodies
from wirewear.test.joints import JOINT, JointStiffness, JointTables
from wirewear.test.lines import LINE_CONTACT, LineTables, PadAndSpecimen
from wirewear.test.points import ANY_BODIES, BALL, BallAndFlat, BallOnFlatTables, LowerAndUpper, PointTables
from wirewear.test.tables import CommonTables, StudyTables
from wirewear.test.template import COMMON, EXAMPLE, Template
from wirewear.test.wires import Wires


@dataclass(frozen=True)
class Kind:
    """The data by which a kind of test differs from others; code tells studies of different kinds apart by their class.

    tables: class of its studies' tables. bodies: keys by which files state its bodies, body_names in the order of
    records. options: keys of bodies that `wirewear new --mapping` takes. rigid_N_per_mm: stiffness above which a rig
    counts as rigid. scatters: True if studies state the scatter of inputs. simulated: True if there are bodies to be
    simulated.
    """

    name: str
    tables: type[CommonTables]
    bodies: type[StatedBodies]
    body_names: tuple[str, ...]
    template: Template
    options: frozenset[str]
    rigid_N_per_mm: float = 1e7
    scatters: bool = True
    simulated: bool = True


KINDS: dict[str, Kind] = {
    kind.name: kind
    for kind in (
        Kind(
            kinds.CROSSED_WIRES,
            StudyTables,
            Wires,
            ("moving", "fixed"),
            Template(
                kinds.CROSSED_WIRES,
                StudyTables,
                ("wires", *COMMON),
                EXAMPLE,
                "The article's test of steel wires, to be changed into yours.",
                ("wires.motion_angle_deg",),
            ),
            frozenset(("diameter_mm", "crossing_angle_deg")),
            rigid_N_per_mm=1e6,
        ),
        Kind(
            kinds.LINE_CONTACT,
            LineTables,
            PadAndSpecimen,
            ("pad", "specimen"),
            LINE_CONTACT,
            frozenset(("length_mm", "radius_mm", "face_half_width_mm", "edge_radius_mm")),
            scatters=False,
        ),
        Kind(kinds.BALL_ON_FLAT, BallOnFlatTables, BallAndFlat, ("flat", "ball"), BALL, frozenset(("diameter_mm",))),
        Kind(kinds.POINT_CONTACT, PointTables, LowerAndUpper, ("lower", "upper"), ANY_BODIES, frozenset()),
        Kind(kinds.JOINT, JointTables, JointStiffness, (), JOINT, frozenset(), scatters=False, simulated=False),
    )
}


class OfAKind(Protocol):
    """Anything that names its kind of test: a study, a record or a result."""

    @property
    def contact_kind(self) -> str:
        """Name of its kind, a key of KINDS."""


def kind_of(one: OfAKind) -> Kind:
    """The kind of test of a study, a record or a result. Raises KeyError for a name that is not in KINDS."""
    return KINDS[one.contact_kind]


def kind_named(asked: object) -> Kind:
    """The kind of test with this name or synonym; crossed wires for any other value, which their tables refuse."""
    found = (KINDS[name] for name, names in kinds.NAMES.items() if asked in names)
    return next(found, KINDS[kinds.CROSSED_WIRES])
