"""Common style of all pictures: sizes, fonts, colours, marks. Nothing here changes global plotting state."""

import math
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from io import BytesIO
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any, TypedDict

import matplotlib as mpl
import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Colormap, LinearSegmentedColormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator
from matplotlib.typing import ColorType, LineStyleType

from geometry.arrays import Array
from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.words import counted
from wirewear.base.writing import in_one_step, writing

if TYPE_CHECKING:
    from wirewear.results import RunResult

GREY = "#8a8a8a"

VARIANT_COLOURS = frame.VARIANT_COLOURS
_LENGTHS = (5, 1.5), (1, 1), (6, 1.5, 1, 1.5), (3, 1), (8, 2)  #: Of dashes and gaps.
VARIANT_DASHES: tuple[LineStyleType, ...] = ("-", *((0, lengths) for lengths in _LENGTHS))

DEPTH_COLOURS: Colormap = LinearSegmentedColormap.from_list("depth", np.divide(frame.DEPTH_SHADES, 255.0))
_RAISED = LinearSegmentedColormap.from_list("raised", ["#fcf4b6", "#8fd0c5", "#12807c", "#07403e"])

#: Pressure and slip: uniform as well, and neither to be taken for a depth.
PRESSURE_COLOURS: Colormap = LinearSegmentedColormap.from_list(
    "pressure", colormaps["viridis_r"](np.linspace(0, 1, 256))
)
SLIP_COLOURS: Colormap = LinearSegmentedColormap.from_list("slip", colormaps["cividis_r"](np.linspace(0, 1, 256)))


#: Text width of a page, both columns of a journal [inch]: every picture's; and one column, of a single panel on paper.
WIDTH_in, COLUMN_in = 7.5, 3.54


_TABLES = tomllib.loads(Path(__file__).with_name("style.toml").read_text(encoding="utf-8"))
_SETTINGS: Any = _TABLES["house"]
_PAPER: Any = _SETTINGS | _TABLES["paper"]
INK: str = _SETTINGS["text.color"]

_used: ContextVar[Mapping[str, Any]] = ContextVar("used", default=_SETTINGS)


class LineLook(TypedDict, total=False):
    """Properties of a line, named and in units as in matplotlib."""

    color: ColorType
    linestyle: LineStyleType
    linewidth: float


class AreaLook(TypedDict, total=False):
    """Properties of a filled area, named as in matplotlib."""

    color: ColorType
    alpha: float


@contextmanager
def on_paper() -> Iterator[None]:
    """Within this context pictures are for a two-column journal: single panels in one column, others across both."""
    before = _used.set(_PAPER)
    try:
        yield
    finally:
        _used.reset(before)


@contextmanager
def styled() -> Iterator[None]:
    """Within this context the common style applies; matplotlib's settings are restored afterwards."""
    with mpl.rc_context(_used.get()):  # type: ignore[arg-type]
        yield


class HouseFigure(Figure):
    """A figure that a notebook displays although it does not belong to pyplot."""

    def _repr_png_(self) -> bytes:
        image = BytesIO()
        with styled():
            self.savefig(image, format="png", dpi=110)
        return image.getvalue()


def new_figure(height_in: float, width_in: float = WIDTH_in, *, arranged: bool = True) -> Figure:
    """An empty figure that draws off screen. arranged: False if panels are put at fixed places."""
    figure = HouseFigure(figsize=(width_in, height_in), layout="constrained" if arranged else None)
    FigureCanvasAgg(figure)
    return figure


def save(draw: Callable[[], Figure], path: Path) -> Path:
    """Draw a figure in the common style, write it in the format of the path's ending (PNG without one), and return the
    path. Raises ResultError if the file cannot be written, or matplotlib does not know the ending.
    """
    require_picture_name(path)
    with styled():
        figure = draw()
        if _used.get() is _PAPER and sum(axes.get_label() != "<colorbar>" for axes in figure.axes) == 1:
            figure.set_size_inches(COLUMN_in, 0.8 * COLUMN_in)
        with writing(ResultError, f"cannot write the picture {path}"), in_one_step(path) as partial:
            figure.savefig(partial, format=path.suffix[1:] or "png")
    return path


def require_picture_name(path: Path) -> None:
    """Raise ResultError unless matplotlib can write the format of the path's ending."""
    if path.suffix[1:].lower() not in {"", *FigureCanvasAgg.get_supported_filetypes()}:
        raise ResultError(f"the picture {path} cannot be drawn: its name must end in .png, .svg or .pdf.")


def svg(draw: Callable[[], Figure]) -> bytes:
    """SVG of a figure in the common style, with text as text and the same bytes for the same figure."""
    image = BytesIO()
    with styled(), mpl.rc_context({"svg.hashsalt": "wirewear"}):
        draw().savefig(image, format="svg", metadata={"Date": None})
    return image.getvalue()


def variant_style(index: int) -> LineLook:
    """Line colour and dashes of the variant with this index, from 0."""
    return {
        "color": VARIANT_COLOURS[index % len(VARIANT_COLOURS)],
        "linestyle": VARIANT_DASHES[index % len(VARIANT_DASHES)],
    }


def cycle_colours(count: int) -> list[tuple[float, float, float, float]]:
    """One colour (red, green, blue, opacity) for each of `count` cycles, from light to dark."""
    shades = [0.0] if count == 1 else np.linspace(0.82, 0.0, count)
    return [colormaps["viridis"](shade) for shade in shades]


def depth_scale(depths_um: Iterable[Array]) -> tuple[Colormap, Normalize]:
    """(colours, scale) for measured depths in µm, NaN ignored: `DEPTH_COLOURS` where worn, green where raised."""
    fields = list(depths_um)
    deepest = max([1e-6, *(float(np.nanmax(depth)) for depth in fields)])
    lowest = min([0.0, *(float(np.nanmin(depth)) for depth in fields)])
    at = np.linspace(lowest, deepest, 1024)
    # What is raised by a quarter of the largest depth has the darkest colour, at the latest.
    raised = _RAISED(np.clip(-at / max(-lowest, 0.25 * deepest), 0.0, 1.0))
    colours = np.where((at < 0.0)[:, None], raised, DEPTH_COLOURS(np.clip(at / deepest, 0.0, 1.0)))
    return ListedColormap(colours), Normalize(lowest, deepest)


def cycle_name(cycle: int) -> str:
    """Number of cycles as text, with thin spaces from 10 000 on."""
    return counted(cycle)


def cycle_axis(axes: Axes) -> None:
    """Make the x axis a logarithmic axis of cycles with ticks at powers of ten; call it after the curves are drawn."""
    axes.set_xscale("log")
    axes.set_xlim(left=1.0)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: cycle_name(round(value))))
    axes.set_xlabel("cycles")
    axes.xaxis.set_major_locator(LogLocator(100.0 if _narrow(axes) else 10.0, numticks=12))
    axes.xaxis.set_minor_locator(NullLocator())


def _narrow(axes: Axes) -> bool:
    """True if labels at all powers of ten up to the last cycle would touch."""
    figure = axes.get_figure(root=True)
    width_in = axes.get_position().width * (figure.get_figwidth() if figure is not None else WIDTH_in)
    # Room that the number of a decade takes on an axis of cycles.
    return width_in < 0.36 * (math.log10(max(axes.get_xlim()[1], 1.0)) + 1.0)


def titled(results: Sequence["RunResult"], result: "RunResult", text: str) -> str:
    """Title of one of several runs' panels, in lines that fit into half of a picture; a single run goes without its
    name, which may be long.
    """
    return text if len(results) == 1 else fill(f"{result.label}: {text}", 40)


def panel_letters(panels: Sequence[Axes]) -> None:
    """Put (a), (b), … before the title of each panel."""
    for letter, axes in zip("abcdefghijklmnopqrstuvwxyz", panels, strict=False):
        axes.set_title(f"({letter})  {axes.get_title(loc='left')}", loc="left")


def round_below(value: float) -> float:
    """The largest of 1, 2, 5 × 10ⁿ that does not exceed `value`, which must be positive."""
    decade = 10.0 ** math.floor(math.log10(value))
    return next(step * decade for step in (5.0, 2.0, 1.0) if step * decade <= value * (1.0 + 1e-9))


def scale_bar(axes: Axes, length_um: float) -> None:
    """Draw a bar of `length_um` with its label in the lower left corner of a panel whose axes are in µm."""
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    start, y = left + 0.04 * (right - left), bottom + 0.06 * (top - bottom)
    axes.plot([start, start + length_um], [y, y], color=INK, linewidth=2.5, solid_capstyle="butt")
    axes.annotate(
        f"{length_um:g} µm", (start, y), xytext=(0, 3), textcoords="offset points", ha="left", va="bottom", fontsize=7.5
    )


def sliding_arrow(axes: Axes) -> None:
    """Draw a double arrow for the sliding direction in the upper right corner of a panel."""
    axes.annotate(
        "",
        xy=(0.97, 0.86),
        xytext=(0.70, 0.86),
        xycoords="axes fraction",
        arrowprops={
            "arrowstyle": "<|-|>",
            "color": INK,
            "linewidth": 1.0,
            "mutation_scale": 8,
            "shrinkA": 0,
            "shrinkB": 0,
        },
    )
    axes.text(0.835, 0.885, "sliding", transform=axes.transAxes, ha="center", va="bottom", fontsize=7.5)
