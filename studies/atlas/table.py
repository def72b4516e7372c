"""The atlas's one table: written, read again as the frozen answer of a release, and what has moved since."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import polars as pl
from rich import box
from rich.table import Table
from rich.text import Text

from studies.atlas.entry import ENTRIES, Row
from wirewear.base.frame import figure
from wirewear.base.writing import write_csv

FROZEN = ENTRIES / "table.csv"
DIGITS = 6  #: Of figures in the table; those beyond change from machine to machine.


def frozen(path: Path = FROZEN) -> list[Row]:
    """The rows of a written table; none where there is no file."""
    if not path.exists():
        return []
    strings = dict.fromkeys(("entry", "test", "figure", "unit"), pl.String)
    table = pl.read_csv(path, schema_overrides=strings, infer_schema_length=None)
    return [Row(**row) for row in table.drop("error", "within").iter_rows(named=True)]


def write_table(rows: Sequence[Row], path: Path) -> Path:
    """Write rows with their error and whether it is within the tolerance."""
    return write_csv(path, pl.DataFrame([_rounded(row) for row in rows], infer_schema_length=None))


def _rounded(row: Row) -> dict[str, object]:
    values = asdict(row) | {"error": row.error, "within": row.within}
    return {key: float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value for key, value in values.items()}


def moved(rows: Sequence[Row], before: Sequence[Row]) -> list[tuple[Row, Row]]:
    """Rows that differ from those of before by more than their tolerance, in what is simulated."""
    known = {(row.entry, row.test, row.figure): row for row in before}
    pairs = [(row, known.get((row.entry, row.test, row.figure))) for row in rows]
    return [(row, old) for row, old in pairs if old is not None and _apart(row, old)]


def _apart(row: Row, old: Row) -> bool:
    if row.simulated is None or old.simulated is None:
        return row.simulated is not old.simulated
    return abs(row.simulated - old.simulated) > row.tolerance * abs(old.simulated)


def compared(rows: Sequence[Row]) -> list[Row]:
    """Those that have an error, largest over tolerance first."""
    known = [row for row in rows if row.error is not None]
    return sorted(known, key=lambda row: -abs(row.error or 0.0) / row.tolerance)


def sentence(rows: Sequence[Row]) -> str:
    """How many figures agree."""
    known, entries = compared(rows), len({row.entry for row in rows})
    predicted = [row for row in known if row.predicted is not None]
    named = f"{entries} {'entry' if entries == 1 else 'entries'}"
    return (
        f"{named}, {len(known)} compared figures: {_within(known)} within tolerance. "
        f"{len(predicted)} of them were predicted before they were compared: {_within(predicted)}."
    )


def _within(rows: Sequence[Row]) -> str:
    count = sum(row.within is True for row in rows)
    return f"{count} of {len(rows)} ({count / len(rows):.0%})" if rows else "none"


def rows_table(rows: Sequence[Row]) -> Table:
    """Rows, to be printed with rich."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("entry", "test", "figure"):
        table.add_column(heading, overflow="fold")
    for heading in ("measured", "published", "simulated", "predicted", "error", "within"):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in rows:
        figures = (figure(value, 4) for value in (row.measured, row.published, row.simulated, row.predicted))
        error = "–" if row.error is None else f"{row.error:+.1%}"
        names = Text(row.entry), Text(row.test), Text(f"{row.figure} [{row.unit}]")
        verdict = Text(f"{row.tolerance:.0%}", "green" if row.within else "red")
        table.add_row(*names, *figures, error, verdict)
    return table
