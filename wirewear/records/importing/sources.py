"""The files that a mapping names, and their columns in the record's units."""

import re
from collections.abc import Mapping
from pathlib import Path

from wirewear.base.delimited import DelimitedLayout
from wirewear.base.errors import RecordError
from wirewear.base.processes import within
from wirewear.base.reading import DELIMITERS, require_within
from wirewear.records.importing.mapping import ColumnMapping, Source, unit_factor
from wirewear.records.importing.registry import kind_of, readers
from wirewear.records.importing.text import TextReader
from wirewear.records.values import Array

#: A pattern that needs longer for a file's name would need for ever.
PATTERN_s = 2.0

Wanted = Mapping[str, ColumnMapping]


def files_of(source: Source, home: Path) -> list[Path]:
    """The files that a source names, each once, patterns in natural order (2 before 10).

    Raises:
        RecordError: there is none.
    """
    found: list[Path] = []
    for name in source.files:
        try:
            matches = [home / name] if (home / name).is_file() else [p for p in home.glob(name) if p.is_file()]
        except (ValueError, NotImplementedError, OSError):
            matches = []
        for path in matches:
            require_within(path, home, RecordError, "the file")
        if not matches:
            raise RecordError(f"there is no file {home / name}.")
        found += sorted(matches, key=_natural)
    return list(dict.fromkeys(found))


def _natural(path: Path) -> list[tuple[int, str]]:
    return [(int(digits or 0), text) for text, digits in re.findall(r"(\D+)(\d*)|$", path.name)]


def numbers_in_name(path: Path, source: Source) -> dict[str, int]:
    """Cycle and repeat as the file's name tells them.

    Raises:
        RecordError: the name does not fit the pattern.
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
    """The wanted columns of one file in the record's units: (n,), or from MATLAB (samples, cycles).

    length_mm: of a line contact, whose forces and energies may be given per millimetre.

    Raises:
        RecordError: the file cannot be read, lacks a column or holds text for a number.
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
    for file in dict.fromkeys(own.file for own in wanted.values()):
        own_path = path if file is None else path.parent / file
        # What a file is, it says itself: "text" stands there when nothing else was chosen.
        kind = kind_of(own_path) if source.kind == TextReader.kind else source.kind
        columns = {name: own.column for name, own in wanted.items() if own.file == file}
        raw |= readers()[kind].columns(own_path, _layout(source), columns)
    return {name: factors[name] * values + wanted[name].offset for name, values in raw.items()}


def _layout(source: Source) -> DelimitedLayout:
    return DelimitedLayout(
        delimiter=DELIMITERS[source.delimiter],
        decimal=source.decimal,
        encoding=source.encoding,
        header_lines=source.header_lines,
        names_line=source.names_line,
        lines_after_names=source.lines_after_names,
        most_rows=source.rows,
    )
