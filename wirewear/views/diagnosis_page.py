"""A diagnosis as a self-contained HTML page with its drawings, and as ten lines of text.

A zone is a part of the measurements, such as a stretch of the loop or a scar's depth; a scatter is the standard
deviation of one test. Nominal values are those of the model without effects, explained ones include the effects of the
best explanation. A bowl is a paraboloid with a scar's depth and length.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from geometry.arrays import Array
from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.files import with_checksum
from wirewear.base.frame import numbers
from wirewear.base.units import unit_of, words_of
from wirewear.base.words import counted
from wirewear.base.writing import finite, json_text, write_text, writing
from wirewear.diagnosis.answer import program
from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.diagnosis.infer.where import Place, places
from wirewear.diagnosis.observe import ObservedBranch, ReducedLoop
from wirewear.diagnosis.observe.reduction import row_labels
from wirewear.diagnosis.observe.scars import FEWEST_POINTS, read_profile
from wirewear.diagnosis.surrogate.candidates import effect_of
from wirewear.diagnosis.surrogate.forward import PredictedLoops, simulate
from wirewear.diagnosis.surrogate.sensed_loops import still_to_come
from wirewear.diagnosis.wording import (
    in_words,
    next_measurement,
    parameters_in_words,
    plain,
    share,
    steps,
    worth_telling,
)
from wirewear.pictures.style import VARIANT_COLOURS
from wirewear.records import MeasuredScar
from wirewear.results.scar import SCAR_EDGE, SCAR_FIGURES, called

if TYPE_CHECKING:
    from wirewear.diagnosis.answer import Diagnosis
    from wirewear.diagnosis.record_diagnosis import Diagnosed


TEMPLATE = Path(__file__).with_name("diagnosis.html")
JSON_FILE_NAME, REPORT_FILE_NAME = "diagnosis.json", "report.html"

#: Of each verdict the heading, and whether the summary is coloured as good, open or bad.
VERDICTS = {
    "no_gap": ("No gap", "good"), "explained": ("Gap explained", ""),
    "ambiguous": ("Gap with several possible causes", "open"), "unexplained": ("Gap without a known cause", "bad"),
}  # fmt: skip
IN_PART = "Gap explained in part", "open"  #: The same where known effects remove most of it.


#: Places on a branch at which forces are compared; standard deviations to each side that hold 95 % of tests.
PLACES, WITHIN = 60, 1.96
DIRECTIONS = (1, -1)  #: Branches in the order of predicted loops, by their direction.
MODEL, WITH, CONFIRMED, MEASURED = *VARIANT_COLOURS[:3], "#9a9a9a"
CURVES = ("model", MODEL), ("explained", WITH)
MOST_LOOPS = 12  #: Cycles whose loops are shown at most.

#: From so many scatters on, a cell of the map has the next colour, pale to dark red, and the next ink.
SHADES = (
    (0, "#fff7e3", "#1a1a1a"), (1, "#fee9b4", "#1a1a1a"), (2, "#fed173", "#1a1a1a"), (3, "#feab49", "#1a1a1a"),
    (5, "#f97a36", "#1a1a1a"), (8, "#e4401f", "#fff"), (12, "#b10026", "#fff"),
)  # fmt: skip


def write_diagnosis(diagnosed: Diagnosed, folder: Path) -> list[Path]:
    """Write diagnosis.json and report.html and return their paths. Raises ResultError if they cannot be written."""
    texts = {
        JSON_FILE_NAME: json_text(with_checksum(finite(diagnosed.diagnosis.to_json())), indent=1) + "\n",
        REPORT_FILE_NAME: page(diagnosed),
    }
    with writing(ResultError, f"cannot write the diagnosis to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return [write_text(folder / name, text) for name, text in texts.items()]


def page(diagnosed: Diagnosed) -> str:
    """Self-contained HTML page of a diagnosis."""
    diagnosis, found = diagnosed.diagnosis, diagnosed.search
    drawn = loops(diagnosed)
    filters: dict[str, frame.Filter] = {
        "plain": plain,
        "named": in_words,
        "parameters": parameters_in_words,
        "share": share,
        "with_unit": _with_unit,
    }
    values = {
        "d": diagnosis,
        "diagnosed": diagnosed,
        "said": IN_PART if diagnosis.partial is not None else VERDICTS[diagnosis.verdict],
        "map": gap_map(diagnosed),
        "zones": zone_bars(diagnosed),
        "likely": worth_telling(diagnosis)[:5],
        "gaps": gap_bars(diagnosed),
        "steps": steps(diagnosis),
        "of_scar": bool(drawn["sections"]) and shows_in_scar(diagnosed),
        "next": next_measurement(diagnosis),
        "sections": drawn["sections"],
        "data": frame.embedded(drawn),
        "script": frame.script(frame.HERE / "charts.js", TEMPLATE.with_name("diagnosis.js")),
        "fits": sorted((found.none, *found.singles, *found.pairs), key=lambda one: -one.log_evidence)[:15],
        "program": program(),
    }
    return frame.rendered(TEMPLATE, values, filters)


def _with_unit(name: str) -> str:
    """Name of a quantity with its unit, such as: slip amplitude [µm]."""
    percent = name.removesuffix("_percent")
    return f"{words_of(percent)} [{unit_of(name) if percent == name else '%'}]"


def ten_lines(diagnosis: Diagnosis) -> str:
    """The answer of a diagnosis in at most ten lines of text, for a terminal."""
    lines = [f"{diagnosis.record}: {diagnosis.sentence}"]
    for one in worth_telling(diagnosis)[:3]:
        values = "; ".join(filter(None, map(parameters_in_words, one.causes)))
        lines.append(f"  {share(one.probability)}: {one.words}{f': {values}' if values else ''}")
    if diagnosis.verdict != "no_gap":
        places = [f"  where: {one.text} ({share(one.share)} of the gap)" for one in diagnosis.where[:2]]
        lines += places or ["  where: no zone alone is beyond chance, many together are"]
        cycles, shrink = ", ".join(map(counted, diagnosis.shrink.held_out)), diagnosis.shrink
        unused = f"{shrink.scar_words}cycle{'s' if len(shrink.held_out) > 1 else ''} {cycles}" if cycles else "nothing"
        lines.append(f"  check on what the fit did not use ({unused}): {_checked(shrink)}")
    lines += [f"  {what}: {text}" for what, text in steps(diagnosis)]
    if diagnosis.undetectable:
        lines.append(f"  could not be seen here: {', '.join(plain(name) for name in diagnosis.undetectable)}")
    return "\n".join(lines[:10])


def _checked(shrink: Shrink) -> str:
    """Sentence on the gap before and after the explanation, and on the floor that chance leaves."""
    floor = f"chance alone leaves {shrink.floor:.2f}"
    if not shrink.shows_gap:
        hidden = "how far tests may scatter hides the gap from this check"
        return f"the model alone differs by {shrink.before:.2f} scatters, {floor}: {hidden}"
    share, low, high = (f"{100.0 * one + 0.0:.0f} %" for one in (shrink.shrink, *shrink.interval95))
    fall = f"the difference falls from {shrink.before:.2f} to {shrink.after:.2f} scatters, {floor}"
    return f"{fall}; shrink {share} ({low} to {high})"


Bar = tuple[str, float, float, str]  #: Name, value, per cent of the longest, colour.


def residuals(
    loops: tuple[ReducedLoop, ...], predicted: PredictedLoops, row: int, scatter: Mapping[str, float], load_N: float
) -> list[dict[str, Array]]:
    """Measured less computed force along the forward and the backward branch of one cycle's loop.

    Each is a table of arrays (n,): displacement_um; force_N, mean over the repeats less the computed force; band_N,
    half-width of the band in which 95 % of tests lie. loops: measured loops of this cycle. predicted: computed loops,
    with this cycle at the index `row`. scatter: standard deviations between tests by name. load_N: normal load.
    """
    found = []
    for place, sign in enumerate(DIRECTIONS):
        own = [branch for loop in loops for branch in loop.branches if branch.sign == sign]
        x, q = sign * predicted.displacement_um[row, place], sign * predicted.tangential_force_N[row, place]
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
    """Half-width in N of the 95 % band: scatter of friction, load, offsets and amplitude, and noise, added in
    squares.
    """

    def size(name: str) -> float:
        return float(scatter.get(name, 0.0))

    stretched = np.hypot(size("friction"), size("load")) * force_N
    moved_um = np.hypot(size("displacement_offset_um"), size("amplitude") * at_um)
    shifted = np.gradient(force_N, at_um) * moved_um
    return np.asarray(WITHIN * np.sqrt(stretched**2 + shifted**2 + (size("force_offset") * load_N) ** 2 + noise_N**2))


def measured_section(scars: Iterable[MeasuredScar]) -> list[tuple[Array, Array]]:
    """For each map with enough points, distances in µm along the motion from the scar's middle, and depths in µm, both
    (n,).
    """
    found = []
    for scar in scars:
        if scar.depth_um.size < FEWEST_POINTS:
            continue
        depth = scar.worn_um
        weight = np.maximum(depth, 0.0)
        if not weight.sum() > 0.0:
            found.append((scar.x_um, depth.mean(axis=1)))
            continue
        middle_x = float(weight.sum(axis=1) @ scar.x_um / weight.sum())
        middle_y = float(weight.sum(axis=0) @ scar.y_um / weight.sum())
        near = np.abs(scar.y_um - middle_y)
        # A section is averaged over this share of the scar's width about its middle.
        strip = near <= max(0.1 * float(np.ptp(scar.y_um)), float(near.min()))
        found.append((scar.x_um - middle_x, depth[:, strip].mean(axis=1)))
    return found


def bowl(figures: Array, places: int = 41) -> tuple[Array, Array]:
    """Section of a paraboloid with the depth and length of a scar: distances and depths (places,) in µm.

    figures: (4,) `SCAR_FIGURES`. A paraboloid's section, averaged over its width, goes as (1 − x²/a²)^(3/2), so that
    the length, measured where that is `SCAR_EDGE` of its largest, is 2 a √(1 − SCAR_EDGE^(2/3)).
    """
    depth, length = (float(figures[SCAR_FIGURES.index(name)]) for name in ("depth", "length"))
    half = 0.5 * length / np.sqrt(1.0 - SCAR_EDGE ** (2.0 / 3.0))
    x = np.linspace(-half, half, places)
    return x, depth * (1.0 - (x / max(half, 1e-9)) ** 2)


def loops(diagnosed: Diagnosed) -> dict[str, object]:
    """Measured and computed loops, their differences and sections of the scars, as plain values for the page."""
    known = sorted({loop.cycle for loop in diagnosed.observed.loops})
    kept = np.unique(np.linspace(0, len(known) - 1, min(MOST_LOOPS, len(known))).round().astype(int))
    cycles = [known[place] for place in kept]
    at = np.array(cycles or [diagnosed.setup.cycles], dtype=float)
    best = diagnosed.search.best
    curves = [("model", MODEL, simulate(diagnosed.states, diagnosed.setup, at))]
    if _explains(diagnosed):
        alike = any(effect_of(name) in members for members in diagnosed.diagnosis.equivalent for name in best.names)
        label = "with " + " and ".join(plain(name) for name in best.names) + (" or its like" if alike else "")
        curves.append((label, WITH, simulate(diagnosed.states, best.setup, at)))
    return {
        "cycles": cycles,
        "measured": [_measured(diagnosed, cycle) for cycle in cycles],
        "colour": MEASURED,
        "left": [
            [_left(diagnosed, predicted, row, cycle) for row, cycle in enumerate(cycles)] for _, _, predicted in curves
        ],
        "begin": _telling_cycle(diagnosed, cycles) if cycles else 0,
        "sections": _sections(diagnosed, curves),
        "curves": [
            {
                "name": name,
                "colour": colour,
                "loops": [
                    [numbers(x.ravel()), numbers(q.ravel())]
                    for x, q in zip(predicted.displacement_um, predicted.tangential_force_N, strict=True)
                    if cycles
                ],
            }
            for name, colour, predicted in curves
        ],
    }


def _left(diagnosed: Diagnosed, predicted: PredictedLoops, row: int, cycle: int) -> list[list[list[float | None]]]:
    """For both branches: displacement, measured less computed force, and half-width of the 95 % band."""
    own = tuple(loop for loop in diagnosed.observed.loops if loop.cycle == cycle)
    scatter = diagnosed.search.covariance.scatter
    branches = residuals(own, predicted, row, scatter, diagnosed.setup.load_N)
    return [[numbers(one[name]) for name in ("displacement_um", "force_N", "band_N")] for one in branches]


def _telling_cycle(diagnosed: Diagnosed, cycles: Sequence[int]) -> int:
    """Index of the last cycle at which the clearest gap shows, or else of the last cycle."""
    shows = [one.cycles[1] for one in diagnosed.diagnosis.resembles[:1]]
    shows = shows or [finding.cycles[1] for finding in diagnosed.diagnosis.where[:1]]
    last = shows[0] if shows else cycles[-1]
    return max((place for place, cycle in enumerate(cycles) if cycle <= last), default=len(cycles) - 1)


def _sections(diagnosed: Diagnosed, curves: Sequence[tuple[str, str, PredictedLoops]]) -> list[dict[str, object]]:
    """Cross-sections of the worn bodies along the motion, measured and computed, to be drawn.

    Where no profile is computed, each computed curve is a bowl with the computed depth and length of the scar.
    """
    found: list[dict[str, object]] = []
    for place, body in enumerate(diagnosed.record.tables.body_names):
        scars, predictions = diagnosed.record.scars_of(body), [predicted for _, _, predicted in curves]
        if predictions[0].profiles:
            measured = [(one.x_um, one.depth_um) for one in map(read_profile, scars)]
            computed = [predicted.profiles[body] for predicted in predictions]
        else:
            measured, computed = measured_section(scars), [bowl(predicted.scars[place]) for predicted in predictions]
        if measured:
            drawn = {"measured": measured, "bowls": computed}
            heights = {name: [[numbers(x), numbers(-depth)] for x, depth in own] for name, own in drawn.items()}
            found.append({"wire": called(body), **heights})
    return found


def gap_map(diagnosed: Diagnosed) -> tuple[list[int], list[tuple[str, list[tuple[Place, str, str] | None]]]]:
    """Cycles, and for each measured zone its label and its cells: difference, colour and ink at each cycle, None if not
    measured.
    """
    found = places(diagnosed.search.problem, diagnosed.search.covariance, diagnosed.setup)
    shades = [next(shade[1:] for shade in reversed(SHADES) if place.in_scatter >= shade[0]) for place in found]
    cells = {(place.zone, place.cycle): (place, *shade) for place, shade in zip(found, shades, strict=True)}
    cycles, measured = sorted({cycle for _, cycle in cells}), {zone for zone, _ in cells}
    zones = [(zone, label) for zone, label in row_labels().items() if zone in measured]
    return cycles, [(label, [cells.get((zone, cycle)) for cycle in cycles]) for zone, label in zones]


def zone_bars(diagnosed: Diagnosed) -> list[tuple[str, bool, list[Bar]]]:
    """For the five zones that differ most: label, whether beyond chance, and bars of the root mean square of the
    difference in scatters, nominal and explained.
    """
    found = diagnosed.search
    setups = [diagnosed.setup, *([found.best.setup] if _explains(diagnosed) else [])]
    rows = [places(found.problem, found.covariance, setup) for setup in setups]
    beyond = {place.zone for place in rows[0] if place.flagged}
    sizes = {
        zone: [float(np.sqrt(np.mean([one.in_scatter**2 for one in row if one.zone == zone]))) for row in rows]
        for zone in {place.zone for place in rows[0]}
    }
    # Zones whose size is shown at most.
    most = sorted(sizes, key=lambda zone: (zone not in beyond, -sizes[zone][0]))[:5]
    longest = max(max(sizes[zone]) for zone in most)
    bars = {
        zone: _bars([(*one, size) for one, size in zip(CURVES, sizes[zone], strict=False)], longest) for zone in most
    }
    return [(row_labels()[zone], zone in beyond, bars[zone]) for zone in most]


def shows_in_scar(diagnosed: Diagnosed) -> bool:
    """True if the largest gap is in a scar, or there are no loops."""
    words = {part.observable.words for part in diagnosed.search.problem.layout if part.observable.of_scars}
    largest = [finding.observable for finding in diagnosed.diagnosis.where[:1]]
    return not diagnosed.observed.loops or not words.isdisjoint(largest)


def _explains(diagnosed: Diagnosed) -> bool:
    """True if the diagnosis states an explanation of all or part of the gap."""
    said = diagnosed.diagnosis.verdict in ("explained", "ambiguous") or diagnosed.diagnosis.partial is not None
    return said and bool(diagnosed.search.best.candidates)


def gap_bars(diagnosed: Diagnosed) -> list[Bar]:
    """Bars of the gap: nominal, explained, by a full simulation if there was one, and the floor that chance leaves."""
    shrink, confirmed = diagnosed.diagnosis.shrink, diagnosed.diagnosis.confirmed
    values = [
        (*CURVES[0], shrink.before),
        *([(*CURVES[1], shrink.after)] if _explains(diagnosed) else []),
        *([("full simulation", CONFIRMED, confirmed.after)] if confirmed else []),
        ("chance alone (floor)", MEASURED, shrink.floor),
    ]
    return _bars(values, max((value for _, _, value in values if np.isfinite(value)), default=0.0) or 1.0)


def _bars(rows: Iterable[tuple[str, str, float]], longest: float) -> list[Bar]:
    return [(name, value, 100.0 * value / longest, colour) for name, colour, value in rows]


def _measured(diagnosed: Diagnosed, cycle: int) -> list[list[list[float | None]]]:
    found = []
    for loop in diagnosed.observed.loops:
        if loop.cycle == cycle:
            x = np.concatenate([branch.sign * branch.displacement_um for branch in loop.branches])
            q = np.concatenate([branch.sign * branch.force_N for branch in loop.branches])
            found.append([numbers(x), numbers(q)])
    return found
