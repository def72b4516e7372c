"""Line contacts as commands ask for them: studies and results are of one millimetre, records of the whole contact."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from wirewear.kinds.kind import Compared

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from rich.console import RenderableType

    from wirewear.interior.strength import Strength, StrengthAsked
    from wirewear.planar import PlanarStudy
    from wirewear.records import LineRecord
    from wirewear.records.as_heights import Surface
    from wirewear.records.importing.guessing import GuessedMapping
    from wirewear.records.line_comparing import LineComparison
    from wirewear.results import RunResult
    from wirewear.study.template import Template


class LineContacts:
    """A pad on a flat in plane strain; each method is described by `Kind`."""

    name: ClassVar[str] = "line-contact"
    names: ClassVar[tuple[str, ...]] = (name, "cylinder-on-flat")
    inside_options: ClassVar[frozenset[str]] = frozenset()
    scatters: ClassVar[bool] = False
    options: ClassVar[frozenset[str]] = frozenset(("length_mm", "radius_mm", "face_half_width_mm", "edge_radius_mm"))

    @property
    def template(self) -> Template:
        """A cylinder on a flat."""
        from wirewear.planar.tables import LINE_CONTACT

        return LINE_CONTACT

    def study_from_tables(self, tables: Mapping[str, Any], where: str) -> PlanarStudy:
        """A study of one millimetre."""
        from wirewear.planar import planar_study_from_tables

        return planar_study_from_tables(tables, where)

    def run(self, study: PlanarStudy, **asked: Any) -> list[RunResult]:
        """Results with their pictures."""
        from wirewear.planar import run_planar_variants

        return run_planar_variants(study, **asked)

    def write_meshes(self, study: PlanarStudy, fidelity: str, folder: Path) -> list[Path]:
        """Pad and specimen, and what holds them."""
        from wirewear.planar.supports import write_planar_meshes

        return write_planar_meshes(study, fidelity, folder)

    @property
    def refined(self) -> Any:
        """Meshes, positions, and jumps where it wears."""
        from wirewear.planar.run import LINES

        return LINES

    def tables_of(self, record: LineRecord) -> dict[str, Any]:
        """Of one millimetre."""
        from wirewear.fitting.study_of_record import tables_of_line_record

        return tables_of_line_record(record)

    def guessed_mapping(
        self, files: Sequence[Path], known: Mapping[str, Any], own: Mapping[str, float], pad: Mapping[str, float]
    ) -> GuessedMapping:
        """The specimen may be of another material than the pad."""
        from wirewear.records.importing.line_guessing import guessed_line_mapping

        return guessed_line_mapping(files, {**known, "specimen": own, "pad": pad})

    def surfaces(self, result: RunResult, noise_um: float, seed: int) -> Mapping[str, Surface]:
        """Profiles across the scar."""
        import numpy as np

        from wirewear.records.as_heights import profile_surfaces

        return profile_surfaces(result, noise_um, np.random.default_rng([seed, 1]))

    def comparison(self, result: RunResult, record: LineRecord) -> LineComparison:
        """Loops, evolution, and profiles moved onto one another."""
        from wirewear.records.line_comparing import compare_line

        return compare_line(result, record)

    def compared(self, result: RunResult, record: LineRecord) -> Compared:
        """Loops, evolution, and profiles moved onto one another."""
        from wirewear.records.line_comparing import line_differences_table, write_line_comparison

        comparison = self.comparison(result, record)
        aside = comparison.aside_um
        moved = [
            f"{left:.3g} µm rms are left between the profiles of the {body}, moved by {aside[body]:+.0f} µm"
            for body, left in comparison.left_um.items()
        ]
        shown: list[RenderableType] = [line_differences_table(comparison), *moved]
        return Compared(comparison.unlike, shown, lambda folder: write_line_comparison(comparison, folder))

    def write_fields(self, result: RunResult, folder: Path, shown: Mapping[str, Any], **asked: Any) -> list[Path]:
        """With a picture of the section at each position."""
        from wirewear.planar.fields import write_planar_fields

        del shown
        return write_planar_fields(result, folder, **asked | {"cycle": round(asked["cycle"])})

    def assessable(self, result: RunResult, body: str, cycle: float, asked: StrengthAsked) -> int:
        """Where contact forces are recorded, of a body that is large enough."""
        from wirewear.planar.fields import planar_assessable

        return planar_assessable(result, body, round(cycle), asked)

    def strength(self, result: RunResult, body: str, cycle: int, asked: StrengthAsked) -> Strength:
        """At all positions of the cycle, averaged over discs."""
        from wirewear.planar.fields import planar_strength

        return planar_strength(result, body, cycle, asked)

    def drawings(self, results: Sequence[RunResult]) -> Mapping[str, Callable[[], Figure]]:
        """Profiles and loops of each run, and several side by side."""
        from wirewear.planar.pictures import planar_drawings

        return planar_drawings(results)
