"""Pictures of a rig stiffness run: loops, pressure, shear and slip of all cases, both scenarios overlaid."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from wirewear.pictures.style import new_figure, save, variant_style
from wirewear.planar.rig_stiffness.results import RigStiffnessResult, RigStiffnessRun

_SCENARIOS = ("1: translation", "2: rotation")
# Rows below the loops: attribute, axis label.
_FIELDS = (
    ("pressure_MPa", "pressure (MPa)"),
    ("shear_MPa", "shear (MPa)"),
    ("slip_amplitude_um", "slip amplitude (µm)"),
)
_TITLES = {"cylinder": "cylinder on flat", "flat": "flat with rounded edges on flat"}


def draw_rig_stiffness_result(folder: Path, result: RigStiffnessResult) -> list[Path]:
    """Draw <contact>.png for each contact in that folder."""
    return [
        save(lambda contact=contact: rig_stiffness_figure(result, contact), folder / f"{contact}.png")  # type: ignore[misc]
        for contact in result.contacts
    ]


def rig_stiffness_figure(result: RigStiffnessResult, contact: str) -> Figure:
    """Loops over displacement; pressure and shear at its largest, and slip amplitude, along the contact; by case."""
    pairs = result.pairs(contact)
    figure = new_figure(8.6)
    panels = figure.subplots(1 + len(_FIELDS), len(pairs), squeeze=False)
    for row in panels[:-1]:
        # Slip keeps a scale of its own in each case: in partial slip it is a hundredth of that in gross slip.
        for axes in row[1:]:
            axes.sharey(row[0])
            axes.tick_params(labelleft=False)
    reach = 1.08 * max(_reach(run) for pair in pairs for run in pair)
    for column, pair in zip(panels.T, pairs, strict=True):
        for index, run in enumerate(pair):
            style = variant_style(index) | {"linewidth": 1.2, "label": _SCENARIOS[index]}
            loop = (np.append(v, v[0]) for v in (run.displacement_um, run.tangential_force_N_per_mm))
            column[0].plot(*loop, **style)
            for axes, (name, _) in zip(column[1:], _FIELDS, strict=True):
                axes.plot(1e-3 * run.x_um, getattr(run, name), **style)
        one, two = (run.stiffness for run in pair)
        column[0].set_title(f"case {pair[0].case}")
        springs = f"1: {one / 1e3:g} kN/mm²\n2: {_short(two)} N/rad"
        column[0].annotate(springs, (0.04, 0.98), xycoords="axes fraction", va="top", fontsize=7.0)
        column[0].margins(y=0.3)
        column[0].set_xlabel("displacement (µm)")
        for axes in column[1:]:
            axes.set_xlim(-reach, reach)
        column[-1].set_ylim(bottom=0.0)
        column[-1].set_xlabel("x on the pad (mm)")
    for axes, label in zip(panels[:, 0], ("tangential force (N/mm)", *(label for _, label in _FIELDS)), strict=True):
        axes.set_ylabel(label)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, title="scenario", ncols=2, loc="outside lower center")
    figure.suptitle(f"{result.name}: {_TITLES[contact]}", x=0.01, ha="left", fontsize=9.5)
    return figure


def _reach(run: RigStiffnessRun) -> float:
    """Half-width that was in contact or slid, mm."""
    touched = (run.pressure_MPa > 0.0) | (run.slip_amplitude_um > 0.0)
    return 1e-3 * float(np.abs(run.x_um[touched]).max())


def _short(value: float) -> str:
    """5.28 · 10⁵."""
    digits, exponent = f"{value:.2e}".split("e")
    return f"{digits} · 10" + str(int(exponent)).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))
