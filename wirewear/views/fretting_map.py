"""Fretting map of a sweep over load and stroke: regimes, energy, wear and life of its runs, and measured tests."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, LogLocator, NullLocator

from geometry.arrays import Array
from wirewear.base.frame import figure as written
from wirewear.base.units import unit_of, words_of
from wirewear.comparison.mapped_tests import MappedTest
from wirewear.comparison.maps import fresh_contact, slides, transition
from wirewear.pictures.style import GREY, INK, VARIANT_COLOURS, new_figure, panel_letters
from wirewear.sweeps.running import SweepResult
from wirewear.sweeps.sweep import FIRST, LIFE, VOLUME
from wirewear.test.lengths import given_length_mm

LOAD, STROKE = "conditions.normal_load_N", "conditions.displacement_amplitude_um"

STUCK = 1e-3  #: A contact whose loop is narrower than this share of its stroke sticks.

#: How each regime is drawn: colours and shapes differ.
MARKS = {
    "stick": (GREY, "v"),
    "partial slip": (VARIANT_COLOURS[0], "o"),
    "mixed": (VARIANT_COLOURS[2], "D"),
    "gross slip": (VARIANT_COLOURS[1], "s"),
}
COLOURED = ("dissipated_energy_mJ", VOLUME, LIFE)  #: Figures that are drawn over load and stroke, where they vary.


def is_map(result: SweepResult) -> bool:
    """True if load and stroke are both varied and at least one run succeeded."""
    return {LOAD, STROKE} <= set(result.sweep.design.keys) and len(result.rows) > len(result.failures)


def regime_of_run(figures: Mapping[str, float | None], amplitude_um: float) -> str | None:
    """Regime of a run by its first and last cycle: "mixed" if only one of them is in gross slip, else as in `MARKS`;
    None if a figure is missing. figures: results of the run by name. amplitude_um: its displacement amplitude.
    """
    found = []
    for first in (FIRST, ""):
        names = ("dissipated_energy_mJ", "slip_amplitude_um", "max_tangential_force_N")
        energy, slip, force = (figures.get(first + name) for name in names)
        if energy is None or slip is None or force is None:
            return None
        if slip < STUCK * amplitude_um:
            found.append("stick")
            continue
        whole = bool(slides(*(np.array([one]) for one in (energy, amplitude_um, slip, force)))[0])
        found.append("gross slip" if whole else "partial slip")
    if "gross slip" in found:
        return "gross slip" if found[0] == found[1] else "mixed"
    return "partial slip" if "partial slip" in found else "stick"


def draw_fretting_map(result: SweepResult, tests: Sequence[MappedTest] = ()) -> Figure:
    """Figure of regimes, and of energy, wear and life where they vary, over stroke and load, with the closed-form
    transition to gross slip. tests: measured tests that are drawn, too.
    """
    design = result.sweep.design
    stroke, load = (design.points[:, design.keys.index(key)] for key in (STROKE, LOAD))
    rows = [result.rows.get(number) for number in range(1, len(result.sweep) + 1)]
    known = [{} if row is None or row.figures is None else row.figures for row in rows]
    figures = {name: _values(known, name) for name in COLOURED if name in result.sweep.figures}
    drawn = [name for name, values in figures.items() if _varies(values)]
    figure = new_figure(2.9 * (1 + len(drawn) // 2) + 0.5)
    panels = list(figure.subplots(1 + len(drawn) // 2, 2, squeeze=False).flat)
    for unused in panels[1 + len(drawn) :]:
        unused.set_visible(False)
    regimes = [regime_of_run(one, float(amplitude)) for one, amplitude in zip(known, stroke, strict=True)]
    _regimes(panels[0], stroke, load, regimes)
    for axes, name in zip(panels[1:], drawn, strict=False):
        there = np.isfinite(figures[name]) & (figures[name] > 0.0)
        colours = axes.scatter(stroke[there], load[there], c=figures[name][there], norm=LogNorm(), cmap="viridis", s=26)
        figure.colorbar(colours, ax=axes, label=f"{words_of(name)}{_unit(name)}")
        axes.plot(stroke[~there], load[~there], "x", color=GREY, markersize=4)
    for axes in panels[: 1 + len(drawn)]:
        _boundaries(axes, result, load)
        _measured(axes, result, tests)
        axes.set(xscale="log", yscale="log", xlabel="displacement amplitude δa [µm]", ylabel="normal load P [N]")
        reach = [stroke, *(np.array([test.displacement_amplitude_um]) for test in tests)]
        axes.set_xlim(np.concatenate(reach).min() / 1.3, np.concatenate(reach).max() * 1.3)
        for axis, values in ((axes.xaxis, stroke), (axes.yaxis, load)):
            # Put ticks at the values of a grid, or at round values for other designs.
            own = np.unique(values)
            axis.set_major_locator(FixedLocator(own.tolist()) if own.size <= 8 else LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter(FuncFormatter(lambda value, _: written(value)))
            axis.set_minor_locator(NullLocator())
    panel_letters(panels[: 1 + len(drawn)])
    named = {label: handle for axes in panels for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(named.values(), named.keys(), loc="outside lower center", ncols=4, fontsize=7)
    return figure


def _values(rows: Sequence[Mapping[str, float | None]], name: str) -> Array:
    numbers = (row.get(name) for row in rows)
    return np.array([np.nan if one is None else one for one in numbers], dtype=np.float64)


def _varies(values: Array) -> bool:
    known = values[np.isfinite(values) & (values > 0.0)]
    return known.size > 1 and float(np.ptp(known)) > 0.0


def _unit(name: str) -> str:
    unit = unit_of(name)
    return f" [{unit}]" if unit not in ("", "1") else ""


def _regimes(axes: Axes, stroke: Array, load: Array, regimes: Sequence[str | None]) -> None:
    for name, (colour, mark) in MARKS.items():
        own = np.array([regime == name for regime in regimes])
        if own.any():
            axes.plot(stroke[own], load[own], mark, color=colour, markersize=5, linestyle="", label=name)
    unknown = np.array([regime is None for regime in regimes])
    if unknown.any():
        axes.plot(stroke[unknown], load[unknown], "x", color=GREY, markersize=4, linestyle="", label="no result")


def _boundaries(axes: Axes, result: SweepResult, load: Array) -> None:
    """Draw the transition to gross slip of the study's fresh contact, alone and with its rig."""
    contact = fresh_contact(result.sweep.study.resolved())
    if contact is None:
        return
    at = transition(contact, np.geomspace(load.min() / 1.2, load.max() * 1.2, 61))
    soft = contact.rig_um_per_N > 0.0
    label = f"fresh contact{' and rig' if soft else ''}, closed form"
    axes.plot(at.test_um, at.normal_load_N, color=INK, linewidth=1.3, label=label)
    if soft:
        axes.plot(at.contact_um, at.normal_load_N, "--", color=INK, linewidth=0.9, label="fresh contact alone")


def _measured(axes: Axes, result: SweepResult, tests: Sequence[MappedTest]) -> None:
    """Draw measured tests with a dark edge, in the colour and shape of their regimes."""
    length = given_length_mm(result.sweep.study.resolved())
    for test in tests:
        colour, mark = MARKS[test.regime]
        load = test.normal_load_N / test.extent.of(length).share
        axes.plot(test.displacement_amplitude_um, load, mark, color=colour, markersize=8, markeredgecolor=INK,
                  markeredgewidth=1.4, linestyle="", label=f"measured: {test.regime}")  # fmt: skip
