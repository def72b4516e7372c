"""Result types of a loop analysis: figures, which are quantities read from a loop, with 95 % intervals.

Symbols: Q tangential force, Q* its amplitude, P normal force, µ friction, δa displacement amplitude, δ0 slip amplitude,
E_d dissipated energy. An interval is open above if it ends at infinity.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from math import prod
from typing import Literal

import numpy as np

from geometry.arrays import Array, BoolArray
from wirewear.base.errors import WirewearError

Regime = Literal["stick", "partial slip", "gross slip", "contact opened"]
RegimeOfTest = Literal["partial slip", "mixed", "gross slip"]

COARSE = 0.95  #: Where it cannot be closer, a search leaves so much between what it finds and the least that µP may be.
WITHIN95 = 3.84  #: χ² of one number with a probability of 95 %.
KEPT = 25.0  #: What is farther off than this is forgotten.


class LoopError(WirewearError):
    """A force–displacement loop cannot be analysed."""


@dataclass(frozen=True)
class Measured:
    """A value and the interval that contains the true one with a probability of 95 %."""

    value: float
    interval95: tuple[float, float]

    @classmethod
    def from_deviation(cls, value: float, deviation: float) -> "Measured":
        """Value with the interval ± 1.96 standard deviations."""
        return cls(float(value), (float(value - 1.96 * deviation), float(value + 1.96 * deviation)))

    @property
    def deviation(self) -> float:
        """Standard deviation of a normal distribution with this 95 % interval."""
        return (self.interval95[1] - self.interval95[0]) / 3.92

    def reaching(self, other: float) -> "Measured":
        """Copy of the value with its interval widened, both ways, by the distance to `other`: another estimate of it,
        which the interval then covers with the same uncertainty.
        """
        return Measured.from_deviation(self.value, self.deviation + abs(other - self.value) / 1.96)

    def over(self, *divisors: "Measured", times: float = 1.0) -> "Measured":
        """This value times `times` over the product of the divisors, none 0, whose errors count as independent."""
        share = times / prod(one.value for one in divisors)
        parts = [share * self.deviation, *(share * self.value * one.deviation / one.value for one in divisors)]
        return Measured.from_deviation(share * self.value, float(np.linalg.norm(parts)))


def mean_of(one: Measured, other: Measured) -> Measured:
    """Mean of two measured values whose errors are independent."""
    return Measured.from_deviation(
        0.5 * (one.value + other.value), 0.5 * float(np.hypot(one.deviation, other.deviation))
    )


@dataclass(frozen=True)
class MicroSlipBranch:
    """A branch just after a reversal, with the line fitted over the first half of its micro-slip."""

    direction: Literal[1, -1]  #: +1 when the displacement grows along the branch, −1 when it falls.
    stiffness_N_per_um: Measured  #: Slope of the fitted line.
    intercept_N: float  #: Force of the fitted line at zero displacement (of the input's axis).
    displacement_um: tuple[float, float]  #: Displacements at the two ends of the fitted part, in order of travel.
    micro_slip_travel_um: float  #: Travel from the reversal to the onset of gross slip (or to the next reversal).
    samples: tuple[int, ...]  #: Indices of the fitted samples in the input arrays, in order of travel.


@dataclass(frozen=True)
class StickSlip:
    """Stick-slip on the plateaus of a sliding loop."""

    share: float  #: Part of the sliding samples that lie between slips.
    slips_per_cycle: int  #: How often the force falls in one cycle.
    frequency_Hz: float | None  #: Slips per second of sliding; None where no times are known.
    force_drop_share: Measured  #: Median fall of the force over the sliding force.
    resolved: bool  #: True if samples are dense enough to count all slips.


@dataclass(frozen=True, eq=False)
class Sticking:
    """Candidate contacts (n,) in partial slip that would leave the measured loop; chi_squared: χ² of the difference
    between each one's loop and the measured one, less that of the best candidate.
    """

    chi_squared: Array
    limit_N: Array  #: Friction limit µP.
    deviation_N: Array  #: Standard deviation of µP if all other parameters were known.
    share: Array  #: Q*/µP; 1 where the contact slides.
    contact_um_per_N: Array  #: Compliance of the fully sticking contact; 0 for parallel cylinders.
    rig_um_per_N: Array  #: Compliance of bodies and rig, in series.
    unseen: BoolArray  #: True if the loop does not show that the contact slips at all.
    load_N: Measured | None  #: Constant normal load; None if unknown.
    #: True if the annulus that slips may have worn. Pressure then concentrates on what sticks, branches straighten, and
    #: the unworn candidates bound friction above alone.
    worn: bool = True

    def given(self, contact_um_per_N: float, doubt: float) -> "Sticking":
        """Candidates that remain if the contact is unworn, and its compliance where all of it sticks is known to a
        relative deviation `doubt`.
        """
        known = np.log(np.maximum(self.contact_um_per_N, 1e-300) / contact_um_per_N) / doubt
        return replace(self.kept(self.chi_squared + known**2), worn=False)

    def kept(self, chi_squared: Array) -> "Sticking":
        """Candidates whose new χ² (n,) lies within 25 of the best's, with these χ², counted from the best."""
        other = chi_squared - chi_squared.min()
        near = other <= KEPT
        return Sticking(
            other[near], self.limit_N[near], self.deviation_N[near], self.share[near], self.contact_um_per_N[near],
            self.rig_um_per_N[near], self.unseen[near], self.load_N, self.worn,
        )  # fmt: skip

    @property
    def friction(self) -> Measured | None:
        """Coefficient of friction with the load's uncertainty; None without a load. NaN where it is only bounded, with
        an interval that is open above where nothing bounds it there.
        """
        if self.load_N is None:
            return None
        load, limit = self.load_N, self.limit
        (low, high), (least, most) = limit.interval95, load.interval95
        return Measured(limit.value / load.value, (low / most, high / max(least, 1e-300)))

    @property
    def limit(self) -> Measured:
        """Friction limit µP in N; NaN where it is only bounded, as `friction`."""
        low, high = self._ends
        if self._unseen:
            force = float((self.limit_N * self.share)[self._left].min())
            return Measured(np.nan, (max(force, COARSE * low), np.inf))
        return Measured(np.nan if self.only_bounded else float(self.limit_N[self._best]), (low, high))

    @property
    def only_bounded(self) -> bool:
        """True if the annulus may have worn, unless all candidates slide."""
        return self.worn and bool(np.any(self.share[self._left] < 1.0))

    @property
    def used(self) -> Measured:
        """Share Q*/µP of the friction limit that is reached; NaN where it is only bounded (0 to 1: not at all)."""
        if self._unseen:
            return Measured(np.nan, (0.0, 1.0))
        share = self.share[self._left]
        if self.only_bounded:
            return Measured(np.nan, (float(share.min()), 1.0))
        return Measured(float(self.share[self._best]), (float(share.min()), float(share.max())))

    @property
    def rig(self) -> Measured:
        """Compliance of bodies and rig in series with the contact, in µm/N; of a contact that may have worn, an upper
        bound.
        """
        left = self.rig_um_per_N[self._left]
        least = 0.0 if self.only_bounded else float(left.min())
        return Measured(float(self.rig_um_per_N[self._best]), (least, float(left.max())))

    @property
    def regimes(self) -> tuple[Regime, ...]:
        """Regimes that the remaining candidates allow, in the order of growing slip."""
        left = self._left
        found: list[tuple[Regime, bool]] = [
            ("stick", self._unseen),
            ("partial slip", bool(np.any(self.share[left] < 1.0))),
            ("gross slip", bool(np.any(self.share[left] >= 1.0))),
        ]
        return tuple(name for name, is_left in found if is_left)

    @property
    def _left(self) -> BoolArray:
        left: BoolArray = self.chi_squared <= WITHIN95
        return left

    @property
    def _ends(self) -> tuple[float, float]:
        left = self._left
        beside = self.deviation_N[left] * np.sqrt(WITHIN95 - self.chi_squared[left])
        # At its largest force a contact whose annulus has worn may be about to slide.
        least = (self.limit_N[left] - beside) * (self.share[left] if self.only_bounded else 1.0)
        return float(least.min()), float((self.limit_N[left] + beside).max())

    @property
    def _unseen(self) -> bool:
        return bool(np.any(self.unseen & self._left))

    @property
    def _best(self) -> int:
        return int(np.argmin(self.chi_squared))


@dataclass(frozen=True)
class LoopFigures:
    """Figures of one force–displacement loop; None for each that this loop lacks, as a note then explains."""

    displacement_amplitude_um: Measured  #: δa, half the stroke.
    slip_amplitude_um: Measured  #: δ0, half the loop's width at its mid force.
    dissipated_energy_mJ: Measured  #: E_d, the loop's area.
    measured_stiffness_N_per_um: Measured | None  #: K_t,m, mean slope of the two micro-slip branches.
    branches: tuple[MicroSlipBranch, MicroSlipBranch]  #: Micro-slip branches: forward, backward.
    friction_max: Measured | None  #: max|Q|/P over the cycle.
    friction_energy: Measured | None  #: E_d/(4Pδ0).
    friction_geometry_independent: Measured | None  #: Tan of the mean friction angle of both directions at mid-slip.
    #: Mean slope of |Q| in the direction of slip over the middle of the plateaus.
    plateau_slope_N_per_um: Measured | None
    #: Peak over mid-slip force (over normal force, if known), mean of both directions (1: flat).
    end_hook_ratio: Measured | None
    #: Area that rounding cuts off the corners between micro-slip and plateau over that of the triangle below them, mean
    #: of both directions (0: sharp; 0.2: a Cattaneo–Mindlin contact alone).
    corner_curvature: Measured | None
    #: A = E_d/(4 δa Q*), 0.2 at the transition to gross slip; the rig's compliance lowers it.
    energy_ratio: Measured | None
    system_free_ratio: Measured | None  #: B = E_d/(4 δ0 Q*), 0.77 at that transition for any rig.
    mean_force_N: Measured  #: Path average of Q over both directions of the same stroke.
    asymmetry: Measured | None  #: (Q₊ − |Q₋|)/(Q₊ + |Q₋|) at mid-slip.
    #: Free play of the holder: width of the shelf about zero force, mean of both branches; None without a shelf.
    free_play_um: Measured | None
    force_zero_N: Measured | None  #: Zero error of the force sensor: force of the shelf.
    friction_forward: Measured | None  #: Q₊/P at mid-slip, from the shelf's force if there is one.
    friction_backward: Measured | None  #: |Q₋|/P at mid-slip, from the shelf's force if any.
    #: Share by which a static peak exceeds the plateau's later peaks; None without a static peak.
    static_overshoot: Measured | None
    stick_slip: StickSlip | None  #: Stick-slip on the plateaus; None if there is none.
    #: "gross slip" if a plateau follows the micro-slip branches, or only sliding explains the loop; else "contact
    #: opened" if the normal force falls to zero within the cycle; else "partial slip".
    regime: Regime
    regimes: tuple[Regime, ...]  #: Regimes that the loop allows, in the order of growing slip.
    outlier_samples: tuple[int, ...]  #: Indices of input samples left out as outliers.
    notes: tuple[str, ...]  #: Sentences about what was left out, assumed or corrected.
    #: Indices of the input samples that gave "energy", "stiffness", "slip" and "friction"; empty where these are left
    #: out or come from other figures.
    used: Mapping[str, tuple[int, ...]] = field(default_factory=dict, compare=False, repr=False)
    #: Contacts that a loop in partial slip allows; None if it slides as a whole.
    sticking: Sticking | None = field(default=None, compare=False, repr=False)

    @property
    def friction_partial_slip(self) -> Measured | None:
        """Coefficient of friction of a loop without a plateau, from its energy, stiffness and shape.

        None where the loop slides or no load is known; NaN where it is only bounded, with an interval that may be open
        above.
        """
        return None if self.sticking is None else self.sticking.friction

    @property
    def used_share(self) -> Measured | None:
        """Share Q*/µP of the friction limit in a loop without a plateau; NaN if friction is only bounded, None where
        the loop slides.
        """
        return None if self.sticking is None else self.sticking.used


def regime_of(figures: Iterable[LoopFigures]) -> RegimeOfTest:
    """Regime of a test: "gross slip" or "partial slip" (also if there are no loops), or "mixed" if only some of its
    loops slide as a whole; loops whose contact opens count as sliding.
    """
    slides = {one.regime != "partial slip" for one in figures}
    if len(slides) == 2:
        return "mixed"
    return "gross slip" if slides == {True} else "partial slip"
