"""Where a diagnosis begins: the nominal model of a record, its run, and the fast model on that run's wear states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from wirewear.base.errors import RecordError
from wirewear.diagnosis.model.nominal import ObserverOf, nominal_study
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.mending import mended
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.kinds import kind_of
from wirewear.records import AnyRecord

if TYPE_CHECKING:
    from wirewear.diagnosis.model.setup import Setup
    from wirewear.planar.tables import PlanarStudy
    from wirewear.study import Study


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
    """A nominal model that is yet to be run: its study, and how that is done."""

    study: Study | PlanarStudy
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
    kind, tables = kind_of(record), record.tables
    study = nominal_study(record) if model is None else kind.checked_model(record, model)

    def run(observer_of: ObserverOf | None) -> Nominal:
        states: Any
        states, limits = kind.states(study, tables, observer_of)
        if model is None and tables.doubts_bodies:
            states = replace(states, described=False)
            told = f"Where pad or specimen are held is not stated: {states.doubts['compliance']:.2g} µm/N of compliance"
            limits = (f"{told} are in doubt, which height_mm of [pad] and [specimen] would settle.",)
        return Nominal(states, kind.setup(study, tables), limits)

    return Beginning(study, run)


def require_of_one_rig(record: AnyRecord, further: Sequence[AnyRecord]) -> None:
    """Further records must be of the same kind of contact, and measurements of their own.

    Raises:
        RecordError: one is not.
    """
    for other in further:
        if other.contact_kind != record.contact_kind:
            raise RecordError(
                f"{other.name!r} is a record of kind {other.contact_kind}, {record.name!r} of kind "
                f"{record.contact_kind}: a further record must be of the same rig."
            )
        if any(np.array_equal(a.tangential_force_N, b.tangential_force_N) for a in record.loops for b in other.loops):
            raise RecordError(
                f"{other.name!r} holds loops of {record.name!r}: a record with what was measured later of the same "
                "test is diagnosed alone."
            )
