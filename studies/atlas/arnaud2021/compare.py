"""Titanium scars at 0.1 and 2 Hz: simulation with and without contact oxygenation, published model, measured scar.

    python studies/titanium_oxygenation/compare.py RESULT_DIR [--output DIR]

RESULT_DIR is the folder that `wirewear run studies/titanium_oxygenation/study.toml` left, with its four variants.
measured_*.csv and published_model_*.csv were read by eye from a publication's figures, as their first lines say.
"""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from rich import box
from rich.table import Table

from wirewear import ResultError
from wirewear.base.verdicts import Finding, finding_table
from wirewear.faces.study_script import comparison_command, wide_console
from wirewear.pictures.style import GREY, INK, VARIANT_COLOURS, VARIANT_DASHES, new_figure, panel_letters, save
from wirewear.results import RunResult, read_results

Array = NDArray[np.float64]

_HERE = Path(__file__).parent
CYCLES = 5000
VARIANTS = {"2Hz": "2Hz", "2Hz_oxygenated": "2Hz", "2Hz_plain": "2Hz", "0p1Hz": "0p1Hz"}

PUBLISHED_ERROR = 0.15  #: The published model's largest error of depth with contact oxygenation.

#: A deepest place nearer to the middle than this counts as in the middle; read by eye, a profile does not say more.
MIDDLE_um = 200.0


@dataclass(frozen=True, eq=False)
class Scar:
    """Depth of the flat over x, arrays (n,)."""

    x_um: Array
    depth_um: Array

    @property
    def deepest_um(self) -> float:
        """Largest depth."""
        return float(self.depth_um.max())

    @property
    def place_um(self) -> float:
        """Distance of the deepest place from the middle; the mean of all that are as deep."""
        return float(np.abs(self.x_um[self.depth_um >= self.deepest_um * (1.0 - 1e-9)]).mean())

    @property
    def middle_um(self) -> float:
        """Depth in the middle."""
        return float(np.interp(0.0, self.x_um, self.depth_um))

    @property
    def area_mm2(self) -> float:
        """Worn cross-section, without what stands above the flat."""
        return 1e-6 * float(np.trapezoid(np.maximum(self.depth_um, 0.0), self.x_um))

    def error(self, measured: "Scar") -> float:
        """Root mean square difference over the measured points, as a share of the measured depth."""
        apart = np.interp(measured.x_um, self.x_um, self.depth_um) - measured.depth_um
        return float(np.sqrt(np.mean(apart**2))) / measured.deepest_um


def scar_in(name: str) -> Scar:
    """A scar beside this script."""
    table = pl.read_csv(_HERE / f"{name}.csv", comment_prefix="#")
    return Scar(1e3 * table["x_mm"].to_numpy(), 1e3 * table["depth_mm"].to_numpy().astype(float))


def simulated(result: RunResult) -> Scar:
    """The simulated flat at the test's end."""
    if CYCLES not in result.scar_cycles():
        raise ResultError(f"{result.full_name} has no profile at {CYCLES} cycles: it has not come to its end.")
    return Scar(*result.scar(CYCLES, "specimen").section_along_motion())


def read_runs(folder: Path) -> dict[str, Scar]:
    """The flat of each variant. Raises ResultError if one is missing or has not come to its end."""
    return {name: simulated(read_results(folder / name)[0]) for name in VARIANTS}


def findings_of(runs: dict[str, Scar]) -> list[Finding]:
    """What the runs say beside the measured scars."""
    fast, slow = scar_in("measured_2Hz"), scar_in("measured_0p1Hz")
    return [
        oxygenation_explains_the_w(runs, fast),
        without_it_the_middle_is_deepest(runs, fast),
        predicts_a_u_at_low_frequency(runs, slow),
        predicts_the_low_frequency_depth(runs, slow),
        wear_alone_is_too_wide(runs, fast),
    ]


def oxygenation_explains_the_w(runs: dict[str, Scar], measured: Scar) -> Finding:
    """Depth and shape at 2 Hz."""
    found = runs["2Hz"]
    depth = found.deepest_um / measured.deepest_um - 1.0
    return Finding(
        "2 Hz, with contact oxygenation: depth and shape within the published model's 15 %, deepest on the flanks",
        f"depth {depth:+.1%}, shape {found.error(measured):.1%} rms, area {_more_area(found, measured)}; "
        f"deepest at ±{found.place_um:.0f} µm, measured ±{measured.place_um:.0f} µm",
        max(abs(depth), found.error(measured)) < PUBLISHED_ERROR and found.place_um > MIDDLE_um,
    )


def without_it_the_middle_is_deepest(runs: dict[str, Scar], measured: Scar) -> Finding:
    """What remains without the effect."""
    found = runs["2Hz_oxygenated"]
    return Finding(
        "2 Hz, without it: the deepest place lies in the middle, which the measured scar contradicts",
        f"middle {found.middle_um:.0f} µm, measured {measured.middle_um:.0f} µm; shape {found.error(measured):.1%} rms",
        found.place_um < MIDDLE_um < measured.place_um,
    )


def predicts_a_u_at_low_frequency(runs: dict[str, Scar], measured: Scar) -> Finding:
    """Nothing is fitted at 0.1 Hz."""
    found = runs["0p1Hz"]
    return Finding(
        "0.1 Hz, predicted with the parameters of 2 Hz: an even scar, deepest in the middle, as measured",
        f"deepest at ±{found.place_um:.0f} µm, measured ±{measured.place_um:.0f} µm",
        max(found.place_um, measured.place_um) < MIDDLE_um,
    )


def predicts_the_low_frequency_depth(runs: dict[str, Scar], measured: Scar) -> Finding:
    """How deep."""
    found, published = runs["0p1Hz"], scar_in("published_model_0p1Hz")
    return Finding(
        "0.1 Hz: its depth within 15 %",
        f"depth {found.deepest_um / measured.deepest_um - 1:+.0%}, area {_more_area(found, measured)}; the published "
        f"model {published.deepest_um / measured.deepest_um - 1:+.0%} and {_more_area(published, measured)}",
        abs(found.deepest_um / measured.deepest_um - 1.0) < PUBLISHED_ERROR,
    )


def _more_area(scar: Scar, measured: Scar) -> str:
    return f"{scar.area_mm2 / measured.area_mm2 - 1.0:+.0%}"


def wear_alone_is_too_wide(runs: dict[str, Scar], measured: Scar) -> Finding:
    """Metal that conforms without debris between."""
    plain = runs["2Hz_plain"]

    def worn_to(scar: Scar) -> float:
        return 1e-3 * float(np.abs(scar.x_um[scar.depth_um > 0.05 * scar.deepest_um]).max())

    return Finding(
        "Wear without debris that carries the load makes a scar of the measured width",
        f"±{worn_to(plain):.1f} mm, measured ±{worn_to(measured):.1f} mm; with debris ±{worn_to(runs['2Hz']):.1f} mm",
        abs(worn_to(plain) / worn_to(measured) - 1.0) < PUBLISHED_ERROR,
    )


def scars_table(runs: dict[str, Scar]) -> Table:
    """Figures of all scars."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("flat", "depth [µm]", "in the middle", "deepest at ± [µm]", "area [mm²]", "shape, rms of depth"):
        table.add_column(heading, justify="left" if heading == "flat" else "right", no_wrap=True)
    rows = [(name, runs[name], frequency) for name, frequency in VARIANTS.items()]
    rows += [(f"published model, {f}", scar_in(f"published_model_{f}"), f) for f in ("2Hz", "0p1Hz")]
    rows += [(f"measured, {f}", scar_in(f"measured_{f}"), f) for f in ("2Hz", "0p1Hz")]
    for name, scar, frequency in rows:
        error = scar.error(scar_in(f"measured_{frequency}"))
        figures = f"{scar.deepest_um:.1f}", f"{scar.middle_um:.1f}", f"{scar.place_um:.0f}", f"{scar.area_mm2:.3f}"
        table.add_row(name, *figures, f"{error:.1%}" if error else "–")
    return table


def picture(runs: dict[str, Scar]) -> Figure:
    """The scars at either frequency."""
    figure = new_figure(3.6)
    panels = figure.subplots(1, 2, sharex=True)
    words = {
        "2Hz": "with oxygenation and debris",
        "2Hz_oxygenated": "with debris only",
        "2Hz_plain": "wear alone",
        "0p1Hz": "with oxygenation and debris",
    }
    for axes, frequency, title in zip(panels, ("2Hz", "0p1Hz"), ("2 Hz", "0.1 Hz, predicted"), strict=True):
        chosen = [name for name, own in VARIANTS.items() if own == frequency]
        for name, colour, dashes in zip(chosen, VARIANT_COLOURS, VARIANT_DASHES, strict=False):
            axes.plot(1e-3 * runs[name].x_um, runs[name].depth_um, color=colour, linestyle=dashes, label=words[name])
        _published(axes, frequency)
        axes.set(title=f"flat after 5 000 cycles, {title}", xlabel="x [mm]", ylabel="depth [µm]")
        axes.invert_yaxis()
    panels[0].set_xlim(-3.0, 3.0)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    panel_letters(list(panels))
    return figure


def _published(axes: Axes, frequency: str) -> None:
    model, measured = scar_in(f"published_model_{frequency}"), scar_in(f"measured_{frequency}")
    axes.plot(1e-3 * model.x_um, model.depth_um, color=GREY, linewidth=1.0, label="published model")
    axes.errorbar(
        1e-3 * measured.x_um,
        measured.depth_um,
        4.0,
        fmt="o",
        color=INK,
        markersize=2.5,
        linewidth=0.6,
        label="measured",
    )


@comparison_command
def main(result_dir: Path, folder: Path) -> None:
    """Set the simulated flats beside the published model's and the measured ones."""
    runs = read_runs(result_dir)
    if any(scar.deepest_um <= 0.0 for scar in runs.values()):
        raise ResultError(f"{result_dir} holds a run in which nothing has worn")
    folder.mkdir(parents=True, exist_ok=True)
    drawn = save(partial(picture, runs), folder / "titanium_oxygenation.png")
    console = wide_console(132)
    console.print(scars_table(runs), finding_table(findings_of(runs)))
    console.print(str(drawn), soft_wrap=True, highlight=False)


if __name__ == "__main__":
    main()
