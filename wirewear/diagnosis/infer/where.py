"""Where the gap lies, and whether it matters.

A zone is a part of a loop or a channel (`Zone`). A place is one zone in one cycle.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import chdtrc

from geometry.arrays import Array, BoolArray
from wirewear.base.frame import figure
from wirewear.base.words import counted
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.covariance import Covariance
from wirewear.diagnosis.infer.inference import Problem
from wirewear.diagnosis.observe.along_branches import PlateauForce
from wirewear.diagnosis.observe.channels import half_width, loop_area
from wirewear.diagnosis.observe.observable import Observable
from wirewear.diagnosis.observe.reduction import Observations, Part
from wirewear.diagnosis.observe.scars import ProfileDepths
from wirewear.diagnosis.surrogate.forward import PredictedLoops, simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.wear_states import WearStates

_KNOWN = constants("infer.where")

#: Share of false discoveries that is accepted among the places flagged (Benjamini & Hochberg 1995).
FALSE_DISCOVERIES = _KNOWN.number("false_discoveries")


@dataclass(frozen=True)
class Place:
    """Difference between measurement and model in one zone of one cycle.

    difference: mean of measurement less model in the observable's unit, in the direction of travel. in_scatter: root
    mean square in standard deviations of one test. excess: χ² above its expectation, at least 0. relative: root mean
    square of what neither specimens, zeros nor noise account for, over the whole force, stroke or size. p_value: of χ².
    flagged: True if the place stands out.
    """

    zone: str
    observable: Observable
    cycle: int
    difference: float
    in_scatter: float
    excess: float
    relative: float
    p_value: float
    flagged: bool


@dataclass(frozen=True)
class GapFinding:
    """A zone that differs from the prediction.

    cycles: first and last cycle in which it does. share: the zone's part of the excess of χ² in all flagged places.
    size_in_scatter: largest difference in standard deviations of one test. text: a sentence.
    """

    observable: str
    zone: str
    cycles: tuple[int, int]
    share: float
    size_in_scatter: float
    text: str

    @property
    def place(self) -> str:
        """Quantity and zone in words: "worn depth along the profile at the edges of the scar"."""
        return self.text.partition(": ")[0]


def places(problem: Problem, covariance: Covariance, setup: SurrogateInputs) -> list[Place]:
    """Differences between record and prediction under `setup`, by zone and cycle; flagged if significant at a share
    `FALSE_DISCOVERIES` of false ones.
    """
    predicted = problem.predicted(setup)
    residual = problem.mean - predicted
    found = _places(problem, covariance, predicted, residual, _unaccounted(residual, covariance))
    # Benjamini and Hochberg (1995): scipy.stats has it, and takes a second to load.
    ordered = np.sort([place.p_value for place in found])
    passed = ordered[ordered <= FALSE_DISCOVERIES * np.arange(1, len(found) + 1) / len(found)]
    flagged = [place.p_value <= passed.max(initial=-1.0) for place in found]
    return [replace(place, flagged=bool(own)) for place, own in zip(found, flagged, strict=True)]


def changes(problem: Problem, covariance: Covariance, setup: SurrogateInputs) -> list[Place]:
    """Change that the explanation `setup` makes in each zone and cycle; flagged if it is at least half of the largest,
    in standard deviations of one test. The fields of a `Place` are of this change in place of a difference from the
    measurement.
    """
    nominal = problem.predicted(replace(problem.setup, **{name: getattr(setup, name) for name in problem.free}))
    change = problem.predicted(setup) - nominal
    found = _places(problem, covariance, nominal, change, change**2)
    most = max((place.in_scatter for place in found), default=0.0)
    return [replace(place, flagged=place.in_scatter >= 0.5 * most) for place in found]


def _places(
    problem: Problem, covariance: Covariance, predicted: Array, residual: Array, unaccounted: Array
) -> list[Place]:
    squares, found = unaccounted.copy(), []
    for part in problem.layout:
        squares[part.rows] /= part.observable.whole(problem.setup, predicted[part.rows]) ** 2
        zones = part.observable.zone(part.sites, problem.setup.amplitude_um)
        for zone in sorted(set(zones.tolist())):
            for cycle in np.unique(part.sites.cycle[zones == zone]):
                keep = (zones == zone) & (part.sites.cycle == cycle)
                found.append(_place(zone, int(cycle), part, keep, residual, squares, covariance))
    return sorted(found, key=lambda place: place.zone)


def _unaccounted(residual: Array, covariance: Covariance) -> Array:
    """Squares (n,) of residuals less specimens and zeros at their likeliest, and less what noise leaves of them.

    Specimens and zeros account for no more than they scatter in nineteen tests of twenty.
    """
    other = covariance.total - covariance.nuisance
    share = np.linalg.solve(covariance.total, other).T
    noise = other - covariance.tolerated
    remaining = (share @ residual) ** 2 - np.einsum("ij,jk,ik->i", share, noise, share, optimize=True)
    return np.asarray(np.maximum(remaining, residual**2 - 1.96**2 * np.diag(covariance.total)))


def _place(
    zone: str, cycle: int, part: Part, keep: BoolArray, residual: Array, unaccounted: Array, covariance: Covariance
) -> Place:
    rows = part.start + np.flatnonzero(keep)
    block, rest = covariance.total[np.ix_(rows, rows)], residual[rows]
    squares = float(rest @ cho_solve(cho_factor(block + 1e-12 * np.diag(np.diag(block)), lower=True), rest))
    # Forces grow along their branch; displacements lag behind it.
    sign = np.where(part.sites.branch[keep] < 0, -1.0, 1.0)
    return Place(
        zone=zone,
        observable=part.observable,
        cycle=cycle,
        difference=float(np.mean(sign * rest)),
        in_scatter=float(np.sqrt(np.mean(rest**2 / covariance.single[rows]))),
        excess=max(squares - rest.size, 0.0),
        relative=float(np.sqrt(max(float(np.mean(unaccounted[rows])), 0.0))),
        p_value=float(chdtrc(rest.size, squares)),
        flagged=False,
    )


def findings(found: list[Place]) -> list[GapFinding]:
    """Zones with flagged places, largest share of the excess first; empty if no place is flagged."""
    total = sum(place.excess for place in found if place.flagged)
    merged = []
    for zone in dict.fromkeys(place.zone for place in found):
        here = [place for place in found if place.zone == zone and place.flagged]
        if not here:
            continue
        share = sum(place.excess for place in here) / total if total > 0.0 else 0.0
        strongest = max(here, key=lambda place: place.in_scatter)
        cycles = min(place.cycle for place in here), max(place.cycle for place in here)
        words = strongest.observable.words
        merged.append(
            GapFinding(words, zone, cycles, round(share, 3), round(strongest.in_scatter, 2), _text(strongest))
        )
    return sorted(merged, key=lambda finding: (-finding.share, finding.zone))


def _text(place: Place) -> str:
    observable = place.observable
    zone = next(f" {zone.words}" if zone.words else "" for zone in observable.zones if zone.name == place.zone)
    return (
        f"{observable.words}{zone}: the measurement is {_compared(observable, place.difference)} the model at cycle "
        f"{counted(place.cycle)}"
    )


def _compared(observable: Observable, difference: float) -> str:
    """``0.3 N above``; of a logarithm ``12.0 % above``, or ``10 times smaller than``."""
    side = observable.sides[0 if difference > 0.0 else 1]
    if observable.unit != "relative":
        return f"{figure(abs(difference))} {_unit(observable)} {side}"
    ratio = float(np.exp(difference))
    if 0.5 <= ratio <= 2.0:
        return f"{100.0 * abs(ratio - 1.0):.1f} % {side}"
    return f"{max(ratio, 1.0 / ratio):.2g} times {'larger' if ratio > 1.0 else 'smaller'} than"


def _unit(observable: Observable) -> str:
    return observable.unit.replace("um", "µm")


@dataclass(frozen=True)
class Largest:
    """The difference that is largest over its tolerance: observable in words, difference relative to the whole
    quantity, and a sentence.
    """

    observable: str
    relative: float
    text: str


@dataclass(frozen=True)
class Relevance:
    """Judgement of the differences: `detected` if beyond chance, `relevant` if also beyond the tolerance; `largest` is
    None if nothing was compared.
    """

    detected: bool
    relevant: bool
    largest: Largest | None


def relevance_of(places: Sequence[Place], tolerance: Mapping[str, float], *, detected: bool) -> Relevance:
    """Relevance of the differences at the flagged places, or at all if none is flagged. tolerance: relative differences
    that count as equal, by the names of `[tolerance]`. detected: see `Relevance`; if it is False nothing is relevant.
    """
    judged = [place for place in places if place.flagged] or places
    if not judged:
        return Relevance(detected, detected, None)
    beyond = [place.relative / max(tolerance[place.observable.tolerance], 1e-12) for place in judged]
    largest = judged[beyond.index(max(beyond))]
    known = Largest(largest.observable.words, round(largest.relative, 4), _text(largest))
    return Relevance(detected, detected and max(beyond) > 1.0, known)


def physical_gap(
    states: WearStates, observed: Observations, before: SurrogateInputs, after: SurrogateInputs, cycles: tuple[int, ...]
) -> Mapping[str, tuple[float, float]]:
    """Mean distances of measured and computed loops over the given cycles, before and after adding effects, by a name
    with its unit such as "slip_amplitude_um"; of depths over all measured profiles. before, after: setups. If no loop
    is of these cycles, all loops count; a distance that no loop shows is left out.
    """
    profiles = _profiles(states, observed, before, after)
    if not observed.loops:
        return profiles
    logged = {loop.cycle for loop in observed.loops}
    used = sorted(logged.intersection(cycles) or logged)
    at = np.array(used, dtype=float)
    both = [simulate(states, setup, at) for setup in (before, after)]
    slip, energy, force = (np.array(rows).T for rows in zip(*(_figures(c, observed, used) for c in both), strict=True))
    found = {"slip_amplitude_um": slip, "dissipated_energy_percent": energy, "tangential_force_rms_N": force}
    known = {name: values[np.isfinite(values).all(axis=1)] for name, values in found.items()}
    return {name: (float(v[:, 0].mean()), float(v[:, 1].mean())) for name, v in known.items() if v.size} | profiles


def _profiles(
    states: WearStates, observed: Observations, before: SurrogateInputs, after: SurrogateInputs
) -> dict[str, tuple[float, float]]:
    """Root mean square of measured less computed depths along profiles; nothing where there are none."""
    layout = observed.layout
    keep = layout.of_kind(ProfileDepths)
    if not keep.any():
        return {}
    part = layout.taken(keep)
    mean = np.nanmean(observed.values[:, keep], axis=0)
    rest = mean - part.computed(states, before, after)
    first, second = (float(np.sqrt(np.nanmean(one**2))) for one in rest)
    return {"profile_depth_um": (first, second)}


def _figures(loops: PredictedLoops, observed: Observations, cycles: list[int]) -> tuple[Array, Array, Array]:
    """Distances at each cycle: half width [µm], area [%], force at equal displacement on the plateaus [N]."""
    widths = half_width(loops.displacement_um, loops.tangential_force_N)
    areas = loop_area(loops.displacement_um, loops.tangential_force_N)
    slip, energy, force = [], [], []
    keep = observed.layout.of_kind(PlateauForce) & np.isin(observed.layout.cycle, cycles)
    plateaus = observed.layout.taken(keep)
    left = np.nanmean(observed.values[:, keep], axis=0) - plateaus.observed(loops)
    for row, cycle in enumerate(cycles):
        here = [loop for loop in observed.loops if loop.cycle == cycle]
        slip.append(abs(float(np.mean([loop.half_width_um for loop in here])) - float(widths[row])))
        measured = float(np.mean([loop.energy_mJ for loop in here]))
        energy.append(100.0 * abs(float(areas[row]) / measured - 1.0))
        rest = left[plateaus.cycle == cycle]
        force.append(float(np.sqrt(np.mean(rest**2))) if rest.size else np.nan)
    return np.array(slip), np.array(energy), np.array(force)
