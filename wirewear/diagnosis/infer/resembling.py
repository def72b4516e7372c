"""What a gap behaves like that no known effect explains: the families of distortions that stand out, in words."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array, BoolArray
from wirewear.base.frame import figure
from wirewear.base.words import counted
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.distortions import SIZES, Distortion, columns_of
from wirewear.diagnosis.infer.families import Family
from wirewear.diagnosis.infer.inference import Fit, Problem, jacobian_of, placed
from wirewear.diagnosis.infer.weighing import NOTICEABLE, SEPARABLE
from wirewear.diagnosis.observe import AlongBranch
from wirewear.diagnosis.observe.along_branches import PlateauForce, Stick
from wirewear.diagnosis.observe.reduction import Part
from wirewear.diagnosis.observe.scars import ProfileDepths
from wirewear.effects import Seam
from wirewear.effects.measurements import (
    CLEANED_SCARS,
    ENCODER,
    INTERRUPTED_SCARS,
    LOWER_FREQUENCY,
    NORMAL_FORCE,
    SECOND_HEIGHT,
)

_KNOWN = constants("infer.resembling")

#: Families less probable than this are not listed; of several, so many are.
LEAST_LISTED, MOST_LISTED = _KNOWN.number("least_listed"), _KNOWN.count("most_listed")

#: A family looks like effects if it leaves at most this share of the deviations that they make.
ALIKE = _KNOWN.number("alike")

#: A distortion is there in cycles and places where it has this share of its largest size.
PRESENT = _KNOWN.number("present")

_ONE_END = "debris piled up at one end, or more wear there", CLEANED_SCARS.what
_AIR = "humidity logged beside the loops"
_BLOCKS = "gauge blocks or a second sensor over the whole stroke"

#: What no effect of the library is and would act as a family, and the measurement that tells, by the family's name.
MADE_BY = {
    "distortion of the force channel, odd in Q":
        ("a load cell that bends or saturates", "weights hung on the load cell"),
    "distortion of the force channel, even in Q": _ONE_END,
    "distortion of the displacement channel, odd in the displacement":
        ("a displacement sensor that is not linear", _BLOCKS),
    "displacement channel that comes after the motion by a play":
        ("a gauge that hangs loose, or a scale with uneven lines", _BLOCKS),
    "gain of the displacement channel that changes over the test": ("a sensor that warms", ENCODER.what),
    "zero of the force channel that changes over the test": _ONE_END,
    "holder that slips, with hysteresis": ("a clamp that slips a little in every cycle", SECOND_HEIGHT.what),
    "holder that stiffens or softens under the force, alike in both directions":
        ("a joint that closes under the force", "the holder pulled without contact, up to the largest force"),
    "holder whose compliance changes over the test":
        ("a joint that creeps or comes loose", "the holder pulled without contact before and after the test"),
    "force that follows the place, as slopes of a surface make it": _ONE_END,
    "friction that differs along the stroke from one side to the other": _ONE_END,
    "friction that differs along the stroke, alike on both sides of its middle":
        ("surfaces that flash hot where they slide fast", LOWER_FREQUENCY.what),
    "friction that passes after each reversal":
        ("debris that rolls back, or surfaces that warm as they slide", LOWER_FREQUENCY.what),
    "friction that changes over the test":
        ("air that turns moist and dry, debris that gathers and leaves at once, or stick–slip that a logger averages",
         f"{_AIR}, and a few loops logged fast and without a filter"),
    "load that changes over the test": ("a lever or guide that sticks", NORMAL_FORCE.what),
    "wear that goes faster and slower over the test":
        ("wear that sets in or turns mild at some depth or pressure, or air that turns moist and dry",
         f"{INTERRUPTED_SCARS.what}, and {_AIR}"),
    "wear that differs from one side of the scar to the other": _ONE_END,
}  # fmt: skip


@dataclass(frozen=True)
class Resemblance:
    """A family of distortions that would produce a gap like the observed one."""

    seam: str  #: Place in the chain from drive to sensors.
    family: str
    probability: float  #: Among all families, given that the cause lies outside the library.
    cycles: tuple[int, int]  #: First and last logged cycle at which it shows.
    where: str  #: Place in the loop, in words.
    text: str  #: A sentence, with its size, and one on what would do so and which measurement would tell.


@dataclass(frozen=True)
class Imitation:
    """A family of distortions that a record cannot tell from the effects which explain it.

    seam: place in the chain from drive to sensors. causes: what of no library would act so. measurement: what would
    tell. deviations: distance from the explanation in standard deviations.
    """

    seam: str
    family: str
    causes: str
    measurement: str
    deviations: float


def imitations(problem: Problem, one: Fit) -> tuple[Imitation, ...]:
    """Families whose cause and measurement are known and that make all that the effects of the fit `one` do, within
    `SEPARABLE` standard deviations, and most of it; nearest first, at most `MOST_LISTED`.
    """
    base = placed(problem, (), one.free)
    made = problem.whitening @ (problem.predicted(one.setup) - problem.predicted(base))
    # The last column: the order of micro-slip, which is free for every explanation, may differ, too.
    freedoms = jacobian_of(problem, one)[:, one.coordinates.size :]
    left: dict[Family, float] = {}
    # Undone where the effects are at work, or made where they are not: what is linear at either end.
    for sets in (*columns_of(problem, one.setup), *columns_of(problem, base)):
        for columns in sets:
            observed = columns.observed
            if columns.knots.size and columns.family.seam not in (Seam.CONTACT, Seam.WEAR):
                mean = columns.of_unknowns.mean(axis=0)  # what is there all the time is no change over the test
                observed = observed - np.outer(observed @ mean, mean) / (mean @ mean)
            moved = np.column_stack([SIZES[-1] * (problem.whitening @ observed), freedoms])
            sizes = np.linalg.solve(moved.T @ moved + np.eye(moved.shape[1]), moved.T @ made)
            rest = float(np.linalg.norm(made - moved @ sizes))
            left[columns.family] = min(left.get(columns.family, np.inf), rest)
    within = min(SEPARABLE, ALIKE * float(np.linalg.norm(made)))
    near = sorted((one for one in left if left[one] < within and one.name in MADE_BY), key=lambda one: left[one])[
        :MOST_LISTED
    ]
    return tuple(Imitation(str(one.seam), one.name, *MADE_BY[one.name], round(left[one], 2)) for one in near)


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
        else f"The gap behaves like a {one.family.name}{beside}, {_over_the_test(problem, one)}: {amount}{at}."
    )
    if one.family.name in MADE_BY:
        cause, measurement = MADE_BY[one.family.name]
        text = f"{text} {cause[0].upper()}{cause[1:]} would do so; {measurement} would tell."
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
        return (
            f"the {sites.body[largest]} wears too {'much' if value > 0.0 else 'little'}, by {figure(abs(value), 2)} µm"
        )
    if observable.unit == "relative":
        return f"{observable.words} {figure(100.0 * abs(np.expm1(value)), 2)} % {'more' if value > 0.0 else 'less'}"
    if observable.unit == "1":
        return f"{observable.words} {figure(abs(value), 2)} {'more' if value > 0.0 else 'less'}"
    unit = observable.unit.replace("um", "µm")
    if isinstance(observable, PlateauForce):
        size = f"{figure(abs(value), 2)} {unit} {'more' if value > 0.0 else 'less'}"
        return f"it reads {size}" if reads else f"{size} resistance"
    return f"{observable.words} {figure(abs(value), 2)} {unit} {'more' if value > 0.0 else 'less'}"


def _alike_place(problem: Problem, part: Part, largest: int, present: BoolArray) -> str:
    level, branch = float(part.sites.level[largest]), int(part.sites.branch[largest])
    if isinstance(part.observable, PlateauForce):
        both = {int(np.sign(at)) for at in part.sites.level[present & (np.abs(part.sites.level) > 1e-9)]} == {-1, 1}
        at = f"{figure(abs(level), 2)} µm to either side" if both else f"{figure(level, 2, sign=True)} µm"
        middle = abs(level) < 0.1 * problem.setup.amplitude_um
        return "at mid-stroke" if middle else f"at {at} of the middle"
    if isinstance(part.observable, Stick):
        return f"at {figure(level * branch, 2, sign=True)} N after a reversal"
    zone = str(part.observable.zone(part.sites, problem.setup.amplitude_um)[largest])
    return next(one.words for one in part.observable.zones if one.name == zone)


def _when(span: tuple[int, int]) -> str:
    first, last = map(counted, span)
    return f"at cycle {first}" if first == last else f"from cycle {first} to {last}"


def _over_the_test(problem: Problem, one: Distortion) -> str:
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
