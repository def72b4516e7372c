"""Runs cylinder.toml and flat.toml, and sets the article's Tables 3 and 4 and its findings beside them.

    python -m studies.rig_stiffness_2d.article [--fidelity LEVEL] [--output DIR] [--jobs N] [--equal]

The runs are left in DIR/cylinder and DIR/flat, and what is there already is read. Pictures correspond to the article's
Figures 12 to 14 (cylinder.png, flat.png) and tables (tables.png); article_tables.csv holds those of Infante-García et
al., On the Role of Contact and System Stiffness in the Measurement of Principal Variables in Fretting Wear Testing,
Sensors 2020, 20(15), 4152. With --equal, rotational springs are found for equal K_t,m.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import click
import numpy as np
import polars as pl
from matplotlib.figure import Figure

from studies.study_script import StudyScript
from studies.verdicts import Comparison, Finding, comparison_table, finding_table
from wirewear import ResultError
from wirewear.app.cli.consoles import progress_bar, wide_console
from wirewear.pictures.style import VARIANT_COLOURS, new_figure, save, variant_style

from .rigs import CONTACTS, LEVELS, Change, Rig, equally_stiff, shipped, simulated

ARTICLE = Path(__file__).parent / "article_tables.csv"

#: Relative tolerances: of K_t,m in scenario 1 against the article, of scenario 2's against scenario 1's, of θ_max.
STIFFNESS = 0.05
SCENARIOS = {"cylinder": 0.05, "flat": 0.08}
TILT = {"cylinder": 0.08, "flat": 0.15}

#: Of rotational springs that a run found for equal K_t,m, and how far off they may be to be those of the same case.
SPRING, OTHER = 0.06, 0.3

EDGE = 0.2  #: Outer part of a contact's half-width, to either side, that counts as its edge.

#: Largest difference of the loops of a cylinder, over the largest force, that still counts as the same loop.
SAME_LOOP = 0.01

VISIBLE = 0.05  #: Share of the load that must press elsewhere for the pressure to differ visibly.


_SCENARIOS = ("1: translation", "2: rotation")
# Rows below the loops: attribute, axis label.
_FIELDS = (
    ("pressure_MPa", "pressure (MPa)"),
    ("shear_MPa", "shear (MPa)"),
    ("slip_amplitude_um", "slip amplitude (µm)"),
)
_TITLES = {"cylinder": "cylinder on flat", "flat": "flat with rounded edges on flat"}


@dataclass(frozen=True)
class Case:
    """A row of the article's tables beside both scenarios of a run."""

    article: dict[str, float | str | None]
    translating: Rig
    rotating: Rig

    @property
    def name(self) -> str:
        return f"{self.translating.contact} {self.translating.case}"

    def printed(self, column: str) -> float:
        """A number of the article's row."""
        return float(self.article[column] or 0.0)


def cases(pairs: Sequence[tuple[Rig, Rig]]) -> list[Case]:
    """All rigs beside the article's. Raises ResultError if a rig is not one of the article's."""
    rows = {(row["contact"], row["case"]): row for row in pl.read_csv(ARTICLE).to_dicts()}
    found = []
    for one, two in pairs:
        row = rows.get((one.contact, one.case))
        found_spring = row is not None and abs(two.stiffness / row["rotational_stiffness_N_per_rad"] - 1.0) < OTHER
        if row is None or not (np.isclose(one.stiffness, row["tangential_stiffness_N_per_mm2"]) and found_spring):
            raise ResultError(f"{one.contact}, case {one.case} is no case of the article: its springs are others")
        found.append(Case(row, one, two))
    return found


def comparisons(found: list[Case]) -> list[Comparison]:
    """K_t,m and θ_max, case by case."""
    rows = []
    for case in found:
        one, two, contact = case.translating, case.rotating, case.translating.contact
        stiffness, tilt = case.printed("measured_stiffness_N_per_mm2"), case.printed("largest_tilt_deg")
        table = "Table 3" if contact == "cylinder" else "Table 4"
        first, second = one.measured_stiffness_N_per_mm2, two.measured_stiffness_N_per_mm2
        spring = case.printed("rotational_stiffness_N_per_rad")
        if not np.isclose(two.stiffness, spring):
            rows.append(Comparison(f"{case.name}: K_θ,s found [N/rad]", two.stiffness, spring, SPRING, table))
        rows += [
            Comparison(f"{case.name}: K_t,m translating [N/mm²]", first, stiffness, STIFFNESS, table),
            Comparison(f"{case.name}: K_t,m rotating [N/mm²]", second, first, SCENARIOS[contact], "translating"),
            Comparison(f"{case.name}: θ_max [°]", two.largest_tilt_deg, tilt, TILT[contact], table),
        ]
    return rows


def findings(found: list[Case], changes: list[Change]) -> list[Finding]:
    """What the article concludes, judged by the run."""
    judged = []
    by_contact = {name: [c for c in changes if c.contact == name] for name in ("cylinder", "flat")}
    if any(case.translating.contact == "cylinder" for case in found):
        expected = [case for case in found if case.article["regime"] is not None]
        matches = [{case.translating.regime, case.rotating.regime} == {case.article["regime"]} for case in expected]
        judged.append(
            Finding(
                "cylinder: cases 1 and 2 in partial slip, 3 and 4 in gross slip, in both scenarios",
                ", ".join(case.translating.regime for case in expected),
                all(matches),
            )
        )
        loops = [change.loop for change in by_contact["cylinder"]]
        judged.append(
            Finding(
                "cylinder: both scenarios give the same loop (within 1 % of its largest force)",
                "differences " + ", ".join(f"{loop:.2%}" for loop in loops),
                max(loops) < SAME_LOOP,
            )
        )
        judged.append(slip_falls_at_the_edges([case for case in found if case.translating.contact == "cylinder"]))
    if by_contact["flat"]:
        flat = by_contact["flat"]
        judged += [
            Finding(
                "flat: rotation changes the pressure visibly, most where the rig is soft",
                "share of the load that presses elsewhere " + ", ".join(f"{c.pressure_reshaped:.0%}" for c in flat),
                flat[0].pressure_reshaped > VISIBLE and flat[0].pressure_reshaped > flat[-1].pressure_reshaped,
            ),
            Finding(
                "flat: rotation concentrates the pressure at an edge and narrows the contact",
                f"case 1: peak × {flat[0].peak_pressure_ratio:.2f}, width × {flat[0].width_ratio:.2f}, centre moved by "
                f"{1e-3 * abs(flat[0].pressure_centre_um):.2f} mm",
                flat[0].peak_pressure_ratio > 1.0 > flat[0].width_ratio,
            ),
            Finding(
                "flat: loops differ most near the transition from partial to gross slip",
                "differences " + ", ".join(f"{c.loop:.2%}" for c in flat),
                max(flat, key=lambda c: c.loop).case in {2, 3},
            ),
            identical_in_gross_slip([case for case in found if case.translating.contact == "flat"], flat),
            slips_less_where_it_lifts([case for case in found if case.translating.contact == "flat"]),
        ]
    return judged


def identical_in_gross_slip(found: list[Case], changes: list[Change]) -> Finding:
    """The article: both scenarios' loops of the flat agree in gross slip."""
    sliding = {
        case.translating.case for case in found if {case.translating.regime, case.rotating.regime} == {"gross slip"}
    }
    loops = {change.case: change.loop for change in changes if change.case in sliding}
    return Finding(
        "flat: loops are identical in gross slip (within 1 % of the largest force)",
        ", ".join(f"case {case}: {loop:.1%}" for case, loop in loops.items()) or "no case slides as a whole",
        bool(loops) and max(loops.values()) < SAME_LOOP,
    )


def slip_falls_at_the_edges(found: list[Case]) -> Finding:
    """The article's Figure 14, cylinder: slip falls slightly at the edges of a contact that rotates."""
    pairs = [_mean_slips(case, _edges(case.translating)) for case in found]
    return Finding(
        "cylinder: rotation lowers the slip at the contact's edges, nowhere raises it (Figure 14)",
        "µm: " + ", ".join(f"{one:.2f} → {two:.2f}" for one, two in pairs),
        any(two < one for one, two in pairs) and all(two <= 1.01 * one for one, two in pairs),
    )


def slips_less_where_it_lifts(found: list[Case]) -> Finding:
    """The article's Figure 14, flat: less slip where rotation lifts the pad off."""
    lifted = [(case.translating.pressure_MPa > 0.0) & (case.rotating.pressure_MPa <= 0.0) for case in found]
    pairs = [_mean_slips(case, where) for case, where in zip(found, lifted, strict=True) if where.any()]
    return Finding(
        "flat: less slip where rotation lifts the pad off (Figure 14)",
        "µm: " + (", ".join(f"{one:.3f} → {two:.3f}" for one, two in pairs) or "no case lifts"),
        bool(pairs) and all(two < one for one, two in pairs),
    )


def _edges(run: Rig) -> np.ndarray:
    pressed = run.pressure_MPa > 0.0
    left, right = run.x_um[pressed].min(), run.x_um[pressed].max()
    width = EDGE * 0.5 * (right - left)
    return np.asarray(pressed & ((run.x_um - left < width) | (right - run.x_um < width)))


def _mean_slips(case: Case, where: np.ndarray) -> tuple[float, float]:
    """Mean slip amplitude there in both scenarios, um."""
    x = case.translating.x_um
    width = float(np.trapezoid(where.astype(float), x))
    one, two = (
        float(np.trapezoid(np.where(where, run.slip_amplitude_um, 0.0), x)) / width
        for run in (case.translating, case.rotating)
    )
    return one, two


def tables_figure(found: list[Case]) -> Figure:
    """K_t,m and θ_max over the stiffness of the tangential spring: the article's values and both scenarios."""
    figure = new_figure(3.2)
    for axes, (name, title) in zip(
        figure.subplots(1, 2),
        (("measured_stiffness_N_per_mm2", "measured stiffness"), ("largest_tilt_deg", "largest tilt")),
        strict=True,
    ):
        for colour, contact in zip(VARIANT_COLOURS, ("cylinder", "flat"), strict=False):
            chosen = [case for case in found if case.translating.contact == contact]
            spring = [case.translating.stiffness for case in chosen]
            axes.plot(
                spring,
                [case.printed(name) for case in chosen],
                "o",
                mfc="none",
                ms=8,
                color=colour,
                label=f"{contact}: article",
            )
            if name == "measured_stiffness_N_per_mm2":
                axes.plot(
                    spring,
                    [getattr(case.translating, name) for case in chosen],
                    "x",
                    color=colour,
                    label=f"{contact}: translating",
                )
            axes.plot(
                spring,
                [getattr(case.rotating, name) for case in chosen],
                "+",
                ms=9,
                color=colour,
                label=f"{contact}: rotating",
            )
        axes.set(xscale="log", yscale="log", title=title, xlabel="tangential spring $K_{t,s}$ (N/mm²)")
    left, right = figure.axes
    left.set_ylabel("$K_{t,m}$ (N/mm²)")
    right.set_ylabel("$θ_{max}$ (°)")
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper")
    return figure


def contact_figure(pairs: Sequence[tuple[Rig, Rig]]) -> Figure:
    """Loops over displacement; pressure and shear at its largest, and slip amplitude, along the contact; by case."""
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
    figure.suptitle(f"rig stiffness in 2D: {_TITLES[pairs[0][0].contact]}", x=0.01, ha="left", fontsize=9.5)
    return figure


def _reach(run: Rig) -> float:
    """Half-width that was in contact or slid, mm."""
    touched = (run.pressure_MPa > 0.0) | (run.slip_amplitude_um > 0.0)
    return 1e-3 * float(np.abs(run.x_um[touched]).max())


def _short(value: float) -> str:
    """A number as text, such as 5.28 · 10⁵."""
    digits, exponent = f"{value:.2e}".split("e")
    return f"{digits} · 10" + str(int(exponent)).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))


@click.command(cls=StudyScript)
@click.option("--fidelity", type=click.Choice(list(LEVELS)), default="standard", show_default=True)
@click.option(
    "--output", "folder", type=click.Path(path_type=Path), default=Path("runs/rig_stiffness_2d"), show_default=True
)
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Runs side by side.")
@click.option("--equal", is_flag=True, help="Find rotational springs that make the loop as stiff as translation does.")
def main(fidelity: str, folder: Path, jobs: int, equal: bool) -> None:
    """Simulate the article's rigs and set its tables beside them."""
    console = wide_console()
    with progress_bar() as bar:
        bar.add_task("16 rigs", total=None)
        pairs = simulated(fidelity, folder, jobs)
        if equal:
            pairs = [
                (one, equally_stiff(one, shipped(one.contact, fidelity).variant(f"rotating_{one.case}"), fidelity))
                for one, _ in pairs
            ]
    found, changes = cases(pairs), [Change.between(*pair) for pair in pairs]
    rows, judged = comparisons(found), findings(found, changes)
    pictures = [save(lambda: tables_figure(found), folder / "tables.png")]
    for contact in CONTACTS:
        own = [pair for pair in pairs if pair[0].contact == contact]
        pictures.append(save(partial(contact_figure, own), folder / f"{contact}.png"))
    console.print(f"rig stiffness in 2D, {fidelity} fidelity")
    console.print(comparison_table(rows), finding_table(judged))
    verdicts = [item.holds for item in rows] + [finding.holds for finding in judged]
    console.print(f"{sum(verdicts)} of {len(verdicts)} hold. Pictures: {', '.join(map(str, pictures))}")


if __name__ == "__main__":
    main()
