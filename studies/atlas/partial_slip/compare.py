"""What partial slip does to two wires: whether the centre keeps sticking, wear comes to an end, and pressure gathers.

    python studies/partial_slip/compare.py RESULT_DIR [--output DIR]

RESULT_DIR is the folder that `wirewear run` left of study.toml. That wear under partial slip ends once the stuck
centre carries the whole load, with pressures at its edge that rise without bound, is shown for half-spaces by
M. Ciavarella & D. A. Hills, Eur. J. Mech. A 18 (1999) 491, and by I. Goryacheva, P. Rajeev & T. Farris, J. Tribol. 123
(2001) 848.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from wirewear import ResultError, RunResult, Scar, read_results
from wirewear.base.verdicts import Finding, finding_table
from wirewear.faces.study_script import comparison_command, wide_console
from wirewear.pictures import save
from wirewear.pictures.style import VARIANT_COLOURS, cycle_axis, cycle_colours, cycle_name, new_figure, panel_letters

STUCK = 0.02  #: A point sticks where it slides by less than this share of the largest distance slid in the first cycle.

#: Worn volume over the last third of a decade of cycles, relative to all, below which wear has come to its end.
AT_AN_END = 0.05


@dataclass(frozen=True)
class Contact:
    """The fixed wire's contact at a logged cycle: radii of equal area, and the pressure."""

    scar: Scar
    stick_radius_um: float
    contact_radius_um: float
    centre_MPa: float
    edge_MPa: float


def contacts_of(run: RunResult) -> list[Contact]:
    """The contact at every logged cycle."""
    scars = [run.scar(cycle, "fixed") for cycle in run.scar_cycles()]
    slip_limit = STUCK * float(scars[0].slip_distance_um.max())
    return [_contact(scar, slip_limit) for scar in scars]


def _contact(scar: Scar, slip_limit_um: float) -> Contact:
    areas = np.outer(_widths(scar.axial_um), _widths(scar.transverse_um))
    touching = scar.pressure_MPa > 0.0
    stuck = touching & (scar.slip_distance_um < slip_limit_um)
    middle = np.hypot(scar.axial_um[:, None], scar.transverse_um[None, :])
    centre = scar.pressure_MPa[np.unravel_index(middle.argmin(), middle.shape)]
    stick_radius = float(np.sqrt(areas[stuck].sum() / np.pi))
    return Contact(
        scar,
        stick_radius,
        float(np.sqrt(areas[touching].sum() / np.pi)),
        float(centre),
        float(scar.pressure_MPa[middle > 0.5 * stick_radius].max()),
    )


def _widths(lines: NDArray[np.float64]) -> NDArray[np.float64]:
    widths = np.zeros_like(lines)
    widths[:-1] += 0.5 * np.diff(lines)
    widths[1:] += 0.5 * np.diff(lines)
    return widths


def stick_zone_stays(contacts: Sequence[Contact]) -> Finding:
    """The stick radius changes by no more than an element."""
    radii = [contact.stick_radius_um for contact in contacts]
    element = float(np.diff(contacts[0].scar.axial_um).min())
    evidence = (
        f"{radii[0]:.2f} µm at first, {min(radii):.2f} to {max(radii):.2f} µm later; elements of {element:.2f} µm"
    )
    return Finding("The stuck centre keeps its radius", evidence, max(abs(np.subtract(radii, radii[0]))) <= element)


def wear_ends(run: RunResult) -> Finding:
    """Worn volume tends to a limit."""
    cycle, volume = run.evolution["cycle"], _volume(run)
    late = volume[-1] - np.interp(cycle[-1] * 10 ** (-1 / 3), cycle, volume)
    early = np.interp(1e-3 * cycle[-1], cycle, volume)
    evidence = (
        f"{1e9 * volume[-1]:.4g} µm³ at the end; {100 * late / volume[-1]:.1f} % of it in the last third of a decade, "
        f"{100 * early / volume[-1]:.1f} % in the first thousandth of the cycles"
    )
    return Finding("The worn volume tends to a limit", evidence, late < AT_AN_END * volume[-1])


def pressure_gathers(contacts: Sequence[Contact]) -> Finding:
    """Highest pressure around the stuck centre's edge, relative to its middle."""
    first, last = contacts[0], contacts[-1]
    evidence = (
        f"beyond half the stick radius: {first.edge_MPa:.0f} → {last.edge_MPa:.0f} MPa; "
        f"in the middle: {first.centre_MPa:.0f} → {last.centre_MPa:.0f} MPa"
    )
    holds = last.edge_MPa > last.centre_MPa and last.edge_MPa > first.edge_MPa
    return Finding("The pressure rises at the edge of the stuck centre", evidence, holds)


def annulus_is_relieved(contacts: Sequence[Contact]) -> Finding:
    """The contact shrinks onto the stuck centre."""
    first, last = contacts[0], contacts[-1]
    evidence = f"contact radius {first.contact_radius_um:.2f} → {last.contact_radius_um:.2f} µm"
    gone = first.contact_radius_um - last.contact_radius_um
    holds = gone > 0.5 * (first.contact_radius_um - first.stick_radius_um)
    return Finding("The annulus that slips wears until it carries little", evidence, holds)


def picture(run: RunResult, contacts: Sequence[Contact]) -> Figure:
    """Depth, pressure and slip on the line along the motion, and how volume and radii evolve."""
    figure = new_figure(5.2)
    grid = figure.subplots(2, 2)
    panels = list(grid.flat)
    labels = ("worn depth, fixed wire [nm]", "pressure at mid-stroke [MPa]", "distance slid in the cycle [µm]")
    for axes, label in zip(panels, labels, strict=False):
        axes.set(xlabel="x, along the motion [µm]", ylabel=label, xlim=(0.0, 1.35 * contacts[0].contact_radius_um))
        axes.axvline(contacts[0].stick_radius_um, color="#8a8a8a", linewidth=0.8, linestyle="--", label="edge of stick")
    for contact, colour in zip(contacts, cycle_colours(len(contacts)), strict=True):
        scar = contact.scar
        # The fixed wire lies across the motion: its crown, on which axial = 0, runs along y.
        row = int(np.argmin(abs(scar.axial_um)))
        x = -scar.transverse_um
        order = np.argsort(x)
        lines = (1e3 * scar.depth_um[row], scar.pressure_MPa[row], scar.slip_distance_um[row])
        for axes, values in zip(panels, lines, strict=False):
            axes.plot(x[order], values[order], color=colour, label=cycle_name(scar.cycle))
    panels[0].set_title("depth")
    panels[1].set_title("pressure")
    panels[2].set_title("slip")
    panels[3].set_title("wear comes to an end")
    volume = _volume(run)
    panels[3].plot(run.evolution["cycle"], 1e9 * volume, color=VARIANT_COLOURS[0])
    cycle_axis(panels[3])
    panels[3].set_xticks(10.0 ** np.arange(0.0, np.log10(run.evolution["cycle"][-1]) + 0.1, 3.0))
    panels[3].set_ylabel("worn volume of both wires [µm³]", color=VARIANT_COLOURS[0])
    radii = panels[3].twinx()
    cycles = [contact.scar.cycle for contact in contacts]
    radii.plot(cycles, [contact.stick_radius_um for contact in contacts], "o--", color=VARIANT_COLOURS[1], markersize=3)
    radii.set_ylim(0.0, 1.2 * contacts[0].contact_radius_um)
    radii.grid(visible=False)
    radii.spines["right"].set_visible(True)
    radii.set_ylabel("stick radius [µm]", color=VARIANT_COLOURS[1])
    (edge, *curves), (its_name, *cycle_names) = panels[0].get_legend_handles_labels()
    panels[0].legend([edge], [its_name], loc="upper left", handlelength=1.2)
    figure.legend(curves, cycle_names, title="cycle", loc="outside right upper", alignment="left")
    panel_letters(panels)
    return figure


def _volume(run: RunResult) -> NDArray[np.float64]:
    volume: NDArray[np.float64] = run.evolution["worn_volume_moving_mm3"] + run.evolution["worn_volume_fixed_mm3"]
    return volume


@comparison_command
def main(result_dir: Path, folder: Path) -> None:
    """Draw the worn annulus around the stuck centre and say what became of it."""
    run = read_results(result_dir)[0]
    contacts = contacts_of(run)
    if len(contacts) < 2 or contacts[0].stick_radius_um == 0.0:
        raise ResultError(f"{result_dir} is no run in partial slip with at least two logged scars")
    findings = [stick_zone_stays(contacts), wear_ends(run), pressure_gathers(contacts), annulus_is_relieved(contacts)]
    folder.mkdir(parents=True, exist_ok=True)
    drawn = save(partial(picture, run, contacts), folder / "partial_slip.png")
    console = wide_console()
    console.print(finding_table(findings))
    console.print(str(drawn), soft_wrap=True, highlight=False)


if __name__ == "__main__":
    main()
