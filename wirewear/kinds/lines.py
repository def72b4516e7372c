"""Line contacts as commands ask for them: studies and results are of one millimetre, records of the whole contact."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from wirewear.diagnosis.model.nominal import ObserverOf
    from wirewear.diagnosis.model.setup import Setup
    from wirewear.diagnosis.model.wear_states import WearStates
    from wirewear.interior.state import InnerState
    from wirewear.interior.strength import Strength, StrengthAsked
    from wirewear.records import LineRecord
    from wirewear.records.contact_tables import LineRecordTables
    from wirewear.records.exporting import Surface
    from wirewear.records.importing.guessing import GuessedMapping
    from wirewear.results import RunResult
    from wirewear.study import LineStudy
    from wirewear.study.template import Template


class LineContacts:
    """A pad on a flat in plane strain; each method is described by `Kind`."""

    name: ClassVar[str] = "line-contact"
    names: ClassVar[tuple[str, ...]] = (name, "cylinder-on-flat")
    inside_options: ClassVar[frozenset[str]] = frozenset()
    scatters: ClassVar[bool] = False
    options: ClassVar[frozenset[str]] = frozenset(("length_mm", "radius_mm", "face_half_width_mm", "edge_radius_mm"))
    foresees_scars: ClassVar[bool] = True
    rigid_N_per_mm: ClassVar[float] = 1e7  # stiffer than what a record may state

    @property
    def template(self) -> Template:
        from wirewear.study.lines import LINE_CONTACT

        return LINE_CONTACT

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

    def write_meshes(self, study: LineStudy, fidelity: str, folder: Path) -> list[Path]:
        """Pad and specimen, and what holds them."""
        from wirewear.simulation import write_line_meshes

        return write_line_meshes(study, fidelity, folder)

    @property
    def refined(self) -> Any:
        from wirewear.simulation import LINES

        return LINES

    def checked_model(self, record: LineRecord, study: LineStudy) -> LineStudy:
        """One of the same face, load and amplitude."""
        from wirewear.diagnosis.model.nominal import checked_line_model

        return checked_line_model(record, study)

    def states(
        self, study: LineStudy, tables: LineRecordTables, observer_of: ObserverOf | None
    ) -> tuple[WearStates, tuple[str, ...]]:
        """Those of the whole contact, of the nominal run."""
        from wirewear.diagnosis.model.line_states import LineStates
        from wirewear.diagnosis.model.nominal import limits_of, line_run, nominal_run

        result = nominal_run(study, observer_of, line_run)
        return LineStates.of_line(result, study.pad.profile, tables.length_mm), limits_of(result, study)

    def setup(self, study: LineStudy, tables: LineRecordTables) -> Setup:
        """Of the whole contact."""
        from wirewear.diagnosis.model.candidates import nominal_line_setup

        return nominal_line_setup(study, tables.length_mm, tables.conditions.drive)

    def with_effects(
        self, study: LineStudy, effects: Sequence[Any], length_mm: float, amplitude_um: float, increments: int
    ) -> LineStudy:
        """Effects of one millimetre; loops have the increments of the plan."""
        from wirewear.study.lines import per_mm

        del increments
        every = (*study.effects, *per_mm(effects, length_mm))
        return study.changed({"effects": every, "conditions": {"displacement_amplitude_um": amplitude_um}})

    def guessed_mapping(
        self, files: Sequence[Path], known: Mapping[str, Any], own: Mapping[str, float], pad: Mapping[str, float]
    ) -> GuessedMapping:
        """The specimen may be of another material than the pad."""
        from wirewear.records.importing.guessing import guessed_mapping, line_contact

        return guessed_mapping(files, dict(known), line_contact(known, own, pad))

    def surfaces(self, result: RunResult, noise_um: float, seed: int) -> Mapping[str, Surface]:
        """Profiles across the scar."""
        import numpy as np

        from wirewear.records.exporting import profile_surfaces

        return profile_surfaces(result, noise_um, np.random.default_rng([seed, 1]))

    def write_fields(self, result: RunResult, folder: Path, shown: Mapping[str, Any], **asked: Any) -> list[Path]:
        """With a picture of the section at each position."""
        from wirewear.interior.lines import write_line_fields

        del shown
        return write_line_fields(result, folder, **asked | {"cycle": round(asked["cycle"])})

    def assessable(self, result: RunResult, body: str, cycle: float, asked: StrengthAsked) -> int:
        """Where contact forces are recorded, of a body that is large enough."""
        from wirewear.interior.lines import line_assessable

        return line_assessable(result, body, round(cycle), asked)

    def inner_states(self, result: RunResult, body: str, cycle: int) -> Sequence[InnerState[Any]]:
        """Where its nodes stand in the worn surface."""
        from wirewear.interior.lines import line_states

        return line_states(result, body, cycle)

    def strength(self, result: RunResult, body: str, cycle: int, asked: StrengthAsked) -> Strength:
        """At all positions of the cycle, averaged over discs."""
        from wirewear.interior.lines import line_strength

        return line_strength(result, body, cycle, asked)

    def drawings(self, results: Sequence[RunResult]) -> Mapping[str, Callable[[], Figure]]:
        """Profiles and loops of each run, and several side by side."""
        from wirewear.pictures.lines import line_drawings

        return line_drawings(results)
