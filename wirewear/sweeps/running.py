"""Running a sweep: an engine computes the runs whose rows are not yet in the output folder's journal.

A row holds the figures of one run. The journal is the file to which each row is added when its run ends.
"""

import json
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from wirewear.base.cache import Identity, digest
from wirewear.base.engine import Engine
from wirewear.base.errors import EngineError, LostTaskError, RunError, StudyError
from wirewear.base.locks import occupied
from wirewear.base.memory import free_disk, free_memory, size_text
from wirewear.base.words import counted
from wirewear.base.writing import prepared_folder, write_text, writing
from wirewear.sweeps.forecast import Forecast, forecast, pilots, sizes_of
from wirewear.sweeps.sweep import Sweep, SweepRow, run_case

JOURNAL = "rows.jsonl"
RESULTS = "runs"


class Journal:
    """Rows of one sweep in the journal of an output folder, which this process has locked."""

    def __init__(self, folder: Path, identity: Identity) -> None:
        """Prepare the journal; nothing is read or written yet. identity: the sweep's."""
        self.path = folder / JOURNAL
        self._identity = identity

    def rows_so_far(self) -> tuple[dict[int, SweepRow], str]:
        """(rows already in the journal by number, note): rows of another version of the program are dropped, which the
        note says, else "". Incomplete lines are dropped, too.

        Raises RunError if the journal belongs to another sweep, or cannot be read or written.
        """
        note, rows = "", {}
        lines = self._lines()
        head = next(lines, None)
        if head is None and self.path.exists():
            raise RunError(f"{self.path} is no journal of a sweep, and is not overwritten: choose another --output.")
        if head is not None:
            known = Identity.of_text(head.get("sweep"))
            if known.asked != self._identity.asked:
                raise RunError(f"{self.path.parent} holds another sweep: choose another --output.")
            if known.made == self._identity.made:
                rows = {row.number: row for row in map(_row, lines) if row is not None}
            else:
                note = f"{self.path.parent} holds rows that another version of the program made: they are made again."
        kept: list[dict[str, object]] = [
            {"sweep": str(self._identity)},
            *(rows[number].to_json() for number in sorted(rows)),
        ]
        with writing(RunError, f"cannot write {self.path}"):
            write_text(self.path, "".join(_line(one) for one in kept))
        return rows, note

    @contextmanager
    def open(self) -> Iterator[TextIO]:
        """The journal opened for adding rows, while the `with` block runs. Raises RunError if it cannot be written."""
        with writing(RunError, f"cannot write {self.path}"), self.path.open("a", encoding="utf-8") as file:
            yield file

    def add(self, file: TextIO, row: SweepRow) -> None:
        """Append a row to the open journal; it is on disk when this returns. Raises RunError if that fails."""
        with writing(RunError, f"cannot write {self.path}", "the same command goes on"):
            file.write(_line(row.to_json()))
            file.flush()
            os.fsync(file.fileno())

    def _lines(self) -> Iterator[dict[str, Any]]:
        """Entries of the journal whose checksum is right; incomplete lines, as a full disk leaves them, are skipped."""
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


def _line(values: Mapping[str, object]) -> str:
    return json.dumps({"of": values, "check": digest(values)}, ensure_ascii=False) + "\n"


def _row(values: dict[str, Any]) -> SweepRow | None:
    try:
        return SweepRow(**values)
    except TypeError:
        return None


class SweepObserver:
    """Receives the progress of a sweep; this base class ignores it."""

    def note(self, sentence: str) -> None:
        """Receive a sentence for the user."""

    def expected(self, forecast: Forecast) -> None:
        """Receive the forecast of all runs, once enough have ended."""

    def done(self, row: SweepRow, rows: int, of: int) -> None:
        """Receive the row of a run that ended; `rows` of `of` runs have ended now."""


@dataclass(frozen=True)
class SweepResult:
    """A sweep with the rows of its runs that have ended, by their number from 1."""

    sweep: Sweep
    rows: Mapping[int, SweepRow]

    @property
    def whole(self) -> bool:
        return len(self.rows) == len(self.sweep)

    @property
    def failures(self) -> list[SweepRow]:
        """Rows of runs that failed, in order of their numbers."""
        return [row for _, row in sorted(self.rows.items()) if row.failed]


def run_sweep(
    sweep: Sweep, output: Path, engine: Engine, observer: SweepObserver | None = None, *, only_pilots: bool = False
) -> SweepResult:
    """Compute every row that OUTPUT does not hold yet, and return all; with `only_pilots`, compute only what a forecast
    needs.

    Raises RunError if OUTPUT holds another sweep, is in use by another process, or cannot be written; StudyError if the
    sweep needs more memory or disk than there is; EngineError if the cluster cannot be reached, or runs another
    program.
    """
    watcher = observer or SweepObserver()
    with occupied(output, f"the sweep {sweep.name!r}"):
        journal = Journal(prepared_folder(output), sweep.identity)
        rows, note = journal.rows_so_far()
        if note:
            watcher.note(note)
        if len(rows) < len(sweep):
            with engine.held():
                _make_missing(sweep, rows, journal, engine, watcher, only_pilots=only_pilots)
        return SweepResult(sweep, dict(sorted(rows.items())))


def _make_missing(
    sweep: Sweep,
    rows: dict[int, SweepRow],
    journal: Journal,
    engine: Engine,
    observer: SweepObserver,
    *,
    only_pilots: bool,
) -> None:
    """Compute the missing rows and add them to `rows`, which is changed in place, and to the journal."""
    output = journal.path.parent
    missing = [place for place in range(len(sweep)) if place + 1 not in rows]
    results = prepared_folder(output / RESULTS).resolve() if sweep.keep_results else None

    def make(places: Iterable[int]) -> None:
        numbers = [place + 1 for place in places]
        tasks = [partial(run_case, *sweep.case(n - 1), sweep.fidelity, n, results) for n in numbers]
        with journal.open() as file:
            for one in engine.done(tasks):
                row = _row_of(numbers[one.place], one.result, one.error)
                # A lost process may have had bad luck: the next time, the run is tried again.
                if not isinstance(one.error, LostTaskError):
                    journal.add(file, row)
                rows[row.number] = row
                observer.done(row, len(rows), len(sweep))

    observer.note(f"planning {counted(len(missing))} runs")
    sizes = sizes_of(sweep)
    foreseeable = bool(np.isfinite(sizes).all())
    first = [place for place in pilots(sizes) if place + 1 not in rows] if foreseeable else []
    if only_pilots:
        # One run that has figures is enough: what others take follows from their sizes.
        for place in first:
            if not any(row.cpu_s > 0.0 for row in rows.values()):
                observer.note(f"run {place + 1} shows what all take")
                make([place])
    else:
        if first:
            observer.note(f"{len(first)} runs come first: they show what all take")
        make(first)
    if foreseeable and any(row.cpu_s > 0.0 for row in rows.values()):
        expected = forecast(sweep, sizes, list(rows.values()), engine.workers)
        observer.expected(expected)
        _require_room(expected, output)
    if not only_pilots:
        make(place for place in missing if place not in first)


def _row_of(number: int, row: SweepRow | None, error: BaseException | None) -> SweepRow:
    """Row that a task returned, or of a failed run if its process was lost; any other error of the task is raised."""
    if isinstance(error, LostTaskError):
        return SweepRow(number, None, str(error).rstrip("."))
    if error is not None:
        raise error
    if row is None:
        raise EngineError(f"run {number} came back without a row.")
    return row


def _require_room(expected: Forecast, output: Path) -> None:
    if expected.disk_bytes > free_disk(output):
        raise RunError(
            f"the sweep takes {size_text(expected.disk_bytes)} of disk, of which {size_text(free_disk(output))} are "
            "free: choose another --output, or keep_results = false."
        )
    if expected.peak_bytes > free_memory():
        raise StudyError(
            f"a run of the sweep takes {size_text(expected.peak_bytes)} of memory, of which "
            f"{size_text(free_memory())} are free: mesh coarser, or allow more by --most-memory."
        )
