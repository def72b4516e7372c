"""Crossed wires as commands ask for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from wirewear.kinds.kind import Compared, Imported

if TYPE_CHECKING:
    from wirewear.records import ExperimentRecord, RecordReport
    from wirewear.records.as_heights import Surface
    from wirewear.records.importing.guessing import GuessedMapping
    from wirewear.results import RunResult
    from wirewear.study import Study
    from wirewear.study.template import Template


class CrossedWires:
    """Two round wires that cross; each method is described by `Kind`."""

    name: ClassVar[str] = "crossed-wires"
    names: ClassVar[tuple[str, ...]] = (name,)
    scatters: ClassVar[bool] = True
    options: ClassVar[frozenset[str]] = frozenset(("diameter_mm", "crossing_angle_deg"))

    def holds(self, _path: Path) -> bool:
        """Whatever no other kind holds."""
        return True

    @property
    def template(self) -> Template:
        """The article's test."""
        from wirewear.study.template import CROSSED_WIRES

        return CROSSED_WIRES

    def study_from_tables(self, tables: Mapping[str, Any], where: str) -> Study:
        """A study of crossed wires."""
        from wirewear.study import study_from_tables

        return study_from_tables(tables, where)

    def run(self, study: Study, **asked: Any) -> list[RunResult]:
        """Results, and the scars over the cycles for ParaView beside each."""
        from wirewear.results.vtk import FOLDER_NAME, write_time_series
        from wirewear.simulation import run_study

        results = run_study(study, **asked)
        for result in results:
            if result.path is not None:
                write_time_series(result, result.path.parent / FOLDER_NAME)
        return results

    def write_meshes(self, study: Study, fidelity: str, folder: Path) -> list[Path]:
        """Both wires."""
        from wirewear.simulation import write_meshes

        return write_meshes(study, fidelity, folder)

    @property
    def refined(self) -> Any:
        """Meshes, positions and jumps."""
        from wirewear.simulation import WIRES

        return WIRES

    def read_record(self, path: Path) -> ExperimentRecord:
        """A record of format 1."""
        from wirewear.records import read_record

        return read_record(path)

    def check(self, record: ExperimentRecord) -> RecordReport:
        """Loops, evolution and scars."""
        from wirewear.records import check_record

        return check_record(record)

    def write_record(self, folder: Path, record: ExperimentRecord) -> Path:
        """The same, written."""
        from wirewear.records import write_record

        return write_record(folder, record)

    def tables_of(self, record: ExperimentRecord) -> dict[str, Any]:
        """Of the whole test."""
        from wirewear.fitting.study_of_record import tables_of_record

        return tables_of_record(record)

    def guessed_mapping(
        self, files: Sequence[Path], known: Mapping[str, Any], own: Mapping[str, float], pad: Mapping[str, float]
    ) -> GuessedMapping:
        """Wires are alike; there is no pad."""
        from wirewear.records.importing.guessing import guessed_mapping

        del pad
        return guessed_mapping(files, {**known, **own})

    def imported(self, mapping_path: Path) -> Imported:
        """With a picture of the first loop, and of the scars."""
        from wirewear.records.importing import import_record
        from wirewear.records.importing.first_loop import draw_first_loop, draw_scars, first_loop_text

        record = import_record(mapping_path)

        def draw(output: Path) -> list[Path]:
            loop = output.with_name(f"{output.name}_first_loop.png")
            return [draw_first_loop(record.loops[0], loop), *draw_scars(record, output)]

        return Imported(record, first_loop_text(record), draw)

    def record_of(self, result: RunResult, length_mm: float | None, reading: Mapping[str, Any]) -> ExperimentRecord:
        """Wires have no length of contact."""
        from wirewear.base.errors import RecordError
        from wirewear.records import record_of_result

        if length_mm is not None:
            raise RecordError(f"--length does not apply to {result.label}, which is a run of crossed wires.")
        return record_of_result(result, **reading)

    def surfaces(self, result: RunResult, noise_um: float, seed: int) -> Mapping[str, Surface]:
        """Scar maps in each wire's own frame."""
        import numpy as np

        from wirewear.records.as_heights import scar_surfaces

        return scar_surfaces(result, noise_um, np.random.default_rng([seed, 1]))

    def compared(self, result: RunResult, record: ExperimentRecord) -> Compared:
        """Loops, evolution and scars."""
        from wirewear.views.comparison import compare
        from wirewear.views.comparison_writing import differences_table, write_comparison

        comparison = compare(result, record)
        return Compared(
            comparison.unlike, [differences_table(comparison)], lambda folder: write_comparison(comparison, folder)
        )
