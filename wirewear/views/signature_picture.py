"""Picture of an effect's signature: loops, their difference, evolution and scars without and with the effect."""

from pathlib import Path
from textwrap import fill

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from wirewear.pictures.panels import draw_loop, name_axes
from wirewear.pictures.smooth import smooth_loop, smooth_scar
from wirewear.pictures.style import (
    GREY,
    INK,
    VARIANT_COLOURS,
    LineLook,
    cycle_axis,
    cycle_name,
    new_figure,
    panel_letters,
    save,
)
from wirewear.results import Scar
from wirewear.sweeps.signature import Signature

#: Lines of runs without and with the effect.
NOMINAL: LineLook = {"color": INK, "linestyle": (0, (4, 1.5)), "linewidth": 1.2}
CHANGED: LineLook = {"color": VARIANT_COLOURS[1], "linestyle": "-", "linewidth": 1.6}
_FIGURES = {
    "slip_amplitude_um": ("slip amplitude δ0", "o"),
    "dissipated_energy_mJ": ("energy per cycle", "s"),
    "friction_max": ("largest Q/P", "^"),
}
_LEVELS = (0.1, 0.5)
_THIN = 0.8
_POINTS = 121


def draw_signature(signature: Signature, path: Path) -> Path:
    """Draw a signature to a PNG file and return its path."""
    return save(lambda: signature_figure(signature), path)


def signature_figure(signature: Signature) -> Figure:
    """Figure with first and last loop, difference of the force at equal phase, evolution, sections and outlines of the
    scars.
    """
    figure = new_figure(5.6)
    panels = list(figure.subplots(2, 3).flat)
    first, last = signature.loops[0], signature.loops[-1]
    for axes, pair in ((panels[0], first), (panels[1], last)):
        for loop, style in zip(pair, (NOMINAL, CHANGED), strict=True):
            draw_loop(axes, *smooth_loop(loop), **style)
        name_axes(axes)
        axes.set_title(f"loop, cycle {cycle_name(pair[0].cycle)}")
    _difference(panels[2], signature)
    _evolution(panels[3], signature)
    scars = [
        (smooth_scar(run.scar(run.loops[-1].cycle, "moving")), smooth_scar(run.scar(run.loops[-1].cycle, "fixed")))
        for run in (signature.nominal, signature.changed)
    ]
    _sections(panels[4], scars)
    _outlines(panels[5], scars)
    panel_letters(panels)
    named, *stated = signature.effect.table().items()
    values = ", ".join(f"{name} = {value if isinstance(value, str) else f'{value:g}'}" for name, value in stated)
    figure.suptitle(f"{named[1]}: {values}", x=0.01, ha="left", fontsize=9.5, fontweight="bold")
    handles = [Line2D([], [], label="nominal", **NOMINAL), Line2D([], [], label="with the effect", **CHANGED)]
    figure.legend(handles=handles, loc="outside lower right", ncols=2)
    figure.supxlabel(fill(signature.effect.signature, 66), x=0.01, ha="left", fontsize=8, color=INK)
    return figure


def _difference(axes: Axes, signature: Signature) -> None:
    """Draw the difference of the force over the phase of the stroke, for the first and the last loop."""
    for place, colour in ((0, VARIANT_COLOURS[0]), (-1, VARIANT_COLOURS[2])):
        phase, nominal, changed = signature.on_one_phase(place)
        label = f"cycle {cycle_name(signature.cycles[place])}"
        axes.plot(360.0 * phase, 1e3 * (changed[1] - nominal[1]), color=colour, linewidth=1.4, label=label)
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set(title="change of the force", xlabel="phase of the stroke [°]")
    axes.set_xticks([0, 90, 180, 270, 360])
    axes.set_ylabel("ΔQ [mN]")
    axes.legend(loc="best", fontsize=7)


def _evolution(axes: Axes, signature: Signature) -> None:
    for (name, change), colour in zip(signature.changes().items(), VARIANT_COLOURS, strict=False):
        label, marker = _FIGURES[name]
        axes.plot(signature.cycles, 100.0 * np.array(change), color=colour, marker=marker, markersize=3, label=label)
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    cycle_axis(axes)
    axes.set(title="change over the test", ylabel="change [%]")
    low, high = axes.get_ylim()
    # A change below a per mille is none, and must not look like one.
    middle, half = 0.5 * (low + high), max(0.5 * (high - low), 0.5)
    # Room for the legend above the lines.
    axes.set_ylim(middle - half, middle + 1.8 * half)
    axes.legend(loc="upper left", fontsize=7)


def _sections(axes: Axes, scars: list[tuple[Scar, Scar]]) -> None:
    """Draw the depth along the motion through the middle of both scars; the moving wire has the thin line."""
    for (moving, fixed), style in zip(scars, (NOMINAL, CHANGED), strict=True):
        for scar, width in ((moving, _THIN), (fixed, style["linewidth"])):
            x, depth = scar.section_along_motion()
            axes.plot(x, -depth, color=style["color"], linestyle=style["linestyle"], linewidth=width)
    reach = 1.1 * max(_reach(scar) for pair in scars for scar in pair)
    axes.set_xlim(-reach, reach)
    # Room for the legend below the deepest point.
    axes.set_ylim(bottom=1.35 * axes.get_ylim()[0])
    axes.set(title="depth on y = 0", xlabel="position x [µm]", ylabel="height change [µm]")
    lines = [Line2D([], [], color=GREY, linewidth=width) for width in (CHANGED["linewidth"], _THIN)]
    axes.legend(lines, ["fixed wire", "moving wire"], loc="lower right", fontsize=7)


def _outlines(axes: Axes, scars: list[tuple[Scar, Scar]]) -> None:
    """Draw contours at 10 % and 50 % of the largest depth of the fixed wire's scar, seen from above."""
    reach = 1.1 * max(_reach(pair[1]) for pair in scars)
    line = np.linspace(-reach, reach, _POINTS)
    for (_, fixed), style in zip(scars, (NOMINAL, CHANGED), strict=True):
        if fixed.max_depth_um > 0.0:
            axes.contour(
                line,
                line,
                fixed.sampled(line, line).T,
                levels=[level * fixed.max_depth_um for level in _LEVELS],
                colors=[style["color"]],
                linestyles=[style["linestyle"]],
                linewidths=style["linewidth"],
            )
    axes.set(aspect="equal", title="fixed wire's outline", xlabel="x [µm]", ylabel="y [µm]")


def _reach(scar: Scar) -> float:
    """Largest |x| or |y| in µm at which more than 5 % of the largest depth is worn."""
    half = float(max(np.abs(scar.axial_um).max(), np.abs(scar.transverse_um).max()))
    line = np.linspace(-half, half, 2 * _POINTS)
    worn = scar.sampled(line, line) > 0.05 * scar.max_depth_um
    return float(np.maximum(np.abs(line)[:, None], np.abs(line)[None, :])[worn].max()) if worn.any() else half
