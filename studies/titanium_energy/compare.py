"""Thirty-nine tests of titanium on titanium: worn volume against friction energy, and which tests leave the line.

    python studies/titanium_energy/compare.py [--output DIR]

tests.csv holds measured volumes and energies with their source. Nothing here is simulated. Every statement is computed
from the table.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from math import log, pi
from pathlib import Path
from typing import Any

import click
import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray
from rich import box
from rich.table import Table
from scipy import stats

from wirewear.files import prepared_folder
from wirewear.pictures import save
from wirewear.pictures.colours import GREY, VARIANT_COLOURS
from wirewear.pictures.style import new_figure, panel_letters
from wirewear.study_script import StudyScript, wide_console
from wirewear.verdicts import Finding, finding_table

Array = NDArray[np.float64]

TESTS = Path(__file__).parent / "tests.csv"

#: Scars: even (U), deeper at their sides (W), between (I).
SHAPES = {"U": "U, even", "I": "I, between", "W": "W, deeper at its sides"}

CONFIDENCE = 0.95


@dataclass(frozen=True)
class MeasuredTest:
    """One measured test: worn volume and friction energy of both bodies, the whole contact and all cycles."""

    name: str
    scar: str
    volume_mm3: float
    energy_J: float
    half_width_mm: float
    length_mm: float
    frequency_Hz: float
    cycles: float

    @property
    def coefficient_mm3_per_J(self) -> float:
        """Its own energy wear coefficient."""
        return self.volume_mm3 / self.energy_J

    @property
    def power_density_W_per_mm2(self) -> float:
        """Mean friction power over Hertz's contact at the largest load."""
        power = self.energy_J / self.cycles * self.frequency_Hz
        return power / (2.0 * self.half_width_mm * self.length_mm)

    @property
    def oxygen_demand_W(self) -> float:
        """Power density times the square of the half-width.

        Oxygen that is used up at a rate per area in proportion to the friction power, and diffuses in from the edges,
        falls by an amount in proportion to this number towards the middle.
        """
        return self.power_density_W_per_mm2 * self.half_width_mm**2


def read_tests(path: Path = TESTS) -> tuple[MeasuredTest, ...]:
    """The tests of the table."""
    return tuple(
        MeasuredTest(
            name=str(row["test"]),
            scar=str(row["scar"]),
            volume_mm3=float(row["volume_mm3"]),
            energy_J=float(row["energy_J"]),
            # Hertz's line contact: p0 = 2P/(πa).
            half_width_mm=2.0 * row["largest_load_N_per_mm"] / (pi * row["hertz_pressure_MPa"]),
            length_mm=float(row["length_mm"]),
            frequency_Hz=float(row["frequency_Hz"]),
            cycles=float(row["cycles"]),
        )
        for row in pl.read_csv(path, comment_prefix="#").iter_rows(named=True)
    )


@dataclass(frozen=True)
class EnergyLine:
    """V = αE by least squares through the origin, with a scatter of the volumes that is the same for all tests."""

    coefficient_mm3_per_J: float
    scatter_mm3: float
    energies_squared_J2: float
    count: int

    @property
    def _quantile(self) -> float:
        return float(stats.t.ppf(0.5 * (1.0 + CONFIDENCE), self.count - 1))

    @property
    def interval_mm3_per_J(self) -> tuple[float, float]:
        """Of the coefficient, 95 %."""
        half = self._quantile * self.scatter_mm3 / self.energies_squared_J2**0.5
        return self.coefficient_mm3_per_J - half, self.coefficient_mm3_per_J + half

    def predicted_mm3(self, energy_J: float) -> tuple[float, float]:
        """Volume of a further test, and half of its 95 % prediction interval."""
        spread = (1.0 + energy_J**2 / self.energies_squared_J2) ** 0.5
        return self.coefficient_mm3_per_J * energy_J, self._quantile * self.scatter_mm3 * spread


def energy_line(tests: Sequence[MeasuredTest]) -> EnergyLine:
    """The line through the origin of at least two tests."""
    energy, volume = _column(tests, "energy_J"), _column(tests, "volume_mm3")
    squared = float(energy @ energy)
    coefficient = float(energy @ volume) / squared
    rest = volume - coefficient * energy
    return EnergyLine(coefficient, float(rest @ rest / (len(tests) - 1)) ** 0.5, squared, len(tests))


def off_the_line(tests: Sequence[MeasuredTest]) -> list[MeasuredTest]:
    """Tests outside the prediction interval of the U-shaped ones, each judged by a line that does not know it."""
    found = []
    for test in tests:
        line = energy_line([other for other in tests if other.scar == "U" and other is not test])
        predicted, half = line.predicted_mm3(test.energy_J)
        if abs(test.volume_mm3 - predicted) > half:
            found.append(test)
    return found


#: Predicts the logarithm of a test's energy wear coefficient from others.
Law = Callable[[Sequence[MeasuredTest], MeasuredTest], float]


def one_coefficient(known: Sequence[MeasuredTest], _test: MeasuredTest) -> float:
    """The same for all: their geometric mean."""
    return float(np.log(_column(known, "coefficient_mm3_per_J")).mean())


def falls_with_power(known: Sequence[MeasuredTest], test: MeasuredTest) -> float:
    """A power of the friction power density."""
    slope, base = power_law(known)
    return base + slope * log(test.power_density_W_per_mm2)


def power_law(tests: Sequence[MeasuredTest]) -> tuple[float, float]:
    """Exponent and log of the coefficient at 1 W/mm², least squares of logarithms."""
    density = np.log(_column(tests, "power_density_W_per_mm2"))
    slope, base = np.polyfit(density, np.log(_column(tests, "coefficient_mm3_per_J")), 1)
    return float(slope), float(base)


LAWS: dict[str, Law] = {"one energy wear coefficient": one_coefficient, "falling with power density": falls_with_power}


def left_out(tests: Sequence[MeasuredTest], law: Law) -> Array:
    """Predicted over measured volume of each test, from all others."""
    ratios = []
    for test in tests:
        coefficient = np.exp(law([other for other in tests if other is not test], test))
        ratios.append(coefficient / test.coefficient_mm3_per_J)
    return np.array(ratios)


def typical_factor(ratios: Array) -> float:
    """The factor by which predictions are off: exp of the root mean square logarithm."""
    return float(np.exp(np.sqrt(np.mean(np.log(ratios) ** 2))))


def w_shaped_tests_are_off(tests: Sequence[MeasuredTest]) -> Finding:
    """The authors: tests that leave the line are those with W-shaped scars."""
    off = off_the_line(tests)
    counts = {shape: [sum(t.scar == shape for t in group) for group in (off, tests)] for shape in SHAPES}
    below = all(test.volume_mm3 < energy_line(_shaped(tests, "U")).predicted_mm3(test.energy_J)[0] for test in off)
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
        logs = np.log(_column(known, "coefficient_mm3_per_J"))
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
    w_shaped = [test.oxygen_demand_W for test in _shaped(tests, "W")]
    others = [test.oxygen_demand_W for test in tests if test.scar != "W"]
    return Finding(
        "Power density × half-width² tells W-shaped scars from all others",
        f"W: at least {min(w_shaped):.2f} W, others: at most {max(others):.2f} W",
        min(w_shaped) > max(others),
    )


def power_alone_does_not(tests: Sequence[MeasuredTest]) -> Finding:
    """Shapes by power density."""
    least = min(test.power_density_W_per_mm2 for test in _shaped(tests, "W"))
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
    w_shaped_tests_are_off,
    only_w_shaped_tests_are_off,
    scatter_in_proportion_lets_them_in,
    width_and_power_tell_the_shape,
    power_alone_does_not,
    power_predicts_better,
)


def lines_table(tests: Sequence[MeasuredTest]) -> Table:
    """Energy wear coefficients by the shape of scar."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("scars", "tests", "α [10⁻⁴ mm³/J]", "95 % interval", "a further test at 5 kJ [mm³]"):
        table.add_column(heading, justify="left" if heading == "scars" else "right", no_wrap=True)
    for name, chosen in {"all": list(tests), **{words: _shaped(tests, s) for s, words in SHAPES.items()}}.items():
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
        chosen = _shaped(tests, shape)
        demand, coefficient = _column(chosen, "oxygen_demand_W"), _column(chosen, "coefficient_mm3_per_J")
        right.plot(demand, 1e4 * coefficient, marker="osD"[list(SHAPES).index(shape)], **_mark(colour, words))
    right.set_xscale("log")
    right.set_ylim(bottom=0.0)
    right.set_xlabel("friction power density × half-width² [W]")
    right.set_ylabel("volume over energy [10⁻⁴ mm³/J]")
    right.set_title("coefficient of each test")
    right.legend(loc="upper right")
    panel_letters([left, right])
    return figure


def _volumes(axes: Axes, tests: Sequence[MeasuredTest]) -> None:
    energy = np.linspace(0.0, 1.05 * max(test.energy_J for test in tests), 100)
    line = energy_line(_shaped(tests, "U"))
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
        chosen = _shaped(tests, shape)
        marks = 1e-3 * _column(chosen, "energy_J"), _column(chosen, "volume_mm3")
        axes.plot(*marks, marker="osD"[list(SHAPES).index(shape)], **_mark(colour, words))
    axes.set_xlim(0.0, 1e-3 * float(energy[-1]))
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("friction energy [kJ]")
    axes.set_ylabel("worn volume [mm³]")
    axes.set_title("measured volumes")
    axes.legend(loc="upper left")


def _mark(colour: str, label: str) -> dict[str, Any]:
    return {"color": colour, "label": label, "linestyle": "none", "markersize": 4.5}


def _shaped(tests: Sequence[MeasuredTest], scar: str) -> list[MeasuredTest]:
    return [test for test in tests if test.scar == scar]


def _column(tests: Sequence[MeasuredTest], name: str) -> Array:
    return np.array([getattr(test, name) for test in tests])


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
