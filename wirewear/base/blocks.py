"""Tables below one another that words such as "Cycle 5000" number, by cycle or by repeat."""

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
    """The numbers of cycles or of repeats that labels state in words; None where one of them states none, or all of
    them may be thousands or fractions of three digits: ``"Cycle 1.000"``.

    key: "cycle" or "repeat".
    """
    found = []
    for label in labels:
        text = plain(label)
        matches = [match for pattern in _COUNTS[key] for match in pattern.finditer(text)]
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
    """What the words above each table say, the nearest last, and the places of its lines, some of them perhaps blank.

    The names of columns stand at `head`, and may stand again above each table; those of a sheet must, whose title is
    nearest.
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
    """Whether a line has two numbers at least, and begins with no word but one for what is missing."""
    fields = re.split(r"[\t;,]\s*|\s+", line.strip())
    numbers = (re.match(r"\"?[-+]?\.?\d", field) or MISSING.fullmatch(field) for field in fields)
    return not WORDS.match(line) and sum(found is not None for found in numbers) > 1


def is_comment(line: str) -> bool:
    """Whether a line among rows is a comment: its first sign says so, and it has no numbers behind a missing one."""
    if _COMMENT.match(line) or not _PERHAPS.match(line):
        return _COMMENT.match(line) is not None
    first, *others = re.split(r"[\t;,]\s*|\s+", line.strip())
    numbers = sum(re.match(r"\"?[-+]?\.?\d", field) is not None for field in others)
    if not first:
        return numbers < 2 and any(_WORD.search(field) and not MISSING.fullmatch(field) for field in others)
    return not numbers or not MISSING.fullmatch(first)


def numbering(labels: Sequence[str]) -> dict[str, list[int]]:
    """The numbers of cycles and of repeats of several blocks, as far as all labels state them; none where two blocks
    would be alike.
    """
    stated = {key: counts_in(labels, key) for key in NUMBER_WORDS}
    known = {key: counts for key, counts in stated.items() if counts is not None}
    pairs = set(zip(*known.values(), strict=True))
    return known if len(labels) > 1 and len(pairs) == len(labels) else {}


def numbered(lines: Sequence[str], head: int, delimiter: str | None) -> list[str]:
    """As many lines: rows of all blocks have their numbers behind them, below the names at `head`; others are blank."""
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
