"""The tests of a campaign side by side: what each shows, what is wrong with it, and which stand apart from the rest."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from wirewear.comparison.mapped_tests import MappedTest

#: Modified deviations from the median beyond which a test stands apart, and its scale: Iglewicz and Hoaglin, How to
#: detect and handle outliers (ASQC 1993).
APART, NORMAL = 3.5, 0.6745

FEWEST = 5  #: Tests without which none stands apart.
LEAST = 0.02  #: Of the median: deviations that matter to no one.


@dataclass(frozen=True)
class CampaignResult:
    """One test of a campaign. mapped: what its loops and scars show, None if `refused` says why they cannot be read.

    problems, notes: of the record and of its import, one sentence each. odd: figures in which it stands apart from the
    other tests. answer: the sentence of its diagnosis, "" without one.
    """

    name: str
    mapped: MappedTest | None = None
    refused: str = ""
    problems: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    odd: tuple[str, ...] = ()
    answer: str = ""
    #: Worn surfaces, maps or profiles, of each body's first repeat.
    surfaces: tuple[Any, ...] = ()

    @property
    def state(self) -> str:
        """ "not read", "problems", "apart" from other tests, or "good"."""
        if self.mapped is None:
            return "not read"
        return "problems" if self.problems else "apart" if self.odd else "good"


#: Figures by which tests are compared, in words; friction and wear rate do not follow load and stroke.
FIGURES: dict[str, Callable[[MappedTest], float]] = {
    "friction": lambda test: test.friction,
    "wear rate": lambda test: test.volume_mm3 / test.energy_J if test.energy_J > 0.0 else np.nan,
}


def with_outliers(tests: Sequence[CampaignResult]) -> list[CampaignResult]:
    """The tests with the figures in which they stand apart: friction, or worn volume over friction energy, more than
    3.5 modified deviations from the median of at least five tests, and more than 2 % of it.
    """
    odd: dict[str, tuple[str, ...]] = {}
    known = [(test.name, test.mapped) for test in tests if test.mapped is not None and not test.problems]
    for words, of in FIGURES.items():
        values = np.array([of(mapped) for _, mapped in known])
        if np.isfinite(values).sum() < FEWEST:
            continue
        middle = float(np.nanmedian(values))
        spread = max(float(np.nanmedian(np.abs(values - middle))) / NORMAL, LEAST / APART * abs(middle))
        for (name, _), value in zip(known, values, strict=True):
            if abs(value - middle) > APART * spread:
                odd[name] = (*odd.get(name, ()), f"{words} {value:.3g}, {middle:.3g} of the other tests")
    return [replace(test, odd=odd.get(test.name, ())) for test in tests]
