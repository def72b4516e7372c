"""McColl's worn flat: simulation, published finite element models and measured scar side by side.

    python studies/mccoll2004/compare.py RESULT_DIR [--output DIR]

RESULT_DIR is the folder that `wirewear run studies/mccoll2004/study.toml` left. The measured profile stands in record/,
the published models' figures beside this script, each with its source.
"""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from wirewear import ResultError
from wirewear.base.verdicts import Comparison, Finding, comparison_table, finding_table
from wirewear.faces.study_script import comparison_command, wide_console
from wirewear.pictures import style
from wirewear.records import LineRecord, MeasuredProfile, read_record
from wirewear.results import RunResult, Scar, read_results

Array = NDArray[np.float64]

_HERE = Path(__file__).parent
CYCLES = 18_000

#: Relative tolerances: of depths against the published range, of area and width, of the measured scar.
DEPTH, SHAPE, MEASURED = 0.01, 0.02, 0.05

PUBLISHED_HALF_WIDTH_um = 255.0  #: Half-width of the published models' scar.

#: Stretches beside the measured scar that look untouched: what they stand above the figure's zero is a second base.
_UNTOUCHED_um = ((-345.0, -300.0), (435.0, 475.0))

#: Pressures are looked at inside this share of the contact; their shape is the polynomial of that degree.
INSIDE, _SHAPE_DEGREE = 0.9, 8
MOST_RIPPLE = 0.02

#: Largest root-mean-square difference of shapes that the measured profile's own roughness explains, in its units.
_ROUGH = 1.5


def measured_scar() -> MeasuredProfile:
    """The measured flat, from the zero of McColl's figure."""
    record: LineRecord = read_record(_HERE / "record")
    return record.scars[0]


def published_scar() -> MeasuredProfile:
    """The flat of the published model that moves its mesh."""
    table = pl.read_csv(_HERE / "published_fe_flat.csv", comment_prefix="#")
    return scar(1e3 * table["x_mm"].to_numpy(), -table["y_um"].to_numpy().astype(float))


def scar(x_um: Array, depth_um: Array) -> MeasuredProfile:
    """A profile (n,) of the flat."""
    return MeasuredProfile(1, "specimen", x_um, depth_um)


def within(whole: MeasuredProfile) -> MeasuredProfile:
    """The part between the edges."""
    left, right = whole.edges_um
    worn = (whole.x_um > left) & (whole.x_um < right)
    return scar(whole.x_um[worn], whole.depth_um[worn])


def base_line_um(measured: MeasuredProfile) -> float:
    """What the untouched stretches beside the scar stand above the figure's zero."""
    beside = [(measured.x_um >= left) & (measured.x_um <= right) for left, right in _UNTOUCHED_um]
    return -float(np.median(measured.depth_um[np.any(beside, axis=0)]))


def simulated_scar(result: RunResult) -> MeasuredProfile:
    """The simulated flat at the test's end, out to where nothing is worn."""
    return scar(*result.scar(CYCLES, "specimen").section_along_motion())


def depth_comparisons(result: RunResult) -> list[Comparison]:
    """Largest depths of the flat against the nearer of the two published ones, or themselves where they lie between."""
    rows = []
    for cycle, shallower, deeper in pl.read_csv(_HERE / "published_fe_depths.csv", comment_prefix="#").iter_rows():
        depth = result.scar(cycle, "specimen").max_depth_um
        expected, source = float(np.clip(depth, shallower, deeper)), f"published FE, {shallower:.3f} to {deeper:.3f}"
        rows.append(Comparison(f"depth after {cycle} cycles [µm]", depth, expected, DEPTH, source))
    return rows


def shape_comparisons(simulated: MeasuredProfile) -> list[Comparison]:
    """Area and width of the scar against the published model and the measured flat."""
    published, measured = published_scar(), measured_scar()
    deepest, area, half_width = float(simulated.depth_um.max()), simulated.area_um2, 0.5 * simulated.width_um
    rows = [
        Comparison("worn area [µm²]", area, published.area_um2, SHAPE, "published FE"),
        Comparison("half-width [µm]", half_width, PUBLISHED_HALF_WIDTH_um, SHAPE, "published FE"),
        Comparison("half-width [µm]", half_width, 0.5 * measured.width_um, MEASURED, "measured"),
    ]
    for base, source in ((0.0, "measured, figure's zero"), (base_line_um(measured), "measured, untouched flat")):
        real_depth, real_area = float(measured.depth_um.max()) + base, measured.area_um2 + base * measured.width_um
        rows += [
            Comparison("depth [µm]", deepest, real_depth, MEASURED, source),
            Comparison("worn area [µm²]", area, real_area, MEASURED, source),
        ]
    return rows


def ripple(pad: Scar) -> float:
    """Largest departure of the pressure from its smooth shape inside 0.9 of the contact, over its mean there."""
    x, p = pad.axial_um, pad.pressure_MPa[:, 0]
    touching = np.flatnonzero(p > 0.0)
    half_width = min(-x[touching[0]], x[touching[-1]])
    inside = abs(x) < INSIDE * half_width
    shape = Polynomial.fit(x[inside], p[inside], _SHAPE_DEGREE)
    return float(abs(p[inside] - shape(x[inside])).max() / p[inside].mean())


def pressure_is_smooth(result: RunResult) -> Finding:
    """No ripples at mid-stroke once the surfaces are worn."""
    cycles = [cycle for cycle in result.scar_cycles() if cycle >= 1000]
    ripples = {cycle: ripple(result.scar(cycle, "pad")) for cycle in cycles}
    evidence = "departure from a smooth curve: " + ", ".join(
        f"{100 * value:.1f} % at {cycle}" for cycle, value in ripples.items()
    )
    return Finding("The pressure at mid-stroke has no ripples", evidence, max(ripples.values()) <= MOST_RIPPLE)


def measured_scar_is_centred(simulated: MeasuredProfile) -> Finding:
    """The simulation has no side that wears more."""
    measured, pitch = measured_scar(), float(np.diff(measured_scar().x_um).mean())
    left, right = measured.edges_um
    evidence = (
        f"centre of area {measured.centre_um:+.1f} µm, simulated {simulated.centre_um:+.1f} µm; "
        f"edges {left:.0f} and {right:.0f} µm, simulated {simulated.edges_um[0]:.0f} and {simulated.edges_um[1]:.0f} µm"
    )
    return Finding("The measured scar is centred", evidence, abs(measured.centre_um - simulated.centre_um) <= pitch)


def nothing_stands_above(simulated: MeasuredProfile) -> Finding:
    """The simulation only removes material; debris, transfer and plastic flow it does not know."""
    measured = measured_scar()
    base = base_line_um(measured)
    above = float(-measured.depth_um.min()) - base
    place = float(measured.x_um[measured.depth_um.argmin()])
    evidence = (
        f"{above:.2f} µm above the untouched flat at {place:.0f} µm; simulated {-simulated.depth_um.min():.2f} µm"
    )
    return Finding("Nothing stands above the measured flat", evidence, above <= 0.1)


def roughness_explains_the_rest(simulated: MeasuredProfile) -> Finding:
    """What is left between both scars is no more than the measured profile's own roughness."""
    worn = within(measured_scar())
    rest = worn.depth_um - np.interp(worn.x_um, simulated.x_um, simulated.depth_um)
    shape = Polynomial.fit(worn.x_um, worn.depth_um, _SHAPE_DEGREE)
    rough, apart = (float(np.sqrt(np.mean(v**2))) for v in (worn.depth_um - shape(worn.x_um), rest))
    evidence = f"{apart:.2f} µm rms between both, {rough:.2f} µm rms of roughness inside the scar"
    return Finding("The measured scar's roughness explains what is left", evidence, apart <= _ROUGH * rough)


def picture(result: RunResult) -> Figure:
    """Scars at the end, depths over cycles, what is left between measurement and simulation, pressures."""
    figure = style.new_figure(5.4)
    panels = list(figure.subplots(2, 2).flat)
    simulated, measured = simulated_scar(result), measured_scar()
    _scars(panels[0], simulated, measured)
    _depths(panels[1], result, measured)
    rest = measured.depth_um - np.interp(measured.x_um, simulated.x_um, simulated.depth_um)
    for base, colour, name in (
        (0.0, style.INK, "figure's zero"),
        (base_line_um(measured), style.VARIANT_COLOURS[1], "untouched flat"),
    ):
        panels[2].plot(measured.x_um, rest + base, color=colour, label=name)
    panels[2].axhline(0.0, color=style.GREY, linewidth=0.8)
    panels[2].set(title="measured less simulated depth", xlabel="x [µm]", ylabel="difference [µm]")
    panels[2].legend(title="measured from", fontsize="small", title_fontsize="small")
    cycles = [cycle for cycle in result.scar_cycles() if cycle >= 1000]
    for shade, cycle in zip(style.cycle_colours(len(cycles)), cycles, strict=True):
        pad = result.scar(cycle, "pad")
        shown = abs(pad.axial_um) < 300.0
        panels[3].plot(pad.axial_um[shown], pad.pressure_MPa[shown, 0], color=shade, label=style.cycle_name(cycle))
    panels[3].set(title="simulated pressure at mid-stroke", xlabel="x [µm]", ylabel="pressure [MPa]")
    panels[3].set_ylim(bottom=0.0)
    panels[3].legend(title="cycles", fontsize="small", title_fontsize="small")
    style.panel_letters(panels)
    return figure


def _scars(axes: Axes, simulated: MeasuredProfile, measured: MeasuredProfile) -> None:
    published = published_scar()
    axes.plot(measured.x_um, measured.depth_um, color=style.GREY, linewidth=1.0, label="measured")
    axes.plot(
        published.x_um, published.depth_um, "o", color=style.VARIANT_COLOURS[1], markersize=3, label="published FE"
    )
    shown = abs(simulated.x_um) < 350.0
    axes.plot(simulated.x_um[shown], simulated.depth_um[shown], color=style.VARIANT_COLOURS[0], label="wirewear")
    axes.invert_yaxis()
    axes.set(title="the flat after 18 000 cycles", xlabel="x [µm]", ylabel="depth [µm]")
    axes.legend(fontsize="small", loc="lower right")


def _depths(axes: Axes, result: RunResult, measured: MeasuredProfile) -> None:
    worn = [(cycle, result.scar(cycle, "specimen").max_depth_um) for cycle in result.scar_cycles()]
    cycles, depths = zip(*[pair for pair in worn if pair[1] > 0.0], strict=True)
    axes.plot(cycles, depths, color=style.VARIANT_COLOURS[0], label="wirewear")
    table = pl.read_csv(_HERE / "published_fe_depths.csv", comment_prefix="#")
    middle = 0.5 * (table["shallower_um"] + table["deeper_um"])
    axes.plot(table["cycle"], middle, "o", color=style.VARIANT_COLOURS[1], markersize=4, label="published FE")
    half = 0.5 * base_line_um(measured)
    axes.errorbar(
        [CYCLES],
        [float(measured.depth_um.max()) + half],
        [half],
        color=style.GREY,
        capsize=3,
        linestyle="none",
        label="measured",
    )
    style.cycle_axis(axes)
    axes.set(yscale="log", title="largest depth of the flat", ylabel="depth [µm]")
    axes.legend(fontsize="small", loc="lower right")


def findings_of(result: RunResult) -> Sequence[Finding]:
    """Whether the run is sound, and what of the measured scar it does not have."""
    simulated = simulated_scar(result)
    return [
        pressure_is_smooth(result),
        measured_scar_is_centred(simulated),
        nothing_stands_above(simulated),
        roughness_explains_the_rest(simulated),
    ]


@comparison_command
def main(result_dir: Path, folder: Path) -> None:
    """Set the simulated flat beside the published models' and the measured one."""
    (result,) = read_results(result_dir)
    if CYCLES not in result.scar_cycles():
        raise ResultError(f"{result_dir} is no complete run of McColl's test: it has no profile at {CYCLES} cycles")
    comparisons, findings = (
        [*depth_comparisons(result), *shape_comparisons(simulated_scar(result))],
        findings_of(result),
    )
    folder.mkdir(parents=True, exist_ok=True)
    drawn = style.save(partial(picture, result), folder / "mccoll2004.png")
    console = wide_console(132)
    console.print(comparison_table(comparisons))
    console.print(finding_table(findings))
    console.print(str(drawn), soft_wrap=True, highlight=False)


if __name__ == "__main__":
    main()
