"""A record of the wires reduced, and the nominal run that it is set beside, as a diagnosis takes both."""

from __future__ import annotations

from pathlib import Path

from wirewear import read_record
from wirewear.diagnosis.model.candidates import nominal_setup
from wirewear.diagnosis.model.nominal import nominal_run, nominal_study
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.corners import read_at_corners
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.diagnosis.observe.spikes import without_spikes


def reduced_record(path: Path) -> tuple[WearStates, Setup, Observations]:
    """States of the nominal run, the circumstances that the record states, and what is observed of it.

    Raises:
        WirewearError: the record cannot be read or its nominal model not be run.
    """
    record, _ = read_at_corners(read_record(path))
    study = nominal_study(record)
    states = WearStates.of_run(nominal_run(study))
    return states, nominal_setup(study, record.tables.conditions.drive), reduce(without_spikes(record))
