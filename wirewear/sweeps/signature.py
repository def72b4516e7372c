"""The signature of an effect: one study run without and with it, a picture of what differs; keys of a sweep's file."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from importlib.resources import files
from pathlib import Path
from textwrap import fill
from typing import Annotated, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from pydantic import BeforeValidator, Field, PlainValidator

from geometry.arrays import Array
from wirewear.base.errors import Quantity, RunError, shown
from wirewear.effects import Effect, Seam
from wirewear.effects.parameter import plain
from wirewear.loops import LoopFigures, analyse_loop
from wirewear.pictures.smooth import smooth_loop, smooth_scar
from wirewear.pictures.style import GREY, INK, VARIANT_COLOURS, cycle_axis, cycle_name, new_figure, panel_letters, save
from wirewear.results import Loop, RunResult, Scar, read_loops
from wirewear.simulation import ObserverOf, run_study
from wirewear.study import FIDELITIES, Study, parse_study
from wirewear.study.keys import CheckedFlag, NamedTable, Table, checked_text, one_of

_STUDY = "signature_study.toml"

#: Lines of runs without and with the effect.
NOMINAL: dict[str, Any] = {"color": INK, "linestyle": (0, (4, 1.5)), "linewidth": 1.2}
CHANGED: dict[str, Any] = {"color": VARIANT_COLOURS[1], "linestyle": "-", "linewidth": 1.6}
_FIGURES = {
    "slip_amplitude_um": ("slip amplitude δ0", "o"),
    "dissipated_energy_mJ": ("energy per cycle", "s"),
    "friction_max": ("largest Q/P", "^"),
}
_LEVELS = (0.1, 0.5)
_THIN = 0.8
_POINTS = 121


def signature_study() -> Study:
    """The steel-wire test, on which signatures are drawn by default."""
    text = files("wirewear.sweeps").joinpath(_STUDY).read_text(encoding="utf-8")
    return parse_study(text, _STUDY)


@dataclass(frozen=True)
class Signature:
    """A run of the nominal model and one with the effect; loops are those that the sensors read."""

    effect: Effect[Any]
    nominal: RunResult
    changed: RunResult

    @cached_property
    def loops(self) -> tuple[tuple[Loop, Loop], ...]:
        """Pairs of loops of the same cycle, nominal and with the effect."""
        return tuple(zip(read_loops(self.nominal), read_loops(self.changed), strict=True))

    def on_one_phase(self, place: int) -> tuple[Array, Array, Array]:
        """Phases of the drive in cycles (n,), and of both loops of a pair displacement and force there (2, n).

        Runs may take different increments: between those of a loop its channels are straight lines.
        """
        pair = self.loops[place]
        turns = [float(self.nominal.study["conditions"]["frequency_Hz"]) * loop.time_s % 1.0 for loop in pair]
        phase = np.unique(np.concatenate([*turns, [0.0, 1.0]]))
        channels = [
            [
                np.interp(phase, turn, getattr(loop, name), period=1.0)
                for name in ("displacement_um", "tangential_force_N")
            ]
            for turn, loop in zip(turns, pair, strict=True)
        ]
        first, second = np.array(channels)
        return phase, first, second

    @cached_property
    def cycles(self) -> tuple[int, ...]:
        return tuple(nominal.cycle for nominal, _ in self.loops)

    @cached_property
    def figures(self) -> tuple[tuple[LoopFigures, LoopFigures], ...]:
        """Their figures, as `analyse_loop` finds them."""
        return tuple((_figures(nominal), _figures(changed)) for nominal, changed in self.loops)

    def changes(self) -> Mapping[str, list[float]]:
        """By how much the figures of each cycle's loop change, relative to the nominal ones."""
        names = ("slip_amplitude_um", "dissipated_energy_mJ", "friction_max")
        return {
            name: [_value(changed, name) / _value(nominal, name) - 1.0 for nominal, changed in self.figures]
            for name in names
        }


def signature_of(
    effect: Effect[Any],
    output: Path,
    *,
    study: Study | None = None,
    fidelity: str = "quick",
    observer_of: ObserverOf | None = None,
) -> Signature:
    """Run a study without and with an effect, in OUTPUT/nominal and OUTPUT/<effect>; finished runs are kept.

    A run that was interrupted is continued; one of another study, fidelity or version is replaced. An effect of the
    sensor needs no run of its own, as the test itself goes on as without it.
    Raises SolverError or StudyError as `run_study` does.
    """
    base = study or signature_study()
    nominal = _run(base.with_effects(), "nominal", output, fidelity, observer_of)
    study = base.with_effects(effect)
    if effect.seam is Seam.SENSOR:
        return Signature(effect, nominal, replace(nominal, study=study.resolved()))
    return Signature(effect, nominal, _run(study, effect.name, output, fidelity, observer_of))


def _run(study: Study, name: str, output: Path, fidelity: str, observer_of: ObserverOf | None) -> RunResult:
    observe = (lambda _: observer_of(name)) if observer_of else None
    run = partial(run_study, study, fidelity=fidelity, output=output / name, observer_of=observe)
    try:
        (result,) = run(resume=True)
    except RunError:
        (result,) = run()
    return result


def _figures(loop: Loop) -> LoopFigures:
    return analyse_loop(loop.displacement_um, loop.tangential_force_N, loop.normal_force_N, time_s=loop.time_s)


def _value(figures: LoopFigures, name: str) -> float:
    measured = getattr(figures, name)
    return float("nan") if measured is None else float(measured.value)


def draw_signature(signature: Signature, path: Path) -> Path:
    """Draw a signature as PNG and return the path."""
    return save(lambda: signature_figure(signature), path)


def signature_figure(signature: Signature) -> Figure:
    """First and last loop, their difference at equal phase, evolution, sections and outlines of the scars."""
    figure = new_figure(5.6)
    panels = list(figure.subplots(2, 3).flat)
    first, last = signature.loops[0], signature.loops[-1]
    for axes, pair in ((panels[0], first), (panels[1], last)):
        _loops(axes, pair)
    _difference(panels[2], signature)
    _evolution(panels[3], signature)
    scars = [
        (smooth_scar(run.scar(run.loops[-1].cycle, "moving")), smooth_scar(run.scar(run.loops[-1].cycle, "fixed")))
        for run in (signature.nominal, signature.changed)
    ]
    _sections(panels[4], scars)
    _outlines(panels[5], scars)
    panel_letters(panels)
    values = ", ".join(f"{name} = {_shown(value)}" for name, value in signature.effect.values.items())
    figure.suptitle(f"{signature.effect.name}: {values}", x=0.01, ha="left", fontsize=9.5, fontweight="bold")
    handles = [Line2D([], [], label="nominal", **NOMINAL), Line2D([], [], label="with the effect", **CHANGED)]
    figure.legend(handles=handles, loc="outside lower right", ncols=2)
    figure.supxlabel(fill(signature.effect.signature, 66), x=0.01, ha="left", fontsize=8, color=INK)
    return figure


def _shown(value: float) -> str:
    written = plain(value)
    return written if isinstance(written, str) else f"{written:g}"


def _loops(axes: Axes, pair: tuple[Loop, Loop]) -> None:
    for loop, style in zip(pair, (NOMINAL, CHANGED), strict=True):
        axes.plot(*smooth_loop(loop), solid_capstyle="butt", **style)
    axes.set(
        title=f"loop, cycle {cycle_name(pair[0].cycle)}", xlabel="displacement δ [µm]", ylabel="tangential force Q [N]"
    )
    axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.axvline(0.0, color=GREY, linewidth=0.6, zorder=1)


def _difference(axes: Axes, signature: Signature) -> None:
    """Difference of the force over the true phase, of the first and the last loop."""
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
    """Depth along the motion through the middle of both scars; the moving wire's line is thin."""
    for (moving, fixed), style in zip(scars, (NOMINAL, CHANGED), strict=True):
        for scar, width in ((moving, _THIN), (fixed, style["linewidth"])):
            x, depth = scar.section_along_motion()
            axes.plot(x, -depth, **{**style, "linewidth": width})
    reach = 1.1 * max(_reach(scar) for pair in scars for scar in pair)
    axes.set_xlim(-reach, reach)
    # Room for the legend below the deepest point.
    axes.set_ylim(bottom=1.35 * axes.get_ylim()[0])
    axes.set(title="depth on y = 0", xlabel="position x [µm]", ylabel="height change [µm]")
    lines = [Line2D([], [], color=GREY, linewidth=width) for width in (CHANGED["linewidth"], _THIN)]
    axes.legend(lines, ["fixed wire", "moving wire"], loc="lower right", fontsize=7)


def _outlines(axes: Axes, scars: list[tuple[Scar, Scar]]) -> None:
    """Lines of a tenth and of half of its own depth of the fixed wire's scar, seen from above."""
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
    """Largest |x| or |y| at which a twentieth of the worst depth is worn."""
    half = float(max(np.abs(scar.axial_um).max(), np.abs(scar.transverse_um).max()))
    line = np.linspace(-half, half, 2 * _POINTS)
    worn = scar.sampled(line, line) > 0.05 * scar.max_depth_um
    return float(np.maximum(np.abs(line)[:, None], np.abs(line)[None, :])[worn].max()) if worn.any() else half


GRID, LATIN_HYPERCUBE, SOBOL = "grid", "latin-hypercube", "sobol"
LINEAR, LOGARITHMIC = "linear", "logarithmic"

_NUMBER = Quantity("1", -1e15, 1e15)


def _checked_values(value: object) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or len(value) < 2:
        raise ValueError(f"is {shown(value)}, but must be a list of at least two numbers")
    numbers = []
    for item in value:
        try:
            numbers.append(float(_NUMBER(item)))
        except ValueError as problem:
            raise ValueError(f"holds an item that {problem}") from None
    if len(set(numbers)) < len(numbers):
        raise ValueError(f"is {shown(value)}, but must name every value once")
    return tuple(numbers)


def _checked_list(value: object) -> object:
    if not isinstance(value, list | tuple) or not value:
        raise ValueError("must be given as tables [[vary]], at least one")
    return tuple(value)


Number = Annotated[float, PlainValidator(_NUMBER)]


class Vary(Table):
    """A key that is varied: between two ends, or over a list of values."""

    key: Annotated[str, PlainValidator(checked_text)] = Field(
        description="key of the study, or effects.<effect>.<parameter>", examples=["contact.friction"]
    )
    low: Number | None = Field(None, description="lower end")
    high: Number | None = Field(None, description="upper end")
    scale: Annotated[str, PlainValidator(one_of(LINEAR, LOGARITHMIC))] = Field(
        LINEAR, description="how values are spread between the ends"
    )
    values: Annotated[tuple[float, ...] | None, PlainValidator(_checked_values)] = Field(
        None, description="the values of a grid"
    )


class SweepTables(NamedTable):
    """A whole sweep."""

    study: Annotated[str, PlainValidator(checked_text)] = Field(
        description="the study's file, beside the sweep's", examples=["study.toml"]
    )
    variant: Annotated[str | None, PlainValidator(checked_text)] = Field(None, description="variant of the study")
    fidelity: Annotated[str, PlainValidator(one_of(*FIDELITIES))] = Field("quick", description="level of fidelity")
    design: Annotated[str, PlainValidator(one_of(GRID, LATIN_HYPERCUBE, SOBOL))] = Field(
        description="way in which the values of the varied keys are chosen", examples=[LATIN_HYPERCUBE]
    )
    samples: Annotated[int | None, PlainValidator(Quantity("1", 2, 10_000_000, whole=True))] = Field(
        None, description="runs of a latin-hypercube; base samples of sobol, a power of 2"
    )
    seed: Annotated[int, PlainValidator(Quantity("1", 0, 2**32 - 1, whole=True))] = Field(
        1, description="seed of what is drawn"
    )
    keep_results: CheckedFlag = Field(False, description="whether each run's result file is kept, in runs/")
    vary: Annotated[tuple[Vary, ...], BeforeValidator(_checked_list)] = Field(description="the keys that are varied")
