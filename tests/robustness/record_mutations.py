"""Mutations of an experiment record, each drawn at random; what it returns says how reading must end.

Some keep the meaning (columns or rows in another order, other line ends, blank lines, a byte order mark): "same".
Others destroy it (text for a number, a duplicated cycle, a missing column): "refused".
"""

from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Literal

RECORD = Path(__file__).parents[2] / "studies" / "steel_wires" / "example_records" / "no_gap"

Files = dict[str, bytes]
Expected = Literal["same", "refused"]
Mutation = Callable[[Files, Random], Expected]


def small_record() -> Files:
    """Two repeats and two cycles of an example record, every second sample, and a coarse scar map."""
    files = {path.name: path.read_bytes() for path in sorted(RECORD.iterdir())}
    keeps: dict[str, Callable[[list[str]], bool]] = {
        "loops.csv": lambda f: f[1] in ("100", "100000") and int(f[2]) % 4 == 0,
        "evolution.csv": lambda _: True,
        "scar_moving.csv": lambda f: float(f[1]) % 40 == 20 and float(f[2]) % 30 == 0,
        "scar_fixed.csv": lambda f: float(f[1]) % 30 == 20 and float(f[2]) % 30 == 0,
    }
    for name, keep in keeps.items():
        header, *lines = files[name].decode().splitlines()
        kept = [line for line in lines if line[0] != "3" and keep(line.split(","))]
        files[name] = "\n".join([header, *kept, ""]).encode()
    return files


def _csv(files: Files, random: Random) -> str:
    return random.choice([name for name in files if name.endswith(".csv")])


def _cells(data: bytes) -> list[list[str]]:
    return [line.split(",") for line in data.decode().splitlines()]


def _joined(cells: list[list[str]]) -> bytes:
    return "\n".join([*(",".join(row) for row in cells), ""]).encode()


def _required_places(name: str, cells: list[list[str]]) -> list[int]:
    """Columns that the format requires."""
    return [place for place, column in enumerate(cells[0]) if column != "normal_force_N" or name != "loops.csv"]


def _set_cell(files: Files, random: Random, text: str) -> None:
    name = _csv(files, random)
    cells = _cells(files[name])
    cells[random.randrange(1, len(cells))][random.randrange(len(cells[0]))] = text
    files[name] = _joined(cells)


def text_for_number(files: Files, random: Random) -> Expected:
    """A word where a number should stand."""
    _set_cell(files, random, random.choice(["abc", "1.2.3", "1;2", "--", "#N/A", "0x1F", "1_000", "µ", "True", "1e"]))
    return "refused"


def huge_number(files: Files, random: Random) -> Expected:
    """A number that no sensor gives."""
    _set_cell(files, random, random.choice(["1e30", "-1e300", "1e999", "inf", "-inf", "9" * 400]))
    return "refused"


def missing_column(files: Files, random: Random) -> Expected:
    """A required column is gone."""
    name = _csv(files, random)
    cells = _cells(files[name])
    place = random.choice(_required_places(name, cells))
    files[name] = _joined([row[:place] + row[place + 1 :] for row in cells])
    return "refused"


def misnamed_column(files: Files, random: Random) -> Expected:
    """A required column has another name."""
    name = _csv(files, random)
    cells = _cells(files[name])
    place = random.choice(_required_places(name, cells))
    cells[0][place] = str(
        random.choice(["", "x", cells[0][place].upper() + "!", cells[0][place - 1], "displacement_mm"])
    )
    files[name] = _joined(cells)
    return "refused"


def reordered_columns(files: Files, random: Random) -> Expected:
    """Columns in another order, and one more."""
    name = _csv(files, random)
    cells = _cells(files[name])
    order = random.sample(range(len(cells[0])), len(cells[0]))
    extra = ["remark", *["text"] * (len(cells) - 1)]
    files[name] = _joined([[row[i] for i in order] + [more] for row, more in zip(cells, extra, strict=True)])
    return "same"


def reordered_rows(files: Files, random: Random) -> Expected:
    """Rows in another order."""
    name = _csv(files, random)
    header, *rows = _cells(files[name])
    files[name] = _joined([header, *(rows[i] for i in random.sample(range(len(rows)), len(rows)))])
    return "same"


def other_spelling(files: Files, random: Random) -> Expected:
    """Other line ends, blank lines, a byte order mark, quotes, spaces."""
    name = _csv(files, random)
    data = files[name]
    match random.randrange(5):
        case 0:
            data = data.replace(b"\n", b"\r\n")
        case 1:
            data = data.replace(b"\n", b"\n\n")
        case 2:
            data = b"\xef\xbb\xbf" + data
        case 3:
            data = data.replace(b",", b'","').replace(b"\n", b'"\n"')[:-1]
            data = b'"' + data
        case _:
            data = data.replace(b",", b", ").rstrip(b"\n")
    files[name] = data
    return "same"


def ragged_line(files: Files, random: Random) -> Expected:
    """A line with a field too many or too few."""
    name = _csv(files, random)
    cells = _cells(files[name])
    row = cells[random.randrange(1, len(cells))]
    if random.random() < 0.5:
        row.append("1")
    else:
        del row[random.randrange(len(row))]
    files[name] = _joined(cells)
    return "refused"


def duplicated_cycle(files: Files, random: Random) -> Expected:
    """The rows of one group stand there twice."""
    name = _csv(files, random)
    header, *rows = _cells(files[name])
    group = rows[random.randrange(len(rows))][:2]
    again = [row for row in rows if row[:2] == group]
    place = random.randrange(len(rows))
    files[name] = _joined([header, *rows[:place], *again, *rows[place:]])
    return "refused"


def empty_file(files: Files, random: Random) -> Expected:
    """A file holds nothing, or blanks, or its first line only."""
    name = random.choice(list(files))
    first = files[name].split(b"\n")[0]
    files[name] = [b"", b"\n\n", b"  ", first, first + b"\n"][random.randrange(5)]
    return "refused"


def missing_file(files: Files, random: Random) -> Expected:
    """A file that the record names is not there."""
    del files[random.choice(list(files))]
    return "refused"


MUTATIONS: tuple[Mutation, ...] = (
    text_for_number, huge_number, missing_column, misnamed_column, reordered_columns, reordered_rows, other_spelling,
    ragged_line, duplicated_cycle, empty_file, missing_file,
)  # fmt: skip
