"""Pictures of the worn surfaces of a campaign's tests beside one another, on one scale of depth for each body."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from wirewear.base.frame import figure as text_of
from wirewear.comparison.campaign import CampaignResult
from wirewear.pictures.panels import draw_map
from wirewear.pictures.style import WIDTH_in, depth_scale, new_figure, svg, variant_style
from wirewear.records import MeasuredScar
from wirewear.records.profiles import MeasuredProfile
from wirewear.results.scar import called

COLUMNS = 4  #: Maps in a row.


def scar_pictures(tests: Sequence[CampaignResult]) -> Iterator[tuple[str, bytes]]:
    """For each body whose surfaces were measured: its name, and an SVG of those of all tests, first repeats only."""
    bodies = dict.fromkeys(surface.body for test in tests for surface in test.surfaces)
    for body in bodies:
        shown = [(test.name, one) for test in tests for one in test.surfaces if one.body == body]
        yield called(body), svg(partial(_DRAWN[type(shown[0][1])], shown))


def _maps(shown: Sequence[tuple[str, Any]]) -> Figure:
    colours, norm = depth_scale(scar.depth_um for _, scar in shown)
    columns = min(len(shown), COLUMNS)
    rows = -(-len(shown) // columns)
    half = [max(float(np.abs(getattr(scar, key)).max()) for _, scar in shown) for key in ("x_um", "y_um")]
    height = min(max(half[1] / half[0], 0.4), 2.0) * 0.8 * WIDTH_in / columns + 0.6
    figure = new_figure(rows * height)
    panels = [*figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).flat]
    for unused in panels[len(shown) :]:
        unused.set_visible(False)
    for axes, (name, scar) in zip(panels, shown, strict=False):
        image = draw_map(axes, (scar.x_um, scar.y_um), scar.depth_um, norm, colours, (half[0], half[1]))
        axes.set_title(f"{name}: {text_of(scar.volume_mm3)} mm³", fontsize=7.5)
    for axes in panels[max(len(shown) - columns, 0) : len(shown)]:
        axes.set_xlabel("x, along the motion [µm]")
        axes.tick_params(labelbottom=True)
    for axes in panels[::columns]:
        axes.set_ylabel("y [µm]")
    figure.colorbar(image, ax=panels, label="worn depth [µm]", shrink=0.7)
    return figure


def _profiles(shown: Sequence[tuple[str, Any]]) -> Figure:
    figure = new_figure(3.4)
    axes = figure.subplots()
    for place, (name, profile) in enumerate(shown):
        axes.plot(profile.x_um, profile.depth_um, label=name, **variant_style(place))
    axes.invert_yaxis()
    axes.set(xlabel="x, along the motion [µm]", ylabel="worn depth [µm]")
    if len(shown) <= 12:  # a legend of more would cover the profiles
        axes.legend(fontsize="small")
    return figure


_DRAWN: Mapping[type, Callable[[Sequence[tuple[str, Any]]], Figure]] = {MeasuredScar: _maps, MeasuredProfile: _profiles}
