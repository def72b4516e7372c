"""The article's Tables 3 and 4 and its findings on rig stiffness beside a run of study.toml.

    python studies/rig_stiffness_2d/compare.py RESULT_DIR [--output DIR]

RESULT_DIR is the folder that `wirewear run studies/rig_stiffness_2d/study.toml` left, with the pictures that correspond
to the article's Figures 12 to 14 (cylinder.png, flat.png). article_tables.csv holds the article's tables:
Infante-García et al., On the Role of Contact and System Stiffness in the Measurement of Principal Variables in
Fretting Wear Testing, Sensors 2020, 20(15), 4152.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import polars as pl
from matplotlib.figure import Figure

from wirewear import ResultError
from wirewear.pictures.colours import VARIANT_COLOURS
from wirewear.pictures.style import new_figure, save
from wirewear.planar.rig_stiffness import RigStiffnessResult, differences, read_rig_stiffness_result
from wirewear.planar.rig_stiffness.results import RigStiffnessRun, ScenarioDifference
from wirewear.study_script import comparison_command, wide_console
from wirewear.verdicts import Comparison, Finding, comparison_table, finding_table

ARTICLE = Path(__file__).parent / "article_tables.csv"

#: Relative tolerances: of K_t,m in scenario 1 against the article, of scenario 2's against scenario 1's, of θ_max.
STIFFNESS = 0.05
SCENARIOS = {"cylinder": 0.05, "flat": 0.08}
TILT = {"cylinder": 0.08, "flat": 0.15}

#: Of rotational springs that a run found for equal K_t,m, and how far off they may be to be those of the same case.
SPRING, OTHER = 0.06, 0.3

#: Outer part of a contact's half-width, to either side, that counts as its edge.
EDGE = 0.2

#: Largest difference of the loops of a cylinder, over the largest force, that still counts as the same loop.
SAME_LOOP = 0.01

#: Share of the load that must press elsewhere for the pressure to differ visibly.
VISIBLE = 0.05


@dataclass(frozen=True)
class Case:
    """A row of the article's tables beside both scenarios of a run."""

    article: dict[str, float | str | None]
    translating: RigStiffnessRun
    rotating: RigStiffnessRun

    @property
    def name(self) -> str:
        """Contact and case."""
        return f"{self.translating.contact} {self.translating.case}"

    def printed(self, column: str) -> float:
        """A number of the article's row."""
        return float(self.article[column] or 0.0)


def cases(result: RigStiffnessResult) -> list[Case]:
    """All cases of a run that are in the article's tables.

    Raises:
        ResultError: the run is not one of this study's cases.
    """
    rows = {(row["contact"], row["case"]): row for row in pl.read_csv(ARTICLE).to_dicts()}
    found = []
    for one, two in (pair for contact in result.contacts for pair in result.pairs(contact)):
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


def findings(found: list[Case], changes: list[ScenarioDifference]) -> list[Finding]:
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


def identical_in_gross_slip(found: list[Case], changes: list[ScenarioDifference]) -> Finding:
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


def _edges(run: RigStiffnessRun) -> np.ndarray:
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
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_title(title)
        axes.set_xlabel("tangential spring $K_{t,s}$ (N/mm²)")
    left, right = figure.axes
    left.set_ylabel("$K_{t,m}$ (N/mm²)")
    right.set_ylabel("$θ_{max}$ (°)")
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper")
    return figure


@comparison_command
def main(result_dir: Path, folder: Path) -> None:
    """Set the article's tables beside a run's."""
    console = wide_console()
    result = read_rig_stiffness_result(result_dir)
    found = cases(result)
    rows, judged = comparisons(found), findings(found, list(differences(result)))
    folder.mkdir(parents=True, exist_ok=True)
    picture = save(lambda: tables_figure(found), folder / "tables.png")
    console.print(f"{result.name}, {result.fidelity} fidelity")
    console.print(comparison_table(rows), finding_table(judged))
    verdicts = [item.holds for item in rows] + [finding.holds for finding in judged]
    console.print(f"{sum(verdicts)} of {len(verdicts)} hold. Picture: {picture}")


if __name__ == "__main__":
    main()
