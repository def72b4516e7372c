"""Pictures of a diagnosis: loops, where the gap lies, causes by class, and how far the gap shrinks."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from wirewear.diagnosis.infer.where import places
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.observe.registry import row_labels
from wirewear.diagnosis.report.wording import plain
from wirewear.pictures.style import DOTS_PER_INCH, GREY, INK, VARIANT_COLOURS, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from wirewear.diagnosis.report.diagnosed import Diagnosed

_MODEL, _WITH, _MEASURED = VARIANT_COLOURS[0], VARIANT_COLOURS[1], "#b5b5b5"


def drawn(diagnosed: Diagnosed) -> dict[str, bytes]:
    """PNG pictures by name; what a record does not hold is not drawn."""
    drawings: dict[str, Callable[[], Figure]] = {
        "loops": lambda: _loops(diagnosed),
        "where": lambda: _where(diagnosed),
        "causes": lambda: _causes(diagnosed),
        "shrink": lambda: _shrink(diagnosed),
    }
    pictures = {}
    with styled():
        for name, draw in drawings.items():
            buffer = io.BytesIO()
            draw().savefig(buffer, dpi=0.8 * DOTS_PER_INCH, format="png")
            pictures[name] = buffer.getvalue()
    return pictures


def _shown_cycles(diagnosed: Diagnosed) -> list[int]:
    cycles = sorted({loop.cycle for loop in diagnosed.observed.loops})
    return sorted({cycles[0], cycles[len(cycles) // 2], cycles[-1]})


def _loops(diagnosed: Diagnosed) -> Figure:
    cycles = _shown_cycles(diagnosed)
    figure = new_figure(2.9)
    axes = np.atleast_1d(figure.subplots(1, len(cycles), sharey=True))
    at = np.array(cycles, dtype=float)
    found, best = diagnosed.search, diagnosed.search.best
    curves = [("model", _MODEL, "-", simulate(diagnosed.states, diagnosed.setup, at))]
    if best.candidates and diagnosed.diagnosis.verdict != "no_gap":
        alike = any(name in members for members in diagnosed.diagnosis.equivalent for name in best.names)
        label = "model with " + " and ".join(plain(name) for name in best.names) + (" or its like" if alike else "")
        curves.append((label, _WITH, "--", simulate(diagnosed.states, found.best.setup, at)))
    for row, (axis, cycle) in enumerate(zip(axes, cycles, strict=True)):
        for loop in diagnosed.observed.loops:
            if loop.cycle == cycle:
                for branch in loop.branches:
                    axis.plot(branch.sign * branch.displacement_um, branch.sign * branch.force_N, ".", ms=2.2,
                              color=_MEASURED, label="measured", zorder=1)  # fmt: skip
        for label, colour, dash, course in curves:
            x, q = course.displacement_um[row], course.tangential_force_N[row]
            axis.plot(np.append(x, x[0, 0]), np.append(q, q[0, 0]), dash, color=colour, lw=1.3, label=label, zorder=2)
        axis.set_title(f"cycle {cycle:,}")
        axis.set_xlabel("displacement [µm]")
    axes[0].set_ylabel("tangential force [N]")
    handles, labels = axes[0].get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    figure.legend(unique.values(), unique.keys(), loc="outside lower center", ncols=3)
    return figure


def _where(diagnosed: Diagnosed) -> Figure:
    from matplotlib.colors import BoundaryNorm

    found = places(diagnosed.search.problem, diagnosed.search.covariance, diagnosed.setup)
    cycles = sorted({place.cycle for place in found})
    labels = row_labels()
    zones = [zone for zone in labels if any(place.zone == zone for place in found)]
    sizes = np.full((len(zones), len(cycles)), np.nan)
    figure = new_figure(0.9 + 0.24 * len(zones))
    axis = figure.subplots()
    for place in found:
        row, column = zones.index(place.zone), cycles.index(place.cycle)
        sizes[row, column] = place.in_scatter
        if place.flagged:
            colour = "white" if place.in_scatter > 5 else INK
            axis.plot(column, row, "o", ms=3.5, color=colour)
    axis.grid(visible=False)
    axis.set_facecolor("#f4f4f4")
    bounds = [0, 1, 2, 3, 5, 8, 12, 20]
    image = axis.imshow(sizes, aspect="auto", cmap="YlOrRd", norm=BoundaryNorm(bounds, 256, extend="max"))
    axis.set_xticks(range(len(cycles)), [f"{cycle:,}" for cycle in cycles], rotation=45, ha="right")
    axis.set_yticks(range(len(zones)), [labels[zone] for zone in zones])
    axis.set_xlabel("cycle")
    figure.colorbar(image, ax=axis, label="difference [scatters of a test]", ticks=bounds)
    return figure


def _causes(diagnosed: Diagnosed) -> Figure:
    diagnosis, weighed = diagnosed.diagnosis, diagnosed.weighed
    listed = diagnosis.causes[:8]

    def rank(name: str) -> tuple[float, str]:
        members = weighed.class_of(name)
        return -max(cause.probability for cause in listed if cause.effect in members), members[0]

    causes = sorted(listed, key=lambda cause: (rank(cause.effect), -cause.probability))
    figure = new_figure(0.8 + 0.27 * len(causes))
    axis = figure.subplots()
    for row, cause in enumerate(causes):
        colour = GREY if cause.effect in ("none", "outside_library") else _WITH
        axis.barh(row, cause.probability, color=colour, height=0.62)
        axis.text(cause.probability + 0.01, row, f"{cause.probability:.0%}", va="center", fontsize=7.5)
    axis.set_yticks(range(len(causes)), [plain(c.effect) + (" (joint)" if c.joint else "") for c in causes])
    axis.invert_yaxis()
    axis.set_xlim(0.0, 1.18)
    axis.set_xticks([0, 0.25, 0.5, 0.75, 1.0])
    axis.set_xlabel("probability")
    for members in diagnosis.equivalent:
        rows = [row for row, cause in enumerate(causes) if cause.effect in members]
        if len(rows) > 1:
            axis.plot([1.09, 1.11, 1.11, 1.09], [rows[0] - 0.25, rows[0] - 0.25, rows[-1] + 0.25, rows[-1] + 0.25],
                      color=INK, lw=1)  # fmt: skip
            axis.text(1.12, float(np.mean(rows)), "cannot be\ntold apart", va="center", fontsize=7, clip_on=False)
    return figure


def _shrink(diagnosed: Diagnosed) -> Figure:
    shrink = diagnosed.diagnosis.shrink
    figure = new_figure(1.55)
    axis = figure.subplots()
    names, values = ["before", "after"], [shrink.before, shrink.after]
    colours = [_MODEL, _WITH]
    if diagnosed.diagnosis.confirmed is not None:
        names.append("after, full simulation")
        values.append(diagnosed.diagnosis.confirmed.after)
        colours.append(VARIANT_COLOURS[2])
    axis.barh(names, values, color=colours, height=0.6)
    axis.axvline(shrink.floor, color=INK, lw=1, ls="--")
    for row, value in enumerate(values):
        background = {"facecolor": "white", "edgecolor": "none", "pad": 0.6}
        axis.annotate(f"{value:.2f}", (value, row), (4, 0), textcoords="offset points", va="center", fontsize=8,
                      bbox=background)  # fmt: skip
    left_out = "a scar that was held out" if shrink.scar_held_out else "held-out loops"
    axis.set_title(f"gap on {left_out}; dashed: floor {shrink.floor:.2f}", fontsize=8.5, fontweight="normal")
    axis.invert_yaxis()
    axis.set_xlim(0.0, 1.12 * max([*values, shrink.floor]))
    axis.set_xlabel("root mean square difference [scatters of a test]")
    return figure
