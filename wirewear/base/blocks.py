"""Blocks of one text: tables below one another, each numbered by words above it such as "Cycle 5000" or "Test 2"."""

import re
from collections.abc import Sequence

from wirewear.base.naming import MISSING, USUAL_NAMES, WORDS, plain
from wirewear.base.spreadsheets import SHEET

#: Words that number a file, a block or a sheet, besides the usual names of columns.
NUMBER_WORDS = {
    "cycle": ("cycle", "cyc", "zyklus", "zykl", "lastspiel", "n", "c"),
    "repeat": ("repeat", "rep", "test", "run", "versuch", "wiederholung", "probe", "specimen", "r", "t"),
}

#: Columns that the rows of blocks have behind their own.
COLUMNS = {"cycle": "cycle of block", "repeat": "repeat of block"}

#: How a line begins that is a comment, and how one that is a comment if it is no row.
_COMMENT, _PERHAPS = re.compile(r"\s*(?:!|%|//|#\s)"), re.compile(r"\s*[#;*]")

_WORD = re.compile(r"[^\W\d_]{2}")

_COUNT = r"(\d+(?:[,.'’ \xa0\u202f]\d{3})*(?:[.,]\d+)?(?:e\+?\d+|\s*[x×·*]\s*10\s?\^?\d+)?)\s*(k|mio|m)?"
_THOUSANDS = re.compile(_COUNT)  #: "5k", which needs no word beside it.


def _patterns(key: str) -> tuple[re.Pattern[str], re.Pattern[str]]:
    words = sorted({*map(plain, NUMBER_WORDS[key]), *USUAL_NAMES[key]}, key=len, reverse=True)
    word = "|".join(re.escape(own).replace("_", r"[\s_.\-]*") for own in words)
    between = r"[\s_:=#.,;|\-]*(?:n\.?o|nr|number|nummer|num|numero)?[\s_:=#.,;|°º\-]*"
    return (
        re.compile(rf"(?<![^\W\d_])(?:{word}){between}(?<!\d)(?<!\d[.,]){_COUNT}(?![^\W\d_])"),
        re.compile(rf"(?<![\w.,]){_COUNT}[\s_.\-]*(?:st|nd|rd|th)?[\s_.\-]*(?:{word})(?![^\W_])"),
    )


_COUNTS = {key: _patterns(key) for key in NUMBER_WORDS}


def counts_in(labels: Sequence[str], key: str) -> list[int] | None:
    """Number of cycles or of repeats that each label states in words, one for each label; key: "cycle" or "repeat".

    None if a label states no whole number, or if every number may be read both as thousands and as a fraction: ``"Cycle
    1.000"``.
    """
    found = []
    for label in labels:
        text = plain(label)
        matches = [match for pattern in _COUNTS[key] for match in pattern.finditer(text)]
        matches = matches or [match for match in [_THOUSANDS.fullmatch(text)] if match and match[2]]
        if not matches:
            return None
        # What stands nearest to the numbers is of them.
        last = max(matches, key=lambda match: match.end())
        found.append((last[1], last[2]))
    doubtful = [re.fullmatch(r"\d{1,3}[.,]\d{3}", number) is not None for number, _ in found]
    if found and all(doubtful):
        return None
    counts = [_count(number, unit) for number, unit in found]
    whole = [int(count) for count in counts if count is not None and count == int(count)]
    return whole if len(whole) == len(labels) else None


def _count(number: str, unit: str | None) -> float | None:
    number = re.sub(r"[,.'’ \xa0\u202f](?=\d{3}(?:\D|$))", "", number).replace(",", ".")
    number = re.sub(r"\s*[x×·*]\s*10\s?\^?", "e", number)
    try:
        return float(number) * {"k": 1e3, "m": 1e6, "mio": 1e6}.get(unit or "", 1.0)
    except ValueError:
        return None


def blocks_of(lines: Sequence[str], head: int) -> tuple[list[str], list[range]]:
    """Words above each table of a text, joined, and the range of its rows' line indices, which may include blank lines;
    one of each for every table.

    head: index of the line of column names. It may be repeated above each table; in a text of several sheets it must
    be, and the sheet's title comes last in the words.
    """
    labels, blocks = list[str](), list[range]()
    names, title, words, begin, named = lines[head].strip(), "", list[str](), -1, True
    for place, line in enumerate([*lines, "end"]):
        text = line.strip()
        if not text or (begin >= 0 and is_row(line)):
            continue
        if begin >= 0:
            blocks.append(range(begin, place))
            words, begin = [], -1
        if text.startswith(SHEET):
            title, words, named = text.removeprefix(SHEET), [], False
        elif text == names:
            named = True
        elif place > head and named and is_row(line):
            labels.append(" ".join([*words, title]))
            begin = place
        else:
            words.append(text)
    return labels, blocks


def is_row(line: str) -> bool:
    """True if a line holds at least two numbers, or words for missing ones, and does not begin with any other word."""
    fields = re.split(r"[\t;,]\s*|\s+", line.strip())
    numbers = (re.match(r"\"?[-+]?\.?\d", field) or MISSING.fullmatch(field) for field in fields)
    return not WORDS.match(line) and sum(found is not None for found in numbers) > 1


def is_comment(line: str) -> bool:
    """True if a line among rows is a comment: it begins with a comment sign and does not just lack its first value."""
    if _COMMENT.match(line) or not _PERHAPS.match(line):
        return _COMMENT.match(line) is not None
    first, *others = re.split(r"[\t;,]\s*|\s+", line.strip())
    numbers = sum(re.match(r"\"?[-+]?\.?\d", field) is not None for field in others)
    if not first:
        return numbers < 2 and any(_WORD.search(field) and not MISSING.fullmatch(field) for field in others)
    return not numbers or not MISSING.fullmatch(first)


def numbering(labels: Sequence[str]) -> dict[str, list[int]]:
    """Numbers of several blocks by their labels, in order: {"cycle": ..., "repeat": ...}, each only if every label
    states it.

    Empty if there is only one block, or if two blocks would have the same numbers.
    """
    stated = {key: counts_in(labels, key) for key in NUMBER_WORDS}
    known = {key: counts for key, counts in stated.items() if counts is not None}
    pairs = set(zip(*known.values(), strict=True))
    return known if len(labels) > 1 and len(pairs) == len(labels) else {}


def numbered(lines: Sequence[str], head: int, delimiter: str | None) -> list[str]:
    """The lines of a text, each row with its block's cycle and repeat appended; lines outside blocks become blank, so
    that their number stays.

    head: index of the line of names, which gets the names of the two new columns. delimiter: None for white space.
    """
    labels, blocks = blocks_of(lines, head)
    numbers, sign = numbering(labels), delimiter or " "
    found, width = [""] * len(lines), len(lines[head].split(delimiter))
    found[head] = sign.join([lines[head].rstrip(), *COLUMNS.values()])
    for number, block in enumerate(blocks):
        own = sign.join("" if key not in numbers else str(numbers[key][number]) for key in COLUMNS)
        for place in block:
            if line := lines[place].rstrip():
                short = max(width - len(line.split(delimiter)), 0)
                found[place] = sign.join([line, *[""] * short, own])
    return found
