"""What the page of a diagnosis draws: loops with and without the leading effect, the map of the gap, bars of causes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.arrays import Array
from wirewear.base.frame import numbers
from wirewear.diagnosis.infer.where import places
from wirewear.diagnosis.model.candidates import effect_of
from wirewear.diagnosis.model.forward import LoopCourse, simulate
from wirewear.diagnosis.model.loop_states import SCAR_EDGE, SCAR_FIGURES
from wirewear.diagnosis.model.readings import still_to_come
from wirewear.diagnosis.observe import ObservedBranch, ReducedLoop
from wirewear.diagnosis.observe.profiles import read_profile
from wirewear.diagnosis.observe.reduction import row_labels
from wirewear.diagnosis.observe.scars import FEWEST_POINTS, above_ground
from wirewear.effects import all_measurements, effect_named
from wirewear.pictures.style import VARIANT_COLOURS
from wirewear.records import MeasuredScar
from wirewear.results.scar import called
from wirewear.views.diagnosis_wording import plain

if TYPE_CHECKING:
    from wirewear.views.diagnosis_values import Cause, Diagnosis
    from wirewear.views.diagnosis_wording import Diagnosed

#: Places on a branch at which forces are compared; standard deviations to each side that hold 95 % of tests.
PLACES, WITHIN = 60, 1.96

DIRECTIONS = (1, -1)  #: Branches in the order of a course, by their direction.
STRIP = 0.1  #: Share of the scar's width about its middle over which a section is averaged.

MODEL, WITH, CONFIRMED, MEASURED = *VARIANT_COLOURS[:3], "#9a9a9a"

MOST_LOOPS = 12  #: Cycles whose loops are shown at most.

#: From so many scatters on, a cell of the map has the next colour; pale to dark red.
SHADES = (
    (0, "#fff7e3"),
    (1, "#fee9b4"),
    (2, "#fed173"),
    (3, "#feab49"),
    (5, "#f97a36"),
    (8, "#e4401f"),
    (12, "#b10026"),
)

DARK = 8  #: From here on a shade is so dark that it takes white letters.


def residuals(
    loops: tuple[ReducedLoop, ...], course: LoopCourse, row: int, scatter: Mapping[str, float], load_N: float
) -> list[dict[str, Array]]:
    """Measured less computed force on both branches of a cycle's loop, against displacement.

    Each is a table of arrays (n,): `displacement_um`, `force_N`, the mean over repeats less the computed force, and
    `band_N`, the half-width of what 95 % of tests differ by.  row: of the course.
    """
    found = []
    for place, sign in enumerate(DIRECTIONS):
        own = [branch for loop in loops for branch in loop.branches if branch.sign == sign]
        x, q = sign * course.displacement_um[row, place], sign * course.tangential_force_N[row, place]
        order = still_to_come(x)
        low = max(float(order[0]), *(float(one.displacement_um.min()) for one in own))
        high = min(float(order[-1]), *(float(one.displacement_um.max()) for one in own))
        at = np.linspace(low, high, PLACES)
        computed = np.interp(at, order, q)
        measured = np.mean([_force_at(one, at) for one in own], axis=0)
        # A bump of the loop counts as correlated noise of its force: samples about their neighbours do not know it.
        noise_N = float(np.mean([loop.sample_noise_N for loop in loops]))
        found.append(
            {
                "displacement_um": sign * at,
                "force_N": sign * (measured - computed),
                "band_N": _band(at, computed, scatter, load_N, noise_N),
            }
        )
    return found


def _force_at(branch: ObservedBranch, at_um: Array) -> Array:
    order = np.argsort(branch.displacement_um, kind="stable")
    return np.asarray(np.interp(at_um, branch.displacement_um[order], branch.force_N[order]))


def _band(at_um: Array, force_N: Array, scatter: Mapping[str, float], load_N: float, noise_N: float) -> Array:
    """Friction and load stretch the force; zeros shift force and displacement; the amplitude stretches the stroke."""

    def size(name: str) -> float:
        return float(scatter.get(name, 0.0))

    stretched = np.hypot(size("friction"), size("load")) * force_N
    moved_um = np.hypot(size("displacement_offset_um"), size("amplitude") * at_um)
    shifted = np.gradient(force_N, at_um) * moved_um
    return np.asarray(WITHIN * np.sqrt(stretched**2 + shifted**2 + (size("force_offset") * load_N) ** 2 + noise_N**2))


def measured_section(scars: Iterable[MeasuredScar]) -> list[tuple[Array, Array]]:
    """Place [µm] along the motion about the scar's middle, and depth [µm], of each map that has enough points."""
    found = []
    for scar in scars:
        if scar.depth_um.size < FEWEST_POINTS:
            continue
        depth = above_ground(scar)
        weight = np.maximum(depth, 0.0)
        if not weight.sum() > 0.0:
            found.append((scar.x_um, depth.mean(axis=1)))
            continue
        middle_x = float(weight.sum(axis=1) @ scar.x_um / weight.sum())
        middle_y = float(weight.sum(axis=0) @ scar.y_um / weight.sum())
        near = np.abs(scar.y_um - middle_y)
        strip = near <= max(STRIP * float(np.ptp(scar.y_um)), float(near.min()))
        found.append((scar.x_um - middle_x, depth[:, strip].mean(axis=1)))
    return found


def bowl(figures: Array, places: int = 41) -> tuple[Array, Array]:
    """The section of a paraboloid of a scar's figures (4,): places and depths [µm].

    The section over its whole width goes as (1 − x²/a²)^(3/2), so that the length, measured where that is `SCAR_EDGE`
    of its largest, is 2 a √(1 − SCAR_EDGE^(2/3)).
    """
    depth, length = (float(figures[SCAR_FIGURES.index(name)]) for name in ("depth", "length"))
    half = 0.5 * length / np.sqrt(1.0 - SCAR_EDGE ** (2.0 / 3.0))
    x = np.linspace(-half, half, places)
    return x, depth * (1.0 - (x / max(half, 1e-9)) ** 2)


@dataclass(frozen=True)
class Cell:
    """One zone at one cycle: how many scatters it is off, its colour, and whether that is beyond chance."""

    in_scatter: float
    colour: str
    ink: str
    flagged: bool


@dataclass(frozen=True)
class GapMap:
    """Where the gap lies: cycles, and a row of cells for each zone, None where nothing was measured."""

    cycles: tuple[int, ...]
    rows: tuple[tuple[str, tuple[Cell | None, ...]], ...]


@dataclass(frozen=True)
class CauseBar:
    """A cause with what it cannot be told apart from."""

    cause: Cause
    percent: float
    colour: str
    like: tuple[str, ...]


@dataclass(frozen=True)
class NextMeasurement:
    """What to measure next, its cost in words, and what it would show under each effect that it splits."""

    what: str
    why: str
    cost: str
    tells: tuple[tuple[str, float, str], ...]


@dataclass(frozen=True)
class GapBar:
    """A root mean square difference, and its length of the longest."""

    name: str
    value: float
    percent: float
    colour: str


def loops(diagnosed: Diagnosed) -> dict[str, Any]:
    """Measured and computed loops as plain values."""
    known = sorted({loop.cycle for loop in diagnosed.observed.loops})
    kept = np.unique(np.linspace(0, len(known) - 1, min(MOST_LOOPS, len(known))).round().astype(int))
    cycles = [known[place] for place in kept]
    at = np.array(cycles or [diagnosed.setup.cycles], dtype=float)
    found, best = diagnosed.search, diagnosed.search.best
    curves = [("model", MODEL, simulate(diagnosed.states, diagnosed.setup, at))]
    if best.candidates and diagnosed.diagnosis.verdict != "no_gap":
        alike = any(name in members for members in diagnosed.diagnosis.equivalent for name in best.names)
        label = "model with " + " and ".join(plain(name) for name in best.names) + (" or its like" if alike else "")
        curves.append((label, WITH, simulate(diagnosed.states, found.best.setup, at)))
    return {
        "cycles": cycles,
        "measured": [_measured(diagnosed, cycle) for cycle in cycles],
        "colour": MEASURED,
        "left": [[_left(diagnosed, course, row, cycle) for row, cycle in enumerate(cycles)] for _, _, course in curves],
        "begin": _telling_cycle(diagnosed, cycles) if cycles else 0,
        "sections": _sections(diagnosed, curves),
        "curves": [
            {
                "name": name,
                "colour": colour,
                "loops": [
                    [numbers(x.ravel()), numbers(q.ravel())]
                    for x, q in zip(course.displacement_um, course.tangential_force_N, strict=True)
                    if cycles
                ],
            }
            for name, colour, course in curves
        ],
    }


def _left(diagnosed: Diagnosed, course: LoopCourse, row: int, cycle: int) -> list[list[list[float | None]]]:
    """Displacement, measured less computed force, and half-width of the band, of both branches."""
    own = tuple(loop for loop in diagnosed.observed.loops if loop.cycle == cycle)
    scatter = diagnosed.search.covariance.scatter
    branches = residuals(own, course, row, scatter, diagnosed.setup.load_N)
    return [[numbers(one[name]) for name in ("displacement_um", "force_N", "band_N")] for one in branches]


def _telling_cycle(diagnosed: Diagnosed, cycles: Sequence[int]) -> int:
    """The place of the last cycle at which a gap shows that has a place, else of the last one."""
    shows = [one.cycles[1] for one in diagnosed.diagnosis.resembles[:1]]
    shows = shows or [finding.cycles[1] for finding in diagnosed.diagnosis.where[:1]]
    last = shows[0] if shows else cycles[-1]
    return max((place for place, cycle in enumerate(cycles) if cycle <= last), default=len(cycles) - 1)


def _sections(diagnosed: Diagnosed, curves: Sequence[tuple[str, str, LoopCourse]]) -> list[dict[str, Any]]:
    """Worn bodies along the motion, measured and computed: profiles, or bowls of the computed depth and length."""
    found = []
    for place, body in enumerate(diagnosed.record.tables.body_names):
        scars, courses = diagnosed.record.scars_of(body), [course for _, _, course in curves]
        if courses[0].profiles:
            measured = [(one.x_um, one.depth_um) for one in map(read_profile, scars)]
            computed = [course.profiles[body] for course in courses]
        else:
            measured, computed = measured_section(scars), [bowl(course.scars[place]) for course in courses]
        if measured:
            drawn = {"measured": measured, "bowls": computed}
            heights = {name: [[numbers(x), numbers(-depth)] for x, depth in own] for name, own in drawn.items()}
            found.append({"wire": called(body), **heights})
    return found


def gap_map(diagnosed: Diagnosed) -> GapMap:
    """Every zone and cycle that was measured."""
    found = places(diagnosed.search.problem, diagnosed.search.covariance, diagnosed.setup)
    cycles = tuple(sorted({place.cycle for place in found}))
    cells = {(place.zone, place.cycle): _cell(place.in_scatter, flagged=place.flagged) for place in found}
    zones = [(zone, label) for zone, label in row_labels().items() if any(place.zone == zone for place in found)]
    return GapMap(cycles, tuple((label, tuple(cells.get((zone, cycle)) for cycle in cycles)) for zone, label in zones))


def cause_bars(diagnosed: Diagnosed, most: int = 8) -> list[CauseBar]:
    """The likeliest causes, those that cannot be told apart next to one another."""
    diagnosis, weighed = diagnosed.diagnosis, diagnosed.weighed
    listed = diagnosis.causes[:most]

    def rank(cause: Cause) -> tuple[float, str, float]:
        members = weighed.class_of(cause.effect)
        return -max(one.probability for one in listed if one.effect in members), members[0], -cause.probability

    def like(name: str) -> tuple[str, ...]:
        return tuple(other for members in diagnosis.equivalent if name in members for other in members if other != name)

    neutral = ("none", "outside_library")
    return [
        CauseBar(one, 100.0 * one.probability, MEASURED if one.effect in neutral else WITH, like(one.effect))
        for one in sorted(listed, key=rank)
    ]


def gap_bars(diagnosed: Diagnosed) -> list[GapBar]:
    """The gap before, after, after a full simulation if there was one, and what tests scatter."""
    shrink, confirmed = diagnosed.diagnosis.shrink, diagnosed.diagnosis.confirmed
    values: Mapping[str, tuple[float, str]] = {
        "before": (shrink.before, MODEL),
        "after": (shrink.after, WITH),
        **({} if confirmed is None else {"after, full simulation": (confirmed.after, CONFIRMED)}),
        "floor: scatter and solver": (shrink.floor, MEASURED),
    }
    longest = max((value for value, _ in values.values() if np.isfinite(value)), default=0.0) or 1.0
    return [GapBar(name, value, 100.0 * value / longest, colour) for name, (value, colour) in values.items()]


def next_measurement(diagnosis: Diagnosis) -> NextMeasurement | None:
    """The next measurement for people, its effects the likeliest first with their probabilities."""
    asked = diagnosis.next_measurement
    if asked is None:
        return None
    known = next(one for one in all_measurements() if one.what == asked["what"])
    probabilities = {cause.effect: cause.probability for cause in diagnosis.causes}
    names = sorted(asked["splits"], key=lambda name: -probabilities.get(effect_of(name), 0.0))
    tells = []
    for name in names:
        effect = effect_of(name)
        text = known.without_gap if effect == "none" else effect_named(effect).answer_to(known)
        tells.append((name, probabilities.get(effect, 0.0), text or "nothing of its own"))
    return NextMeasurement(known.what, known.why, _days(known.cost_days), tuple(tells))


def _days(days: float) -> str:
    """A cost in words: half a day."""
    words = {0.5: "half a day", 1.0: "a day"}
    return words.get(days, f"{8.0 * days:.2g} hours" if days < 1.0 else f"{days:.2g} days")


def _measured(diagnosed: Diagnosed, cycle: int) -> list[list[list[float | None]]]:
    found = []
    for loop in diagnosed.observed.loops:
        if loop.cycle == cycle:
            x = np.concatenate([branch.sign * branch.displacement_um for branch in loop.branches])
            q = np.concatenate([branch.sign * branch.force_N for branch in loop.branches])
            found.append([numbers(x), numbers(q)])
    return found


def _cell(in_scatter: float, *, flagged: bool) -> Cell:
    start, colour = next((shade for shade in reversed(SHADES) if in_scatter >= shade[0]), SHADES[0])
    return Cell(in_scatter, colour, "#fff" if start >= DARK else "#1a1a1a", flagged)
