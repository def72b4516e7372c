"""The contract's aims beside what was reached, for the terminal and the page."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.table import Table

#: What stands for a figure that scores of earlier versions lack.
NOT_REPORTED: Mapping[str, Any] = {"value": None, "interval95": None}


@dataclass(frozen=True)
class AimRow:
    """A figure in words, what was reached, what was aimed at, and whether it is met (None: no aim, or no cases).

    certain: whether the whole 95 % interval says the same.
    """

    what: str
    reached: str
    aim: str
    met: bool | None
    certain: bool = True

    @property
    def mark(self) -> str:
        """Whether the aim is met, in a word."""
        if self.met is None:
            return ""
        return ("met" if self.met else "missed") + ("" if self.certain else " (too few cases to be sure)")


def share_text(share: Mapping[str, Any]) -> str:
    """A share with its interval and counts, in per cent."""
    if share["value"] is None:
        return "–"
    low, high = share["interval95"]
    return f"{100 * share['value']:.0f} % ({100 * low:.0f} to {100 * high:.0f}), {share['hits']} of {share['of']}"


def aim_rows(report: Mapping[str, Any]) -> list[AimRow]:
    """Every headline figure; the aims are those for the tier T1."""
    opened, shrink = report["open_set"], report["shrink"]
    return [
        _share("false alarms on gap-free records", report["false_alarms"], "≤ 5 %", high=0.05),
        _share("gap found where there is one", report["detected"]),
        _share("gap found, gaps above 5 scatters", report["detected_large"]),
        _share("class right, all single effects", report["top1"]),
        _share("class right, gaps above 5 scatters", report["top1_large"], "≥ 90 %", low=0.9),
        _share("class among the first two, gaps above 5 scatters", report["top2_large"]),
        _share("class right where an effect is named", report["right_given_detection"], "≥ 97 %", low=0.97),
        _share("a true effect where one is named, all records", report["true_where_named"]),
        _number("effects in the true class, mean", report["mean_class_size"]),
        _number("probability on the truth, single effects", report["truth_probability"]["single"]),
        _number("probability on the truth where a gap is seen", report.get("truth_probability_detected")),
        _number("calibration error", report["calibration_error"]),
        _share("90 % class sets that hold the truth", report["set_coverage"], "87 to 95 %", low=0.87, high=0.95),
        _share("95 % parameter intervals that hold the truth", report["parameters"]["coverage"]),
        _area("open set: area under the ROC", opened["auroc"], "≥ 0.95", low=0.95),
        _area("open set, gaps above 5 scatters: area under the ROC", opened.get("auroc_large", NOT_REPORTED)),
        _share("effects of no library left unexplained", opened["rejected"]["outside"]),
        _share(
            "effects of no library left unexplained, gaps above 5 scatters",
            opened.get("rejected_large", {}).get("outside", NOT_REPORTED),
        ),
        _share("the right seam where they are, gaps above 5 scatters", opened.get("right_seam_large", NOT_REPORTED)),
        _share("effects left out of the library: right", opened["left_out_right"]),
        _share("known effects left unexplained", opened["known_rejected"]),
        _share("pairs: both named", report["pairs"]["both"]),
        _share("pairs whose weaker effect is above 3 scatters: both", report["pairs"].get("both_large", NOT_REPORTED)),
        _share("pairs: at least one named", report["pairs"]["at_least_one"]),
        _number("shrink predicted, mean", shrink["predicted"]),
        _number("shrink achieved, mean", shrink["achieved"]),
        _number("shrink of an oracle given the truth, mean", shrink["oracle"]),
        _number("shrink lost against the oracle, gaps found", shrink["regret"], "≤ 0.05", high=0.05),
        _number("shrink lost against the oracle, all gaps", shrink["regret_of_all"], "≤ 0.05", high=0.05),
    ]


def _share(
    what: str, share: Mapping[str, Any], aim: str = "", low: float | None = None, high: float | None = None
) -> AimRow:
    met, ends = _met(share["value"], low, high), share["interval95"] or ()
    return AimRow(what, share_text(share), aim, met, all(_met(end, low, high) == met for end in ends))


def _area(what: str, area: Mapping[str, Any], aim: str = "", low: float | None = None) -> AimRow:
    ends = area["interval95"] or ()
    text = "–" if area["value"] is None else f"{area['value']:.3f}"
    if ends:
        text += f" ({ends[0]:.2f} to {ends[1]:.2f})"
    met = _met(area["value"], low, None)
    return AimRow(what, text, aim, met, all(_met(end, low, None) == met for end in ends))


def _number(
    what: str, value: float | None, aim: str = "", low: float | None = None, high: float | None = None
) -> AimRow:
    return AimRow(what, "–" if value is None else f"{value:.3f}", aim, _met(value, low, high))


def _met(value: float | None, low: float | None, high: float | None) -> bool | None:
    if value is None or (low is None and high is None):
        return None
    return (low is None or value >= low) and (high is None or value <= high)


def words(name: str) -> str:
    """A baseline's folder as words."""
    return "baseline " + {"bic": "BIC"}.get(name, name.replace("_", " "))


def score_table(report: Mapping[str, Any]) -> Table:
    """The table for a terminal."""
    from rich.table import Table

    run = report["run"]
    table = Table(
        title=f"Tier {report['tier']} ({report['model']}): {report['cases']} cases, "
        f"{report['unanswered']} without an answer, {len(report['unmade'])} that could not be made, "
        f"scored run {run['run']}"
    )
    for name in ("figure", "reached (95 % interval)", "aim of T1", ""):
        table.add_column(name)
    for row in aim_rows(report):
        table.add_row(row.what, row.reached, row.aim, row.mark)
    for name, figures in report["baselines"].items():
        table.add_row(f"{words(name)}: class right, gaps above 5", share_text(figures["top1_large"]), "", "")
        table.add_row(f"{words(name)}: false alarms", share_text(figures["false_alarms"]), "", "")
    return table
