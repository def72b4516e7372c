"""A record's report as it is printed on a terminal."""

from rich.console import Group
from rich.padding import Padding
from rich.text import Text

from wirewear.records.remarks import RecordReport, listed, plural


def report_text(report: RecordReport) -> Group:
    """The report, to be printed with rich."""
    lines: list[Text | Padding] = [
        Text(report.name, style="bold"),
        Text(
            f"{plural(len(report.repeats), 'repeat')}, {plural(report.loops, 'loop')} of "
            f"{plural(report.samples, 'sample')} in all, cycles {listed(report.cycles)}"
        ),
    ]
    if report.metadata:
        lines += _list("Of the test", report.metadata, "default")
    for level, heading, colour in (("problem", "Problems", "red"), ("note", "To be known", "yellow")):
        own = [remark for remark in report.remarks if remark.level == level]
        if own:
            lines += _list(heading, [f"{remark.topic}: {remark.text}" for remark in own], colour)
    if not report.remarks:
        lines.append(Text("Nothing odd was found.", style="green"))
    lines += _list("The record supports", report.supports, "green")
    if report.cannot:
        lines += _list("It cannot support", report.cannot, "yellow")
    return Group(*lines)


def _list(heading: str, sentences: tuple[str, ...] | list[str], colour: str) -> list[Text | Padding]:
    items = [Padding(Text(f"– {sentence}"), (0, 0, 0, 2)) for sentence in sentences]
    return [Text(heading, style=colour), *items]
