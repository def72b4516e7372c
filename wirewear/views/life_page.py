"""Lives of bodies as sentences, JSON, pictures and an HTML page.

The sum is Miner's sum of damage; a crack begins where it reaches 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from geometry.arrays import Array
from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.words import counted
from wirewear.base.writing import json_text, write_csv, write_text, writing
from wirewear.pictures.style import INK, VARIANT_COLOURS, cycle_name, new_figure, panel_letters, save, svg
from wirewear.stress.life import BodyLife
from wirewear.stress.pictures import STRESS_COLOURS
from wirewear.test.materials import material_named

_PAGE = Path(__file__).parent / "life.html"
_DRAWN = 1e-3  #: Sums below this share of the largest are drawn as none.
NOT_AVERAGED = (
    "Stresses are not averaged over any length: this life does not converge as the mesh is refined. State a critical "
    "distance, a threshold with a fatigue limit, a grain or an averaging length."
)


def sentence(life: BodyLife) -> str:
    """Sentence on when and where a crack begins in a body, or why none does."""
    end = life.damage.end
    if life.initiation is None:
        peak = float(life.growth[1].max())
        why = f"no stress of it would make one within {_cycles(life.table.endurance_cycles)[0]} cycles"
        # Less than the damage of one such cycle is what interpolation leaves of none.
        if peak > 1.0 / life.table.endurance_cycles:
            why = f"damage wears off faster than it grows; the largest sum is {frame.figure(peak)}"
        return f"{life.called}: no crack begins, for {why}."
    median, first, *last = _cycles(life.cycles, *filter(np.isfinite, life.interval))
    between = f"{first} to {last[0]}" if last else f"from {first} on, or never"
    x, y = life.place_um
    where = f"x = {x:.0f} µm" + ("" if life.plane else f", y = {y:.0f} µm")
    deep = f"{life.depth_um:.1f} µm deep" if life.depth_um > 1e-2 else "at the surface"
    worn = f" under {life.worn_um:.1f} µm worn off" if life.worn_um > 1e-2 else ""
    angle = "" if life.plane_angle_deg is None else f", on a plane at {life.plane_angle_deg:.0f}° to the surface"
    when = f"after {median} cycles (95 % of lives by the scatter of data: {between})"
    how = f"a crack begins {when}"
    if life.initiation.beyond:
        on = "as at its end" if len(life.course.ahead) == 1 else "with its blocks in turn"
        how = f"no crack begins within {counted(round(end))} cycles; if it went on {on}, one would {when}"
    return f"{life.called}: {how}, at {where}, {deep}{worn}{angle}."


def _cycles(*lives: float) -> list[str]:
    """Numbers of cycles as text, all in the same notation."""
    return [counted(float(f"{life:.2g}")) if max(lives) < 1e9 else f"{life:.1e}" for life in lives]


def notes(life: BodyLife) -> list[str]:
    """Sentences on what limits a life's validity; empty if nothing does."""
    found = [] if life.averaged else [NOT_AVERAGED]
    if life.course.not_reached and any(one is None or one.beyond for one in (life.initiation, life.high)):
        names = " and ".join(life.course.not_reached)
        found.append(f"The run ended before {names} of its programme: what is said of cycles beyond leaves that out.")
    if life.table.material is not None:
        item = material_named(life.table.material)
        found.append(f"Data of {item.name}: {item.fatigue_note}.")
    return found


def life_json(lives: Sequence[BodyLife]) -> str:
    """JSON of lives; infinite values are null."""
    return json_text({"lives": [_plain(life) for life in lives]})


def _plain(life: BodyLife) -> dict[str, object]:
    low, high = life.interval
    initiation = life.initiation
    found: dict[str, object] = {
        "body": life.body,
        "sentence": sentence(life),
        "criterion": life.table.criterion,
        "cycles_to_initiation": frame.number(life.cycles),
        "cycles_low": frame.number(low),
        "cycles_high": frame.number(high),
        "beyond_the_run": None if initiation is None else initiation.beyond,
        "run_cycles": life.damage.end,
        "wear_states": [state.cycle for state in life.states],
        "averaged": life.averaged,
        "data": life.table.model_dump(exclude_none=True),
        "notes": notes(life),
    }
    if initiation is not None:
        x, y = life.place_um
        found |= {
            "x_um": x,
            "y_um": y,
            "depth_um": life.depth_um,
            "worn_off_um": life.worn_um,
            "plane_angle_deg": life.plane_angle_deg,
            "plane_normal": life.normal.tolist(),
        }
    return found


def write_lives(lives: Sequence[BodyLife], name: str, folder: Path, cycle: float | None = None) -> list[Path]:
    """Write life.json, life.csv (largest sum over the cycles), a picture of each body and life.html; return their
    paths. name: of the run. cycle: of the damage maps; None for the one at which the crack begins or, without one, the
    sum is largest. Raises ResultError if the folder cannot be written to.
    """
    rows = [
        {"body": life.body, "cycle": float(at), "largest_sum": float(largest)}
        for life in lives
        for at, largest in zip(*life.growth, strict=True)
    ]
    with writing(ResultError, f"cannot write lives to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return [
            write_text(folder / "life.json", life_json(lives)),
            write_csv(folder / "life.csv", rows),
            *(save(partial(draw_life, life, cycle), folder / f"life_{life.body}.png") for life in lives),
            write_text(folder / "life.html", page(lives, name, cycle)),
        ]


def page(lives: Sequence[BodyLife], name: str, cycle: float | None = None) -> str:
    """Self-contained HTML page of the lives of a run's bodies; name and cycle as in `write_lives`."""
    shown = [
        {
            "name": life.called,
            "sentence": sentence(life),
            "notes": notes(life),
            "picture": frame.inline_svg(svg(partial(draw_life, life, cycle)), f"life-{life.body}"),
            "data": life.table.model_dump(exclude_none=True),
            "states": ", ".join(counted(state.cycle) for state in life.states),
        }
        for life in lives
    ]
    first = min(lives, key=lambda life: life.cycles)
    values = {
        "name": name,
        "lives": shown,
        "summary": sentence(first)[:1].upper() + sentence(first)[1:],
        "mood": "good" if all(life.averaged for life in lives) else "open",
    }
    return frame.rendered(_PAGE, values)


def draw_life(life: BodyLife, cycle: float | None = None) -> Figure:
    """Figure of the largest sum over the cycles, and maps of the sum at one cycle from above and in a section. cycle:
    as in `write_lives`.
    """
    cycles, largest = life.growth
    default = life.cycles if life.cycles < life.damage.end else float(cycles[largest.argmax()])
    at = min(default if cycle is None else cycle, life.damage.end)
    now = life.damage.at(at)
    there = life.damage.of_present(now)
    figure = new_figure(2.9)
    ratios = (1.2, 1.5) if life.plane else (1.2, 1.0, 1.3)
    panels = figure.subplots(1, len(ratios), width_ratios=ratios)
    _draw_growth(panels[0], life)
    highest = float(there.max()) or 1.0
    limits = _DRAWN * highest, highest
    if not life.plane:
        _draw_above(panels[1], life, there.max(axis=1), limits)
    _draw_beneath(panels[-1], life, np.where(life.damage.present(now.worn_mm), now.damage, 0.0), now.worn_mm, limits)
    figure.colorbar(
        ScalarMappable(LogNorm(*limits), STRESS_COLOURS), ax=list(panels[1:]), label="Miner's sum", pad=0.02
    )
    panel_letters(list(panels))
    figure.suptitle(f"{life.called}, {life.table.criterion}, maps after {cycle_name(round(at))} cycles", fontsize=9)
    return figure


def _draw_growth(axes: Axes, life: BodyLife) -> None:
    cycles, largest = life.growth
    axes.loglog(cycles, np.maximum(largest, 1e-12), color=VARIANT_COLOURS[0])
    axes.axhline(1.0, color=INK, linewidth=0.6)
    low, high = life.interval
    if low <= cycles[-1]:
        axes.axvspan(low, min(high, cycles[-1]), color=VARIANT_COLOURS[0], alpha=0.15, linewidth=0.0)
    if largest[-1] < 0.99 * largest.max():
        axes.text(0.97, 0.05, "falls as damaged\nmetal wears off", transform=axes.transAxes, ha="right", fontsize=7.5)
    axes.set(
        title="largest sum left", xlabel="cycles", ylabel="Miner's sum", ylim=(_DRAWN * largest.max() or _DRAWN, 10.0)
    )


def _draw_above(axes: Axes, life: BodyLife, largest: Array, limits: tuple[float, float]) -> None:
    columns = np.column_stack([life.columns_mm, np.zeros(len(life.columns_mm))])
    x, y, _ = 1e3 * life.to_world @ columns.T
    levels = np.geomspace(limits[0], limits[1] * (1.0 + 1e-9), 13)
    axes.tricontourf(
        x, y, np.maximum(largest, 1e-2 * limits[0]), levels=levels, norm=LogNorm(*limits), cmap=STRESS_COLOURS
    )
    if life.initiation is not None:
        axes.plot(*life.place_um, marker="x", color=VARIANT_COLOURS[0])
    axes.set(aspect="equal", title="largest beneath", xlabel="x, along the motion [µm]", ylabel="y [µm]")
    axes.grid(visible=False)


def _draw_beneath(axes: Axes, life: BodyLife, damage: Array, worn_mm: Array, limits: tuple[float, float]) -> None:
    """Draw the sum below the surface along the motion, in the section through its largest value."""
    state = life.states[-1]
    shape = len(state.axial_mm), len(state.transverse_mm)
    i, j = np.unravel_index(int(damage.max(axis=1).argmax()), shape)
    along = abs(float(life.to_world[0, 0])) > 0.5**0.5 or life.plane
    line = (slice(None), j) if along else (i, slice(None))
    order = np.arange(len(life.columns_mm)).reshape(shape)[line]
    columns = np.column_stack([life.columns_mm[order], np.zeros(len(order))])
    x = 1e3 * (life.to_world @ columns.T)[0]
    depth = 1e3 * life.damage.levels_mm
    shown = np.ma.masked_less(damage[order].T, limits[0])
    axes.pcolormesh(x, depth, shown, shading="nearest", norm=LogNorm(*limits), cmap=STRESS_COLOURS, rasterized=True)
    axes.fill_between(x, 0.0, 1e3 * worn_mm[order], color="#ffffff", zorder=2)
    axes.plot(x, 1e3 * worn_mm[order], color=INK, linewidth=0.8, zorder=3)
    reached = depth[(damage[order] > limits[0]).any(axis=0)].max(initial=1e3 * float(worn_mm[order].max()))
    axes.set(
        title="beneath it",
        xlabel="x, along the motion [µm]",
        ylabel="depth below the unworn surface [µm]",
        ylim=(1.1 * float(reached) + float(depth[1]), 0.0),
    )
    axes.grid(visible=False)
