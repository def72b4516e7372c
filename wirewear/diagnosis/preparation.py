"""A record prepared once: checked for what can be diagnosed, with its nominal model, then reduced to observables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np

from wirewear.base.errors import RecordError, StudyError
from wirewear.diagnosis.observe.observed_record import repaired
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.nominal import ObserverOf, Stage, nominal_study
from wirewear.diagnosis.surrogate.nominal_model import nominal_model
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.effects import Seam, all_effects
from wirewear.records import AnyRecord, Remark
from wirewear.records.checking import remarks_of
from wirewear.test import AnyStudy

_NOT_STATED = (
    "[stated] gives no {}: what the record shows stands in for it, or the wear of steel on steel, so that no gap is "
    "seen there; state what you expected before the test to have it judged."
)


#: Wear states of a nominal run, inputs of the fast model, and sentences on what limits both.
Nominal: TypeAlias = tuple[WearStates, SurrogateInputs, tuple[str, ...]]


@dataclass(frozen=True, eq=False)
class ReducedRecord:
    """A record reduced to its observables, beside its nominal model.

    study, states, setup: the model, the wear states of its nominal run, and its inputs of the fast model. checked:
    remarks of `wirewear check`.
    """

    record: AnyRecord
    study: AnyStudy
    states: WearStates
    setup: SurrogateInputs
    observed: Observations
    checked: tuple[Remark, ...] = ()

    @property
    def unfit(self) -> tuple[str, ...]:
        """Names of the effects of specimens that the record's bodies cannot have, such as pads that are flattened."""
        found = []
        for name, kind in all_effects().items():
            if kind.seam is Seam.SPECIMENS:
                try:
                    self.study.with_effects(kind.sized("easy", self.setup.stated))
                except StudyError:
                    found.append(name)
        return tuple(found)


@dataclass(frozen=True, eq=False)
class PreparedRecord:
    """A record that can be diagnosed, and the study of its test, which has not been run."""

    record: AnyRecord  #: With friction and wear from its loops and scars where its owner states none.
    study: AnyStudy
    is_stated: bool  #: True if the study is made of the record's statements, False if it was given.
    #: Relative standard deviations of unstated quantities, by name.
    unknown: Mapping[str, float] = field(default_factory=dict)

    @property
    def assumed(self) -> str:
        """A sentence on the quantities that are not stated; "" if all are."""
        return _NOT_STATED.format(" and ".join(self.unknown)) if self.unknown else ""

    def nominal(self, observer_of: ObserverOf | None = None) -> Nominal:
        """Wear states of the study's nominal run, its inputs of the fast model, and sentences on what limits both.

        observer_of: makes the observer of a run from its name. Raises StudyError or SolverError if the study cannot be
        run.
        """
        tables, model = self.record.tables, nominal_model(self.study)
        states: Any
        states, limits = model.states(tables, observer_of)
        if self.is_stated and tables.doubts_bodies:
            states = replace(states, described=False)
            doubt = f"{states.doubts['compliance']:.2g} µm/N of compliance are in doubt"
            settled = "which height_mm of [pad] and [specimen] would settle"
            limits = (f"Where pad or specimen are held is not stated: {doubt}, {settled}.",)
        if self.unknown:
            states = replace(states, unknown=self.unknown)
            limits = (self.assumed, *limits)
        return states, model.inputs(tables), limits

    def reduced(
        self, observer_of: ObserverOf | None = None, stage: Stage = nullcontext, nominal: Nominal | None = None
    ) -> ReducedRecord:
        """Observables of the record, and its nominal model under the drive's measured motion.

        observer_of: makes the observer of a run from its name. stage: entered for each step of the work. nominal: what
        `nominal` returned before, of the same test. Raises
        RecordError if nothing can be concluded from the record, or no loop can be read; StudyError or SolverError if
        the study cannot be run.
        """
        with stage("checking the record"):
            checked = remarks_of(self.record)
        with stage("reducing the loops"):
            record, notes = repaired(self.record)
            observed = reduce(record)
        states, setup, limits = nominal or self.nominal(observer_of)
        observed = replace(observed, notes=(*limits, *notes, *observed.notes))
        return ReducedRecord(record, self.study, states, replace(setup, motion=observed.motion), observed, checked)


def prepared(
    record: AnyRecord, model: AnyStudy | None = None, further: Sequence[AnyRecord] = ()
) -> tuple[PreparedRecord, ...]:
    """A record with the study that it states, or with `model`, and after it further records of the same rig with their
    own.

    Of a programme, the block with the longest stroke comes first and its other blocks follow as further records do,
    unless a record is of one block already. Raises RecordError if a record states too little; if the model is of
    another test or kind of contact; if a further record is of another kind of contact, or holds the first one's own
    loops.
    """
    own, others = record.blocks(), [one for other in further for one in other.blocks()]
    first = _prepared(own[0], model)
    _require_of_one_rig(own[0], others)
    return first, *(_prepared(one, model) for one in own[1:]), *(_prepared(one, None) for one in others)


def _prepared(record: AnyRecord, model: AnyStudy | None) -> PreparedRecord:
    if model is None:
        unknown: dict[str, float] = {}
        if record.tables.missing:
            from wirewear.diagnosis.fit import completed

            record, unknown = completed(record)
        return PreparedRecord(record, nominal_study(record), is_stated=True, unknown=unknown)
    if model.contact_kind != record.contact_kind:
        raise RecordError(
            f'the model {model.name!r} is a study of kind "{model.kind}", but the record {record.name!r} is of '
            f"kind {record.contact_kind}."
        )
    return PreparedRecord(record, nominal_model(model).of_record(record), is_stated=False)


def _require_of_one_rig(record: AnyRecord, further: Sequence[AnyRecord]) -> None:
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
