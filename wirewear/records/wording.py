"""Numbers and lists as they stand in sentences."""

from collections.abc import Mapping, Sequence

from wirewear.base.quantity import counted

MOST_LISTED = 8


def plural(count: int, noun: str) -> str:
    """``1 loop``, ``3 loops``."""
    return f"{counted(count)} {noun}{'' if count == 1 else 's'}"


def listed(values: Sequence[int]) -> str:
    """``1, 2, 3 and 12 more``."""
    shown = ", ".join(counted(value) for value in values[:MOST_LISTED])
    more = len(values) - MOST_LISTED
    return f"{shown} and {more} more" if more > 0 else shown


#: Conditions are rounded to this share of themselves, and alike within it.
ALIKE = 0.01


def unlike_conditions(
    pairs: Mapping[str, tuple[float | None, float | None]], cycles: tuple[float, float]
) -> str | None:
    """A sentence on the conditions in which a run and a record differ, by key; None where they are of one test.

    pairs: of the run and of the record, None where it says nothing.  cycles: a run may be the longer one.
    """
    differ = [
        f"{key} is {own:.4g} in the run and {other:.4g} in the record"
        for key, (own, other) in pairs.items()
        if own is not None and other is not None and abs(own - other) > ALIKE * max(abs(own), abs(other))
    ]
    if cycles[0] < cycles[1]:
        differ.append(f"the run ends after {cycles[0]:.9g} cycles and the record after {cycles[1]:.9g}")
    return f"The run and the record are not of the same test: {', '.join(differ)}." if differ else None
