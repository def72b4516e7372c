"""Crossed wires as commands ask for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from wirewear.diagnosis.model.nominal import ObserverOf
    from wirewear.diagnosis.model.setup import Setup
    from wirewear.diagnosis.model.wear_states import WearStates
    from wirewear.interior.strength import Strength, StrengthAsked
    from wirewear.records import ExperimentRecord, RecordTables
    from wirewear.records.as_heights import Surface
    from wirewear.records.importing.guessing import GuessedMapping
    from wirewear.results import RunResult
    from wirewear.study import Study
    from wirewear.study.template import Template


class CrossedWires:
    """Two round wires that cross; each method is described by `Kind`."""

    name: ClassVar[str] = "crossed-wires"
    names: ClassVar[tuple[str, ...]] = (name,)
    inside_options: ClassVar[frozenset[str]] = frozenset(
        ("--body", "--integration-points", "--no-pictures", "--animate")
    )
    scatters: ClassVar[bool] = True
    options: ClassVar[frozenset[str]] = frozenset(("diameter_mm", "crossing_angle_deg"))
    rigid_N_per_mm: ClassVar[float] = 1e6

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
        """Results of whole wires."""
        from wirewear.simulation import run_study

        return run_study(study, **asked)

    def write_beside(self, results: Sequence[RunResult], folder: Path) -> None:
        """The scars of each run over the cycles for ParaView."""
        from wirewear.results.vtk import FOLDER_NAME, write_time_series

        for result in results:
            write_time_series(result, (folder if result.path is None else result.path.parent) / FOLDER_NAME)

    def write_meshes(self, study: Study, fidelity: str, folder: Path) -> list[Path]:
        """Both wires."""
        from wirewear.simulation import write_meshes

        return write_meshes(study, fidelity, folder)

    @property
    def refined(self) -> Any:
        """Meshes, positions and jumps."""
        from wirewear.simulation import WIRES

        return WIRES

    def checked_model(self, record: ExperimentRecord, study: Study) -> Study:
        """One of the same wires, load and amplitude."""
        from wirewear.diagnosis.model.nominal import checked_model

        return checked_model(record, study)

    def states(
        self, study: Study, tables: RecordTables, observer_of: ObserverOf | None
    ) -> tuple[WearStates, tuple[str, ...]]:
        """Those of the nominal run, which may end early."""
        from wirewear.diagnosis.model.nominal import limits_of, nominal_run
        from wirewear.diagnosis.model.wear_states import WearStates

        del tables
        result = nominal_run(study, observer_of)
        return WearStates.of_run(result), limits_of(result)

    def setup(self, study: Study, tables: RecordTables) -> Setup:
        """With the fast model's numerical freedoms as expected."""
        from wirewear.diagnosis.model.candidates import nominal_setup

        return nominal_setup(study, tables.conditions.drive)

    def guessed_mapping(
        self, files: Sequence[Path], known: Mapping[str, Any], own: Mapping[str, float], pad: Mapping[str, float]
    ) -> GuessedMapping:
        """Wires are alike; there is no pad."""
        from wirewear.records.importing.guessing import guessed_mapping

        del pad
        return guessed_mapping(files, {**known, **own})

    def surfaces(self, result: RunResult, noise_um: float, seed: int) -> Mapping[str, Surface]:
        """Scar maps in each wire's own frame."""
        import numpy as np

        from wirewear.records.as_heights import scar_surfaces

        return scar_surfaces(result, noise_um, np.random.default_rng([seed, 1]))

    def write_fields(self, result: RunResult, folder: Path, shown: Mapping[str, Any], **asked: Any) -> list[Path]:
        """With pictures and animations."""
        from wirewear.interior.writing import write_fields

        return write_fields(result, folder, **shown, **asked)

    def assessable(self, result: RunResult, body: str, cycle: float, asked: StrengthAsked) -> int:
        """Where contact forces are recorded, of a wire that is thick enough."""
        from wirewear.interior.strength import assessable

        return assessable(result, body, cycle, asked)

    def strength(self, result: RunResult, body: str, cycle: int, asked: StrengthAsked) -> Strength:
        """At all positions of the cycle."""
        from wirewear.interior.strength import strength_of

        return strength_of(
            result,
            body,
            cycle,
            yield_strength_MPa=asked.yield_strength_MPa,
            crossland_slope=asked.crossland_slope,
            averaging_length_um=asked.averaging_length_um,
        )

    def drawings(self, results: Sequence[RunResult]) -> Mapping[str, Callable[[], Figure]]:
        """Loops, evolution and scars."""
        from wirewear.pictures import drawings

        return drawings(results)
