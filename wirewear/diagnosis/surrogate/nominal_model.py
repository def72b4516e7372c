"""The nominal model of a test, by kind of contact: the study that stands for it, its wear states, and the fast model's
inputs.

Contacts at a point, line contacts and joints differ here, and nowhere above.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import atan, sqrt
from typing import ClassVar, Literal, TypeVar, cast

from wirewear.base.errors import RecordError
from wirewear.diagnosis.surrogate import nominal
from wirewear.diagnosis.surrogate.candidates import EXPECTED
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.line_states import LineStates
from wirewear.diagnosis.surrogate.nominal import ObserverOf, require_the_same, wears_evenly
from wirewear.diagnosis.surrogate.wear_states import JointStates, WearStates
from wirewear.effects import AnyEffect
from wirewear.records import AnyRecord, ExperimentRecord, LineRecord
from wirewear.records.contact_tables import AnyTables
from wirewear.reference import kept_approach
from wirewear.results import RunResult
from wirewear.results.scar import called
from wirewear.test import AnyStudy, LineStudy, Study
from wirewear.test.conditions import held_keys
from wirewear.test.gaps import Gap, hertz_of
from wirewear.test.study import JointStudy


def nominal_inputs(study: Study, drive: Literal["sensor", "stroke"]) -> SurrogateInputs:
    """The inputs that a study of a contact at a point states, with its effects and the freedoms at their usual values.
    drive: see `SurrogateInputs.of`. A study without wear has a wear coefficient of 0.
    """
    wear, friction = study.wear, study.contact.friction
    worn = 0.0 if wear is None else wear.volume_per_sliding_mm3_per_N_m(friction) / max(friction, 1e-9)
    setup = SurrogateInputs.of(study, drive, worn)
    load = study.conditions.normal_load_N
    gap, tables = Gap.like(load, *study.bodies), study.with_effects().tables
    fresh = hertz_of(load, *study.bodies).contact_radius_mm, gap.radius_mm / sqrt(gap.along)
    stated = [] if study.contact.plasticity == "none" else filter(None, tables.yields.values())
    kept = 1e3 * max((kept_approach(load, *fresh, stress) for stress, _ in stated), default=0.0)
    return replace(setup, crossing_error_rad=atan(gap.shear), print_um=kept, effects=study.effects, **EXPECTED)


def nominal_line_inputs(study: LineStudy, drive: Literal["sensor", "stroke"]) -> SurrogateInputs:
    """The inputs that a study of a line contact states, with its effects; drive: see `SurrogateInputs.of`."""
    setup = SurrogateInputs.of(study, drive, sum(study.energy_coefficients()), study.contact.length_mm)
    return replace(setup, effects=study.effects)


@dataclass(frozen=True)
class PointModel:
    """The study of a test in which two bodies touch at a point."""

    study: Study
    #: Whether a full simulation's worn surfaces are compared with measured ones.
    predicts_scars: ClassVar[bool] = False

    def of_record(self, record: ExperimentRecord) -> Study:
        """The study itself. Raises RecordError if its bodies, load, amplitude or held quantity differ from the record's
        test.
        """
        own, asked = self.study.conditions, record.tables.conditions
        bodies = zip(self.study.bodies, record.tables.bodies_of_test, strict=True)
        pairs = {
            **{
                f"diameter_mm of the {called(one.name)}": (min(one.diameters_mm), min(other.diameters_mm))
                for one, other in bodies
            },
            "normal_load_N": (own.normal_load_N, asked.normal_load_N),
            "displacement_amplitude_um": (own.displacement_amplitude_um, asked.displacement_amplitude_um),
            **{key: (getattr(own, key) or 0.0, getattr(asked, key) or 0.0) for key in held_keys(asked)},
        }
        require_the_same(record, self.study, pairs)
        return self.study

    def states(self, _tables: object, observer_of: ObserverOf | None) -> tuple[WearStates, tuple[str, ...]]:
        """Wear states of the study's nominal run, made now or kept from before, and sentences on what limits them.

        observer_of: see `nominal_run`. Raises StudyError or SolverError if the study cannot be run; RunError if its
        loops carry no force.
        """
        result = nominal.nominal_run(self.study, observer_of)
        return _of_run(WearStates.of_run(result), result, self.study), nominal.limits_of(result, self.study)

    def inputs(self, tables: AnyTables) -> SurrogateInputs:
        """The inputs of the fast model that the study states, with its effects and the freedoms at their usual values;
        of the record's `tables` the drive alone is taken.
        """
        return nominal_inputs(self.study, tables.conditions.drive)

    def with_effects(self, effects: Sequence[AnyEffect], amplitude_um: float, increments: int) -> Study:
        """The study with effects added to its own and another amplitude in µm. increments: number in a loop of
        quick runs, used if the study states none.
        """
        stated = self.study.fidelity("quick").increments_per_cycle or increments
        return self.study.with_effects(*self.study.effects, *effects).changed(
            {
                "fidelity": {"quick": {"increments_per_cycle": stated}},
                "conditions": {"displacement_amplitude_um": amplitude_um},
            }
        )


@dataclass(frozen=True)
class LineModel:
    """The study of a test of a pad on a specimen in plane strain."""

    study: LineStudy
    predicts_scars: ClassVar[bool] = True

    def of_record(self, record: LineRecord) -> LineStudy:
        """The study, of the record's length. Raises RecordError if it has variants, or its pad, load, amplitude or
        cycles differ from the record's test.
        """
        study = self.study.of_length(record.tables.contact.length_mm)
        if study.variant_names:
            names = ", ".join(study.variant_names)
            raise RecordError(f"the model {study.name!r} has variants ({names}): give a study of one of them.")
        own, asked = study.conditions, record.tables.conditions
        pairs = {
            "normal_load_N": (own.normal_load_N, asked.normal_load_N),
            "displacement_amplitude_um": (own.displacement_amplitude_um, asked.displacement_amplitude_um),
            "cycles": (own.cycles, asked.cycles),
        }
        for key in ("radius_mm", "face_half_width_mm", "edge_radius_mm"):
            stated, recorded = getattr(study.pad, key), getattr(record.tables.pad, key, None)
            if stated is not None or recorded is not None:
                pairs[key] = (stated or 0.0, recorded or 0.0)
        require_the_same(record, study, pairs)
        return study

    def states(self, tables: AnyTables, observer_of: ObserverOf | None) -> tuple[WearStates, tuple[str, ...]]:
        """Wear states of the study's nominal run over the record's length (1 mm if it states none), and sentences on
        what limits them. observer_of: see `nominal_run`. Raises as `PointModel.states` does.
        """
        result = nominal.nominal_run(self.study, observer_of, nominal.line_recipe)
        length_mm = tables.length_mm or 1.0
        states = LineStates.of_line(result, self.study.pad.profile, length_mm)
        states = _of_run(states, result.of_length(length_mm), self.study)
        return states, nominal.limits_of(result, self.study)

    def inputs(self, tables: AnyTables) -> SurrogateInputs:
        """The inputs of the fast model that the study states, with its effects; of the record's `tables` the drive
        alone is taken.
        """
        return nominal_line_inputs(self.study, tables.conditions.drive)

    def with_effects(self, effects: Sequence[AnyEffect], amplitude_um: float, _increments: int) -> LineStudy:
        """The study with effects added to its own and another amplitude in µm."""
        every = (*self.study.effects, *effects)
        return self.study.changed({"effects": every, "conditions": {"displacement_amplitude_um": amplitude_um}})


@dataclass(frozen=True)
class JointModel:
    """The study of a joint, whose states have a closed form; nothing is run."""

    study: JointStudy

    def of_record(self, record: AnyRecord) -> JointStudy:
        """The study itself. Raises RecordError if its load or amplitude differs from the record's test."""
        own, asked = self.study.conditions, record.tables.conditions
        keys = ("normal_load_N", "displacement_amplitude_um")
        require_the_same(record, self.study, {key: (getattr(own, key), getattr(asked, key)) for key in keys})
        return self.study

    def states(self, _tables: object, _observer_of: ObserverOf | None) -> tuple[WearStates, tuple[str, ...]]:
        """States of the joint as it is stated, and no sentences on limits of a nominal run, as nothing is run."""
        return JointStates.of_study(self.study), ()

    def inputs(self, tables: AnyTables) -> SurrogateInputs:
        """The inputs of the fast model that the study states, with its effects and no wear; of the record's `tables`
        the drive alone is taken.
        """
        setup = SurrogateInputs.of(self.study, tables.conditions.drive, 0.0)
        return replace(setup, effects=self.study.effects)


States = TypeVar("States", bound=WearStates)


def _of_run(states: States, result: RunResult, study: AnyStudy) -> States:
    """The states of a run, sliding under the friction of its layers and wearing as it does."""
    if not states.sticks and any(layer.friction is not None for own in study.layers.values() for layer in own):
        states = states.under_layers()
    return states if wears_evenly(study) else states.wearing_as(result)


NominalModel = PointModel | LineModel | JointModel


def nominal_model(study: AnyStudy) -> NominalModel:
    """The interface of the fast model to a study: `JointModel`, `LineModel` or `PointModel`, by its kind of contact."""
    if isinstance(study, JointStudy):
        return JointModel(study)
    return LineModel(study) if isinstance(study, LineStudy) else PointModel(cast("Study", study))
