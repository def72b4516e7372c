"""Crossed wires as commands ask for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from wirewear.kinds.points import AtAPoint

if TYPE_CHECKING:
    from wirewear.diagnosis.model.nominal import ObserverOf
    from wirewear.diagnosis.model.setup import Setup
    from wirewear.diagnosis.model.wear_states import WearStates
    from wirewear.records import ExperimentRecord, RecordTables
    from wirewear.records.importing.guessing import GuessedMapping
    from wirewear.study import Study
    from wirewear.study.template import Template


class CrossedWires(AtAPoint):
    """Two round wires that cross; each method is described by `Kind`."""

    name: ClassVar[str] = "crossed-wires"
    names: ClassVar[tuple[str, ...]] = (name,)
    bodies: ClassVar[tuple[str, str]] = ("moving", "fixed")
    options: ClassVar[frozenset[str]] = frozenset(("diameter_mm", "crossing_angle_deg"))
    rigid_N_per_mm: ClassVar[float] = 1e6

    @property
    def template(self) -> Template:
        """The article's test."""
        from wirewear.study.template import CROSSED_WIRES

        return CROSSED_WIRES

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
        from wirewear.records.importing.guessing import crossed_wires, guessed_mapping

        del pad
        return guessed_mapping(files, dict(known), crossed_wires(known, own))
