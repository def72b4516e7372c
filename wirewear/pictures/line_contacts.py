"""Pictures of line contacts: worn profiles, pressure, loops, growth of scars, supports. Forces are per mm of length."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import cycle as endless

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from geometry import PlanarMesh
from wirewear.pictures import style
from wirewear.pictures.gallery import loops_by_run
from wirewear.pictures.panels import draw_loop, name_axes
from wirewear.pictures.smooth import chosen_cycles
from wirewear.pictures.supports import HeldBody, Supports, draw_boundary_conditions
from wirewear.results import BODIES, RunResult, Scar, read_loops
from wirewear.test import LineStudy


def line_supports(study: LineStudy, pad: PlanarMesh, specimen: PlanarMesh) -> Figure:
    """Picture of the section of both meshed bodies with their supports, load and motion."""
    unit = study.of_length(1.0)
    conditions, holder = unit.conditions, unit.holder
    tangential, rotational = holder.tangential_stiffness_N_per_mm, holder.rotational_stiffness_N_mm_per_rad
    overlap, pushed = study.specimen.interference_um, study.specimen.assembly_force_N
    supports = Supports(
        load=f"pushed in by {pushed:g} N"
        if pushed is not None
        else f"{conditions.normal_load_N:g} N/mm"
        if overlap is None
        else f"{overlap:g} µm larger shaft",
        stroke=f"±{conditions.displacement_amplitude_um:g} µm",
        tangential="" if tangential == "rigid" else f"{tangential:g} N/mm²",
        rotational="" if rotational == "rigid" else f"{rotational:g} N/rad",
        pivot_height=None if rotational == "rigid" else holder.pivot_height_mm,
    )
    is_shaft = study.specimen.shaft_radius_mm is not None
    called = "hub on shaft, about its axis" if is_shaft else "pad on specimen, plane strain"
    view = (called, _held(pad, upper=True), _held(specimen, upper=False))
    return draw_boundary_conditions([view], supports, along_motion=[True])


def _held(body: PlanarMesh, *, upper: bool) -> HeldBody:
    points = body.mesh.points * np.array([1.0, -1.0 if upper else 1.0])
    edges = points[body.mesh.boundary_facets()]
    return HeldBody(edges, points[body.mesh.surfaces["grip"]], body.bedding is not None)


def line_drawings(results: Sequence[RunResult]) -> dict[str, Callable[[], Figure]]:
    """Functions that draw each picture these results allow, by file name: of each run, and of several together."""
    logged = [result.computed for result in results if result.loops]
    found: dict[str, Callable[[], Figure]] = {}
    for result in logged:
        suffix = f"_{result.variant}" if len(results) > 1 else ""
        found |= {
            f"profiles{suffix}": partial(line_profiles, result),
            f"loops{suffix}": partial(loops_by_run, [replace(result, loops=read_loops(result))], "N/mm"),
        }
    return found | ({"variants": partial(line_variants, logged)} if len(logged) > 1 else {})


def line_variants(results: Sequence[RunResult]) -> Figure:
    """Picture of the worn depth of both bodies, the pressure at mid-stroke and the loop at the last logged cycle, for
    all runs.
    """
    figure = style.new_figure(5.2)
    panels = figure.subplots(2, 2)
    results = [result.computed for result in results]
    for colour, dashes, result in zip(endless(style.VARIANT_COLOURS), endless(style.VARIANT_DASHES), results):
        last = max(loop.cycle for loop in result.loops)
        look: style.LineLook = {"color": colour, "linestyle": dashes}
        for axes, body in zip(panels[0], BODIES, strict=True):
            scar = result.scar(last, body)
            axes.plot(scar.axial_um, scar.depth_um[:, 0], **look)
        pad = result.scar(last, "pad")
        panels[1][0].plot(pad.axial_um, pad.pressure_MPa[:, 0], **look)
        loop = next(one for one in read_loops(result) if one.cycle == last)
        whole = loop.displacement_um, loop.tangential_force_N
        draw_loop(
            panels[1][1], *whole, label=f"{result.variant or result.name}, {style.cycle_name(last)} cycles", **look
        )
    reach = max(_reach(result) for result in results)
    deepest = max(axes.get_ylim()[1] for axes in panels[0])
    for axes, title in zip(
        panels.ravel(),
        ("worn depth, pad", "worn depth, specimen", "pressure at mid-stroke", "friction loop"),
        strict=True,
    ):
        axes.set_title(title)
    for axes in (*panels[0], panels[1][0]):
        axes.set(xlim=(-reach, reach), xlabel="x [µm]")
        axes.locator_params(axis="x", nbins=6)
    for axes in panels[0]:
        axes.set(ylim=(deepest, 0.0), ylabel="depth [µm]")
    panels[1][0].set_ylim(bottom=0.0)
    panels[1][0].set_ylabel("pressure [MPa]")
    name_axes(panels[1][1], "N/mm")
    figure.legend(*panels[1][1].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    style.panel_letters(list(panels.ravel()))
    return figure


def line_profiles(result: RunResult) -> Figure:
    """Picture of worn depth of both bodies and pressure at mid-stroke over x at up to six cycles, and of growth."""
    cycles = chosen_cycles([loop.cycle for loop in result.loops])
    figure = style.new_figure(5.2)
    panels = figure.subplots(2, 2)
    reach = _reach(result)
    for axes, body in zip(panels[0], BODIES, strict=True):
        for colour, cycle in zip(style.cycle_colours(len(cycles)), cycles, strict=True):
            scar = result.scar(cycle, body)
            axes.plot(scar.axial_um, -scar.depth_um[:, 0], color=colour, label=style.cycle_name(cycle))
        axes.set(title=f"worn depth, {body}", xlabel="x [µm]", ylabel="depth [µm]")
        axes.yaxis.set_major_formatter(lambda value, _: f"{abs(value):g}")
        axes.set_xlim(-reach, reach)
    lowest = min(axes.get_ylim()[0] for axes in panels[0])
    for axes in panels[0]:
        axes.set_ylim(lowest, -0.05 * lowest)
    for colour, cycle in zip(style.cycle_colours(len(cycles)), cycles, strict=True):
        scar = result.scar(cycle, "pad")
        panels[1][0].plot(scar.axial_um, scar.pressure_MPa[:, 0], color=colour, label=style.cycle_name(cycle))
    panels[1][0].set(title="pressure at mid-stroke", xlabel="x [µm]", ylabel="pressure [MPa]", xlim=(-reach, reach))
    panels[1][0].set_ylim(bottom=0.0)
    for axes in (*panels[0], panels[1][0]):
        axes.locator_params(axis="x", nbins=6)
    _growth(panels[1][1], result)
    handles, labels = panels[1][0].get_legend_handles_labels()
    figure.legend(handles, labels, title="cycles", loc="outside right upper")
    style.panel_letters(list(panels.ravel()))
    return figure


def _growth(axes: Axes, result: RunResult) -> None:
    cycles = result.evolution["cycle"]
    for colour, dashes, body in zip(style.VARIANT_COLOURS, style.VARIANT_DASHES, BODIES, strict=False):
        depth = result.evolution[f"max_depth_{body}_um"]
        worn = depth > 0.0
        if worn.any():
            axes.plot(cycles[worn], depth[worn], color=colour, linestyle=dashes, marker="o", markersize=3, label=body)
    axes.set(title="largest depth", ylabel="depth [µm]")
    style.cycle_axis(axes)
    if axes.lines:
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.legend()
    else:
        axes.text(0.5, 0.5, "nothing is worn", transform=axes.transAxes, ha="center", va="center")


def _reach(result: RunResult) -> float:
    """Half-width in µm of the picture: the worn or pressed range with a margin of 15 %."""

    def of_one(scar: Scar) -> float:
        shown = (scar.pressure_MPa > 0.0) | (scar.depth_um > 0.01 * max(scar.max_depth_um, 1e-12))
        return float(np.abs(scar.axial_um[shown[:, 0]]).max())

    return 1.15 * max(map(of_one, result.scars))
