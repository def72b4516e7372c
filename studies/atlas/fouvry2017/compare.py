"""Thirty-nine tests of titanium on titanium: worn volume against friction energy, and which tests leave the line.

    python studies/titanium_energy/compare.py [--output DIR]

tests.csv holds measured volumes and energies with their source. Nothing here is simulated. Every statement is computed
from the table.
"""

import sys
from collections.abc import Callable, Sequence
from functools import partial
from math import log
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich import box
from rich.table import Table
from scipy import stats

from wirewear.base.verdicts import Finding, finding_table
from wirewear.base.writing import prepared_folder
from wirewear.faces.study_script import StudyScript, wide_console
from wirewear.pictures import save
from wirewear.pictures.style import GREY, VARIANT_COLOURS, new_figure, panel_letters

if not __package__:
    # Run by its path, as `make run` does: its neighbours are found from the root of the repository.
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
    __package__ = "studies.titanium_energy"

from .laws import CONFIDENCE, LAWS, energy_line, left_out, off_the_line, power_law, typical_factor
from .measured import SHAPES, MeasuredTest, column, read_tests, shaped


def w_shaped_tests_are_off(tests: Sequence[MeasuredTest]) -> Finding:
    """The authors: tests that leave the line are those with W-shaped scars."""
    off = off_the_line(tests)
    counts = {shape: [sum(t.scar == shape for t in group) for group in (off, tests)] for shape in SHAPES}
    below = all(test.volume_mm3 < energy_line(shaped(tests, "U")).predicted_mm3(test.energy_J)[0] for test in off)
    evidence = ", ".join(f"{out} of {total} {shape}" for shape, (out, total) in counts.items())
    return Finding(
        "All W-shaped tests leave the line of the U-shaped ones, below it",
        f"outside its 95 % prediction interval: {evidence}",
        counts["W"][0] == counts["W"][1] and below,
    )


def only_w_shaped_tests_are_off(tests: Sequence[MeasuredTest]) -> Finding:
    """And no others."""
    others = [f"{test.name} ({test.scar})" for test in off_the_line(tests) if test.scar != "W"]
    return Finding("Only W-shaped tests leave it", f"also outside: {', '.join(others) or 'none'}", not others)


def scatter_in_proportion_lets_them_in(tests: Sequence[MeasuredTest]) -> Finding:
    """Judged by ratios instead of differences the line is wider."""
    off = []
    for test in tests:
        known = [other for other in tests if other.scar == "U" and other is not test]
        logs = np.log(column(known, "coefficient_mm3_per_J"))
        reach = stats.t.ppf(0.5 * (1.0 + CONFIDENCE), len(known) - 1) * logs.std(ddof=1) * (1 + 1 / len(known)) ** 0.5
        if abs(log(test.coefficient_mm3_per_J) - logs.mean()) > reach:
            off.append(test)
    inside = [test.name for test in tests if test.scar == "W" and test not in off]
    return Finding(
        "The same if scatter is in proportion to the volume",
        f"outside: {', '.join(f'{t.name} ({t.scar})' for t in off) or 'none'}; W-shaped but inside: "
        f"{', '.join(inside) or 'none'}",
        not inside,
    )


def width_and_power_tell_the_shape(tests: Sequence[MeasuredTest]) -> Finding:
    """Shapes by power density times half-width squared."""
    w_shaped = [test.oxygen_demand_W for test in shaped(tests, "W")]
    others = [test.oxygen_demand_W for test in tests if test.scar != "W"]
    return Finding(
        "Power density × half-width² tells W-shaped scars from all others",
        f"W: at least {min(w_shaped):.2f} W, others: at most {max(others):.2f} W",
        min(w_shaped) > max(others),
    )


def power_alone_does_not(tests: Sequence[MeasuredTest]) -> Finding:
    """Shapes by power density."""
    least = min(test.power_density_W_per_mm2 for test in shaped(tests, "W"))
    above = [test.name for test in tests if test.scar != "W" and test.power_density_W_per_mm2 > least]
    return Finding(
        "Power density alone does so too", f"W: at least {least:.2f} W/mm²; above it too: {', '.join(above)}", not above
    )


def power_predicts_better(tests: Sequence[MeasuredTest]) -> Finding:
    """Leave-one-out."""
    factors = {name: typical_factor(left_out(tests, law)) for name, law in LAWS.items()}
    slope, _ = power_law(tests)
    return Finding(
        "A coefficient that falls with power density predicts volumes better, each test from all others",
        "; ".join(f"{name}: within a factor {factor:.2f}" for name, factor in factors.items())
        + f"; exponent {slope:.2f}",
        factors["falling with power density"] < factors["one energy wear coefficient"],
    )


FINDINGS: tuple[Callable[[Sequence[MeasuredTest]], Finding], ...] = (
    w_shaped_tests_are_off, only_w_shaped_tests_are_off, scatter_in_proportion_lets_them_in,
    width_and_power_tell_the_shape, power_alone_does_not, power_predicts_better,
)  # fmt: skip


def lines_table(tests: Sequence[MeasuredTest]) -> Table:
    """Energy wear coefficients by the shape of scar."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("scars", "tests", "α [10⁻⁴ mm³/J]", "95 % interval", "a further test at 5 kJ [mm³]"):
        table.add_column(heading, justify="left" if heading == "scars" else "right", no_wrap=True)
    for name, chosen in {"all": list(tests), **{words: shaped(tests, s) for s, words in SHAPES.items()}}.items():
        line = energy_line(chosen)
        low, high = line.interval_mm3_per_J
        volume, half = line.predicted_mm3(5000.0)
        table.add_row(
            name,
            str(line.count),
            f"{1e4 * line.coefficient_mm3_per_J:.2f}",
            f"{1e4 * low:.2f} to {1e4 * high:.2f}",
            f"{volume:.2f} ± {half:.2f}",
        )
    return table


def picture(tests: Sequence[MeasuredTest]) -> Figure:
    """Volume over energy with the line of the U-shaped tests, and the coefficient over what tells the shapes apart."""
    figure = new_figure(3.6)
    left, right = figure.subplots(1, 2)
    _volumes(left, tests)
    for (shape, words), colour in zip(SHAPES.items(), VARIANT_COLOURS, strict=False):
        chosen = shaped(tests, shape)
        demand, coefficient = column(chosen, "oxygen_demand_W"), column(chosen, "coefficient_mm3_per_J")
        right.plot(demand, 1e4 * coefficient, marker="osD"[list(SHAPES).index(shape)], **_mark(colour, words))
    right.set_xscale("log")
    right.set_ylim(bottom=0.0)
    right.set(
        xlabel="friction power density × half-width² [W]",
        ylabel="volume over energy [10⁻⁴ mm³/J]",
        title="coefficient of each test",
    )
    right.legend(loc="upper right")
    panel_letters([left, right])
    return figure


def _volumes(axes: Axes, tests: Sequence[MeasuredTest]) -> None:
    energy = np.linspace(0.0, 1.05 * max(test.energy_J for test in tests), 100)
    line = energy_line(shaped(tests, "U"))
    predicted, half = np.array([line.predicted_mm3(float(e)) for e in energy]).T
    axes.fill_between(
        1e-3 * energy,
        np.maximum(predicted - half, 0.0),
        predicted + half,
        color="#e8eef4",
        label="95 % of further U tests",
    )
    axes.plot(1e-3 * energy, predicted, color=GREY, linewidth=1.0)
    for (shape, words), colour in zip(SHAPES.items(), VARIANT_COLOURS, strict=False):
        chosen = shaped(tests, shape)
        marks = 1e-3 * column(chosen, "energy_J"), column(chosen, "volume_mm3")
        axes.plot(*marks, marker="osD"[list(SHAPES).index(shape)], **_mark(colour, words))
    axes.set_xlim(0.0, 1e-3 * float(energy[-1]))
    axes.set_ylim(bottom=0.0)
    axes.set(xlabel="friction energy [kJ]", ylabel="worn volume [mm³]", title="measured volumes")
    axes.legend(loc="upper left")


def _mark(colour: str, label: str) -> dict[str, Any]:
    return {"color": colour, "label": label, "linestyle": "none", "markersize": 4.5}


@click.command(cls=StudyScript)
@click.option("--output", type=click.Path(path_type=Path), default=Path("runs/titanium_energy"), show_default=True)
def main(output: Path) -> None:
    """Set the measured volumes of titanium contacts beside their friction energies."""
    console = wide_console(132)
    tests = read_tests()
    prepared_folder(output)
    drawn = save(partial(picture, tests), output / "titanium_energy.png")
    console.print("V = αE by the shape of the scar, least squares through the origin")
    console.print(lines_table(tests), finding_table([judge(tests) for judge in FINDINGS]))
    console.print(str(drawn), soft_wrap=True, highlight=False)


if __name__ == "__main__":
    main()
