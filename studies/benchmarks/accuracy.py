"""The three pictures of docs/accuracy.md, and the rows of its table that whole runs give.

Usage: python -m studies.benchmarks.accuracy [--level quick --level standard --level fine] [--output DIR]

The steel wires on the compliant rig at every level, beside closed forms at the first cycle and beside their limit at
the last; a ball on a flat that wears out in partial slip under a held force, beside the shape at which that ends. Runs
that are complete in the output folder stay.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import wirewear as ww
from studies.study_script import StudyScript
from wirewear import RunResult, reference
from wirewear.pictures import style
from wirewear.pictures.panels import draw_loop, name_axes
from wirewear.test.fidelity import FIDELITIES
from wirewear.verification.partial_slip_run import held_force_shape, held_force_study

STUDY = Path(__file__).parents[1] / "steel_wires" / "study.toml"
RIG_N_per_mm, AMPLITUDE_mm = 167.0, 0.06
_STEEL = reference.Elastic(210000.0, 0.3)
_MODULI_MPa = (reference.contact_modulus(_STEEL, _STEEL), reference.tangential_contact_modulus(_STEEL, _STEEL))
_HERTZ = reference.hertz_point(2.0, 0.225, _MODULI_MPa[0])
_CONTACT = reference.partial_slip_point(2.0, 0.62, _HERTZ.contact_radius_mm, _MODULI_MPa[1])

#: What a whole run comes to: name, value and error of its limit, how it is read off the last cycle. The first four are
#: of another code, the others of Richardson's extrapolation (studies/steel_wires/README.md).
LIMITS = (
    ("largest force", "1.90 ± 0.02 N", 1.90, 0.02, ("max_tangential_force_N",)),
    ("energy of a cycle", "242 ± 1 µJ", 0.242, 0.001, ("dissipated_energy_mJ",)),
    ("depth of the fixed wire", "19.8 ± 0.1 µm", 19.8, 0.1, ("max_depth_fixed_um",)),
    ("depth of the moving wire", "10.9 ± 0.1 µm", 10.9, 0.1, ("max_depth_moving_um",)),
    ("slip amplitude", "47.9 ± 0.4 µm", 47.94, 0.44, ("slip_amplitude_um",)),
    (
        "worn volume",
        "0.7365 ± 0.0073 · 10⁻³ mm³",
        0.7365e-3,
        0.0073e-3,
        ("worn_volume_fixed_mm3", "worn_volume_moving_mm3"),
    ),
)


def errors_of(run: RunResult) -> dict[str, float]:
    """How far a run of the steel wires is from every limit, as a share of the limit."""
    last = {name: float(column[-1]) for name, column in run.evolution.items()}
    return {name: sum(last[column] for column in columns) / limit - 1.0 for name, _, limit, _, columns in LIMITS}


def rows(runs: Mapping[str, RunResult]) -> list[str]:
    """Lines of the table in the docs."""
    found = [errors_of(run) for run in runs.values()]
    return [
        f"| {name} | {words} | " + " | ".join(f"{100.0 * one[name]:+.1f} %".replace("-", "−") for one in found) + " |"
        for name, words, *_ in LIMITS
    ]


def worn_out_row(runs: Mapping[str, RunResult]) -> str:
    """Line of the table in the docs on wear in partial slip: errors of volume and largest depth at the end."""
    exact, volume = held_force_shape()
    cells = [
        f"{100.0 * (float(volume_of(run)[-1]) / volume - 1.0):+.1f}; "
        f"{100.0 * (1e-6 * float(depth_of(run).max()) / exact.deepest_mm[0] - 1.0):+.1f} %"
        for run in runs.values()
    ]
    return f"| worn volume; largest depth | Ciavarella and Hills | {' | '.join(cells)} |".replace("-", "−")


def volume_of(run: RunResult) -> NDArray[np.float64]:
    """Worn volume of both bodies at each computed cycle, mm³."""
    return np.asarray(run.worn_volume_mm3)


def depth_of(run: RunResult) -> NDArray[np.float64]:
    """Worn depth of both bodies at all nodes of the last map, nm."""
    fixed, moving = (run.scar(run.scar_cycles()[-1], body) for body in ("fixed", "moving"))
    return np.asarray(1e3 * (fixed.depth_um + moving.depth_um))


def fresh(runs: Mapping[str, RunResult]) -> Figure:
    """The first cycle: pressure at mid-stroke beside Hertz's, and the loop beside Cattaneo and Mindlin's."""
    figure = style.new_figure(3.1)
    pressed, moved = figure.subplots(1, 2)
    radius_um = np.linspace(0.0, 20.0, 400)
    pressed.plot(radius_um, _HERTZ.pressure(1e-3 * radius_um), color=style.INK, label="Hertz")
    loop = reference.closed_loop(_CONTACT, AMPLITUDE_mm, RIG_N_per_mm)
    draw_loop(moved, 1e3 * loop.displacement_mm, loop.tangential_force_N, color=style.INK, label="closed form")
    for index, (level, run) in enumerate(runs.items()):
        dots = {"color": style.VARIANT_COLOURS[index], "linestyle": "", "marker": "osd"[index % 3], "markersize": 3.5}
        scar, first = run.scar(1, "fixed"), run.loops[0]
        near = _distance_um(scar.axial_um, scar.transverse_um) <= radius_um[-1]
        distance = _distance_um(scar.axial_um, scar.transverse_um)[near]
        pressed.plot(distance, scar.pressure_MPa[near], label=level, **dots)
        moved.plot(first.displacement_um, first.tangential_force_N, label=level, **dots)
    pressed.set(title="pressure", xlabel="distance from the middle [µm]", ylabel="pressure at mid-stroke [MPa]")
    name_axes(moved)
    moved.set_title("loop")
    return _finished(figure, pressed, moved)


def levels(runs: Mapping[str, RunResult]) -> Figure:
    """The last cycle of every level beside the limits and their errors."""
    figure = style.new_figure(2.6)
    axes = figure.subplots()
    places = np.arange(len(LIMITS))[::-1]
    known = [100.0 * error / limit for _, _, limit, error, _ in LIMITS]
    axes.barh(places, [2.0 * each for each in known], left=[-each for each in known], height=0.7, color="#e2e2e2")
    for index, (level, run) in enumerate(runs.items()):
        found = 100.0 * np.array(list(errors_of(run).values()))
        look: dict[str, Any] = {"color": style.VARIANT_COLOURS[index], "linestyle": "", "marker": "osd"[index % 3]}
        axes.plot(found, places, label=level, **look)
    axes.axvline(0.0, color=style.INK, linewidth=0.8)
    axes.set_yticks(places, [name for name, *_ in LIMITS])
    axes.set(xlabel="difference from the limit after 100 000 cycles [%]; grey: error of the limit")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return figure


def worn_out(runs: Mapping[str, RunResult]) -> Figure:
    """Depth at all nodes and worn volume of a ball on a flat in partial slip, beside the shape at the end."""
    figure = style.new_figure(3.1)
    depths, volumes = figure.subplots(1, 2)
    exact, volume_mm3 = held_force_shape()
    radius_um = np.linspace(0.0, 1.3e3 * exact.edge_radius_mm, 600)
    depths.plot(radius_um, 1e6 * exact.depth(1e-3 * radius_um), color=style.INK, label="closed form")
    volumes.axhline(1e9 * volume_mm3, color=style.INK, label="closed form")
    for index, (level, run) in enumerate(runs.items()):
        look = {"color": style.VARIANT_COLOURS[index], "label": level, "marker": "osd"[index % 3], "markersize": 3.0}
        last = run.scar(run.scar_cycles()[-1], "fixed")
        distance = _distance_um(last.axial_um, last.transverse_um)
        near = distance <= radius_um[-1]
        depths.plot(distance[near], depth_of(run)[near], linestyle="", **look)
        volumes.plot(run.evolution["cycle"], 1e9 * volume_of(run), **look)
    depths.set(title="depth", xlabel="distance from the middle [µm]", ylabel="worn depth of both bodies [nm]")
    volumes.set(title="volume", ylabel="worn volume of both bodies [µm³]")
    style.cycle_axis(volumes)
    return _finished(figure, depths, volumes)


def _distance_um(axial_um: NDArray[np.float64], transverse_um: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.hypot(axial_um[:, None], transverse_um[None, :])


def _finished(figure: Figure, left: Axes, right: Axes) -> Figure:
    style.panel_letters([left, right])
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))
    return figure


@click.command(cls=StudyScript)
@click.option("--level", "chosen", multiple=True, type=click.Choice(FIDELITIES), default=FIDELITIES)
@click.option("--output", type=click.Path(path_type=Path), default=Path("runs/accuracy"), show_default=True)
def main(chosen: tuple[str, ...], output: Path) -> None:
    """Run what is not there yet, draw accuracy_*.png and print the rows."""
    study = ww.load(STUDY).variant("compliant")
    runs = {level: ww.run(study, fidelity=level, output=output / level, resume=True) for level in chosen}
    held = held_force_study()
    out = {level: ww.run(held, fidelity=level, output=output / f"slip_{level}", resume=True) for level in chosen}
    for name, draw in (
        ("fresh", lambda: fresh(runs)),
        ("levels", lambda: levels(runs)),
        ("partial_slip", lambda: worn_out(out)),
    ):
        click.echo(style.save(draw, output / f"accuracy_{name}.png"))
    click.echo("\n".join([*rows(runs), worn_out_row(out)]))


if __name__ == "__main__":
    raise SystemExit(main())
