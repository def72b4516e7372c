"""What the frozen scores of blind batches are compared with."""

from pathlib import Path

from studies.blind import frozen


def require_no_lower_score(tier: str, folder: Path) -> None:
    """The diagnosis scores no lower than when the records were frozen, all of the article's nominal test."""
    records = frozen.frozen_records((tier,), article_only=True)
    assert len(records) >= 15
    judgements = frozen.diagnosed(records, folder)
    assert frozen.complaints(records, judgements) == []
    # What the guard compares with was right, so it can fall. Gaps of about what is tolerated, one in twenty, are none.
    assert sum(one.points for one in records) >= 0.75 * len(records)
    assert sum(map(frozen.points_of, judgements)) >= 0.75 * len(records)
    assert sum(map(frozen.is_wrongly_named, judgements)) <= 2
