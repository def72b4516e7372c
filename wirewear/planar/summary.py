"""What came out of a planar run, on one screen."""

from rich import box
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from wirewear.base.quantity import counted
from wirewear.planar.results import BODIES, PlanarResult
from wirewear.results import PRESSURE_LENGTH
from wirewear.results.quality import flagged

_Column = tuple[str, str, str]

_COLUMNS: tuple[_Column, ...] = (
    ("Q_max\n[N/mm]", "max_tangential_force_N_per_mm", ".4g"),
    ("δ0\n[µm]", "slip_amplitude_um", ".4g"),
    ("E_d\n[mJ/mm]", "dissipated_energy_mJ_per_mm", ".4g"),
)

_MEANS: tuple[_Column, ...] = (
    ("p_max\n[MPa]", "max_mean_pressure_MPa", ".4g"),
    ("mid-\nstroke\n[MPa]", "mid_stroke_mean_pressure_MPa", ".4g"),
)

#: Results of earlier versions have no others.
_AT_NODES: tuple[_Column, ...] = (
    ("p_max\n[MPa]", "max_pressure_MPa", ".4g"),
    ("mid-\nstroke\n[MPa]", "mid_stroke_pressure_MPa", ".4g"),
)


def planar_summary(result: PlanarResult) -> RenderableType:
    """A table over the logged cycles that fits 80 columns, and the worst residual of each kind."""
    of_bodies = (heading for body in BODIES for heading in (f"{body}:\ndepth\n[µm]", "width\n[µm]"))
    evolution = result.evolution
    length = result.settings.get(PRESSURE_LENGTH)
    columns = (*_COLUMNS, *(_AT_NODES if length is None else _MEANS))
    table = Table(box=box.SIMPLE, pad_edge=False, collapse_padding=True, title_justify="left")
    table.title = escape(result.label)
    for heading in ("cycle", *(heading for heading, _, _ in columns), *of_bodies):
        table.add_column(Text(heading), justify="right")
    for i in range(len(evolution["cycle"])):
        # Results of earlier versions lack some columns.
        figures = [format(evolution[name][i], style) if name in evolution else "–" for _, name, style in columns]
        cells = [counted(evolution["cycle"][i]), *figures]
        for body in BODIES:
            depth = evolution[f"{body}_max_depth_um"][i]
            left, right = evolution[f"{body}_left_edge_um"][i], evolution[f"{body}_right_edge_um"][i]
            cells += [f"{depth:.3f}", f"{right - left:.0f}" if depth > 0.0 else "–"]
        table.add_row(*cells)
    pressures = "at single nodes" if length is None else f"means over {length:.3g} µm"
    worst = "; ".join(f"{name} {flagged(name, value)}" for name, value in result.quality.items())
    return Group(table, Text(f"pressures: {pressures}"), Text(f"worst residuals: {worst}"))
