"""Files that a mapping names, and their columns in the record's units."""

import re
import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from threading import current_thread, main_thread

import numpy as np

from geometry.arrays import Array
from wirewear.base.blocks import NUMBER_WORDS
from wirewear.base.delimited import DelimitedLayout
from wirewear.base.errors import RecordError
from wirewear.base.files import DELIMITERS, require_within
from wirewear.records.importing.loggers import kind_of, readers
from wirewear.records.importing.mapping import PROFILOMETER, ColumnMapping, Source, unit_factor
from wirewear.records.importing.text_reader import TextReader
from wirewear.records.reading import RECORD_COLUMNS
from wirewear.test.keys import Table

PATTERN_s = 2.0  #: A pattern that needs longer for a file's name would need for ever.

Wanted = Mapping[str, ColumnMapping]


def files_of(source: Source, home: Path) -> list[Path]:
    """Files that a source names, each once; names are relative to `home`, matches of a pattern in natural order (2
    before 10). Raises RecordError if a name or pattern matches no file.
    """
    found: list[Path] = []
    for name in source.files:
        try:
            matches = [home / name] if (home / name).is_file() else [p for p in home.glob(name) if p.is_file()]
        except (ValueError, NotImplementedError, OSError):
            matches = []
        if not matches:
            raise RecordError(f"there is no file {home / name}.")
        for path in matches:
            require_within(path, home, RecordError, "the file")
        found += sorted(matches, key=_natural)
    return list(dict.fromkeys(found))


def file_of(column: ColumnMapping, path: Path) -> Path:
    """File of a column: the one that it names, beside the source's file `path`, or else `path`. Raises RecordError if
    the one named does not exist, is not an ordinary file, or lies outside the folder of `path`.
    """
    if column.file is None:
        return path
    own = path.parent / column.file
    require_within(own, path.parent, RecordError, "the file")
    if not own.is_file():
        raise RecordError(f"{own} is no ordinary file." if own.exists() else f"there is no file {own}.")
    return own


def _natural(path: Path) -> list[tuple[int, str]]:
    return [(int(digits or 0), text) for text, digits in re.findall(r"(\D+)(\d*)|$", path.name)]


def numbers_in_name(path: Path, source: Source) -> dict[str, int]:
    """Cycle and repeat in a file's name by the source's pattern, by key; empty without a pattern. Raises RecordError if
    the name does not match it.
    """
    if source.name_pattern is None:
        return {}
    try:
        with within(PATTERN_s):
            found = re.search(source.name_pattern, path.name)
    except TimeoutError:
        raise RecordError(
            f"{path}: name_pattern = {source.name_pattern!r} takes too long on the file's name: repeat nothing that "
            "is repeated already."
        ) from None
    if found is None:
        raise RecordError(f"{path}: the file's name does not fit name_pattern = {source.name_pattern!r}.")
    try:
        return {key: int(value) for key, value in found.groupdict().items() if value is not None}
    except ValueError:
        raise RecordError(f"{path}: name_pattern finds {found.groupdict()}, which are no whole numbers.") from None


def read_source(path: Path, source: Source, wanted: Wanted, length_mm: float | None = None) -> dict[str, Array]:
    """Wanted columns of one file by name in the record's units: (n,), or matrices as `Reader.columns` gives them.

    length_mm: of a line contact, whose forces and energies may be given per millimetre; None for contacts at a point.
    Raises RecordError if the file cannot be read, lacks a column or holds text for a number.
    """
    factors = {}
    for name, mapping in wanted.items():
        try:
            factors[name] = unit_factor(name, mapping, length_mm)
        except ValueError as problem:
            raise RecordError(f"{path}: {problem}.") from None
    if any(own.file for own in wanted.values()) and (len(source.files) > 1 or re.search(r"[*?\[]", source.files[0])):
        raise RecordError(f"{path}: a column with a file of its own goes with one file, not with several.")
    raw: dict[str, Array] = {}
    files = {name: file_of(own, path) for name, own in wanted.items()}
    for file in dict.fromkeys(files.values()):
        # What a file is, it says itself: "text" stands there when nothing else was chosen.
        kind = kind_of(file) if source.kind == TextReader.kind else source.kind
        columns = {name: own.column for name, own in wanted.items() if files[name] == file}
        raw |= readers()[kind].columns(file, layout_of(source), columns)
    return {name: factors[name] * values + wanted[name].offset for name, values in raw.items()}


def layout_of(source: Source) -> DelimitedLayout:
    """How the texts of a source are spelled (delimiter, decimal sign, encoding, lines of the header), for readers of
    columns.
    """
    return DelimitedLayout(
        delimiter=DELIMITERS[source.delimiter],
        decimal=source.decimal,
        encoding=source.encoding,
        header_lines=source.header_lines,
        names_line=source.names_line,
        lines_after_names=source.lines_after_names,
        most_rows=source.rows,
        blocks=source.blocks,
    )


def wanted_columns(columns: Table) -> dict[str, ColumnMapping]:
    """Columns that a mapping gives in a table such as `LoopColumns`, by the record's column name."""
    return {name: getattr(columns, name) for name in type(columns).model_fields if getattr(columns, name) is not None}


def equal_rows(file: Path, columns: dict[str, Array], first: str) -> dict[str, Array]:
    """The columns, each flattened to (n,). Raises RecordError, whose message begins with `file`, if one has another
    number of values than the column `first`.
    """
    count = columns[first].size
    for name, values in columns.items():
        if values.size != count:
            raise RecordError(f"{file}: {name} has {values.size} values where {first} has {count}.")
    return {name: values.ravel() for name, values in columns.items()}


def columns_of_levels(
    file: Path, source: Source, columns: Table | None, table: str, repeat: int, step_um: float | None = None
) -> tuple[str, dict[str, Array]]:
    """The key that a file of worn surfaces gives, depth_um or height_um, and its columns (n,) by name, "repeat" among
    them.

    columns, table: the columns' mapping, and the name of its table for messages. repeat: for files without a column of
    repeats. step_um: spacing of rows, if there is no column of positions. Raises RecordError if the mapping gives no
    columns, or not exactly one of both keys, or columns do not fit together.
    """
    if columns is None:
        raise RecordError(f'{file}: [{table}] must give columns, or kind = "{PROFILOMETER}".')
    given = [key for key in ("depth_um", "height_um") if getattr(columns, key) is not None]
    if len(given) != 1:
        raise RecordError(f"{file}: [{table}.columns] must give either depth_um or height_um.")
    read = equal_rows(file, read_source(file, source, wanted_columns(columns)), given[0])
    if "x_um" not in read:
        if step_um is None:
            raise RecordError(f"{file}: [{table}] must give x_um among its columns, or step_um.")
        read["x_um"] = step_um * np.arange(float(read[given[0]].size))
    repeats = read.get("repeat", np.full(read["x_um"].size, float(repeat)))
    read |= {"repeat": repeats}
    require_recorded(file, **read)
    return given[0], read


def require_recorded(file: Path, **columns: Array) -> None:
    """Raise RecordError if a column holds a value that a record's column of its name may not have; unknown names
    pass.
    """
    for name, values in columns.items():
        column = RECORD_COLUMNS.get(name)
        place = None if column is None else column.first_wrong(values)
        if column is not None and place is not None:
            lacking = f"missing in {np.isnan(values).sum()} of {values.size} rows"
            found = lacking if np.isnan(values[place]) else f"{values[place]:g}"
            raise RecordError(f"{file}: {name} is {found}, but must be {column.kind}.")


def name_pattern(names: Sequence[str], *, has_cycle: bool) -> str | None:
    """Regular expression for the numbers, cycle and repeat, in which file names differ; None for a single name.

    has_cycle: True if a column counts the cycles, so that only the repeat is looked for. Raises RecordError if the
    names differ by more than numbers.
    """
    if len(names) < 2:
        return None
    parts = [re.split(r"(\d+)", name) for name in names]
    if len({len(part) for part in parts}) != 1 or len({tuple(part[::2]) for part in parts}) != 1:
        raise RecordError(
            f"the files' names, such as {names[0]!r} and {names[1]!r}, differ by more than numbers: give those of one "
            "kind, or write a name_pattern."
        )
    pattern, left = "", ["repeat"] if has_cycle else ["cycle", "repeat"]
    for place, part in enumerate(parts[0]):
        differs = len({own[place] for own in parts}) > 1
        if place % 2 == 0 or not differs or not left:
            pattern += re.escape(part)
            continue
        before = re.sub(r"[^a-zäöü]", " ", parts[0][place - 1].lower()).split()
        word = before[-1] if before else ""
        key = next((key for key in left if word in NUMBER_WORDS[key]), left[0])
        left.remove(key)
        pattern += rf"(?P<{key}>\d+)"
    return pattern


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Context that raises TimeoutError in its work after this much processor time in s; without effect outside the main
    thread. Processor time counts, so that a busy machine does not cut work short; signals reach the main thread only.
    """
    if current_thread() is not main_thread():
        yield
        return

    def late(_number: int, _frame: object) -> None:
        raise TimeoutError

    before = signal.signal(signal.SIGVTALRM, late)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)
