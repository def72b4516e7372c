"""A fretting test as maps show it, measured or simulated."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from wirewear.views.regression import RegressionLine, line_through_origin, line_with_threshold

if TYPE_CHECKING:
    from wirewear.loops import LoopFigures
    from wirewear.records.metadata import Source
    from wirewear.views.run_maps import FreshContact

Regime = Literal["partial slip", "mixed", "gross slip"]

REGIMES: tuple[Regime, ...] = ("partial slip", "mixed", "gross slip")

#: Energies of tests must differ by this factor for a threshold to be told from their scatter.
LEAST_SPREAD = 1.5


@dataclass(frozen=True)
class SlidingMap:
    """Criteria of sliding of one cycle, means of the tests on fresh specimens: A = E_d/(4 δa Q*), B = E_d/(4 δ0 Q*)."""

    cycle: int
    energy_ratio: float
    system_free_ratio: float


@dataclass(frozen=True)
class WornTest:
    """Friction energy of one test on fresh specimens in J, and the volume that both bodies lost in mm³."""

    energy_J: float
    volume_mm3: float


@dataclass(frozen=True, eq=False)
class MappedTest:
    """One test, of one or several repeats.

    Attributes:
        name: its title.
        source: "measured" or "simulated", or "record" where a record does not say which.
        path: what it was read from.
        normal_load_N: mean of the loops' median load, or what was asked for.
        displacement_amplitude_um: δa, mean of all loops.
        slip_amplitude_um: δ0 at the first and at the last cycle.
        regime: "mixed" where some of its loops slide as a whole and others do not.
        sliding: criteria of sliding by cycle.
        worn: energy and volume of each repeat that tells both.
        cracks: "found" or "none", where the test's owner looked for them.
        contact: the fresh contact behind its rig; None where too little is known of it.
        friction: coefficient by geometry, mean of all loops; NaN where none slides.
        per_mm: whether load, energies and volumes are those of a millimetre of a line contact.
    """

    name: str
    source: Source | Literal["record"]
    path: str
    normal_load_N: float
    displacement_amplitude_um: float
    worn: tuple[WornTest, ...]
    slip_amplitude_um: tuple[float, float] = (float("nan"), float("nan"))
    regime: Regime = "partial slip"
    sliding: tuple[SlidingMap, ...] = ()
    cracks: str | None = None
    contact: FreshContact | None = None
    friction: float = float("nan")
    per_mm: bool = False

    @property
    def repeats(self) -> int:
        """Tests whose wear is known."""
        return len(self.worn)

    @property
    def energy_J(self) -> float:
        """Mean friction energy of a test; NaN where none is known."""
        return float(np.mean([one.energy_J for one in self.worn])) if self.worn else float("nan")

    @property
    def volume_mm3(self) -> float:
        """Mean worn volume of a test; NaN where none is known."""
        return float(np.mean([one.volume_mm3 for one in self.worn])) if self.worn else float("nan")


def regime_of(figures: Iterable[LoopFigures]) -> Regime:
    """Gross or partial slip of all loops, or mixed."""
    slides = {one.regime == "gross slip" for one in figures}
    if len(slides) == 2:
        return "mixed"
    return "gross slip" if slides == {True} else "partial slip"


def lines_of(tests: Iterable[MappedTest]) -> tuple[RegressionLine | None, RegressionLine | None]:
    """Worn volume over friction energy of all repeats: through the origin, and with a threshold energy.

    None where there is no test that tells both, or, for the threshold, where fewer than three or none that differ.
    """
    worn = [one for test in tests for one in test.worn if one.energy_J > 0.0]
    if not worn:
        return None, None
    energy, volume = (np.array([getattr(one, name) for one in worn]) for name in ("energy_J", "volume_mm3"))
    spread = energy.size >= 3 and float(energy.max() / energy.min()) > LEAST_SPREAD
    return line_through_origin(energy, volume), line_with_threshold(energy, volume) if spread else None
