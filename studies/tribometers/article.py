"""Published tribometers: theoretical contact stiffness beside the article's, and where the lost displacement goes.

    python -m studies.tribometers.article [--output DIR]

The rows of tribometers.csv are Table 2 of Infante-García et al., Sensors 2020, 20(15), 4152. Every verdict is computed
from them; the bodies assumed for the finite elements are varied one dimension at a time, to say how much they matter.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import click
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from rich import box
from rich.table import Table

from studies.study_script import StudyScript
from studies.verdicts import Comparison, Finding, comparison_table, finding_table
from wirewear.app.cli.consoles import progress_bar, wide_console
from wirewear.base.writing import prepared_folder
from wirewear.pictures import save
from wirewear.pictures.style import GREY, INK, VARIANT_COLOURS, cycle_name, new_figure, panel_letters

from .contact_stiffness import ASSUMED, Bodies, line_contact_stiffness
from .judge import Tribometer, hertz_length, judge, tribometers_table, verdicts_table
from .rows import TribometerRow, read_rows

ROWS = Path(__file__).parent / "tribometers.csv"

#: The article: K_t,m lies 37–94 % below K_t,c. Ours may differ from its K_t,c by this much more.
BELOW, MARGIN = (0.37, 0.94), 0.02
TOLERANCE = 0.10

HALF = (0.4, 0.6)  #: "About half" of the applied displacement.
SAME_STROKE = 0.06  #: Strokes of two rows that count as one.

#: One dimension at a time.
VARIED: tuple[tuple[str, Bodies], ...] = (
    ("as assumed", ASSUMED),
    ("pad at most 12 mm wide instead of 20", replace(ASSUMED, pad_half_width_mm=6.0)),
    ("pad at most 15 mm wide", replace(ASSUMED, pad_half_width_mm=7.5)),
    ("pad at most 30 mm wide", replace(ASSUMED, pad_half_width_mm=15.0)),
    ("pad at most 7.5 mm high instead of 10", replace(ASSUMED, pad_height_mm=7.5)),
    ("pad at most 15 mm high", replace(ASSUMED, pad_height_mm=15.0)),
    ("specimen 20 mm wide instead of 40", replace(ASSUMED, specimen_half_width_mm=10.0)),
    ("specimen 80 mm wide", replace(ASSUMED, specimen_half_width_mm=40.0)),
    ("specimen 5 mm thick instead of 10", replace(ASSUMED, specimen_height_mm=5.0)),
    ("specimen 20 mm thick", replace(ASSUMED, specimen_height_mm=20.0)),
    ("points 4.5 mm deep instead of 5", replace(ASSUMED, point_depth_mm=4.5)),
    ("points 5.5 mm deep", replace(ASSUMED, point_depth_mm=5.5)),
)


def label(row: Tribometer, separator: str = ", ") -> str:
    """What distinguishes rows of one source."""
    cycles = "" if row.cycles is None else f", {cycle_name(round(row.cycles))} cycles"
    return f"{row.source}{separator}{row.normal_load_N:g} N{cycles}"


def stiffness_comparisons(rows: Sequence[Tribometer]) -> list[Comparison]:
    """K_t,c of every row beside the article's."""
    return [
        Comparison(label(row), row.contact_stiffness_N_per_um, stated, TOLERANCE, "the article")
        for row in rows
        if (stated := row.stated_contact_stiffness_N_per_um) is not None
    ]


def measured_lies_below(rows: Sequence[Tribometer]) -> Finding:
    """Rig and bodies make loops softer than contacts."""
    below = [1.0 - row.measured_stiffness_N_per_um / row.contact_stiffness_N_per_um for row in rows]
    return Finding(
        f"K_t,m lies {100 * BELOW[0]:.0f}–{100 * BELOW[1]:.0f} % below K_t,c, give or take {100 * MARGIN:.0f} points",
        f"by {100 * min(below):.0f} to {100 * max(below):.0f} %",
        BELOW[0] - MARGIN <= min(below) and max(below) <= BELOW[1] + MARGIN,
    )


def half_is_lost(rows: Sequence[Tribometer]) -> Finding:
    """The applied displacement does not become slip."""
    shares = [row.lost_um / row.displacement_amplitude_um for row in rows]
    mean = float(np.mean(shares))
    return Finding(
        "About half of the applied displacement is lost",
        f"{100 * mean:.0f} % on average, {100 * min(shares):.0f} to {100 * max(shares):.0f} %",
        HALF[0] <= mean <= HALF[1],
    )


def force_lowers_slip(rows: Sequence[Tribometer]) -> Finding:
    """Between rows of one rig and load the stroke hardly changes, friction and slip do."""
    pairs = [
        (first, second)
        for i, first in enumerate(rows)
        for second in rows[i + 1 :]
        if (first.source, first.normal_load_N) == (second.source, second.normal_load_N)
    ]
    alike = [
        (a, b) for a, b in pairs if abs(b.displacement_amplitude_um / a.displacement_amplitude_um - 1.0) <= SAME_STROKE
    ]
    opposite = [(b.friction_max - a.friction_max) * (b.slip_amplitude_um - a.slip_amplitude_um) < 0.0 for a, b in alike]
    return Finding(
        f"At constant δa (within {100 * SAME_STROKE:.0f} %), rising Q lowers δ0",
        f"in {sum(opposite)} of {len(alike)} pairs of one rig and load; in {len(pairs) - len(alike)} more δa differs "
        "further",
        bool(alike) and all(opposite),
    )


def compliance_suffices(rows: Sequence[Tribometer]) -> Finding:
    """What no spring in series takes."""
    more = [row for row in rows if row.unexplained_um > TOLERANCE * row.lost_um]
    named = "; ".join(f"{label(row)}: {row.unexplained_um:.2f} of {row.lost_um:.1f} µm" for row in more)
    return Finding("No row loses more than compliance takes, within 10 % of the loss", named or "none", not more)


def one_rig_one_stiffness(rows: Sequence[Tribometer]) -> Finding:
    """If the series spring means anything, rows of one source share it."""
    spreads = {}
    for source in dict.fromkeys(row.source for row in rows):
        rigs = [row.rig_stiffness_N_per_um or np.nan for row in rows if row.source == source]
        if len(rigs) > 1:
            spreads[source] = max(rigs) / min(rigs) - 1.0
    return Finding(
        "Rows of one source share their rig stiffness within 15 %",
        "\n".join(f"{source} {100 * spread:.0f} %" for source, spread in spreads.items()),
        all(spread <= 0.15 for spread in spreads.values()),
    )


FINDINGS: tuple[Callable[[Sequence[Tribometer]], Finding], ...] = (
    measured_lies_below, half_is_lost, force_lowers_slip, compliance_suffices, one_rig_one_stiffness,
)  # fmt: skip


def sensitivity_table(rows: Sequence[TribometerRow]) -> Table:
    """Deviation of K_t,c from the article's, in per cent, for every contact and every variation of the bodies."""
    contacts = list(
        {
            (row.radius_mm, row.contact_half_width_mm): row
            for row in rows
            if row.theoretical_stiffness_N_per_um and not row.crossed
        }.values()
    )
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title="K_t,c against the article's [%]", title_justify="left")
    table.add_column("bodies", no_wrap=True)
    for row in contacts:
        table.add_column(f"R {row.radius_mm:g}, a {row.contact_half_width_mm:g} mm", justify="right", no_wrap=True)
    with progress_bar() as bar:
        for name, bodies in bar.track(VARIED, description="bodies varied"):
            table.add_row(name, *(f"{100 * _deviation(row, bodies):+.1f}" for row in contacts))
    return table


def _deviation(row: TribometerRow, bodies: Bodies) -> float:
    stiffness = line_contact_stiffness(row.radius_mm, row.contact_half_width_mm, row.pad, row.specimen, bodies)
    length = row.contact_length_mm or hertz_length(row)
    return 1e-3 * length * stiffness / (row.theoretical_stiffness_N_per_um or np.nan) - 1.0


def picture(rows: Sequence[Tribometer]) -> Figure:
    """Stiffnesses, and where the displacement goes, row by row."""
    figure = new_figure(5.6)
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=[1.0, 1.25])
    y = -np.arange(len(rows), dtype=float)
    _stiffnesses(left, rows, y)
    _budget(right, rows, y)
    left.set_yticks(y, [label(row, "\n") for row in rows])
    left.set_ylim(y[-1] - 0.6, 0.6)
    for axes in (left, right):
        axes.grid(visible=False, axis="y")
        axes.tick_params(axis="y", length=0)
        for above, below in pairwise(range(len(rows))):
            if rows[above].source != rows[below].source:
                axes.axhline(y[above] - 0.5, color="#d0d0d0", linewidth=0.7)
    panel_letters([left, right])
    for axes in (left, right):
        legend = axes.legend(
            loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=2, handletextpad=0.5, columnspacing=1.2
        )
        for handle in legend.legend_handles:
            if isinstance(handle, Line2D):
                handle.set_markersize(min(handle.get_markersize(), 9.0))
    return figure


def _stiffnesses(axes: Axes, rows: Sequence[Tribometer], y: np.ndarray) -> None:
    blue, orange, green = VARIANT_COLOURS[:3]
    columns: tuple[tuple[list[float | None], str, dict[str, Any]], ...] = (
        (
            [row.stated_contact_stiffness_N_per_um for row in rows],
            "$K_{t,c}$, the article",
            {"marker": "o", "mfc": "none", "mec": INK, "ms": 7},
        ),
        (
            [row.contact_stiffness_N_per_um for row in rows],
            "$K_{t,c}$, computed",
            {"marker": "o", "color": blue, "ms": 3.5},
        ),
        (
            [row.measured_stiffness_N_per_um for row in rows],
            "$K_{t,m}$, measured",
            {"marker": "s", "color": orange, "ms": 4.5},
        ),
        (
            [row.rig_stiffness_N_per_um for row in rows],
            "rig in series",
            {"marker": "|", "color": green, "ms": 9, "mew": 1.8},
        ),
    )
    for row, place in zip(rows, y, strict=True):
        axes.plot(
            [row.measured_stiffness_N_per_um, row.contact_stiffness_N_per_um],
            [place] * 2,
            color="#d0d0d0",
            linewidth=1.0,
        )
    for values, name, style in columns:
        axes.plot([np.nan if v is None else v for v in values], y, linestyle="none", label=name, **style)
    axes.set(xscale="log", xlim=(0.6, 600.0))
    axes.set_xticks([1, 10, 100], ["1", "10", "100"])
    axes.minorticks_off()
    axes.set(xlabel="tangential stiffness [N/µm]", title="stiffness")


def _budget(axes: Axes, rows: Sequence[Tribometer], y: np.ndarray) -> None:
    stroke = np.array([row.displacement_amplitude_um for row in rows])
    terms = (
        ("in contact", [row.lost_in_contact_um for row in rows], VARIANT_COLOURS[0]),
        ("in bodies and fixtures", [row.lost_in_rig_um or 0.0 for row in rows], VARIANT_COLOURS[2]),
        ("slip predicted", [row.predicted_slip_amplitude_um for row in rows], "#dddddd"),
    )
    start = np.zeros(len(rows))
    for name, values, colour in terms:
        share = 100.0 * np.array(values) / stroke
        axes.barh(y, share, left=start, height=0.55, color=colour, label=name)
        start = start + share
    lost = 100.0 * np.array([row.lost_um for row in rows]) / stroke
    axes.plot(
        lost, y, linestyle="none", marker="|", markersize=17, markeredgewidth=1.8, color=INK, label="loss measured"
    )
    for row, place in zip(rows, y, strict=True):
        axes.text(101.5, place, f"of {row.displacement_amplitude_um:.1f} µm", va="center", fontsize=7.5, color=GREY)
    axes.set_xlim(0.0, 122.0)
    axes.set_xticks(range(0, 101, 20))
    axes.set(xlabel="share of the displacement amplitude δa [%]", title="where the displacement goes")


@click.command(cls=StudyScript)
@click.option("--output", type=click.Path(path_type=Path), default=Path("runs/tribometers"), show_default=True)
def main(output: Path) -> None:
    """Judge the published tribometers and set their stiffness beside the article's."""
    console = wide_console(132)
    prepared_folder(output)
    published = read_rows(ROWS)
    with progress_bar() as bar:
        rows = [judge(row) for row in bar.track(published, description="rows")]
    drawn = save(partial(picture, rows), output / "tribometers.png")
    sensitivity = sensitivity_table(published)
    comparisons, findings = stiffness_comparisons(rows), [judged(rows) for judged in FINDINGS]
    console.print(tribometers_table(rows), verdicts_table(rows))
    console.print("Theoretical contact stiffness K_t,c [N/µm]")
    console.print(comparison_table(comparisons))
    errors = np.abs([item.deviation for item in comparisons])
    console.print(f"mean of the absolute differences {100 * errors.mean():.1f} %, largest {100 * errors.max():.1f} %\n")
    console.print(finding_table(findings), sensitivity)
    excess = 100.0 * np.array([row.predicted_slip_amplitude_um / row.slip_amplitude_um - 1.0 for row in rows])
    console.print(
        f"δ0 predicted from K_t,m: off by {excess.min():+.1f} to {excess.max():+.1f} %, mean {excess.mean():+.1f} %"
    )
    verdicts = [item.holds for item in comparisons] + [finding.holds for finding in findings]
    console.print(f"{sum(verdicts)} of {len(verdicts)} hold. Picture:")
    console.print(str(drawn), soft_wrap=True, highlight=False)


if __name__ == "__main__":
    main()
