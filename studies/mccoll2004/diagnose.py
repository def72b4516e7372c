"""McColl's measured flat against the simulation: where they differ, what would explain it, and how far it shrinks.

    python -m studies.mccoll2004.diagnose RESULT_DIR [--output DIR]

RESULT_DIR is the folder that `wirewear run studies/mccoll2004/causes.toml` left. One profile is all there is: causes
are told apart by the shape of the scar alone. Where the flat's zero and level lie in the figure is not known, so the
scar is read in three ways; how far aside its middle lies is always left free.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.polynomial import Polynomial
from numpy.typing import NDArray
from rich import box
from rich.table import Table
from scipy.optimize import minimize_scalar

from wirewear.pictures.style import GREY, INK, VARIANT_COLOURS, new_figure, panel_letters, save
from wirewear.planar.results import PlanarResult, read_planar_result
from wirewear.study_script import comparison_command, wide_console
from wirewear.verdicts import Finding, finding_table

from .compare import CYCLES, Scar, base_line_um, measured_scar

Array = NDArray[np.float64]

#: Where scars are compared: the measured scar and a little beside it. Beyond, the flat has features that are no wear.
_FROM_um, _TO_um = -300.0, 340.0

#: Degree of the smooth curve that is taken for the measured shape; what it leaves is roughness.
_SHAPE_DEGREE = 8

#: How far the simulated scar may be moved aside, and how finely that is searched.
_MOST_ASIDE_um, _STEP_um = 30.0, 2.0

#: Width of the blocks of which every other one is left out of a fit.
_BLOCK_um = 80.0

#: Misfit of the nominal scar, over that of the measured shape, above which there is a gap to speak of.
_GAP = 1.5


@dataclass(frozen=True)
class Cause:
    """Something that the model may lack: the scars that it makes at some values of its size.

    nominal: the value with which it changes nothing.  words: what it is, and of which class it is one.
    """

    name: str
    words: str
    values: Array
    scars: tuple[Scar, ...]
    nominal: float

    def depth_um(self, value: float, x_um: Array) -> Array:
        """Depth at places, in between by straight lines from size to size."""
        depths = np.array([np.interp(x_um, scar.x_um, scar.depth_um) for scar in self.scars])
        upper = int(np.clip(np.searchsorted(self.values, value), 1, len(self.values) - 1))
        low, high = self.values[upper - 1 : upper + 1]
        share = (value - low) / (high - low)
        return np.asarray((1.0 - share) * depths[upper - 1] + share * depths[upper])


@dataclass(frozen=True, eq=False)
class Fit:
    """A scar moved aside, up and level onto the measured one.

    aside_um: to the right.  rms_um: what is left.  misfit: the same squared over the number of points, in units of the
    roughness, whose neighbours are alike.  depth_um: of the fitted scar at the measured places.
    """

    value: float
    aside_um: float
    rms_um: float
    misfit: float
    depth_um: Array


class Profile:
    """The measured profile where it is compared, and its roughness; read from a zero, or with zero and level free."""

    def __init__(self, measured: Scar, base_um: float = 0.0, *, free: bool = False) -> None:
        """Of a measured scar; base_um: what the flat stands above the figure's zero."""
        measured = Scar(measured.x_um, measured.depth_um + base_um)
        self.free = free
        inside = (measured.x_um >= _FROM_um) & (measured.x_um <= _TO_um)
        self.x_um, self.depth_um = measured.x_um[inside], measured.depth_um[inside]
        self.shape = np.asarray(Polynomial.fit(self.x_um, self.depth_um, _SHAPE_DEGREE)(self.x_um))
        rough = self.depth_um - self.shape
        self.roughness_um = float(np.sqrt(np.mean(rough**2)))
        self.alike = float(np.clip(np.corrcoef(rough[:-1], rough[1:])[0, 1], 0.0, 0.98))

    def whitened(self, rows: Array) -> Array:
        """Neighbours' likeness taken out, in units of the roughness; along the first axis."""
        scaled = rows / self.roughness_um
        first = scaled[:1]
        later = (scaled[1:] - self.alike * scaled[:-1]) / np.sqrt(1.0 - self.alike**2)
        return np.concatenate([first, later])

    def levelled(self, depth: Array, chosen: NDArray[np.bool_]) -> Array:
        """A depth with the zero and the level that suit the chosen points best, if these are free."""
        if not self.free:
            return depth
        rows = np.column_stack([np.ones_like(self.x_um), self.x_um / 100.0])
        white, target = self.whitened(rows)[chosen], self.whitened(self.depth_um - depth)[chosen]
        return np.asarray(depth + rows @ np.linalg.lstsq(white, target, rcond=None)[0])

    def misfit(self, depth: Array, chosen: NDArray[np.bool_]) -> float:
        """Mean square of what is left at the chosen points, whitened."""
        return float(np.mean(self.whitened(self.depth_um - depth)[chosen] ** 2))

    @property
    def everywhere(self) -> NDArray[np.bool_]:
        """All points."""
        return np.ones(len(self.x_um), dtype=bool)

    @property
    def blocks(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Every other block of points, and the rest."""
        even = np.floor((self.x_um - _FROM_um) / _BLOCK_um).astype(int) % 2 == 0
        return even, ~even


def fitted(profile: Profile, cause: Cause, chosen: NDArray[np.bool_], value: float | None = None) -> Fit:
    """The best fit at the chosen points, with the cause's size free, or held at a value."""

    def at(size: float, aside: float) -> Array:
        return profile.levelled(cause.depth_um(size, profile.x_um - aside), chosen)

    def best_size(aside: float) -> tuple[float, float]:
        if value is not None:
            return value, profile.misfit(at(value, aside), chosen)
        found = minimize_scalar(
            lambda size: profile.misfit(at(size, aside), chosen),
            bounds=(cause.values[0], cause.values[-1]),
            method="bounded",
        )
        return float(found.x), float(found.fun)

    places = np.arange(-_MOST_ASIDE_um, _MOST_ASIDE_um + 1e-9, _STEP_um)
    tried = [best_size(aside) for aside in places]
    best = int(np.argmin([misfit for _, misfit in tried]))
    size, aside = tried[best][0], float(places[best])
    depth = at(size, aside)
    rest = (profile.depth_um - depth)[chosen]
    return Fit(size, aside, float(np.sqrt(np.mean(rest**2))), profile.misfit(depth, chosen), depth)


def interval(profile: Profile, cause: Cause, best: Fit) -> tuple[float, float]:
    """Of the size, 95 %: where the misfit rises by 3.84 of what a point leaves at best; ends of the range where not."""
    sizes = np.linspace(cause.values[0], cause.values[-1], 41)
    count, every = len(profile.x_um), profile.everywhere
    levels = [profile.levelled(cause.depth_um(s, profile.x_um - best.aside_um), every) for s in sizes]
    excess = np.array([profile.misfit(depth, every) for depth in levels]) / best.misfit - 1.0
    inside = sizes[excess * count <= 3.84]
    return (float(inside[0]), float(inside[-1])) if len(inside) else (best.value, best.value)


def shrink(profile: Profile, cause: Cause) -> float:
    """By what share the gap shrinks on blocks left out of the fit, down to the measured shape's own roughness.

    NaN where the nominal scar leaves hardly more than that.
    """
    before = after = floor = 0.0
    for fit_on, judged_on in (profile.blocks, profile.blocks[::-1]):
        nominal = fitted(profile, cause, fit_on, cause.nominal)
        better = fitted(profile, cause, fit_on)
        before += profile.misfit(nominal.depth_um, judged_on)
        after += profile.misfit(better.depth_um, judged_on)
        floor += profile.misfit(profile.shape, judged_on)
    return (before - after) / (before - floor) if before > _GAP * floor else float("nan")


def bump(nominal: Scar) -> Cause:
    """The placebo: the nominal scar and a smooth bump of any size in its middle that no effect has made."""
    width = 0.5 * nominal.width_um
    shape = np.maximum(1.0 - (nominal.x_um / width) ** 2, 0.0) ** 2
    scars = tuple(Scar(nominal.x_um, nominal.depth_um + size * shape) for size in (-1.0, 1.0))
    return Cause(
        "a smooth bump (placebo)", "µm deeper in the middle, made by nothing", np.array([-1.0, 1.0]), scars, 0.0
    )


def causes_of(runs: dict[str, PlanarResult]) -> list[Cause]:
    """What causes.toml varies."""

    def scar(name: str, cycle: int = CYCLES) -> Scar:
        profile = runs[name].profile(cycle, "specimen")
        return Scar(profile.x_um, profile.depth_um)

    nominal = scar("wear_rate")
    cycles = sorted({profile.cycle for profile in runs["wear_rate"].profiles})
    return [
        Cause(
            "wear rate",
            "factor on the wear coefficients; by Archard's law a load or a number of cycles does nearly the same",
            np.array(cycles) / CYCLES,
            tuple(scar("wear_rate", cycle) for cycle in cycles),
            1.0,
        ),
        Cause(
            "stroke",
            "true amplitude in µm, of which 25 are stated: gain of the displacement sensor, compliance of the rig",
            np.array([20.0, 25.0, 30.0]),
            (scar("shorter_stroke"), nominal, scar("longer_stroke")),
            25.0,
        ),
        Cause(
            "third body",
            "share of the worn depth that debris of 20 GPa fills",
            np.array([0.0, 0.3]),
            (nominal, scar("third_body")),
            0.0,
        ),
        bump(nominal),
    ]


@dataclass(frozen=True, eq=False)
class Judged:
    """A cause beside the measured scar."""

    cause: Cause
    fit: Fit
    interval95: tuple[float, float]
    shrink: float


def judged(profile: Profile, causes: Sequence[Cause]) -> list[Judged]:
    """Every cause fitted, the one that leaves least first."""
    found = []
    for cause in causes:
        fit = fitted(profile, cause, profile.everywhere)
        found.append(Judged(cause, fit, interval(profile, cause, fit), shrink(profile, cause)))
    return sorted(found, key=lambda one: one.fit.misfit)


def causes_table(profile: Profile, nominal: Fit, found: Sequence[Judged]) -> Table:
    """Sizes, what they leave, and how far the gap shrinks."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("cause", no_wrap=True)
    for heading in ("size", "95 %", "left, rms [µm]", "misfit", "shrink, left out"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("what it is")
    table.add_row("nothing", "–", "–", f"{nominal.rms_um:.3f}", f"{nominal.misfit:.2f}", "–", "the model as it is")
    for one in found:
        low, high = one.interval95
        figures = f"{one.fit.value:.3g}", f"{low:.3g} to {high:.3g}", f"{one.fit.rms_um:.3f}", f"{one.fit.misfit:.2f}"
        table.add_row(one.cause.name, *figures, _percent(one.shrink), one.cause.words)
    floor = profile.misfit(profile.shape, profile.everywhere)
    table.add_row(
        "roughness", "–", "–", f"{profile.roughness_um:.3f}", f"{floor:.2f}", "100%", "the measured shape's own"
    )
    return table


def _percent(share: float) -> str:
    return "no gap" if np.isnan(share) else f"{share:.0%}"


def findings_of(profile: Profile, nominal: Fit, found: Sequence[Judged]) -> list[Finding]:
    """Where the gap lies, whether one class explains it, and whether a placebo does as well."""
    rest = profile.depth_um - nominal.depth_um
    parts = {
        "left wall": (-300.0, -170.0),
        "middle": (-170.0, 170.0),
        "right wall": (170.0, 340.0),
    }
    means = {
        name: float(np.mean(rest[(profile.x_um >= low) & (profile.x_um < high)])) for name, (low, high) in parts.items()
    }
    effects = [one for one in found if "placebo" not in one.cause.name]
    placebo = next(one for one in found if "placebo" in one.cause.name)
    best = effects[0]
    return [
        Finding(
            "There is a gap: the simulated scar leaves more than roughness",
            f"{nominal.rms_um:.2f} µm rms against {profile.roughness_um:.2f}; measured deeper by "
            + ", ".join(f"{value:+.2f} µm ({name})" for name, value in means.items()),
            nominal.misfit > _GAP * profile.misfit(profile.shape, profile.everywhere),
        ),
        Finding(
            "One class of causes explains it, down to roughness",
            f"{best.cause.name} {best.fit.value:.3g} leaves {best.fit.rms_um:.2f} µm rms",
            best.fit.misfit <= _GAP * profile.misfit(profile.shape, profile.everywhere) < nominal.misfit,
        ),
        Finding(
            "That class is told from the others by this profile",
            "; ".join(f"{one.cause.name}: misfit {one.fit.misfit:.2f}" for one in effects),
            len(effects) > 1 and effects[1].fit.misfit / best.fit.misfit - 1.0 > 3.84 / len(profile.x_um),
        ),
        Finding(
            "It shrinks the gap more than a placebo does, on blocks left out of the fit",
            f"{_percent(best.shrink)} against {_percent(placebo.shrink)}",
            best.shrink > placebo.shrink,
        ),
    ]


def picture(profile: Profile, nominal: Fit, found: Sequence[Judged]) -> Figure:
    """The measured scar with the nominal and the best fits, and what they leave."""
    figure = new_figure(3.4)
    left, right = figure.subplots(1, 2)
    left.plot(profile.x_um, profile.depth_um, ".", color=INK, markersize=2.5, label="measured")
    curves: list[tuple[str, Array]] = [("as it is", nominal.depth_um)]
    better = [one for one in found if "placebo" not in one.cause.name and one.fit.misfit < 0.99 * nominal.misfit]
    curves += [(f"{one.cause.name} {one.fit.value:.3g}", one.fit.depth_um) for one in better]
    for (label, depth), colour in zip(curves, VARIANT_COLOURS, strict=False):
        left.plot(profile.x_um, depth, color=colour, linewidth=1.1, label=label)
        right.plot(profile.x_um, profile.depth_um - depth, color=colour, linewidth=1.1)
    right.axhspan(-profile.roughness_um, profile.roughness_um, color="#eeeeee", zorder=0)
    right.axhline(0.0, color=GREY, linewidth=0.8)
    left.invert_yaxis()
    left.set_title("the flat, from the figure's zero")
    right.set_title("measured less simulated")
    for axes in (left, right):
        axes.set_xlabel("x [µm]")
        axes.set_ylabel("depth [µm]")
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    panel_letters([left, right])
    return figure


def readings() -> dict[str, Profile]:
    """The measured profile, from either zero, and with zero and level free."""
    measured = measured_scar()
    return {
        "from the figure's zero": Profile(measured),
        "from the untouched flat": Profile(measured, base_line_um(measured)),
        "zero and level free": Profile(measured, free=True),
    }


def diagnosed(profile: Profile, causes: Sequence[Cause]) -> tuple[Profile, Fit, list[Judged]]:
    """A profile, the nominal scar on it, and every cause beside it."""
    nominal = fitted(profile, causes[0], profile.everywhere, causes[0].nominal)
    return profile, nominal, judged(profile, causes)


NAMES = ("wear_rate", "shorter_stroke", "longer_stroke", "third_body")


@comparison_command
def main(result_dir: Path, folder: Path) -> None:
    """Diagnose the measured flat against the simulation."""
    causes = causes_of({name: read_planar_result(result_dir / name) for name in NAMES})
    found = {words: diagnosed(profile, causes) for words, profile in readings().items()}
    folder.mkdir(parents=True, exist_ok=True)
    draw: Callable[[], Figure] = partial(picture, *found["from the figure's zero"])
    drawn = save(draw, folder / "diagnosis.png")
    console = wide_console(132)
    for words, one in found.items():
        console.print(f"The measured scar {words}")
        console.print(causes_table(*one), finding_table(findings_of(*one)))
    console.print(str(drawn), soft_wrap=True, highlight=False)


if __name__ == "__main__":
    main()
