"""Guess of a delimited text's layout from its first lines: encoding, delimiter, decimal sign, header, units."""

import re
import unicodedata
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from geometry.arrays import Array
from wirewear.base import delimited, written_numbers
from wirewear.base.blocks import COLUMNS, blocks_of, is_comment, numbering
from wirewear.base.errors import RecordError
from wirewear.base.naming import KNOWN_UNITS, MISSING, WORDS, encoding_of, usual_unit
from wirewear.base.spreadsheets import UNCOMPUTED, Sheet, left_out, sheet_text, workbook_text
from wirewear.base.units import FIELD_UNITS

FIRST_LINES = 200  #: Lines that are looked at: headers of profilometers and controllers have some eighty.
FEWEST_ALONE = 16  #: Numbers below one another that are a profile's heights, and no notes.


#: What marks a line of names as a comment.
_COMMENT = re.compile(r"^\s*(?:#+|%+|//+|;+)\s*")

_NUMBER = r"[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?"

_NO_UNIT = frozenset(("-", "–", "", "1", "none", "#"))

_RATE = re.compile(
    r"(?:sampl\w*[ _]*(?:rate|freq\w*)|abtast(?:rate|frequenz)|messrate|cadence|"
    r"fr[eé]quence d.[eé]chantillonnage|frecuencia de muestreo)[^\d\n]{0,20}?\[?(k?)(?:Hz)?\]?[^\d\n]{0,6}"
    r"(\d+(?:[.,]\d+)?)(?:\s*(k)Hz)?",
    re.IGNORECASE,
)


_STEP = re.compile(
    r"(?:pitch|step|spacing|interval|paso|passo|\bpas\b|schrittweite|punktabstand|messpunktabstand|间距|间隔)[^\d\n]{0,20}?"
    r"(\d+(?:[.,]\d+)?)[\s;,\"]*\[?(nm|um|µm|μm|mm)\b",
    re.IGNORECASE,
)


class NoTableError(RecordError):
    """A text holds no table of numbers."""


@dataclass(frozen=True)
class GuessedLayout:
    """Guessed layout of a text, with its columns' names (empty if no line names them) and units ("" if unstated)."""

    layout: delimited.DelimitedLayout
    names: tuple[str, ...]
    units: tuple[str, ...]
    width: int = 0  #: Number of fields in a row.
    sample_rate_Hz: float | None = None  #: Sample rate that the header states; None if it states none.
    clocks: bool = False  #: True if a column holds times of day.
    #: Layouts of several tables with the same names, or of one followed by other text; else empty.
    tables: tuple[delimited.DelimitedLayout, ...] = ()
    #: Spacing of points of a line of heights, as the header states it; None if it does not.
    step_um: float | None = None
    words: frozenset[int] = frozenset()  #: Indices of the columns of words.
    remarks: tuple[str, ...] = ()  #: Sentences on blocks and sheets.

    @property
    def plain(self) -> bool:
        """True if a line names the columns, there is a single table, and no column holds times of day."""
        return self.layout.names_line and not self.clocks and len(self.tables) < 2


def guessed_layout(path: Path) -> GuessedLayout:
    """Layout of a text file or spreadsheet with a table of numbers, guessed from its first 200 lines.

    Raises RecordError if the file cannot be read or its numbers are ambiguous, and NoTableError if no table of numbers
    is found.
    """
    data, sheets = delimited.contents_of(path)
    encoding = "utf-8" if sheets else encoding_of(data)
    text = data.decode(encoding, errors="replace").replace("\r\n", "\n").replace("\r", "\n")
    lines = text.split("\n", FIRST_LINES)[:FIRST_LINES]
    found = [_table(lines, delimiter, decimal) for delimiter in ("\t", ";", ",", None) for decimal in (".", ",")]
    best = max(found, key=lambda table: table.score)
    if best.score <= 0:
        best = max((_table(lines, "\t", decimal, 1) for decimal in (".", ",")), key=lambda table: table.score)
    if best.score <= 0:
        raise NoTableError(f"{path}: no table of numbers is found in its first {FIRST_LINES} lines.")
    if in_doubt_of := _thousands_or_fractions(lines[best.first :], best):
        raise RecordError(
            f"{path}: whether {in_doubt_of} is a fraction or a number of thousands is uncertain: save it without signs "
            "between thousands."
        )
    names, names_line, units = _names(lines, best)
    units = _units_in_header(lines[: best.first], best, names) or units
    units = tuple(
        "s" if place in best.clocks else (below or _unit_of_name(name))
        for place, (name, below) in enumerate(zip(names, units, strict=True))
    )
    layout = delimited.DelimitedLayout(
        delimiter=best.delimiter,
        decimal=best.decimal,
        encoding=encoding,
        header_lines=names_line if names else best.first,
        names_line=bool(names),
        lines_after_names=best.first - names_line - 1 if names else 0,
        # LabVIEW names a column of remarks, which most rows lack.
        ragged=names[best.width :] == ("Comment",),
    )
    read = delimited.DelimitedText(path, "\n".join(lines).encode(), layout).names if names else ()
    if read != names or not all(names):
        # Names with blanks between columns that are parted by blanks, or none: numbers name columns.
        layout = delimited.DelimitedLayout(best.delimiter, best.decimal, encoding, best.first, names_line=False)
    rate, tables = _rate(lines[: best.first], best), _tables(text, layout)
    if layout.names_line:
        first = replace(layout, header_lines=lines.index(lines[layout.header_lines]))
        if delimited.repeated_heads(text.split("\n"), first):
            layout, tables = first, ()
    step = _STEP.search("\n".join(lines[: best.first]))
    step_um = float(step[1].replace(",", ".")) * FIELD_UNITS["um"][step[2]] if step else None
    guessed = GuessedLayout(layout, names, units, best.width, rate, bool(best.clocks), tables, step_um, best.words)
    return _of_blocks(path, guessed, workbook_text(sheets).decode() if len(sheets) > 1 else text, sheets)


def _of_blocks(path: Path, guessed: GuessedLayout, text: str, sheets: list[Sheet]) -> GuessedLayout:
    """Layout extended to all numbered blocks of a text, or sheets with the same column names, with remarks on them."""
    layout, lines = guessed.layout, text.split("\n")
    own = sheet_text(sheets).decode().split("\n") if sheets else lines
    name = own[layout.header_lines] if layout.header_lines < len(own) else ""
    head = lines.index(name) if name in lines else layout.header_lines
    wanted = layout.names_line and (len(sheets) > 1 or WORDS.search(text, _place(text, layout.lines_before_rows)))
    labels, _ = blocks_of(lines, head) if wanted else ([], [])
    if numbers := numbering(labels):
        layout = replace(layout, blocks=True, header_lines=head)
        names, units = (*guessed.names[: guessed.width], *COLUMNS.values()), (*guessed.units[: guessed.width], "", "")
        what = " and ".join(f"{key}s {', '.join(map(str, counts))}" for key, counts in numbers.items())
        remarks = [f"{path.name}: {len(labels)} {'sheets' if sheets else 'blocks'} are read, as {what}"]
        guessed = replace(guessed, layout=layout, names=names, units=units, width=len(names), tables=())
    else:
        remarks = []
    return replace(guessed, remarks=(*remarks, *left_out(path, sheets, name if numbers else None)))


def _place(text: str, lines: int) -> int:
    """Index of the character behind this number of lines."""
    place = 0
    for _ in range(lines):
        place = text.find("\n", place) + 1
    return place


def _tables(text: str, layout: delimited.DelimitedLayout) -> tuple[delimited.DelimitedLayout, ...]:
    """Layouts of the tables in a text that continues behind the first table; empty if it does not.

    The rest must repeat the line of names, or hold nothing but lines of words.
    """
    head, start = layout.header_lines, layout.lines_before_rows
    starts = [0, *(match.end() for match in re.finditer("\n", text))]
    if start >= len(starts) or WORDS.match(text, starts[start]) or not (end := WORDS.search(text, starts[start])):
        return ()
    lines = text.split("\n")
    again = [place for place in range(start, len(lines)) if layout.names_line and lines[place] == lines[head]]
    if not again and any(line.strip() and not WORDS.match(line) for line in text[end.start() :].split("\n")):
        return ()
    found = []
    for place in (head, *again):
        first = place + start - head
        end = WORDS.search(text, starts[first]) if first < len(starts) else None
        last = len(lines) if end is None else bisect_left(starts, end.start())
        while last > first and not lines[last - 1].strip():
            last -= 1
        if last > first:
            found.append(replace(layout, header_lines=place, most_rows=last - first))
    return tuple(found)


def _thousands_or_fractions(lines: list[str], table: "_Table") -> str:
    """First number that may be read as thousands or as a fraction, if no number of the table settles it; else ""."""
    rows = [delimited.fields_of(line, table.delimiter) for line in lines if line.strip()]
    signed = [field for row in rows for field in row if table.decimal in field]
    if not signed or not all(map(written_numbers.in_doubt, signed)):
        return ""
    places = (own for own in zip(*rows, strict=False) if any(field.isdecimal() for field in own))
    return next((field for own in places for field in own if table.decimal in field), "")


@dataclass(frozen=True)
class _Table:
    delimiter: str | None
    decimal: str
    first: int = 0
    width: int = 0
    score: float = 0.0
    clocks: frozenset[int] = frozenset()
    words: frozenset[int] = frozenset()


def _table(lines: list[str], delimiter: str | None, decimal: str, least: int = 2) -> _Table:
    """Longest run of similar lines with at least `least` numbers each, read with this delimiter and decimal sign."""
    if delimiter == decimal and not any('"' in line for line in lines):
        return _Table(delimiter, decimal)
    number = re.compile(_NUMBER.replace("[.,]", re.escape(decimal)) + r"(?:\s?[kKM])?")  # 5k cycles
    best, run, profile, strange = _Table(delimiter, decimal), list[int](), "", 0
    for place, line in enumerate([*lines, "end"]):
        if run and (not line.strip() or is_comment(line)):
            continue
        kinds = "".join(
            _kind(written_numbers.ungrouped(field, decimal), number) for field in delimited.fields_of(line, delimiter)
        ).rstrip(" ")
        between = kinds == "t" and len(profile) > 1 and place < len(lines) and not re.search(r"[\t;,]", line)
        if run and strange < FEWEST_ALONE and (between or _has_a_word(profile, kinds)):
            # If numbers go on below it, it is a row, or a word between rows: reading it names it.
            strange += 1
            continue
        strange = 0
        if kinds.count("n") + kinds.count("c") < least or "n" not in kinds:
            kinds = ""
        joined = _joined(profile, kinds)
        if run and joined is None:
            best = max(best, _run(lines, run, profile, _Table(delimiter, decimal)), key=lambda table: table.score)
            run, joined = [], kinds
        profile = joined or kinds
        if kinds:
            run.append(place)
    return best


def _kind(field: str, number: re.Pattern[str]) -> str:
    if not field or MISSING.fullmatch(field):
        return " "
    if number.fullmatch(field) or field == UNCOMPUTED:
        return "n"
    return "c" if written_numbers.is_clock(field) else "t"


def _has_a_word(profile: str, kinds: str) -> bool:
    """True if a line is like the table's rows but has a word in place of some numbers."""
    pairs = set(zip(profile, kinds, strict=False))
    odd = {(one, other) for one, other in pairs if one != other and " " not in (one, other)}
    return len(profile) == len(kinds) and ("n", "n") in pairs and bool(odd) and odd <= {("n", "t"), ("c", "t")}


def _joined(profile: str, kinds: str) -> str | None:
    """Common kinds of field of two lines ("n" number, "c" clock, "t" text); None if they cannot be rows of one
    table.
    """
    if not profile or not kinds or abs(len(profile) - len(kinds)) > 1:
        return None
    short, long = sorted((profile, kinds), key=len)
    pairs = list(zip(short.ljust(len(long)), long, strict=True))
    if any(" " not in pair and pair[0] != pair[1] for pair in pairs):
        return None
    return "".join(a if b == " " else b for a, b in pairs)


def _run(lines: list[str], rows: list[int], profile: str, spelled: _Table) -> _Table:
    # Of readings that explain as many lines, that with more decimal fractions is likelier than that with more columns.
    fields = [delimited.fields_of(lines[place], spelled.delimiter) for place in rows[:5]]
    fractions = sum(spelled.decimal in field for row in fields for field in row)
    score = len(rows) * (1.0 - profile.count("t") / len(profile)) + 0.01 * min(fractions, 50)
    score += 0.5 if spelled.delimiter else 0.0
    if len(profile) == 1 and len(rows) < FEWEST_ALONE:
        score = 0.0
    if (spelled.delimiter, spelled.decimal) == (",", ".") and _are_halves(lines, rows):
        score = 0.0
    clocks, words = (frozenset(place for place, kind in enumerate(profile) if kind == own) for own in "ct")
    return _Table(spelled.delimiter, spelled.decimal, rows[0], len(profile), score, clocks, words)


def _are_halves(lines: list[str], rows: list[int]) -> bool:
    """True if each row's two whole numbers are the halves of one number with a decimal comma, such as ``0,0123``."""
    halves = [delimited.fields_of(lines[place], ",") for place in rows]
    whole = all(len(own) == 2 and re.fullmatch(r"-?\d+", own[0]) and own[1].isdecimal() for own in halves)
    return whole and any(re.match(r"0\d", own[1]) for own in halves)


def _names(lines: list[str], table: _Table) -> tuple[tuple[str, ...], int, tuple[str, ...]]:
    """Column names, the index of their line, and the units in the line below; () and 0 if no line names the columns."""
    candidates = []
    # Lines that may stand between the names of the columns and the numbers: units, a blank one, a word such as DATA.
    for place in range(table.first - 1, max(table.first - 2 - 4, -1), -1):
        fields = _named_fields(lines[place], table)
        named = any(re.search(r"[^\W\d_]", field) for field in fields) or _are_units(fields)
        if fields and named:
            candidates.append((place, fields))
        elif lines[place].strip() and (candidates or len(delimited.fields_of(lines[place], table.delimiter)) > 1):
            break
        if len(candidates) == 2:
            break
    if not candidates:
        return (), 0, ()
    place, fields = candidates[0]
    units: list[str] = []
    if len(candidates) > 1 and _are_units(fields):
        units = [usual_unit(unit.strip("[]() ")) for unit in fields]
        place, fields = candidates[1]
    units = [*units, *[""] * len(fields)][: len(fields)]
    return tuple(fields), place, tuple("" if unit in _NO_UNIT else unit for unit in units)


def _named_fields(line: str, table: _Table) -> list[str]:
    """Fields of a line that may name the table's columns; empty if they are too few."""
    line = _COMMENT.sub("", line) if table.delimiter is None else line
    fields = delimited.fields_of(line, table.delimiter)
    if table.delimiter is None and len(fields) != table.width:
        spaced = [re.split(r"\t+|\s{2,}", line.strip()), re.findall(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?", line)]
        fields = next((one for one in spaced if len(one) == table.width), [])
    # Units of the last columns may be left out.
    return fields if len(fields) >= table.width or (len(fields) > 1 and _are_units(fields)) else []


def _are_units(fields: list[str]) -> bool:
    """True if the fields are units: at most 12 characters each, and more than half of them known."""
    bare = [usual_unit(field.strip("[]() ")) for field in fields]
    stated = [unit for unit in bare if unit not in _NO_UNIT]
    known = sum(unit in KNOWN_UNITS for unit in stated)
    return any(fields) and all(len(unit) <= 12 for unit in stated) and (2 * known > len(stated) or not stated)


def _units_in_header(header: list[str], table: _Table, names: tuple[str, ...]) -> tuple[str, ...]:
    """Units of LabVIEW's channels as a header line states them, with s for their times; empty if there is no
    such line.
    """
    labels = next(
        (delimited.fields_of(line, table.delimiter)[1:] for line in header if line.startswith("Y_Unit_Label")), None
    )
    if labels is None:
        return ()
    left = iter(labels)
    return tuple("s" if name == "X_Value" else "" if name == "Comment" else next(left, "") for name in names)


def _unit_of_name(name: str) -> str:
    name = unicodedata.normalize("NFKC", name)
    match = re.search(r"[\[(]\s*([^\s\[\]()]+)\s*[\])]\s*$", name) or re.search(r"[_\s/]([^\s_/]+)$", name)
    unit = usual_unit(match[1]) if match else ""
    return unit if unit in KNOWN_UNITS else ""


def _rate(header: list[str], table: _Table) -> float | None:
    for line in header:
        fields = delimited.fields_of(line, table.delimiter)
        if fields[0] == "Delta_X" and len(fields) > 1:
            step = float(fields[1].replace(",", "."))
            return 1.0 / step if step > 0.0 else None
        if found := _RATE.search(line):
            kilo = 1e3 if found[1] or found[3] else 1.0
            return kilo * float(found[2].replace(",", "."))
    return None


def known_columns(file: Path, names: Sequence[str]) -> dict[str, Array]:
    """Columns (n,) of a text file by name, for those of `names` that it has. Raises RecordError if unreadable."""
    text = delimited.read_delimited(file, guessed_layout(file).layout)
    places: dict[str, int] = {name: text.names.index(name) for name in names if name in text.names}
    return text.numbers(places).columns if places else {}
