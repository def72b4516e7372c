"""An entry of the atlas: what a publication prints, how it is simulated, and what is compared.

Its folder holds entry.toml and a table of tests. Columns of that table, constants fitted on some of its rows and the
two sides of every comparison are SQL expressions over it: a further row is a further test, without any code.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import polars as pl
from polars import selectors
from polars.exceptions import PolarsError
from pydantic import ConfigDict

from wirewear import StudyError
from wirewear.base.files import read_toml
from wirewear.base.words import as_sentence
from wirewear.test.keys import Table
from wirewear.test.messages import validated

ENTRIES = Path(__file__).parent
PREDICTIONS = "predictions.csv"
ALL = "all"  #: What stands for the test where a comparison is of all of them together.

#: Figures of a run for one test, by name.
Simulated = Callable[[Mapping[str, Any]], Mapping[str, float]]


class _Table(Table):
    model_config = ConfigDict(defer_build=False)


class Compared(_Table):
    """A figure to be compared: SQL for either side, and for that of a published model; for which rows (`where`).

    tolerance: relative error that is still within, and why that much.
    """

    figure: str
    unit: str
    measured: str
    simulated: str
    published: str = "NULL"
    where: str = "TRUE"
    tolerance: float
    why: str


class EntryTable(_Table):
    """What entry.toml says.

    tests: the table, a test a row. taken: rows of it that are looked at, in SQL. fitted: those of them that constants
    are fitted on; all others are predictions. constants: numbers, or SQL over the fitted rows. columns: SQL, row by
    row; a column with a dot in its name is a key of the study. figures: a function, `module:name`, that gives a row's
    figures where no study does, and why.
    """

    name: str
    citation: str
    licence: str
    printed: str
    not_stated: tuple[str, ...] = ()
    simulated: str = ""
    diagnosis: str = ""
    unknown: str = ""
    study: str | None = None
    figures: str | None = None
    figures_because: str = ""
    tests: str = "tests.csv"
    taken: str = "TRUE"
    fitted: str | None = None
    constants: Mapping[str, float | str] = {}
    columns: Mapping[str, float | str] = {}
    compare: tuple[Compared, ...]


@dataclass(frozen=True)
class Row:
    """One compared figure of one test; None is what is not known. predicted: as it was written down beforehand."""

    entry: str
    test: str
    figure: str
    unit: str
    measured: float | None
    published: float | None
    simulated: float | None
    predicted: float | None
    tolerance: float

    @property
    def error(self) -> float | None:
        """What was predicted, or else is simulated, relative to what was measured."""
        found = self.simulated if self.predicted is None else self.predicted
        return None if found is None or not self.measured else found / self.measured - 1.0

    @property
    def within(self) -> bool | None:
        """Whether that is within the tolerance."""
        return None if self.error is None else abs(self.error) <= self.tolerance


@dataclass(frozen=True)
class Entry:
    """A folder of the atlas."""

    folder: Path
    table: EntryTable

    @classmethod
    def read(cls, folder: Path) -> "Entry":
        """The entry of a folder. Raises StudyError, in one sentence, if its entry.toml is none."""
        path = folder / "entry.toml"
        return cls(folder, validated(EntryTable, read_toml(path, StudyError, "entry"), str(path), StudyError))

    @property
    def name(self) -> str:
        """The name of its folder."""
        return self.folder.name

    @cached_property
    def tests(self) -> pl.DataFrame:
        """Its tests with constants and columns. Raises StudyError, in one sentence, if they cannot be computed."""
        path = self.folder / self.table.tests
        try:
            frame = pl.read_csv(path, comment_prefix="#", infer_schema_length=None)
        except (OSError, PolarsError) as error:
            raise StudyError(as_sentence(f"{path} is no table of tests: {error}")) from None
        if "test" not in frame.columns or frame["test"].is_duplicated().any():
            raise StudyError(f"{path} needs a column test that names each row, every name once.")
        frame = frame.with_columns(pl.col(pl.Int64).exclude("test").cast(pl.Float64), pl.col("test").cast(pl.String))
        frame = frame.filter(self._sql(self.table.taken))
        for name, value in self.table.constants.items():
            fitted = frame if self.table.fitted is None else frame.filter(self._sql(self.table.fitted))
            frame = frame.with_columns(pl.lit(self._evaluated(fitted.select, {name: value})[name][0]).alias(name))
        for name, value in self.table.columns.items():
            frame = self._evaluated(frame.with_columns, {name: value})
        return frame

    @cached_property
    def predictions(self) -> dict[tuple[str, str], float]:
        """What was written down before it was compared, by test and figure."""
        path = self.folder / PREDICTIONS
        if not path.exists():
            return {}
        table = pl.read_csv(path, comment_prefix="#", schema_overrides={"test": pl.String})
        return {(row["test"], row["figure"]): row["predicted"] for row in table.iter_rows(named=True)}

    def rows(self, simulated: Simulated, *, to_predict: bool = False) -> list[Row]:
        """All comparisons; or, of rows that are not fitted, what is to be predicted, without a look at measurements.

        A row that is not fitted is compared once its prediction is written down. A column of the table hides a figure
        of a run of the same name.
        Raises StudyError, in one sentence, if an expression cannot be computed.
        """
        frame, fitted = self.tests, self.table.fitted
        predicted = pl.lit(value=False) if fitted is None else ~self._sql(fitted).fill_null(value=False)
        frame = frame.with_columns(predicted.alias("is_predicted"))
        if to_predict:
            frame = frame.filter("is_predicted")
        figures = pl.DataFrame([simulated(row) for row in frame.iter_rows(named=True)], infer_schema_length=None)
        frame = frame.with_columns(column for column in figures if column.name not in frame.columns)
        return [row for one in self.table.compare for row in self._compared(frame, one, measured=not to_predict)]

    def _compared(self, frame: pl.DataFrame, one: Compared, *, measured: bool) -> list[Row]:
        chosen = frame.filter(self._sql(one.where))
        real = one.measured if measured else "NULL"
        sides = {one.figure: real, "simulated": one.simulated, "published": one.published}
        values = self._evaluated(chosen.select, sides).select(pl.all().cast(pl.Float64, strict=False).fill_nan(None))
        together = values.height == 1 and chosen.height > 1
        rows = []
        for place, (known, simulated, published) in enumerate(values.iter_rows()):
            test = ALL if together else chosen["test"][place]
            written = self.predictions.get((test, one.figure))
            hidden = written is None and not together and chosen["is_predicted"][place]
            figures = None if hidden else known, published, simulated, written, one.tolerance
            rows.append(Row(self.name, test, one.figure, one.unit, *figures))
        return rows

    def _sql(self, text: str | float) -> pl.Expr:
        try:
            return pl.sql_expr(str(text))
        except PolarsError as error:
            raise StudyError(as_sentence(f"{text!r} in {self.folder / 'entry.toml'} is no SQL: {error}")) from None

    def _evaluated(self, taken: Callable[..., pl.DataFrame], expressions: Mapping[str, str | float]) -> pl.DataFrame:
        """What a frame's `select` or `with_columns` gives for expressions by name."""
        try:
            found = taken([self._sql(text).alias(name) for name, text in expressions.items()])
            return found.with_columns(selectors.decimal().cast(pl.Float64))
        except PolarsError as error:
            names, reason = next(iter(expressions)), str(error).splitlines()[0]
            raise StudyError(
                as_sentence(f"{names} in {self.folder / 'entry.toml'} cannot be computed: {reason}")
            ) from None


def read_entries(names: Sequence[str] = (), folder: Path = ENTRIES) -> list[Entry]:
    """The entries of those names, or all. Raises StudyError if there is none of a name, or one cannot be read."""
    known = {path.parent.name: path.parent for path in sorted(folder.glob("*/entry.toml"))}
    if unknown := set(names) - known.keys():
        raise StudyError(f"there is no entry {', '.join(sorted(unknown))}: choose among {', '.join(known)}.")
    return [Entry.read(known[name]) for name in names or known]
