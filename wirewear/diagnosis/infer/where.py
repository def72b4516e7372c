"""Where the gap lies, whether it matters, and what it behaves like if no known effect explains it.

A zone is a part of a loop or a channel (`Zone`). A place is one zone in one cycle.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import chdtrc

from geometry.arrays import Array, BoolArray
from wirewear.base.words import counted
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.covariance import Covariance
from wirewear.diagnosis.infer.distortions import Distortion
from wirewear.diagnosis.infer.inference import Problem
from wirewear.diagnosis.infer.weighing import NOTICEABLE
from wirewear.diagnosis.observe import AlongBranch
from wirewear.diagnosis.observe.along_branches import PlateauForce, Stick
from wirewear.diagnosis.observe.observable import Observable
from wirewear.diagnosis.observe.reduction import Part
from wirewear.diagnosis.observe.scars import ProfileDepths
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.effects import Seam

_KNOWN = constants("infer.where")

#: Share of false discoveries that is accepted among the places flagged (Benjamini & Hochberg 1995).
FALSE_DISCOVERIES = _KNOWN.number("false_discoveries")

_ALIKE = constants("infer.where.resembling")

#: Families less probable than this are not listed; of several, so many are.
LEAST_LISTED, MOST_LISTED = _ALIKE.number("least_listed"), _ALIKE.count("most_listed")

#: A distortion is there in cycles and places where it has this share of its largest size.
PRESENT = _ALIKE.number("present")


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

    cycles: first and last cycle in which it does. share: of the excess of χ² in all flagged places. size_in_scatter:
    largest difference in standard deviations of one test. text: a sentence.
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
        return f"{abs(difference):.3g} {_unit(observable)} {side}"
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


@dataclass(frozen=True)
class Resemblance:
    """A family of distortions that would produce a gap like the observed one."""

    seam: str  #: Place in the chain from drive to sensors.
    family: str
    probability: float  #: Among all families, given that the cause lies outside the library.
    cycles: tuple[int, int]  #: First and last logged cycle at which it shows.
    where: str  #: Place in the loop, in words.
    text: str  #: A sentence, with its size.


def resemblances(problem: Problem, found: Sequence[Distortion], best_log_evidence: float) -> tuple[Resemblance, ...]:
    """The families among `found` that may stand for the cause, most probable first; empty if the best beats the best
    explanation alone by less than `NOTICEABLE`. best_log_evidence: of the best explanation without distortions.
    """
    best: dict[str, Distortion] = {}
    for one in found:
        if one.family.name not in best or one.log_evidence > best[one.family.name].log_evidence:
            best[one.family.name] = one
    ordered = sorted(best.values(), key=lambda one: -one.log_evidence)
    if not ordered or ordered[0].log_evidence - best_log_evidence < NOTICEABLE:
        return ()
    logs = np.array([one.log_evidence for one in ordered])
    weights = np.exp(logs - np.logaddexp.reduce(logs))
    pairs = zip(ordered, weights.tolist(), strict=True)
    return tuple(_described(problem, one, weight) for one, weight in pairs if weight >= LEAST_LISTED)[:MOST_LISTED]


def _described(problem: Problem, one: Distortion, probability: float) -> Resemblance:
    part = _telling(problem, one)
    change = one.observed[part.rows]
    size = np.abs(change)
    present = size >= PRESENT * size.max()
    # Sensors, holders and loads are bent alike in all loops.
    alike = bool(one.family.shapes) and not one.family.develops
    cycles = part.sites.cycle if alike else part.sites.cycle[present]
    span = int(cycles.min()), int(cycles.max())
    largest = int(np.argmax(size))
    where = _alike_place(problem, part, largest, present)
    at = f" {where}" if where else ""
    beside = f" beside {_joined(one.beside.names)}" if one.beside.candidates else ""
    amount = _amount(part, change, largest, reads=one.family.seam is Seam.SENSOR)
    text = (
        f"The gap behaves like a {one.family.name}{beside}: {amount}{at}, {_when(span)}."
        if not one.family.column
        else f"The gap behaves like a {one.family.name}{beside}, {_course(problem, one)}: {amount}{at}."
    )
    where = where or part.observable.words
    return Resemblance(str(one.family.seam), one.family.name, round(probability, 3), span, where, text)


def _telling(problem: Problem, one: Distortion) -> Part:
    """The observable in which a distortion is largest against what is known of it."""
    deviations = np.sqrt(np.diag(np.linalg.inv(problem.whitening.T @ problem.whitening)))

    def size(part: Part) -> float:
        return float((np.abs(one.observed) / deviations)[part.rows].max())

    largest = max(problem.layout, key=size)
    # A force or a displacement in the loop says more to a person than a figure taken from it.
    plain = [part for part in problem.layout if isinstance(part.observable, AlongBranch)]
    seen = max(plain, key=size, default=largest)
    return seen if size(seen) >= PRESENT * size(largest) else largest


def _amount(part: Part, change: Array, largest: int, *, reads: bool) -> str:
    """For example: 0.08 N more resistance, or reads 0.08 N more, in the direction of travel."""
    sites, observable = part.sites, part.observable
    branch = int(sites.branch[largest])
    value = float(change[largest]) * (branch or 1)
    if isinstance(observable, ProfileDepths):
        return f"the {sites.wire[largest]} wears too {'much' if value > 0.0 else 'little'}, by {abs(value):.2g} µm"
    if observable.unit == "relative":
        return f"{observable.words} {100.0 * abs(np.expm1(value)):.2g} % {'more' if value > 0.0 else 'less'}"
    if observable.unit == "1":
        return f"{observable.words} {abs(value):.2g} {'more' if value > 0.0 else 'less'}"
    unit = observable.unit.replace("um", "µm")
    if isinstance(observable, PlateauForce):
        size = f"{abs(value):.2g} {unit} {'more' if value > 0.0 else 'less'}"
        return f"it reads {size}" if reads else f"{size} resistance"
    return f"{observable.words} {abs(value):.2g} {unit} {'more' if value > 0.0 else 'less'}"


def _alike_place(problem: Problem, part: Part, largest: int, present: BoolArray) -> str:
    level, branch = float(part.sites.level[largest]), int(part.sites.branch[largest])
    if isinstance(part.observable, PlateauForce):
        both = {int(np.sign(at)) for at in part.sites.level[present & (np.abs(part.sites.level) > 1e-9)]} == {-1, 1}
        at = f"{abs(level):.2g} µm to either side" if both else f"{level:+.2g} µm"
        middle = abs(level) < 0.1 * problem.setup.amplitude_um
        return "at mid-stroke" if middle else f"at {at} of the middle".replace("-", "−")
    if isinstance(part.observable, Stick):
        return f"at {level * branch:+.2g} N after a reversal".replace("-", "−")
    zone = str(part.observable.zone(part.sites, problem.setup.amplitude_um)[largest])
    return next(one.words for one in part.observable.zones if one.name == zone)


def _when(span: tuple[int, int]) -> str:
    first, last = map(counted, span)
    return f"at cycle {first}" if first == last else f"from cycle {first} to {last}"


def _course(problem: Problem, one: Distortion) -> str:
    """How a quantity goes over the test, relative to the model: "from +12 % to −3 %, most about cycle 1000"."""
    knots, values = one.over_time
    if one.family.scale == "compliance":
        scale, unit, digits = 1e3 * problem.setup.amplitude_um / problem.setup.plateau_force_N, " µm/kN", 3
    elif one.family.scale == "force":
        scale, unit, digits = problem.setup.plateau_force_N, " N", 2
    else:
        scale, unit, digits = 100.0, " %", 2
    first, last, most = values[0], values[-1], int(np.argmax(np.abs(values)))
    text = f"{scale * first:+.{digits}g}{unit} at first, {scale * last:+.{digits}g}{unit} in the end"
    if most not in (0, values.size - 1):
        text += f", {scale * values[most]:+.{digits}g}{unit} about cycle {counted(float(f'{np.exp(knots[most]):.2g}'))}"
    return text.replace("-", "−")


def _joined(names: Sequence[str]) -> str:
    effects = [name.replace("_", " ").partition(":") for name in names]
    return " and ".join(f"{effect} ({chosen})" if chosen else effect for effect, _, chosen in effects)
