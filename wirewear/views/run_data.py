"""What a page shows of a run, as plain values: rounded to what can be seen, fields as 16-bit integers."""

import base64
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from geometry.arrays import Array
from wirewear.base.frame import number, numbers
from wirewear.loops import LoopError, LoopFigures, analyse_loop
from wirewear.pictures.smooth import chosen_cycles, smooth_loop, smooth_scar, worn_half_extent
from wirewear.pictures.style import DEPTH_COLOURS, VARIANT_COLOURS
from wirewear.results import PRESSURE_LENGTH, Loop, RunResult, Scar
from wirewear.results.flat import named_for_users
from wirewear.results.scar import called
from wirewear.views.run_maps import (
    LOADS,
    energy_ratio,
    fresh_contact,
    line_through_origin,
    running_conditions,
    tension_lines,
)

Course = tuple[str, str, str]  #: A column of the evolution, what it is called, and its dashes in SVG.

_OF_NODES: tuple[Course, ...] = (
    ("max_pressure_MPa", "largest at a node", "5 3"),
    ("mid_stroke_pressure_MPa", "at a node at mid-stroke", ""),
)

#: What a page calls columns of the evolution.
_COURSES = {
    "cycle": "cycle",
    "amplitude": "displacement_amplitude_um",
    "slip": "slip_amplitude_um",
    "energy": "dissipated_energy_mJ",
    "force": "max_tangential_force_N",
    "load": "normal_force_N",
    "worked": "accumulated_energy_J",
}


#: Points of a loop and of a section; lines of a surface along each side; scars at most; colours of the depth.
LOOP_POINTS, SECTION_POINTS, LINES, MOST_SCARS, SHADES = 160, 161, 72, 8, 48

MARGIN = 1.25  #: Surfaces are shown to this many times the worn half-length.
BEYOND = 4.0  #: The map of the material's response reaches beyond the test's displacement by this factor.
DASHES = ("", "7 3", "2 2", "8 2 2 2", "4 2", "10 3")  #: What dashes tell runs apart in SVG.


def pressure_courses(evolution: Mapping[str, Array], settings: Mapping[str, Any]) -> tuple[Course, ...]:
    """The largest pressure of the cycle and that about mid-stroke, of a run's evolution and settings."""
    if PRESSURE_LENGTH not in settings:
        return _OF_NODES
    over = f"mean over {settings[PRESSURE_LENGTH]:.3g} µm"
    found: tuple[Course, ...] = (
        ("max_mean_pressure_MPa", f"largest {over}", "5 3"),
        ("mid_stroke_mean_pressure_MPa", f"{over} at mid-stroke", ""),
    )
    return found if all(name in evolution for name, _, _ in found) else _OF_NODES


def page_data(results: Iterable[RunResult]) -> dict[str, Any]:
    """Everything that the page of these runs draws."""
    runs = [_run(result, index) for index, result in enumerate(results)]
    shades = DEPTH_COLOURS(np.linspace(0.0, 1.0, SHADES))[:, :3]
    return {"runs": runs, "shades": np.round(255 * shades).astype(int).tolist()}


def friction_log(loops: Iterable[Loop]) -> list[tuple[int, LoopFigures]]:
    """The figures of each loop that can be analysed, by its cycle."""
    found = []
    for loop in loops:
        try:
            figures = analyse_loop(
                loop.displacement_um, loop.tangential_force_N, loop.normal_force_N, time_s=loop.time_s
            )
        except LoopError:
            continue
        found.append((loop.cycle, figures))
    return found


def slope_mm3_per_J(energy_J: Array, volume_mm3: Array) -> float:
    """Of the straight line through the origin, by least squares; NaN where nothing is dissipated."""
    return line_through_origin(energy_J, volume_mm3).slope_mm3_per_J if energy_J.any() else float("nan")


def _run(result: RunResult, index: int) -> dict[str, Any]:
    """What a page shows of a run; of a line contact per mm of its length."""
    conditions = running_conditions(result.study)
    per, worn, worn_unit = ("", 1e3, "10⁻³ mm³") if not result.length_mm else ("/mm", 1e6, "µm²")
    result = result.of_length(1.0) if per else result
    evolution = result.evolution
    columns = {
        **{name: evolution[column] for name, column in _COURSES.items()},
        "worn": worn * result.worn_volume_mm3,
        "ratio": energy_ratio(*(evolution[_COURSES[name]] for name in ("energy", "amplitude", "force"))),
    }
    pressures = pressure_courses(result.evolution, result.settings)
    bodies = result.bodies[::-1]
    return {
        "label": result.label,
        "color": VARIANT_COLOURS[index % len(VARIANT_COLOURS)],
        "dash": DASHES[index % len(DASHES)],
        "units": {"force": f"N{per}", "energy": f"mJ{per}", "worked": f"J{per}", "worn": worn_unit},
        "evolution": {
            **{name: numbers(column) for name, column in named_for_users(result, result.evolution).items()},
            "energy_ratio": numbers(columns["ratio"]),
        },
        "courses": {name: numbers(column) for name, column in columns.items()},
        "depths": [(called(body), numbers(evolution[f"max_depth_{body}_um"])) for body in bodies],
        "pressures": [(words, dash, numbers(evolution[name])) for name, words, dash in pressures],
        "loops": [_loop(loop) for loop in sorted(result.loops, key=lambda loop: loop.cycle)],
        "friction": _friction(result),
        "slope_mm3_per_J": number(slope_mm3_per_J(evolution["accumulated_energy_J"], result.worn_volume_mm3)),
        "worn_per_mm3": worn,
        "conditions": None
        if conditions is None
        else {name: numbers(getattr(conditions, name)) for name in ("normal_load_N", "contact_um", "test_um")},
        "tensions": _tensions(result),
        "scars": {body: _scars(result, body) for body in bodies} if result.scar_cycles() else None,
    }


def _tensions(result: RunResult) -> list[dict[str, Any]]:
    """Lines of equal tension about the test, none where too little is stated."""
    contact = fresh_contact(result.study)
    if contact is None:
        return []
    low, high = (contact.normal_load_N * float(LOADS[end]) for end in (0, -1))
    reach = BEYOND * float(result.evolution["displacement_amplitude_um"].max())
    return [
        {"tension": number(line.tension_MPa), "x": numbers(line.displacement_um), "y": numbers(line.normal_load_N)}
        for line in tension_lines(contact, reach, (low, high))
    ]


def _loop(loop: Loop) -> dict[str, Any]:
    x, q = smooth_loop(loop, LOOP_POINTS)
    return {"cycle": loop.cycle, "x": numbers(x), "q": numbers(q)}


def _friction(result: RunResult) -> dict[str, list[float | None]]:
    log = friction_log(sorted(result.loops, key=lambda loop: loop.cycle))
    names = ("friction_max", "friction_energy", "friction_geometry_independent")
    columns: dict[str, list[float | None]] = {"cycle": [cycle for cycle, _ in log]}
    for name in names:
        values = [getattr(figures, name) for _, figures in log]
        columns[name] = [None if one is None else number(one.value) for one in values]
    return columns


def _scars(result: RunResult, body: str) -> dict[str, Any]:
    """The scars of a body on one grid in the sliding frame, and their sections along the motion.

    Of a line contact they are sections alone, with pressure and slip amplitude.
    """
    cycles = chosen_cycles(result.scar_cycles(), MOST_SCARS)
    scars = [result.scar(cycle, body) for cycle in cycles]
    own: dict[str, Any] = {"cycles": list(cycles), "called": called(body)}
    if result.length_mm:
        x, smooth = scars[-1].axial_um, scars
        deepest = max(scar.max_depth_um for scar in scars)
        pressures = [numbers(scar.pressure_MPa[:, 0]) for scar in scars]
        slips = [numbers(0.25 * scar.slip_distance_um[:, 0]) for scar in scars]
        own["profiles"] = {"pressure_MPa": pressures, "slip_amplitude_um": slips}
    else:
        reach = MARGIN * max(worn_half_extent(scars))
        lines, x = np.linspace(-reach, reach, LINES), np.linspace(-reach, reach, SECTION_POINTS)
        smooth = [smooth_scar(scar) for scar in scars]
        depths = [scar.sampled(lines, lines) for scar in smooth]
        deepest = max(float(depth.max()) for depth in depths) or 1.0
        own["lines"] = numbers(lines)
        own["depths"] = [_packed(depth, deepest) for depth in depths]
        own["unworn"] = [numbers(row) for row in _heights(scars[-1], lines[:, None], lines[None, :])]
    section = {
        "x": numbers(x),
        "unworn": numbers(_heights(scars[-1], x, np.zeros(1))),
        "depths": [numbers(scar.sampled(x, np.zeros(1))[:, 0]) for scar in smooth],
    }
    return own | {"deepest": number(deepest), "section": section}


def _heights(scar: Scar, x: Array, y: Array) -> Array:
    """Heights [µm] of the unworn surface, NaN beyond its flanks."""
    places, flanks = scar.wire_coordinates(x, y), scar.flanks_um
    inside = (np.abs(places[0]) < flanks[0]) & (np.abs(places[1]) < flanks[1])
    return np.where(inside, scar.unworn_height_um(*places), np.nan)


def _packed(depth: Array, deepest: float) -> str:
    """Depths as shares of the deepest, in little-endian 16-bit integers."""
    return base64.b64encode(np.round(65535.0 * depth / deepest).astype("<u2").tobytes()).decode("ascii")
