"""The rows of a sweep on disk as they come in: a line each, so that none is lost and none is twice."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TextIO

from wirewear.errors import RunError
from wirewear.files import write_text, writing
from wirewear.files.identity import Identity, digest
from wirewear.sweeps.case import SweepRow

JOURNAL = "rows.jsonl"


class Journal:
    """Rows of one sweep in a folder that this process holds."""

    def __init__(self, folder: Path, identity: Identity) -> None:
        """Nothing is read or written before it is asked for."""
        self.path = folder / JOURNAL
        self._identity = identity

    def begun(self) -> tuple[dict[int, SweepRow], str]:
        """Rows by their number that stand there already, and a sentence if such were given up.

        Raises:
            RunError: another sweep's rows stand there, or the file cannot be read or written.
        """
        note, rows = "", {}
        lines = self._lines()
        head = next(lines, None)
        if head is not None:
            known = Identity.of_text(head.get("sweep"))
            if known.asked != self._identity.asked:
                raise RunError(f"{self.path.parent} holds another sweep: choose another --output.")
            if known.made == self._identity.made:
                rows = {row.number: row for row in map(_row, lines) if row is not None}
            else:
                note = f"{self.path.parent} holds rows that another version of the program made: they are made anew."
        kept = [{"sweep": str(self._identity)}, *(rows[number].to_json() for number in sorted(rows))]
        with writing(RunError, f"cannot write {self.path}"):
            write_text(self.path, "".join(_line(one) for one in kept))
        return rows, note

    @contextmanager
    def open(self) -> Iterator[TextIO]:
        """The file, to add rows to."""
        with writing(RunError, f"cannot write {self.path}"), self.path.open("a", encoding="utf-8") as file:
            yield file

    def add(self, file: TextIO, row: SweepRow) -> None:
        """Add a row; it is on disk when this returns.

        Raises:
            RunError: it cannot be written.
        """
        with writing(RunError, f"cannot write {self.path}", "the same command goes on"):
            file.write(_line(row.to_json()))
            file.flush()
            os.fsync(file.fileno())

    def _lines(self) -> Iterator[dict[str, Any]]:
        """What stands there and is whole; a line that a full disk or an end from outside cut off is passed over."""
        try:
            text = self.path.read_text(encoding="utf-8", errors="replace")
        except FileNotFoundError:
            return
        except OSError as problem:
            raise RunError(f"{self.path} cannot be read ({problem.strerror}).") from None
        for line in text.splitlines():
            with suppress(ValueError, TypeError, KeyError):
                found = json.loads(line)
                if found["check"] == digest(found["of"]):
                    yield found["of"]


def _line(values: dict[str, Any]) -> str:
    return json.dumps({"of": values, "check": digest(values)}, ensure_ascii=False) + "\n"


def _row(values: dict[str, Any]) -> SweepRow | None:
    try:
        return SweepRow(**values)
    except TypeError:
        return None
