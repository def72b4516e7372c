"""Page of a campaign's tests, and their table for a terminal and as CSV."""

from collections.abc import Sequence
from pathlib import Path

from rich import box
from rich.table import Table
from rich.text import Text

from wirewear.base import frame
from wirewear.base.errors import ResultError
from wirewear.base.words import counted
from wirewear.base.writing import write_csv, write_text, writing
from wirewear.comparison.campaign import CampaignResult
from wirewear.comparison.mapped_tests import MappedTest
from wirewear.views.campaign_scars import scar_pictures
from wirewear.views.maps_page import columns_of, row_of, shown_in, write_maps
from wirewear.views.maps_page import sentences as maps_sentences

HERE = Path(__file__).parent
PAGE, TABLE = "lab.html", "lab.csv"


def said_of(tests: Sequence[CampaignResult]) -> list[tuple[str, str]]:
    """(names, sentence) for what is wrong with tests, sets them apart, or was done to their files; each sentence once,
    with the tests that it is about.
    """
    found: dict[str, list[str]] = {}
    for test in tests:
        said = (test.refused, *test.problems, *(f"stands apart: {one}" for one in test.odd), *test.notes)
        for text in filter(None, said):
            found.setdefault(text, []).append(test.name)
    return [
        (", ".join(names) if len(names) <= 5 else f"{counted(len(names))} tests", text) for text, names in found.items()
    ]


def sentences(tests: Sequence[CampaignResult]) -> list[str]:
    """Summary: how many tests are good, have problems, stand apart or cannot be read, and the regimes of those read."""
    states = [test.state for test in tests]
    words = {"good": "good", "apart": "apart from the others", "problems": "with problems", "not read": "not read"}
    found = [f"{counted(states.count(state))} {text}" for state, text in words.items() if state in states]
    mapped = _mapped(tests)
    return [f"{counted(len(tests))} tests: {', '.join(found)}.", *(maps_sentences(mapped) if mapped else ())]


def _mapped(tests: Sequence[CampaignResult]) -> list[MappedTest]:
    return [test.mapped for test in tests if test.mapped is not None and not test.problems]


def _rows(tests: Sequence[CampaignResult]) -> list[tuple[CampaignResult, dict[str, object]]]:
    known = next((test.mapped for test in tests if test.mapped is not None), None)
    unknown = dict.fromkeys(name for name, _, _ in columns_of([known])) if known is not None else {}
    return [(test, unknown if test.mapped is None else row_of(test.mapped)) for test in tests]


def _columns(tests: Sequence[CampaignResult]) -> tuple[tuple[str, str, int], ...]:
    """The columns of `columns_of` that some test fills."""
    known = [test.mapped for test in tests if test.mapped is not None]
    filled = {name for test in known for name, value in row_of(test).items() if value}
    return tuple(column for column in (columns_of(known) if known else ()) if column[0] in filled)


def campaign_table(tests: Sequence[CampaignResult]) -> Table:
    """Table of a campaign's tests, to be printed with rich."""
    table, columns = Table(box=box.SIMPLE_HEAD, pad_edge=False), _columns(tests)
    for heading in ("test", "state"):
        table.add_column(heading, overflow="fold")
    for _, heading, digits in columns:
        table.add_column(Text(heading), justify="right" if digits else "left")
    for test, row in _rows(tests):
        cells = (shown_in(row[name], digits) for name, _, digits in columns)
        table.add_row(Text(test.name), test.state, *cells)
    return table


def campaign_json(tests: Sequence[CampaignResult]) -> list[dict[str, object]]:
    """Plain values of each test: its name, state, figures by the columns of `row_of`, remarks and diagnosis."""
    return [
        {"test": test.name, "state": test.state}
        | {key: value for key, value in row.items() if key not in ("test", "source")}
        | {"remarks": " ".join(text for _, text in said_of([test])), "diagnosis": test.answer}
        for test, row in _rows(tests)
    ]


def write_campaign(tests: Sequence[CampaignResult], source: Path, folder: Path) -> list[Path]:
    """Write lab.html and lab.csv into a folder, and maps of the tests that are read there, and return their paths.

    source: the campaign's folder. Raises ResultError if a file cannot be written.
    """
    mapped = _mapped(tests)
    maps = write_maps(mapped, folder) if mapped else []
    page = frame.rendered(
        HERE / "campaign.html",
        {
            "tests": tests,
            "folder": source.resolve().name,
            "rows": _rows(tests),
            "columns": _columns(tests),
            "sentences": sentences(tests),
            "all_good": all(test.state == "good" for test in tests),
            "maps": bool(maps),
            "said": said_of(tests),
            "scars": [
                (body, frame.inline_svg(image, f"scars{place}"))
                for place, (body, image) in enumerate(scar_pictures(tests))
            ],
            "answers": [(test.name, test.answer) for test in tests if test.answer],
            "table": TABLE,
        },
    )
    with writing(ResultError, f"cannot write the campaign to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return [write_text(folder / PAGE, page), write_csv(folder / TABLE, campaign_json(tests)), *maps]
