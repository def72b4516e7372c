"""Pictures of a scored batch: calibration, open set, size of the gap, shrink, confusion."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from studies.blind.scoring.judging import Judgement
from wirewear.pictures.style import GREY, INK, VARIANT_COLOURS, new_figure

CELL_in, LABELS_in = 0.25, 1.9  #: Side of a square of the confusion matrix, and room for its labels.

#: Height of a panel that stands alone.
SIDE_in = 3.4
BLUE, ORANGE = VARIANT_COLOURS[0], VARIANT_COLOURS[1]


#: Size of the gap of a single effect in scatters, and whether it was put into the right class.
Single = tuple[float, bool]


def singles_of(judgements: Sequence[Judgement]) -> list[Single]:
    """What is drawn of each single effect."""
    return [(j.truth.gap_in_scatter, j.first_right) for j in judgements if j.truth.kind == "single"]


def panel_pictures(report: Mapping[str, Any], singles: Sequence[Single]) -> list[Callable[[], Figure]]:
    """The panels of the overview as figures of their own, for a page on which they stack."""
    return [partial(_alone, draw) for draw in _panels(report, singles)]


def _panels(report: Mapping[str, Any], singles: Sequence[Single]) -> list[Callable[[Axes], None]]:
    return [
        lambda axes: _gap_panel(axes, report["by_gap"], singles),
        lambda axes: _reliability_panel(axes, report["reliability"], report["calibration_error"]),
        lambda axes: _roc_panel(axes, report["open_set"]),
        lambda axes: _shrink_panel(axes, report["shrink"]["rows"]),
    ]


def _alone(draw: Callable[[Axes], None]) -> Figure:
    figure = new_figure(SIDE_in, 1.2 * SIDE_in)
    draw(figure.subplots())
    return figure


def _gap_panel(axes: Axes, rows: Sequence[Mapping[str, Any]], singles: Sequence[Single]) -> None:
    axes.set_title("class right, by size of the gap", loc="left")
    gaps = [max(gap, 0.32) for gap, _ in singles]
    marks = [1.07 if right else -0.07 for _, right in singles]
    axes.plot(gaps, marks, "|", color=GREY, markersize=5, markeredgewidth=0.7)
    top = max([40.0, *gaps])
    for row, style in ((row, style) for row in rows for style in (("top2", ORANGE, 1.06), ("top1", BLUE, 1.0))):
        name, colour, aside = style
        found = row[name]
        if not found["of"]:
            continue
        low, high = max(row["from"], 0.3), row["to"] or top
        middle = aside * float(np.sqrt(low * high))
        ends = found["interval95"]
        axes.plot([middle, middle], ends, color=colour, linewidth=1.2)
        axes.plot(middle, found["value"], "o" if name == "top1" else "s", color=colour, markersize=4.5)
    axes.plot([], [], "s", color=ORANGE, markersize=4.5, label="first two")
    axes.plot([], [], "o", color=BLUE, markersize=4.5, label="first")
    axes.plot([], [], "|", color=GREY, markersize=5, label="one record")
    axes.set(xscale="log", xlabel="gap in scatters of one test", ylabel="share of single effects", ylim=(-0.12, 1.12))
    axes.set_xticks([1, 3, 10, 30, 100], ["1", "3", "10", "30", "100"])
    axes.set_xlim(0.3, 1.3 * top)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, -0.36), ncols=3, columnspacing=1.0, handletextpad=0.3)


def _reliability_panel(axes: Axes, bins: Sequence[Mapping[str, Any]], error: float | None) -> None:
    axes.set_title("reliability of the leading answer", loc="left")
    axes.plot([0, 1], [0, 1], color=GREY, linewidth=0.8)
    for one in bins:
        axes.plot([one["probability"]] * 2, one["right"]["interval95"], color=BLUE, linewidth=1.2)
        size = 3.0 + 7.0 * np.sqrt(one["right"]["of"] / max(b["right"]["of"] for b in bins))
        axes.plot(one["probability"], one["right"]["value"], "o", color=BLUE, markersize=size, clip_on=False)
    if error is not None:
        axes.text(0.97, 0.06, f"calibration error {error:.3f}", transform=axes.transAxes, fontsize=8, ha="right")
    axes.set(xlabel="probability stated", ylabel="share right", xlim=(0, 1.02), ylim=(-0.02, 1.04))


def _roc_panel(axes: Axes, open_set: Mapping[str, Any]) -> None:
    axes.set_title("effects of no library", loc="left")
    axes.plot([0, 1], [0, 1], color=GREY, linewidth=0.8)
    roc, area = open_set["roc"], open_set["auroc"]
    if area["value"] is not None:
        low, high = area["interval95"]
        text = f"area {area['value']:.3f} ({low:.2f} to {high:.2f})"
        axes.text(0.97, 0.06, text, transform=axes.transAxes, fontsize=8, ha="right")
    if roc["false"]:
        axes.plot(roc["false"], roc["true"], color=BLUE)
    axes.set(
        xlabel="known effects called unknown",
        ylabel="unknown effects called so",
        xlim=(-0.02, 1.02),
        ylim=(-0.02, 1.04),
    )


def _shrink_panel(axes: Axes, rows: Sequence[Mapping[str, Any]]) -> None:
    """Share of the records by how far their gap shrinks: most shrink as a whole or not at all, which points hide."""
    axes.set_title(f"shrink of the gap, {len(rows)} records", loc="left")
    lowest = 0.0
    for name, label, style in (
        ("achieved", "achieved", {"color": BLUE}),
        ("predicted", "predicted", {"color": INK, "linestyle": ":"}),
        ("oracle", "by a diagnosis given the truth", {"color": ORANGE, "linestyle": "--"}),
    ):
        values = np.sort(np.clip([row[name] for row in rows if row[name] is not None], -0.2, 1.0))
        if not values.size:
            continue
        lowest = min(lowest, float(values[0]))
        shares = np.concatenate([[1.0], np.arange(len(values), -1.0, -1.0) / len(values)])
        places = np.concatenate([[-0.2], values, [1.0]])
        axes.step(places, shares, where="pre", label=f"{label}, mean {values.mean():.2f}", **style)  # type: ignore[arg-type]
    if rows and all(row["oracle"] is None for row in rows):
        axes.plot([], [], " ", label="no diagnosis was given the truth")
    axes.set(xlabel="shrink", ylabel="share of records that shrink so far", ylim=(-0.02, 1.04))
    axes.set_xlim(lowest - 0.04, 1.04)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower left")


def confusion_picture(confusion: Mapping[str, Any]) -> Figure:
    """Answers (columns) to truths (rows): number of cases, shaded by share of the row."""
    rows, columns = confusion["truths"], confusion["answers"]
    counts = np.array(confusion["counts"], dtype=float).reshape(len(rows), len(columns))
    figure = new_figure(LABELS_in + CELL_in * len(rows), LABELS_in + 0.4 + CELL_in * max(len(columns), 5))
    axes = figure.subplots()
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1.0)
    # Squares rather than an image, which stay sharp at any size.
    axes.pcolormesh(
        np.arange(len(columns) + 1) - 0.5, np.arange(len(rows) + 1) - 0.5, shares, cmap="Blues", vmin=0.0, vmax=1.15
    )
    axes.invert_yaxis()
    axes.set_aspect("equal")
    for row, column in zip(*np.nonzero(counts), strict=True):
        share = counts[row, column] / counts[row].sum()
        colour = "white" if share > 0.6 else INK
        axes.text(column, row, f"{counts[row, column]:.0f}", ha="center", va="center", fontsize=7, color=colour)
    axes.set_xticks(range(len(columns)), [_plain(c) for c in columns], rotation=60, ha="right", rotation_mode="anchor")
    axes.set_yticks(range(len(rows)), [_plain(r) for r in rows])
    axes.tick_params(labelsize=7, length=0)
    axes.set(xlabel="answer", ylabel="truth")
    axes.grid(visible=False)
    for index, truth in enumerate(rows):
        if truth in columns:
            place = columns.index(truth)
            axes.add_patch(_frame(place, index))
    return figure


def _frame(column: int, row: int) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle((column - 0.5, row - 0.5), 1.0, 1.0, fill=False, edgecolor=INK, linewidth=0.9)


def _plain(label: str) -> str:
    if label == "none":
        return "no gap"
    if label == "outside_library":
        return "unexplained"
    if " / " in label:
        return "compliance, either kind" if "compliance" in label else label
    return label.replace("_", " ")
