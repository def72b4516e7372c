"""Where a diagnosis begins: the nominal model of a record, its run, and the fast model on that run's wear states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from wirewear.base.errors import RecordError
from wirewear.diagnosis.model.candidates import nominal_line_setup, nominal_setup
from wirewear.diagnosis.model.line_nominal import checked_line_model, nominal_line_run, nominal_line_study
from wirewear.diagnosis.model.line_states import LineStates
from wirewear.diagnosis.model.nominal import ObserverOf, checked_model, limits_of, nominal_run, nominal_study
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.mending import mended
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.planar.tables import PlanarStudy
from wirewear.records import AnyRecord, LineRecord
from wirewear.records.checking import remarks_told
from wirewear.records.line_believed import doubts_bodies
from wirewear.study import Study

if TYPE_CHECKING:
    from wirewear.diagnosis.model.setup import Setup
    from wirewear.records import ExperimentRecord, LineRecord, Remark


def reduced_record(record: AnyRecord) -> tuple[Nominal, Observations]:
    """What is believed of a record's test without any effect, under the drive that was measured, and what is observed.

    Raises:
        RecordError: the record states too little, or has no loops in gross slip.
        StudyError, SolverError: the nominal model cannot be run.
    """
    own, _ = mended(record)
    observed = reduce(own)
    nominal = beginning_of(record, None).run(None)
    return replace(nominal, setup=replace(nominal.setup, motion=observed.motion)), observed


@dataclass(frozen=True, eq=False)
class Nominal:
    """What is believed of a record's test: the fast model's states and circumstances, and what limits them."""

    states: WearStates
    setup: Setup
    limits: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Beginning:
    """A nominal model that is yet to be run: its study, and what the record's check says."""

    study: Study | PlanarStudy
    check: Callable[[], tuple[Remark, ...]]
    run: Callable[[ObserverOf | None], Nominal]


def beginning_of(record: AnyRecord, model: Study | PlanarStudy | None) -> Beginning:
    """The nominal model of a record, or `model` if it is of the same test.

    Raises:
        RecordError: the record states too little, or the model is of another test, or of another kind of contact.
    """
    if model is not None and model.contact_kind != record.contact_kind:
        raise RecordError(
            f'the model {model.name!r} is a study of kind "{model.kind}", but the record {record.name!r} is of '
            f"kind {record.contact_kind}."
        )
    return _BEGINNINGS[record.contact_kind](record, model)


def _of_wires(record: ExperimentRecord, model: Study | None) -> Beginning:
    study = nominal_study(record) if model is None else checked_model(record, model)

    def run(observer_of: ObserverOf | None) -> Nominal:
        nominal = nominal_run(study, observer_of)
        setup = nominal_setup(study, record.tables.conditions.drive)
        return Nominal(WearStates.of_run(nominal), setup, limits_of(nominal))

    return Beginning(study, lambda: remarks_told(record), run)


def _of_line(record: LineRecord, model: PlanarStudy | None) -> Beginning:
    study = nominal_line_study(record) if model is None else checked_line_model(record, model)
    length = record.tables.contact.length_mm

    def run(observer_of: ObserverOf | None) -> Nominal:
        states = LineStates.of_line(nominal_line_run(study, observer_of), study.pad.profile, length)
        setup = nominal_line_setup(study, length, record.tables.conditions.drive)
        if model is not None or not doubts_bodies(record.tables):
            return Nominal(states, setup)
        states = replace(states, described=False)
        told = f"Where pad or specimen are held is not stated: {states.doubts['compliance']:.2g} µm/N of compliance are"
        return Nominal(states, setup, (f"{told} in doubt, which height_mm of [pad] and [specimen] would settle.",))

    return Beginning(study, lambda: remarks_told(record), run)


_BEGINNINGS: dict[str, Callable[[Any, Any], Beginning]] = {"crossed-wires": _of_wires, "line-contact": _of_line}
