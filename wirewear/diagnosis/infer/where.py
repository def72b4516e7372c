"""Where the gap lies: zones of the loop, cycles and channels in which measurement and model differ beyond chance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.stats import chi2

from wirewear.diagnosis.infer.covariance import Covariance
from wirewear.diagnosis.infer.inference import Problem
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.observe.layout import KINDS, Array, Layout

#: Share of false discoveries that is accepted among the places flagged (Benjamini & Hochberg 1995).
FALSE_DISCOVERIES = 0.05


@dataclass(frozen=True)
class Place:
    """One zone of one cycle (or of a channel): does it differ beyond chance, and by how much.

    `difference` is the mean of measurement less model in the zone's unit, in the direction of travel; `in_scatter` is
    the root mean square in standard deviations of one test; `excess` what chi² has beyond its expectation.
    """

    zone: str
    kind: str
    cycle: int
    difference: float
    in_scatter: float
    excess: float
    p_value: float
    flagged: bool


@dataclass(frozen=True)
class Finding:
    """A zone that differs, over the cycles at which it does."""

    observable: str
    zone: str
    cycles: tuple[int, int]
    share: float
    size_in_scatter: float
    text: str


def places(problem: Problem, covariance: Covariance, setup: Setup) -> list[Place]:
    """All zones and cycles, flagged where they differ."""
    layout = problem.layout
    residual = problem.mean - problem.predicted(setup)
    zones = layout.zone(setup.amplitude_um)
    found = []
    for zone in sorted(set(zones.tolist())):
        for cycle in np.unique(layout.cycle[zones == zone]):
            keep = (zones == zone) & (layout.cycle == cycle)
            found.append(_place(zone, int(cycle), keep, layout, residual, covariance))
    order = np.argsort([place.p_value for place in found], kind="stable")
    limit = 0
    for rank, index in enumerate(order, start=1):
        if found[index].p_value <= FALSE_DISCOVERIES * rank / len(found):
            limit = rank
    flagged = set(order[:limit].tolist())
    return [Place(**{**place.__dict__, "flagged": i in flagged}) for i, place in enumerate(found)]


def _place(
    zone: str, cycle: int, keep: NDArray[np.bool_], layout: Layout, residual: Array, covariance: Covariance
) -> Place:
    block = covariance.total[np.ix_(keep, keep)]
    rest = residual[keep]
    squares = float(rest @ cho_solve(cho_factor(block + 1e-12 * np.diag(np.diag(block)), lower=True), rest))
    count = int(keep.sum())
    kind = str(layout.kind[keep][0])
    # Forces grow along their branch; displacements lag behind it.
    sign = np.where(layout.branch[keep] < 0, -1.0, 1.0)
    return Place(
        zone=zone,
        kind=kind,
        cycle=cycle,
        difference=float(np.mean(sign * rest)),
        in_scatter=float(np.sqrt(np.mean(rest**2 / covariance.single[keep]))),
        excess=max(squares - count, 0.0),
        p_value=float(chi2.sf(squares, count)),
        flagged=False,
    )


def findings(found: list[Place]) -> list[Finding]:
    """Zones that differ, largest share of the excess first."""
    total = sum(place.excess for place in found if place.flagged)
    merged = []
    for zone in dict.fromkeys(place.zone for place in found):
        here = [place for place in found if place.zone == zone and place.flagged]
        if not here:
            continue
        share = sum(place.excess for place in here) / total if total > 0.0 else 0.0
        strongest = max(here, key=lambda place: place.in_scatter)
        cycles = min(place.cycle for place in here), max(place.cycle for place in here)
        words, unit = KINDS[strongest.kind]
        merged.append(
            Finding(words, zone, cycles, round(share, 3), round(strongest.in_scatter, 2), _text(strongest, unit))
        )
    return sorted(merged, key=lambda finding: (-finding.share, finding.zone))


def _text(place: Place, unit: str) -> str:
    size = abs(place.difference)
    amount = f"{100 * size:.1f} %" if unit == "relative" else f"{size:.3g} {unit.replace('um', 'µm')}"
    side = "above" if place.difference > 0 else "below"
    where = {"stick": "just after a reversal", "plateau": "on the plateaus", "tip": "at the ends of the stroke"}
    words = KINDS[place.kind][0]
    zone = f" {where[place.zone]}" if place.zone in where else ""
    if place.kind == "stick":
        side = "ahead of" if place.difference > 0 else "behind"
    return f"{words}{zone}: the measurement is {amount} {side} the model at cycle {place.cycle:,}"
