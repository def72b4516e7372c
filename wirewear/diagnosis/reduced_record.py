"""A record as the fit sees it: mended, reduced, and beside the fast model on its nominal run."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, cast

from wirewear.diagnosis.beginning import Nominal, beginning_of
from wirewear.diagnosis.observe.corners import read_at_corners
from wirewear.diagnosis.observe.definitions import of_own_definitions
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.diagnosis.observe.spikes import without_spikes

if TYPE_CHECKING:
    from wirewear.records import ExperimentRecord
    from wirewear.records.line_values import LineRecord


def mended(record: ExperimentRecord | LineRecord) -> tuple[ExperimentRecord | LineRecord, tuple[str, ...]]:
    """The record with coarse loops at their corners, without spikes and without figures of other definitions; notes."""
    # Each of these takes either kind, and says so with a type variable, which takes no union.
    own, notes = of_own_definitions(cast("ExperimentRecord", record))
    read, note = read_at_corners(own)
    return without_spikes(read), ((note,) if note else ()) + notes


def reduced_record(record: ExperimentRecord | LineRecord) -> tuple[Nominal, Observations]:
    """What is believed of a record's test without any effect, under the drive that was measured, and what is observed.

    Raises:
        RecordError: the record states too little, or has no loops in gross slip.
        StudyError, SolverError: the nominal model cannot be run.
    """
    own, _ = mended(record)
    observed = reduce(own)
    nominal = beginning_of(record, None).run(None)
    return replace(nominal, setup=replace(nominal.setup, motion=observed.motion)), observed
