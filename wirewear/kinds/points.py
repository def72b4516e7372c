"""Contacts at a point as commands ask for them: of crossed wires, of any two bodies, and of a ball on a flat."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from wirewear.base import kinds
from wirewear.base.errors import RecordError
from wirewear.kinds.kind import Kind, elsewhere

if TYPE_CHECKING:
    from wirewear.results import RunResult


class AtAPoint(Kind):
    """What all contacts at a point have in common."""

    inside_options: ClassVar[frozenset[str]] = frozenset(("--integration-points", "--no-pictures", "--animate"))
    scatters: ClassVar[bool] = True
    refined = elsewhere("wirewear.simulation:POINTS")
    inside = elsewhere("wirewear.stress.bodies:INSIDE_POINTS")
    write_meshes = elsewhere("wirewear.simulation:write_meshes")
    surfaces = elsewhere("wirewear.records.exporting:scar_surfaces")
    write_fields = elsewhere("wirewear.stress.writing:write_fields")
    drawings = elsewhere("wirewear.pictures:drawings")

    def write_beside(self, results: Sequence[RunResult], folder: Path) -> None:
        """The scars of each run over the cycles for ParaView."""
        from wirewear.results.flat import FOLDER_NAME, write_time_series

        for result in results:
            write_time_series(result, (folder if result.path is None else result.path.parent) / FOLDER_NAME)


class CrossedWires(AtAPoint):
    """Two round wires that cross."""

    name: ClassVar[str] = kinds.CROSSED_WIRES
    options: ClassVar[frozenset[str]] = frozenset(("diameter_mm", "crossing_angle_deg"))
    rigid_N_per_mm: ClassVar[float] = 1e6
    template = elsewhere("wirewear.test.template:CROSSED_WIRES")
    touching = elsewhere("wirewear.records.importing.guessing:crossed_wires")


class AnyBodies(AtAPoint):
    """Two bodies of any shapes."""

    name: ClassVar[str] = kinds.POINT_CONTACT
    options: ClassVar[frozenset[str]] = frozenset()
    rigid_N_per_mm: ClassVar[float] = 1e7
    template = elsewhere("wirewear.test.points:ANY_BODIES")

    def touching(self, *_: Any) -> Any:
        """No options state shapes; RecordError says so."""
        raise RecordError(
            f"no options state the shapes of a {self.name}: write [contact] and [bodies] of a mapping yourself "
            "(docs/records.md), or take --kind ball-on-flat or crossed-wires."
        )


class BallOnFlat(AtAPoint):
    """A ball held above a flat."""

    name: ClassVar[str] = kinds.BALL_ON_FLAT
    options: ClassVar[frozenset[str]] = frozenset(("diameter_mm",))
    rigid_N_per_mm: ClassVar[float] = 1e7
    template = elsewhere("wirewear.test.points:BALL")
    touching = elsewhere("wirewear.records.importing.guessing:ball_on_flat")
