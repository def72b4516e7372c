"""The frozen records of a tier diagnosed again: of the article's nominal test, which share its nominal run.

A tier has a file of its own, so that tiers are diagnosed side by side; `python -m studies.blind.frozen` takes all.
"""

from pathlib import Path

from studies.blind.frozen import complaints, diagnosed, frozen_records, is_wrongly_named, points_of


def require_no_lower_score(tier: str, folder: Path) -> None:
    """The diagnosis scores no lower than when the records were frozen."""
    records = frozen_records((tier,), article_only=True)
    assert len(records) >= 15
    judgements = diagnosed(records, folder)
    assert complaints(records, judgements) == []
    # What the guard compares with was right, so it can fall. Gaps of about what is tolerated, one in twenty, are none.
    assert sum(one.points for one in records) >= 0.75 * len(records)
    assert sum(map(points_of, judgements)) >= 0.75 * len(records)
    assert sum(map(is_wrongly_named, judgements)) <= 2
