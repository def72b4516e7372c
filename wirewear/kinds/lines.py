"""Line contacts as commands ask for them: studies and results are of one millimetre, records of the whole contact."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from wirewear.base import kinds
from wirewear.kinds.kind import Kind, elsewhere

if TYPE_CHECKING:
    from wirewear.results import RunResult


class LineContacts(Kind):
    """A pad on a flat in plane strain."""

    name: ClassVar[str] = kinds.LINE_CONTACT
    inside_options: ClassVar[frozenset[str]] = frozenset()
    scatters: ClassVar[bool] = False
    options: ClassVar[frozenset[str]] = frozenset(("length_mm", "radius_mm", "face_half_width_mm", "edge_radius_mm"))
    rigid_N_per_mm: ClassVar[float] = 1e7  # stiffer than what a record may state
    template = elsewhere("wirewear.test.lines:LINE_CONTACT")
    refined = elsewhere("wirewear.simulation:LINES")
    inside = elsewhere("wirewear.stress.lines:INSIDE_LINES")
    write_meshes = elsewhere("wirewear.simulation:write_line_meshes")
    touching = elsewhere("wirewear.records.importing.guessing:line_contact")
    surfaces = elsewhere("wirewear.records.exporting:profile_surfaces")
    write_fields = elsewhere("wirewear.stress.lines:write_line_fields")
    drawings = elsewhere("wirewear.pictures.lines:line_drawings")

    def write_beside(self, results: Sequence[RunResult], folder: Path) -> None:
        """Tables and pictures of each run, and a picture of several side by side."""
        from wirewear.pictures.lines import line_drawings, line_variants
        from wirewear.pictures.style import save
        from wirewear.results.flat import write_flat_tables

        for result in results:
            own = folder if result.path is None else result.path.parent
            write_flat_tables(result, own, "csv")
            for name, draw in line_drawings([result]).items():
                save(draw, own / f"{name}.png")
        if len(results) > 1:
            save(lambda: line_variants(results), folder / "variants.png")
