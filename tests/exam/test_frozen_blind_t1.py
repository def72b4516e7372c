"""Frozen records of tier T1 are diagnosed again."""

from pathlib import Path

import pytest

from tests.exam.frozen_scores import require_no_lower_score


@pytest.mark.slow(minutes=3)
def test_the_diagnosis_scores_no_lower_on_t1_than_when_its_records_were_frozen(tmp_path: Path) -> None:
    require_no_lower_score("T1", tmp_path)
