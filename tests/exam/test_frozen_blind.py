"""Records of spent blind batches guard the diagnosis' score; test_frozen_blind_t*.py diagnose them again.

A tier has a file of its own, so that tiers are diagnosed side by side; `python -m studies.blind.frozen` takes all.
"""

from pathlib import Path

import pytest

from studies.blind import TIERS, frozen
from studies.blind.generators.cases import planned_cases
from studies.blind.generators.finite_element.model import FiniteElementModel
from studies.blind.generators.generator import Generator
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.scoring.judging import judged
from tests.exam.blind_batches import answer, perfect
from wirewear import read_record

#: Number of cases, seed and number of nominal tests of the batches that frozen records come from; the article's test
#: has at least so large a share of the cases.
BATCHES = {
    "T0_third": (40, 118823, 2),
    "T1_third": (100, 651908, 2),
    "T1_fourth": (40, 905112, 2),
    "T2_third": (60, 733201, 3),
}
REFERENCE_SHARE = 0.4


@pytest.mark.parametrize("tier", TIERS)
def test_each_tier_has_twenty_records_of_every_kind(tier: str) -> None:
    records = frozen.frozen_records((tier,))
    assert len(records) >= 20
    assert {one.truth.kind for one in records} == {"none", "single", "pair", "outside", "left_out"}
    effects = {effect for one in records if one.truth.kind == "single" for effect in one.truth.effects}
    assert len(effects) >= 10


@pytest.mark.parametrize(
    "model",
    [FiniteElementModel("T0"), FiniteElementModel("T1"), IndependentModel("weakening")],
    ids=lambda model: model.tier,
)
def test_the_truth_of_a_frozen_record_is_what_the_seed_of_its_batch_draws(model: Generator) -> None:
    planned = {
        f"{batch}-{case.name}": case
        for batch, (count, seed, tests) in BATCHES.items()
        if batch.startswith(model.tier)
        for case in planned_cases(
            count, seed, model.library, model.outside, tests, model.nominals, reference_share=REFERENCE_SHARE
        )
    }
    for one in frozen.frozen_records((model.tier,)):
        case = planned[one.name]
        assert {effect.effect: effect.parameters for effect in case.effects} == one.truth.parameters
        assert (case.kind, case.left_out) == (one.truth.kind, one.left_out)


def test_the_archives_hold_records(tmp_path: Path) -> None:
    records = frozen.frozen_records()
    frozen.unpack(records, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {one.name for one in records}
    for one in records[::10]:
        assert read_record(tmp_path / one.name).loops


def test_one_new_false_alarm_is_a_complaint() -> None:
    records = frozen.frozen_records()
    alarmed = next(one for one in records if one.truth.kind == "none")
    said = [
        answer("explained", {"free_play": 0.9}) if one is alarmed else perfect(one.truth) for one in records
    ]  # fmt: skip
    judgements = [judged(one.truth, own) for one, own in zip(records, said, strict=True)]
    assert frozen.complaints(records, judgements) == [
        f"{alarmed.name} has no gap, and now a false alarm: explained, free_play 0.90."
    ]
