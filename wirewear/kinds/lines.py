"""Line contacts as commands ask for them: studies and results are of one millimetre, records of the whole contact."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from wirewear.kinds.kind import Kind, elsewhere

if TYPE_CHECKING:
    from wirewear.diagnosis.surrogate.inputs import Setup
    from wirewear.diagnosis.surrogate.nominal import ObserverOf
    from wirewear.diagnosis.surrogate.wear_states import WearStates
    from wirewear.records.contact_tables import LineRecordTables
    from wirewear.results import RunResult
    from wirewear.study import LineStudy


class LineContacts(Kind):
    """A pad on a flat in plane strain."""

    name: ClassVar[str] = "line-contact"
    names: ClassVar[tuple[str, ...]] = (name, "cylinder-on-flat")
    inside_options: ClassVar[frozenset[str]] = frozenset()
    scatters: ClassVar[bool] = False
    options: ClassVar[frozenset[str]] = frozenset(("length_mm", "radius_mm", "face_half_width_mm", "edge_radius_mm"))
    foresees_scars: ClassVar[bool] = True
    rigid_N_per_mm: ClassVar[float] = 1e7  # stiffer than what a record may state
    template = elsewhere("wirewear.study.lines:LINE_CONTACT")
    refined = elsewhere("wirewear.simulation:LINES")
    inside = elsewhere("wirewear.interior.lines:INSIDE_LINES")
    write_meshes = elsewhere("wirewear.simulation:write_line_meshes")
    checked_model = elsewhere("wirewear.diagnosis.surrogate.nominal:checked_line_model")
    touching = elsewhere("wirewear.records.importing.guessing:line_contact")
    surfaces = elsewhere("wirewear.records.exporting:profile_surfaces")
    write_fields = elsewhere("wirewear.interior.lines:write_line_fields")
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

    def states(
        self, study: LineStudy, tables: LineRecordTables, observer_of: ObserverOf | None
    ) -> tuple[WearStates, tuple[str, ...]]:
        """Runs the nominal study; wear states of the whole length, and what limits them."""
        from wirewear.diagnosis.surrogate.line_states import LineStates
        from wirewear.diagnosis.surrogate.nominal import limits_of, line_run, nominal_run

        result = nominal_run(study, observer_of, line_run)
        return LineStates.of_line(result, study.pad.profile, tables.length_mm), limits_of(result, study)

    def setup(self, study: LineStudy, tables: LineRecordTables) -> Setup:
        from wirewear.diagnosis.surrogate.candidates import nominal_line_setup

        return nominal_line_setup(study, tables.conditions.drive)

    def with_effects(
        self, study: LineStudy, effects: Sequence[Any], amplitude_um: float, _increments: int
    ) -> LineStudy:
        """Loops have the increments of the plan."""
        every = (*study.effects, *effects)
        return study.changed({"effects": every, "conditions": {"displacement_amplitude_um": amplitude_um}})
