"""Contacts at a point as commands ask for them: of any two bodies, and of a ball on a flat."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from wirewear.base.errors import RecordError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from wirewear.diagnosis.model.nominal import ObserverOf
    from wirewear.diagnosis.model.setup import Setup
    from wirewear.diagnosis.model.wear_states import WearStates
    from wirewear.interior.state import InnerState
    from wirewear.interior.strength import Strength, StrengthAsked
    from wirewear.records import AnyRecord
    from wirewear.records.exporting import Surface
    from wirewear.records.importing.guessing import GuessedMapping
    from wirewear.records.tables import PointRecordTables
    from wirewear.results import RunResult
    from wirewear.study import Study
    from wirewear.study.template import Template


class AtAPoint:
    """What all contacts at a point have in common; each method is described by `Kind`."""

    inside_options: ClassVar[frozenset[str]] = frozenset(
        ("--body", "--integration-points", "--no-pictures", "--animate")
    )
    scatters: ClassVar[bool] = True
    foresees_scars: ClassVar[bool] = False
    bodies: ClassVar[tuple[str, str]]

    def write_beside(self, results: Sequence[RunResult], folder: Path) -> None:
        """The scars of each run over the cycles for ParaView."""
        from wirewear.results.flat import FOLDER_NAME, write_time_series

        for result in results:
            write_time_series(result, (folder if result.path is None else result.path.parent) / FOLDER_NAME)

    def write_meshes(self, study: Study, fidelity: str, folder: Path) -> list[Path]:
        """Both bodies."""
        from wirewear.simulation import write_meshes

        return write_meshes(study, fidelity, folder)

    @property
    def refined(self) -> Any:
        from wirewear.simulation import point_contact

        return point_contact(self.bodies)

    def checked_model(self, record: AnyRecord, study: Study) -> Study:
        """One of the same bodies, load and amplitude."""
        from wirewear.diagnosis.model.nominal import checked_model

        return checked_model(record, study)

    def states(
        self, study: Study, tables: PointRecordTables, observer_of: ObserverOf | None
    ) -> tuple[WearStates, tuple[str, ...]]:
        """Those of the nominal run, which may end early."""
        from wirewear.diagnosis.model.nominal import limits_of, nominal_run
        from wirewear.diagnosis.model.wear_states import WearStates
        from wirewear.study.bodies import Gap

        del tables
        Gap.of(*study.bodies)  # refused before it is run
        result = nominal_run(study, observer_of)
        return WearStates.of_run(result), limits_of(result, study)

    def setup(self, study: Study, tables: PointRecordTables) -> Setup:
        """With the fast model's numerical freedoms as expected."""
        from wirewear.diagnosis.model.candidates import nominal_setup

        return nominal_setup(study, tables.conditions.drive)

    def with_effects(
        self, study: Study, effects: Sequence[Any], length_mm: float, amplitude_um: float, increments: int
    ) -> Study:
        """Loops have the increments that quick runs state, if any."""
        del length_mm
        stated = study.fidelity("quick").increments_per_cycle or increments
        return study.with_effects(*study.effects, *effects).changed(
            {
                "fidelity": {"quick": {"increments_per_cycle": stated}},
                "conditions": {"displacement_amplitude_um": amplitude_um},
            }
        )

    def write_fields(self, result: RunResult, folder: Path, shown: Mapping[str, Any], **asked: Any) -> list[Path]:
        """With pictures and animations."""
        from wirewear.interior.writing import write_fields

        return write_fields(result, folder, **shown, **asked)

    def assessable(self, result: RunResult, body: str, cycle: float, asked: StrengthAsked) -> int:
        """Where contact forces are recorded, of a body that is thick enough."""
        from wirewear.interior.strength import assessable

        return assessable(result, body, cycle, asked)

    def inner_states(self, result: RunResult, body: str, cycle: int) -> Sequence[InnerState[Any]]:
        """Where its nodes stand in the worn surface."""
        from wirewear.interior.bodies import body_states

        return body_states(result, body, cycle)

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

    def surfaces(self, result: RunResult, noise_um: float, seed: int) -> Mapping[str, Surface]:
        """Scar maps in each body's own frame."""
        import numpy as np

        from wirewear.records.exporting import scar_surfaces

        return scar_surfaces(result, noise_um, np.random.default_rng([seed, 1]))

    def drawings(self, results: Sequence[RunResult]) -> Mapping[str, Callable[[], Figure]]:
        """Loops, evolution and scars."""
        from wirewear.pictures import drawings

        return drawings(results)


class AnyBodies(AtAPoint):
    """Two bodies of any shapes."""

    name: ClassVar[str] = "point-contact"
    names: ClassVar[tuple[str, ...]] = (name,)
    bodies: ClassVar[tuple[str, str]] = ("lower", "upper")
    options: ClassVar[frozenset[str]] = frozenset()
    rigid_N_per_mm: ClassVar[float] = 1e7

    @property
    def template(self) -> Template:
        from wirewear.study.points import ANY_BODIES

        return ANY_BODIES

    def guessed_mapping(self, *_: Any) -> GuessedMapping:
        """No options tell shapes; RecordError says so."""
        raise RecordError(
            f"no options tell the shapes of a {self.name}: write [contact] and [bodies] of a mapping yourself "
            "(docs/records.md), or take --kind ball-on-flat or crossed-wires."
        )


class BallOnFlat(AnyBodies):
    """A ball held above a flat."""

    name: ClassVar[str] = "ball-on-flat"
    names: ClassVar[tuple[str, ...]] = (name,)
    bodies: ClassVar[tuple[str, str]] = ("flat", "ball")
    options: ClassVar[frozenset[str]] = frozenset(("diameter_mm",))

    @property
    def template(self) -> Template:
        from wirewear.study.points import BALL

        return BALL

    def guessed_mapping(
        self, files: Sequence[Path], known: Mapping[str, Any], own: Mapping[str, float], pad: Mapping[str, float]
    ) -> GuessedMapping:
        """The ball may be of another material."""
        from wirewear.records.importing.guessing import ball_on_flat, guessed_mapping

        return guessed_mapping(files, dict(known), ball_on_flat(known, own, pad))
