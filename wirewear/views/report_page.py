"""Report of one test for print on A4, and its sections for a template of one's own."""

from collections.abc import Iterator
from pathlib import Path
from string import Template

from wirewear.base import frame
from wirewear.base.errors import RecordError, ResultError
from wirewear.base.files import read_text
from wirewear.base.writing import finite, json_text, write_text, writing
from wirewear.comparison.laboratory_report import UNREAD, LaboratoryReport
from wirewear.pictures.style import svg
from wirewear.records.importing.loop_sources import SampledLoop
from wirewear.views.loops_picture import figure_of
from wirewear.views.loops_report import analyse_loops

HERE = Path(__file__).parent
PAGE, NUMBERS = "test_report.html", "test_report.json"

#: Sections by the names of their placeholders, in their order.
SECTIONS = ("summary", "figures", "items", "deviations", "loops", "budgets", "inputs")


def write_report(report: LaboratoryReport, folder: Path, template: Path | None = None) -> list[Path]:
    """Write test_report.html and test_report.json into a folder and return their paths. template: a text with
    placeholders such as ${figures} and ${style} in place of the page; see SECTIONS, and ${title}.

    Raises RecordError if the template cannot be read or names an unknown placeholder, ResultError if a file cannot be
    written.
    """
    sections = dict(_sections(report))
    if template is None:
        text = sections["page"]
    else:
        given = read_text(template, RecordError, "template")
        try:
            text = Template(given).substitute(sections)
        except (KeyError, ValueError) as problem:
            known = ", ".join(f"${{{name}}}" for name in sections if name != "page")
            raise RecordError(f"{template}: {problem} is no placeholder; there are {known}.") from None
    with writing(ResultError, f"cannot write the report to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        numbers = json_text(finite(report.to_json()), indent=1) + "\n"
        return [write_text(folder / PAGE, text), write_text(folder / NUMBERS, numbers)]


def _sections(report: LaboratoryReport) -> Iterator[tuple[str, str]]:
    """The whole page, its title and style, and each section as HTML, by their names."""
    load = report.record.tables.conditions.normal_load_N
    analysed = analyse_loops(SampledLoop.of(loop, load) for loop in report.loops)
    values = {
        "report": report,
        "unread": UNREAD,
        "picture": frame.inline_svg(svg(lambda: figure_of(analysed)), "loops"),
        "known": sum(item.known for item in report.items),
    }
    yield "page", frame.rendered(HERE / "report.html", values)
    page = frame.environment(HERE).get_template("report.html")
    context = page.new_context({**values, "css": "", "version": "", "citation": ""})
    yield "title", "".join(page.blocks["title"](context))
    yield "style", "".join(page.blocks["style"](context))
    for name in SECTIONS:
        yield name, "".join(page.blocks[name](context))
