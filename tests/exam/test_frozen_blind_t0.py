"""Frozen records of tier T0 are diagnosed again."""

from pathlib import Path

import pytest

from tests.exam.frozen_scores import require_no_lower_score


@pytest.mark.slow(minutes=4)
def test_the_diagnosis_scores_no_lower_on_t0_than_when_its_records_were_frozen(tmp_path: Path) -> None:
    require_no_lower_score("T0", tmp_path)
