"""HTML page of the runs of a study side by side, and the outcome of a run as sentences and rows."""

import base64
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from geometry.arrays import Array
from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.frame import DEPTH_SHADES, VARIANT_COLOURS, number, numbers
from wirewear.base.writing import write_text, writing
from wirewear.comparison.maps import LOADS, TRANSITION, energy_ratio, fresh_contact, running_conditions, tension_lines
from wirewear.loops import LoopError, LoopFigures, analyse_loop
from wirewear.pictures.smooth import chosen_cycles, smooth_loop, smooth_scar, worn_half_extent
from wirewear.results import PRESSURE_LENGTH, Loop, RunResult, Scar
from wirewear.results.export import named_for_users
from wirewear.results.health import health
from wirewear.views.run_words import balance, sentence, settings_rows, slope_mm3_per_J

Column = tuple[str, str, str]  #: A column of the evolution, what it is called, and its dashes in SVG.

_OF_NODES: tuple[Column, ...] = (
    ("max_pressure_MPa", "largest at a node", "5 3"),
    ("mid_stroke_pressure_MPa", "at a node at mid-stroke", ""),
)

#: What a page calls columns of the evolution.
_COLUMNS = {
    "cycle": "cycle",
    "amplitude": "displacement_amplitude_um",
    "slip": "slip_amplitude_um",
    "energy": "dissipated_energy_mJ",
    "force": "max_tangential_force_N",
    "load": "normal_force_N",
    "worked": "accumulated_energy_J",
}


#: Points of a loop and of a section; lines of a surface along each side; scars at most.
LOOP_POINTS, SECTION_POINTS, LINES, MOST_SCARS = 160, 161, 72, 8

BEYOND = 4.0  #: The map of the material's response reaches beyond the test's displacement by this factor.
DASHES = ("", "7 3", "2 2", "8 2 2 2", "4 2", "10 3")  #: Dashes that distinguish runs in SVG.

PAGE_NAME = "report.html"
HERE = Path(__file__).parent
_SCRIPTS = ("fretting_log", "slider", "run")


def pressures_shown(evolution: Mapping[str, Array], settings: Mapping[str, object]) -> tuple[Column, ...]:
    """Columns of the evolution for the largest pressure of a cycle and for the pressure at mid-stroke, each with words
    and dashes; averaged over a length if the run has such means. evolution, settings: of the run.
    """
    if PRESSURE_LENGTH not in settings:
        return _OF_NODES
    over = f"mean over {settings[PRESSURE_LENGTH]:.3g} µm"
    found: tuple[Column, ...] = (
        ("max_mean_pressure_MPa", f"largest {over}", "5 3"),
        ("mid_stroke_mean_pressure_MPa", f"{over} at mid-stroke", ""),
    )
    return found if all(name in evolution for name, _, _ in found) else _OF_NODES


def page_data(results: Iterable[RunResult]) -> dict[str, object]:
    """Data of the page of these runs as plain values, for JSON."""
    return {"runs": [_data_of_run(result, index) for index, result in enumerate(results)], "shades": DEPTH_SHADES}


def friction_log(loops: Iterable[Loop]) -> list[tuple[int, LoopFigures]]:
    """Cycle and figures of each loop that can be analysed; others are left out."""
    found = []
    for loop in loops:
        try:
            signals = loop.displacement_um, loop.tangential_force_N, loop.normal_force_N
            figures = analyse_loop(*signals, time_s=loop.time_s, cycle=loop.cycle)
        except LoopError:
            continue
        found.append((loop.cycle, figures))
    return found


def _data_of_run(result: RunResult, index: int) -> dict[str, object]:
    """Values of one run for the page; for a line contact per mm of its length."""
    conditions = running_conditions(result.study)
    per, (worn, worn_unit) = result.extent.per, result.extent.wear_unit
    result = result.computed
    evolution = result.evolution
    columns = {
        **{name: evolution[column] for name, column in _COLUMNS.items()},
        "worn": worn * result.worn_volume_mm3,
        "ratio": energy_ratio(*(evolution[_COLUMNS[name]] for name in ("energy", "amplitude", "force"))),
    }
    pressures = pressures_shown(result.evolution, result.settings)
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
        "depths": [(result.called(body), numbers(evolution[f"max_depth_{body}_um"])) for body in bodies],
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


def _tensions(result: RunResult) -> list[dict[str, object]]:
    """Lines of equal tension around the test; empty if the study states too little."""
    contact = fresh_contact(result.study)
    if contact is None:
        return []
    low, high = (contact.normal_load_N * float(LOADS[end]) for end in (0, -1))
    reach = BEYOND * float(result.evolution["displacement_amplitude_um"].max())
    return [
        {"tension": number(line.tension_MPa), "x": numbers(line.displacement_um), "y": numbers(line.normal_load_N)}
        for line in tension_lines(contact, reach, (low, high))
    ]


def _loop(loop: Loop) -> dict[str, object]:
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


def _scars(result: RunResult, body: str) -> dict[str, object]:
    """Scars of a body on a common grid in the sliding frame, and their sections along the motion.

    For a line contact: sections only, with pressure and slip amplitude.
    """
    cycles = chosen_cycles(result.scar_cycles(), MOST_SCARS)
    scars = [result.scar(cycle, body) for cycle in cycles]
    own: dict[str, object] = {"cycles": list(cycles), "called": result.called(body)}
    x, smooth, deepest, shown = _WORN[result.extent.worn](scars)
    section = {
        "x": numbers(x),
        "unworn": numbers(_heights(scars[-1], x, np.zeros(1))),
        "depths": [numbers(scar.sampled(x, np.zeros(1))[:, 0]) for scar in smooth],
        "layers": numbers(result.layer_faces_um(body)),
    }
    return {**own, **shown, "deepest": number(deepest), "section": section}


#: Places along a section, the scars as sections show them, the deepest depth, and what else a page holds of scars.
Worn = tuple[Array, Sequence[Scar], float, dict[str, object]]


def _profiles(scars: Sequence[Scar]) -> Worn:
    """Sections of a line contact's scars with their pressures and slip amplitudes."""
    pressures = [numbers(scar.pressure_MPa[:, 0]) for scar in scars]
    slips = [numbers(0.25 * scar.slip_distance_um[:, 0]) for scar in scars]
    deepest = max(scar.max_depth_um for scar in scars)
    return scars[-1].axial_um, scars, deepest, {"profiles": {"pressure_MPa": pressures, "slip_amplitude_um": slips}}


def _maps(scars: Sequence[Scar]) -> Worn:
    """Depth maps of a point contact's scars on a common grid."""
    reach = 1.25 * max(worn_half_extent(scars))
    lines, x = np.linspace(-reach, reach, LINES), np.linspace(-reach, reach, SECTION_POINTS)
    smooth = [smooth_scar(scar) for scar in scars]
    depths = [scar.sampled(lines, lines) for scar in smooth]
    deepest = max(float(depth.max()) for depth in depths) or 1.0
    shares = (np.round(65535.0 * depth / deepest).astype("<u2") for depth in depths)
    shown: dict[str, object] = {
        "lines": numbers(lines),
        # As shares of the deepest, in little-endian 16-bit integers.
        "depths": [base64.b64encode(one.tobytes()).decode("ascii") for one in shares],
        "unworn": [numbers(row) for row in _heights(scars[-1], lines[:, None], lines[None, :])],
    }
    return x, smooth, deepest, shown


_WORN: dict[str, Callable[[Sequence[Scar]], Worn]] = {"scars": _maps, "profiles": _profiles}


def _heights(scar: Scar, x: Array, y: Array) -> Array:
    """Heights in µm of the unworn surface, NaN beyond the body's flanks."""
    places, flanks = scar.wire_coordinates(x, y), scar.flanks_um
    inside = (np.abs(places[0]) < flanks[0]) & (np.abs(places[1]) < flanks[1])
    return np.where(inside, scar.unworn_height_um(*places), np.nan)


def run_page(results: Sequence[RunResult]) -> str:
    """Self-contained HTML page of runs of one study. Raises ResultError if none has a measured cycle yet."""
    shown = [result for result in results if len(result.evolution["cycle"])]
    if not shown:
        raise ResultError("nothing is measured yet, so there is nothing to report")
    scripts = (frame.HERE / "charts.js", frame.HERE / "surface.js", *(HERE / f"{one}.js" for one in _SCRIPTS))
    return frame.rendered(
        HERE / "run.html",
        {
            "name": shown[0].name,
            "fidelity": shown[0].fidelity,
            "results": shown,
            "maps": running_conditions(shown[0].study) is not None,
            "sentences": [sentence(result) for result in results],
            "complete": all(result.status == "complete" for result in results),
            "balance": [balance(result) for result in shown],
            "transition": TRANSITION,
            "health": health(shown),
            "study": [settings_rows(result.study) for result in shown],
            "settings": [settings_rows(result.settings) for result in shown],
            "data": frame.embedded(page_data(shown)),
            "script": frame.script(*scripts),
        },
    )


def write_page(results: Sequence[RunResult], folder: Path) -> Path:
    """Write the page of runs of one study as report.html into a folder, created if missing, and return its path. Raises
    ResultError if no run has a measured cycle yet, or the page cannot be written.
    """
    text = run_page(results)
    with writing(ResultError, f"cannot write the page to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return write_text(folder / PAGE_NAME, text)
