"""A table of runs side by side that fits on one screen of a terminal."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from rich import box
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from wirewear.base.errors import ResultError
from wirewear.base.words import counted
from wirewear.results import RunResult
from wirewear.results.evolution import OVER_YIELD, PLASTIC_VOLUME, PRESSURE_LENGTH
from wirewear.results.health import flagged, limit_of, remedies

STATUS_STYLES = {"complete": "green", "running": "yellow", "failed": "red"}
NOTHING = "–"

Row = tuple[str, Callable[[RunResult], str]]  #: One cell for each run; each function takes a result.


def summary(results: Sequence[RunResult]) -> RenderableType:
    """A table for rich to print, one column per run (state, amplitudes, energy, wear, pressures, quality and time),
    then remedies for qualities beyond their limits and the files. Raises ResultError if there are no results.
    """
    if not results:
        raise ResultError("there are no results to sum up")
    table = Table(box=box.SIMPLE, pad_edge=False)
    said = results[0].extent.said
    of_length = f", {said}" if said else ""
    table.add_column(Text(f"{results[0].name}, {results[0].fidelity} fidelity{of_length}"), overflow="fold")
    for result in results:
        table.add_column(Text(result.variant), justify="right", overflow="fold")
    bodies, name_of = results[0].bodies, results[0].called
    layered = [body for body in bodies if any(len(result.layer_faces_um(body)) for result in results)]
    for section in (
        _STATE,
        [*_MOTION, *_bulk_rows(results)],
        [
            *((f"deepest wear, {name_of(body)} [µm]", _at(f"max_depth_{body}_um", -1)) for body in bodies),
            *((f"layers worn through, {name_of(body)} [cycle]", _worn_through(body)) for body in layered),
            *(
                (f"worn volume, {name_of(body)} [10⁻³ mm³]", _at(f"worn_volume_{body}_mm3", -1, 1e-3))
                for body in bodies
            ),
            *(_PRINTS if any(PLASTIC_VOLUME in result.evolution for result in results) else ()),
        ],
        _PRESSURES,
        _quality_rows(results),
        _COST,
    ):
        for name, cell in section:
            table.add_row(Text(name), *(cell(result) for result in results))
        table.add_section()
    files = [Text(str(result.path), overflow="fold") for result in results if result.path]
    beyond = {name for result in results for name, value in result.quality.items() if value > limit_of(name)}
    return Group(table, *map(Text, remedies(beyond)), *([Text("Results are in"), *files] if files else []))


def _status(result: RunResult) -> str:
    return f"[{STATUS_STYLES[result.status]}]{result.status}[/]"


def _message(result: RunResult) -> str:
    return escape(result.message) or NOTHING


def _at(column: str, place: int, unit: float = 1.0) -> Callable[[RunResult], str]:
    """A function that gives the text of a column's value at the first (0) or last (−1) measured cycle, over `unit`."""

    def cell(result: RunResult) -> str:
        values = result.evolution.get(column, np.zeros(0))
        return _number(float(values[place]) / unit) if values.size else NOTHING

    return cell


def _first_and_last(column: str) -> Callable[[RunResult], str]:
    first, last = _at(column, 0), _at(column, -1)
    return lambda result: f"{first(result)} → {last(result)}"


def _largest(column: str) -> Callable[[RunResult], str]:
    def cell(result: RunResult) -> str:
        values = [value for value in result.evolution[column] if not math.isnan(value)]
        return _number(max(values)) if values else NOTHING

    return cell


def _cycles(result: RunResult) -> str:
    cycles = result.evolution["cycle"]
    return f"{counted(cycles[-1])} ({cycles.size} measured)" if cycles.size else NOTHING


def _quality_rows(results: Sequence[RunResult]) -> list[Row]:
    names = sorted({name for result in results for name in result.quality})

    def value(name: str) -> Callable[[RunResult], str]:
        return lambda result: flagged(name, result.quality[name]) if name in result.quality else NOTHING

    return [(f"worst {name.replace('_', ' ')}", value(name)) for name in names]


def _worn_through(body: str) -> Callable[[RunResult], str]:
    def cell(result: RunResult) -> str:
        cycles = ["not" if cycle is None else counted(round(cycle)) for cycle in result.worn_through(body)]
        return ", ".join(cycles) or NOTHING

    return cell


def _bulk_rows(results: Sequence[RunResult]) -> list[Row]:
    """Rows with the least and the largest axial plus bending stress over the first logged cycle, for bodies that carry
    any.
    """

    def cell(body: str) -> Callable[[RunResult], str]:
        def shown(result: RunResult) -> str:
            found = (one.bulk_stress_MPa for one in result.contact_forces if one.body == body)
            stress = next((one for one in found if one is not None), None)
            if stress is None:
                return NOTHING
            along = stress[:, :2].sum(axis=1)
            return f"{_number(float(along.min()))} … {_number(float(along.max()))}"

        return shown

    rows = [(f"bulk stress along the {results[0].called(body)} [MPa]", cell(body)) for body in results[0].bodies]
    return [row for row in rows if any(row[1](result) != NOTHING for result in results)]


def _pressure_length(result: RunResult) -> str:
    return _number(float(result.settings.get(PRESSURE_LENGTH, math.nan)))


def _wall_time(result: RunResult) -> str:
    if "total" in result.timings_s:
        return f"{result.timings_s['total']:.1f} s"
    return f"{math.fsum(result.timings_s.values()):.1f} s" if result.timings_s else NOTHING


def _number(value: float) -> str:
    return NOTHING if math.isnan(value) else f"{value:.4g}"


_STATE: list[Row] = [("status", _status), ("message", _message), ("cycles", _cycles)]

_MOTION: list[Row] = [
    ("displacement amplitude δa [µm]", _at("displacement_amplitude_um", -1)),
    ("slip amplitude δ0, first → last [µm]", _first_and_last("slip_amplitude_um")),
    ("energy per cycle, first → last [mJ]", _first_and_last("dissipated_energy_mJ")),
    ("friction energy in all [J]", _at("accumulated_energy_J", -1)),
    ("largest tangential force [N]", _largest("max_tangential_force_N")),
]

_PRINTS: list[Row] = [
    ("volume of prints [10⁻³ mm³]", _at(PLASTIC_VOLUME, -1, 1e-3)),
    ("mean pressure over yield stress, first → last", _first_and_last(OVER_YIELD)),
]

_PRESSURES: list[Row] = [
    ("mean pressures are over [µm]", _pressure_length),
    ("largest mean pressure, first → last [MPa]", _first_and_last("max_mean_pressure_MPa")),
    ("the same at mid-stroke, median [MPa]", _first_and_last("mid_stroke_mean_pressure_MPa")),
    ("largest pressure at a node, first → last [MPa]", _first_and_last("max_pressure_MPa")),
    ("the same at mid-stroke, median [MPa]", _first_and_last("mid_stroke_pressure_MPa")),
]

_COST: list[Row] = [("wall time", _wall_time)]
