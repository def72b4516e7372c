"""Temperatures that friction gives the surfaces of a finished run's bodies, cycle by cycle.

The friction power of a loop enters where bodies slide, in proportion to the friction there. One share of it flows into
each body, such that both surfaces are as hot where they are hottest (Blok, Proc. General Discussion on Lubrication 2
(IMechE, 1937) 222). Each body is a half-space to the contact; see `solvers.conduction`. Rises are above the
surroundings.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from rich import box
from rich.table import Table
from scipy.interpolate import PchipInterpolator, make_interp_spline

from geometry.arrays import Array, BoolArray
from geometry.patch import linear_weights
from solvers.conduction import Conductor, surface_rise
from wirewear.base.errors import ResultError
from wirewear.base.words import counted
from wirewear.base.writing import write_csv, writing
from wirewear.pictures.style import cycle_name, new_figure, save
from wirewear.results import ContactForces, RunResult, Scar
from wirewear.test.lengths import extent_of

_MOMENTS = 96  # Of a cycle: a sliding contact passes less than a fifteenth of its stroke between two of them.
_CELLS = 96  # Along the longer side of the heated part of a surface.


@dataclass(frozen=True)
class SurfaceHeat:
    """Temperatures of one body's surface in one cycle.

    share: of the friction power that flows into it. axial_um, transverse_um: middles (n,) and (m,) of cells. rise_K:
    (k, n, m) at equally spaced moments. power_mW: (k,) friction power. touched: (n, m) True where heat enters.
    """

    body: str
    cycle: int
    share: float
    axial_um: Array
    transverse_um: Array
    rise_K: Array
    power_mW: Array
    touched: BoolArray

    @property
    def row(self) -> dict[str, Any]:
        """The figures by name, as heat.csv has them."""
        return {
            "body": self.body,
            "cycle": self.cycle,
            "friction_power_mW": float(self.power_mW.mean()),
            "share_of_power": self.share,
            "mean_rise_K": self.mean_K,
            "largest_rise_K": self.largest_K,
        }

    @property
    def mean_K(self) -> float:
        """Mean over the heated surface and the cycle."""
        return float(self.rise_K.mean(axis=0)[self.touched].mean())

    @property
    def largest_K(self) -> float:
        """Largest at any place and moment."""
        return float(self.rise_K.max())


def surface_heat(result: RunResult, cycle: float, conductors: Mapping[str, Conductor]) -> tuple[SurfaceHeat, ...]:
    """Temperatures of both bodies of a run in the recorded cycle nearest to `cycle`; conductors: by body.

    Raises ResultError if no contact forces are recorded.
    """
    whole = [_heated(result, result.forces(cycle, body), conductors[body]) for body in result.bodies]
    hottest = [one.largest_K for one in whole]
    if not all(hottest):
        raise ResultError(f"{result.label}: nothing slides in cycle {counted(whole[0].cycle)}, so nothing is heated")
    parted = zip(whole, reversed(hottest), strict=True)
    return tuple(
        replace(one, share=other / sum(hottest), rise_K=one.rise_K * other / sum(hottest)) for one, other in parted
    )


def _heated(result: RunResult, forces: ContactForces, conductor: Conductor) -> SurfaceHeat:
    """The body's temperatures if all heat flowed into it."""
    scar, loop = result.scar(forces.cycle, forces.body), result.loop(forces.cycle)
    period_s = 1.0 / float(result.study["conditions"]["frequency_Hz"])
    since, work = (loop.time_s - loop.time_s[0]) / period_s, loop.friction_work_mJ
    done = PchipInterpolator(np.append(since, 1.0), np.append(work, work[-1] + work[0]))
    power = np.diff(done(np.arange(_MOMENTS + 1) / _MOMENTS)) * _MOMENTS / period_s
    axial, transverse, spread = _cells(scar, forces)
    slid = scar.slip_distance_um.ravel()[forces.nodes] > 0.0
    friction = np.linalg.norm(forces.force_N[:, :, :2], axis=2) * slid
    place = (forces.phase - _mid_stroke(forces)) % 1.0
    order = np.argsort(place)
    wrapped = [
        np.concatenate([one[order[-1:]] - back, one[order], one[order[:1]] + back])
        for one, back in ((place, 1.0), (friction, 0.0))
    ]
    heat = np.stack(
        [spread(nodal) for nodal in make_interp_spline(*wrapped, k=1)((np.arange(_MOMENTS) + 0.5) / _MOMENTS)]
    )
    total = heat.sum(axis=(1, 2))
    heat *= np.divide(power, total, out=np.zeros(_MOMENTS), where=total > 0.0)[:, None, None]
    rise = surface_rise(heat, 1e-3 * float(axial[1] - axial[0]), period_s, conductor)
    return SurfaceHeat(forces.body, forces.cycle, 1.0, axial, transverse, rise, power, np.asarray(heat.any(axis=0)))


def _mid_stroke(forces: ContactForces) -> float:
    """Phase at which the driven body passes the middle of its stroke towards +x, where loops start."""
    rising = np.flatnonzero(np.diff(forces.drive_um, prepend=forces.drive_um[-1]) > 0.0)
    return float(forces.phase[rising[np.argmin(np.abs(forces.drive_um[rising]))]])


def _cells(scar: Scar, forces: ContactForces) -> tuple[Array, Array, Callable[[Array], Array]]:
    """Middles in µm of square cells over the loaded nodes, and what spreads nodal forces (m,) over the cells (n, m), in
    proportion to the force per area between nodes.
    """
    rows, columns = np.unravel_index(forces.nodes, scar.depth_um.shape)
    lines = (scar.axial_um, scar.transverse_um)
    # A line contact has one line, which stands for all of its length.
    ends = [
        (own[max(at.min() - 1, 0)] - beyond, own[min(at.max() + 1, len(own) - 1)] + beyond)
        for own, at, beyond in zip(lines, (rows, columns), (0.0, 1e3 * extent_of(scar.length_mm).half_mm), strict=True)
    ]
    cell = max(high - low for low, high in ends) / _CELLS
    middles = [
        0.5 * (low + high) + cell * (np.arange(count) - 0.5 * (count - 1))
        for low, high in ends
        for count in [max(2, round((high - low) / cell))]
    ]
    along = linear_weights(scar.axial_um, middles[0])
    across = linear_weights(scar.transverse_um, middles[1])
    widths = [np.gradient(own) if len(own) > 1 else np.ones(1) for own in lines]

    def spread(nodal: Array) -> Array:
        density = np.zeros(scar.depth_um.shape)
        density[rows, columns] = nodal / (widths[0][rows] * widths[1][columns])
        return np.asarray(along @ density @ across.T)

    return middles[0], middles[1], spread


def heat_table(courses: Sequence[SurfaceHeat], called: Callable[[str], str]) -> Table:
    """Table of the temperatures, a row for each body and cycle. called: from a body's name to its name in headings."""
    table = Table("body", box=box.SIMPLE_HEAD)
    for heading in ("cycle", "friction power [mW]", "share of it", "mean rise [K]", "largest rise [K]"):
        table.add_column(heading, justify="right")
    for one in courses:
        _, cycle, *figures = one.row.values()
        table.add_row(called(one.body), counted(int(cycle)), *(f"{figure:.3g}" for figure in figures))
    return table


def write_heat(courses: Sequence[SurfaceHeat], folder: Path) -> list[Path]:
    """Write heat.csv, a row for each body and cycle, and a picture of the latest cycle; their paths. Raises ResultError
    if they cannot be written.
    """
    last = [one for one in courses if one.cycle == courses[-1].cycle]
    with writing(ResultError, f"cannot write temperatures to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return [
            write_csv(folder / "heat.csv", [one.row for one in courses]),
            save(partial(draw_heat, last), folder / "heat.png"),
        ]


def draw_heat(bodies: Sequence[SurfaceHeat]) -> Figure:
    """Picture of each surface at its hottest moment, and how hot its hottest place is over the cycle."""
    figure = new_figure(3.0)
    panels = figure.subplots(1, len(bodies) + 1)
    top = max(one.largest_K for one in bodies)
    for axes, one in zip(panels, bodies, strict=False):
        course = one.rise_K.max(axis=(1, 2))
        hottest = one.rise_K[int(course.argmax())].T
        levels = np.linspace(0.0, top, 13)
        filled = axes.contourf(one.axial_um, one.transverse_um, hottest, levels=levels, cmap="inferno", extend="both")
        axes.set(title=f"{one.body}, cycle {cycle_name(one.cycle)}", xlabel="along the body [µm]", aspect="equal")
        axes.grid(visible=False)
        panels[-1].plot((np.arange(len(course)) + 0.5) / len(course), course, label=one.body)
    panels[0].set_ylabel("across it [µm]")
    ticks = np.linspace(0.0, top, 4)
    bar = figure.colorbar(filled, ax=list(panels[:-1]), label="rise [K]", orientation="horizontal", ticks=ticks)
    bar.ax.set_xticklabels([f"{tick:.2g}" for tick in ticks])
    panels[-1].set(title="hottest place", xlabel="share of the cycle, from mid-stroke", ylabel="rise [K]")
    panels[-1].set_ylim(bottom=0.0)
    panels[-1].legend(loc="lower left")
    return figure
