"""Heat of friction and debris as causes: where they are weighed, what is distinguished from them and by what."""

from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest

from tests.diagnosis import diagnosis_cases
from tests.diagnosis.diagnosis_cases import concluded, diagnosed, nominal, record, states, tables
from tests.exam.frozen_states import frozen_states
from tests.exam.independent_records import independent_record
from wirewear.diagnosis.answer import Diagnosis
from wirewear.diagnosis.infer.families import FAMILIES, PROFILE_FAMILIES
from wirewear.diagnosis.infer.resembling import MADE_BY
from wirewear.diagnosis.infer.search import search, updated
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.record_diagnosis import judged
from wirewear.diagnosis.surrogate.candidates import library
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.nominal import nominal_study
from wirewear.diagnosis.surrogate.nominal_model import nominal_inputs
from wirewear.effects.effect import Chain, LineChain
from wirewear.records import ExperimentRecord, RecordTables

HEAT = {"conductivity_W_per_m_K": 20.0, "heat_capacity_J_per_cm3_K": 2.4, "friction_per_K": -1.5e-3}


def at(frequency_Hz: float, drive: str = "sensor", **stated: float | str) -> RecordTables:
    known = tables(drive, **stated)
    return known.model_copy(update={"conditions": known.conditions.model_copy(update={"frequency_Hz": frequency_Hz})})


def rubbed(frequency_Hz: float, *, seed: int = 1) -> ExperimentRecord:
    """A record of wires whose friction falls as they warm: by 50 K at 1000 Hz."""
    with patch.object(diagnosis_cases, "tables", lambda *own, **stated: at(frequency_Hz, *own, **stated)):
        return record({"friction_heat": HEAT}, seed=seed)


def inputs_of(one: ExperimentRecord) -> SurrogateInputs:
    return nominal_inputs(nominal_study(one), one.tables.conditions.drive)


def answer(first: ExperimentRecord, *further: ExperimentRecord) -> Diagnosis:
    found = search(states(), inputs_of(first), reduce(first))
    for other in further:
        found = updated(found, states(), inputs_of(other), reduce(other))
    return judged(first, nominal_study(first), states(), reduce(first), found, further).diagnosis


def test_heat_is_weighed_only_where_surfaces_warm() -> None:
    cold, warm = (
        {one.name for one in library(replace(nominal(), frequency_Hz=hertz), states())} for hertz in (3.0, 1000.0)
    )
    assert warm - cold == {"friction_heat", "holder_inertia"}


def test_what_follows_temperature_is_as_uncertain_as_the_conductivity() -> None:
    setup = replace(nominal(), frequency_Hz=1000.0)
    heat = next(one for one in library(setup, states()) if one.name == "friction_heat")
    assert set(heat.parameters) == {"wear_kJ_per_mol", "friction_per_K"}
    for name in heat.parameters:
        assert heat.unknown_spread(name, 0.0) == 0.0
        assert heat.unknown_spread(name, 1.0) == pytest.approx(np.log(400.0) / 3.92)


def test_a_line_contact_warms_as_a_rectangle_and_a_square_as_a_disc() -> None:
    setup = replace(nominal(), effects=())
    disc = setup.chain(1e3, 1e4, *np.zeros((3, 1)))
    line = replace(setup, length_mm=0.1).chain(1e3, 1e4, *np.zeros((3, 1)))
    assert isinstance(disc, Chain)
    assert isinstance(line, LineChain)
    assert line.warming_per_um == pytest.approx(disc.warming_per_um, rel=0.02)
    assert line.edge_um == pytest.approx(25.0)
    # Of a long strip (Carslaw & Jaeger, § 10.5): ln(4 l/b) + 1/2 over 2 π l, with the half-width b and half-length l.
    strip = replace(setup, length_mm=10.0).chain(1e3, 1e6, *np.zeros((3, 1)))
    assert strip.warming_per_um == pytest.approx((np.log(2.0 * 100.0) + 0.5) / (np.pi * 1e4), rel=0.01)


def test_sentences_on_what_acts_as_a_family_are_on_families() -> None:
    assert set(MADE_BY) <= {one.name for one in (*FAMILIES, *PROFILE_FAMILIES)}


@pytest.mark.slow
def test_a_record_at_a_tenth_of_the_frequency_tells_heat_from_friction_that_runs_in() -> None:
    first = rubbed(1000.0)
    alone = answer(first)
    assert alone.verdict == "explained"
    assert {"friction_heat", "friction_evolution"} <= set(alone.equivalent[0])
    assert alone.next_measurement is not None
    assert alone.next_measurement["what"] == "the same test at a tenth of the frequency"
    both = answer(first, rubbed(100.0, seed=2))
    assert both.equivalent == ()
    assert both.causes[0].effect == "friction_heat"
    assert both.causes[0].probability > 0.95


@pytest.mark.slow
@pytest.mark.parametrize(("cause", "size"), [
    ("debris_ridge", {"force_N": 0.12, "begins": 0.5, "cycles": 3e4}), ("lopsided_wear", {"slant": 0.6}),
])  # fmt: skip
def test_debris_at_one_end_is_no_effect_but_named_with_what_would_tell(cause: str, size: dict[str, float]) -> None:
    one = independent_record({cause: size}, scars=True)
    found = concluded(one, nominal_study(one), frozen_states(), reduce(one))
    assert found.diagnosis.verdict == "unexplained"
    assert "debris is cleaned" in found.diagnosis.resembles[0].text
    # Debris that leaves is weighed where worn depths show it, not by loops alone.
    assert ("debris_balance",) in {single.names for single in found.search.singles}
    assert ("debris_balance",) not in {single.names for single in diagnosed(record()).search.singles}
