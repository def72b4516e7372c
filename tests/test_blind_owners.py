"""Records whose owner states the scatter between tests."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from studies.blind import generator_of, make_batch
from studies.blind.errors import BlindError
from studies.blind.generators.cases import Case, planned_cases
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.owners import EARLIER_TESTS, OwnersWhoKnow, estimated
from wirewear import read_record

MODEL = IndependentModel(points=8)


def cases() -> list[Case]:
    return list(planned_cases(12, 5, MODEL.library, MODEL.outside, 2, MODEL.nominals))


@pytest.mark.slow
def test_the_stated_share_of_records_states_all_of_the_scatter_and_the_others_are_as_they_were() -> None:
    own = OwnersWhoKnow(MODEL, 0.5)
    stating = 0
    for case in cases():
        plain, made = MODEL.make(case).record, own.make(case).record
        stated = made.tables.scatter.model_dump(exclude_none=True)
        stating += bool(stated)
        assert len(stated) in (0, 5)
        assert made.tables.model_copy(update={"scatter": plain.tables.scatter}) == plain.tables
        assert all(
            np.array_equal(a.displacement_um, b.displacement_um) for a, b in zip(made.loops, plain.loops, strict=True)
        )
    assert 2 <= stating <= 10


def test_an_owner_states_the_same_whatever_effect_there_is() -> None:
    own = OwnersWhoKnow(MODEL, 1.0)
    case = next(one for one in cases() if one.kind == "single")
    without = replace(case, kind="none", ease=None, effects=())
    assert own.make(case).record.tables.scatter == own.make(without).record.tables.scatter


def test_what_an_owner_states_is_off_as_a_standard_deviation_of_ten_tests_is() -> None:
    nuisances, random = cases()[0].nuisances, np.random.default_rng(3)
    ratios = np.array([estimated(nuisances, random).wear for _ in range(2000)]) / nuisances.scatter.wear
    assert np.mean(ratios**2) == pytest.approx(1.0, abs=0.05)
    assert np.std(ratios) == pytest.approx(np.sqrt(0.5 / (EARLIER_TESTS - 1)), rel=0.1)


@pytest.mark.slow
def test_a_batch_says_in_how_many_records_scatter_is_stated_and_goes_on_with_the_same_share_only(
    tmp_path: Path,
) -> None:
    make_batch(tmp_path / "records", cases=3, seed=2, generator=OwnersWhoKnow(MODEL, 1.0), tests=2)
    manifest = (tmp_path / "records" / "manifest.json").read_text(encoding="utf-8")
    assert "stated in 100% of the records" in manifest
    assert read_record(tmp_path / "records" / "case_001").tables.scatter.wear is not None
    with pytest.raises(BlindError, match="other arguments"):
        make_batch(tmp_path / "records", cases=3, seed=2, generator=MODEL, tests=2)


def test_line_contacts_state_none() -> None:
    with pytest.raises(BlindError, match="state no scatter"):
        generator_of("L1", stated_scatter=0.5)
