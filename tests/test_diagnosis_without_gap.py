"""Where a record lies among records without a gap."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import kstest

from studies.diagnosis.gap_free_chances import Chance, gap_free_cases, written
from wirewear.diagnosis.calibration import FILE, sources
from wirewear.diagnosis.infer.without_gap import LEFT, share_beyond


def test_records_like_those_it_was_learned_on_have_uniform_shares() -> None:
    drawn = np.random.default_rng(3).choice(LEFT, 400) + np.random.default_rng(4).normal(0.0, 0.002, 400)
    assert kstest([share_beyond(left) for left in drawn], "uniform").pvalue > 0.05


def test_a_record_that_leaves_more_is_the_rarer_and_none_is_impossible() -> None:
    shares = [share_beyond(left) for left in (0.0, *LEFT, 50.0)]
    assert np.all(np.diff(shares) <= 0.0)
    assert shares[0] < 1.0
    assert shares[-1] == pytest.approx(1.0 / (LEFT.size + 1.0))


def test_as_many_records_of_finite_elements_as_of_the_independent_model_taught_it() -> None:
    assert LEFT.size == 120
    assert "sixty by finer finite elements" in sources()["gap_free_left"]["what"]


def test_what_gap_free_records_leave_is_written_sorted_with_its_commit() -> None:
    found = [Chance("b", 200, 250.0, {}), Chance("a", 100, 80.0, {})]
    entry = tomllib.loads(written(FILE.read_text(encoding="utf-8"), found, "abcdef0"))["infer"]["without_gap"]["left"]
    assert entry == {"value": [0.8, 1.25], "unit": "1", "source": "gap_free_left", "commit": "abcdef0"}


def test_a_score_tells_which_records_have_no_gap(tmp_path: Path) -> None:
    lines = [{"case": "case_001", "kind": "none"}, {"case": "case_002", "kind": "single"}]
    score = tmp_path / "score.json"
    score.write_text(json.dumps({"lines": lines}), encoding="utf-8")
    assert gap_free_cases(score) == {"case_001"}
