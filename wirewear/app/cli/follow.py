"""Command that follows a running test: what its loops show so far, and a warning when a cause becomes probable."""

from __future__ import annotations

import hashlib
import time
from dataclasses import asdict, replace
from datetime import datetime
from math import inf, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wirewear.app.cli.group import Finite, OutputFolder, busy, cli, most_memory, stage
from wirewear.base.errors import RecordError, WirewearError
from wirewear.base.files import kept_table
from wirewear.base.writing import json_text, write_text

if TYPE_CHECKING:
    from wirewear.comparison.running_test import FollowedLoop
    from wirewear.diagnosis.watch import Look, Watched
    from wirewear.records import AnyRecord
    from wirewear.records.importing.growing import Growth
    from wirewear.records.values import MeasuredLoop
    from wirewear.views.follow_page import RunningTest

JOURNAL = "follow.json"  #: What was seen of each loop, and when.
REST = 4.0  #: Files that take long to be read are looked at after so many times as long.


@cli.command()
@click.argument("mapping_path", metavar="MAPPING.toml", type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", required=True, type=OutputFolder())
@click.option("--every", metavar="S", type=Finite(0.05, 86_400.0), default=5.0, show_default=True,
              help="How often the files are looked at.")  # fmt: skip
@click.option("--quiet", metavar="S", type=Finite(0.0, 1e7),
              help="Ended if nothing was written for so long.  [default: with the last cycle]")  # fmt: skip
@click.option("--alarm-rate", type=Finite(1e-6, 0.5), default=0.01, show_default=True,
              help="False alarms in a test, at most.")  # fmt: skip
@most_memory
def follow(mapping_path: Path, output: Path, every: float, quiet: float | None, alarm_rate: float) -> None:
    """Follow a running test while its logger writes, and diagnose it when it has ended.

    Prints a line for each logged loop, and a warning when a cause of a gap becomes probable. Interrupted, the same
    command goes on. At the end it imports and diagnoses the test as `import` and `diagnose` do.
    """
    from wirewear.base.locks import occupied
    from wirewear.records import require_place
    from wirewear.records.importing.growing import Growth

    click.echo(f"wirewear: following {mapping_path}: interrupted, the same command goes on.", err=True)
    began = time.monotonic()
    with occupied(output, f"follow {mapping_path}"):
        seen, growth = _Seen(output, mapping_path, alarm_rate), None
        written_at, refused = began, ""
        while True:
            started = time.monotonic()
            try:
                now = Growth.of(mapping_path)
                ended = now == growth and (
                    seen.reached_the_end or (quiet is not None and started - written_at >= quiet)
                )
                if now != growth or ended:
                    require_place(output / "record", made_of=[path for path, _, _ in now.files], overwrite=True)
                    seen.take(now, ended=ended)
                    written_at, growth, refused = started if now != growth else written_at, now, ""
                if ended:
                    break
            except RecordError as problem:
                # A file may not be there yet, or hold too little: it grows.
                if str(problem) != refused:
                    click.echo(f"wirewear: {problem}", err=True)
                refused = str(problem)
                if quiet is not None and time.monotonic() - written_at >= quiet:
                    raise
            time.sleep(max(every, REST * seen.reading_s))
        for path in [*seen.write(ended=True), *_whole(mapping_path, output)]:
            click.echo(path)


def _whole(mapping_path: Path, output: Path) -> list[Path]:
    """Import and diagnose the test that has ended, as `import` and `diagnose` do; returns what was written."""
    from wirewear.diagnosis import diagnose_prepared, prepared
    from wirewear.records import read_record, write_record
    from wirewear.records.importing import import_record
    from wirewear.simulation import ProgressBar
    from wirewear.views.diagnosis_page import ten_lines, write_diagnosis

    with busy("reading the whole test"):
        imported = import_record(mapping_path)
        folder = write_record(output / "record", imported, made_of=[mapping_path], overwrite=True)
        records = prepared(read_record(output / "record"))
    diagnosed = diagnose_prepared(records, observer_of=ProgressBar, stage=stage)
    click.echo(ten_lines(diagnosed.diagnosis))
    return [folder, *write_diagnosis(diagnosed, output / "diagnosis")]


class _Seen:
    """What was seen of a test, kept in a journal: figures by the digest of a loop, looks by that of all loops so
    far.
    """

    def __init__(self, output: Path, mapping_path: Path, alarm_rate: float) -> None:
        """Go on from the journal in `output`, unless the mapping or the rate has changed."""
        self.output, self.alarm_rate = output, alarm_rate
        text = mapping_path.read_bytes() if mapping_path.is_file() else b""
        asked = hashlib.sha256(text + repr(alarm_rate).encode()).hexdigest()
        journal = kept_table(output / JOURNAL)
        fresh: dict[str, Any] = {"asked": asked, "loops": {}, "looks": {}, "wear_mm3_per_J": None}
        self.journal: dict[str, Any] = journal if journal.get("asked") == asked else fresh
        self.reached_the_end, self.reading_s = False, 0.0
        self._course: RunningTest | None = None
        self._watched: Watched | None = None
        self._said = ""

    def take(self, growth: Growth, *, ended: bool) -> None:
        """Read the files; print and keep what is new in them."""
        from wirewear.comparison.running_test import energies_J
        from wirewear.diagnosis.watch import looks_among
        from wirewear.records.importing.growing import record_so_far
        from wirewear.views.follow_page import RunningTest

        started = time.monotonic()
        whole = record_so_far(growth.files[0][0], growth, ended=ended)
        self.reading_s = time.monotonic() - started
        cycles = whole.tables.conditions.cycles
        self.reached_the_end = any(loop.cycle >= cycles for loop in whole.loops)
        if len(loops := whole.loops if ended else whole.loops[:-1]) == 0:
            return
        record = replace(whole, loops=loops).of_block()
        digests, clock = [_digest(loop) for loop in record.loops], datetime.now().astimezone().isoformat(" ", "seconds")
        new = {digest for digest in digests if digest not in self.journal["loops"]}
        rows = [self._figures(record, *one, clock) for one in zip(record.loops, digests, strict=True)]
        energies = energies_J(record, rows)
        course = RunningTest(record, rows, energies, self.journal["wear_mm3_per_J"], alarm_rate=self.alarm_rate)
        due = {place: number for number, place in enumerate(looks_among(record.loops, cycles), 1)}
        so_far = hashlib.sha256()
        for place, digest in enumerate(digests):
            so_far.update(digest.encode())
            if place in due:
                first = replace(record, loops=record.loops[: min(due) + 1])
                look = self._look(first, record.loops[: place + 1], due[place], so_far.hexdigest(), clock)
                course = course.looked(look, self.journal["wear_mm3_per_J"])
            if digest in new:
                click.echo(course.line(place))
                if place in due and (warning := course.warning) is not None:
                    click.echo(warning)
        self._course = course
        self.write()

    def write(self, *, ended: bool = False) -> list[Path]:
        """Write the journal, and the page and table of what was seen; returns the latter's paths."""
        from wirewear.views.follow_page import write_follow

        write_text(self.output / JOURNAL, json_text(self.journal, indent=None) + "\n")
        return [] if self._course is None else write_follow(self._course, self.output, ended=ended)

    def _figures(self, record: AnyRecord, loop: MeasuredLoop, digest: str, clock: str) -> FollowedLoop:
        from wirewear.comparison.running_test import FollowedLoop, followed_loop

        kept = self.journal["loops"]
        if digest not in kept:
            conditions = record.tables.conditions
            kept[digest] = asdict(followed_loop(loop, conditions.normal_load_N, conditions.frequency_Hz, clock))
        found: dict[str, Any] = {key: nan if value is None else value for key, value in kept[digest].items()}
        return FollowedLoop(**found)

    def _look(self, first: AnyRecord, loops: tuple[MeasuredLoop, ...], number: int, digest: str, clock: str) -> Look:
        """The look of this number at the loops so far. first: the record of the loops at the first look."""
        from wirewear.diagnosis.watch import Look, Watched, no_look
        from wirewear.simulation import ProgressBar

        kept = self.journal["looks"]
        if digest not in kept:
            try:
                if self._watched is None:
                    self._watched = Watched.of(first, ProgressBar)
                    self.journal["wear_mm3_per_J"] = self._watched.wear_mm3_per_J or None
                look = self._watched.look(loops, number, self.alarm_rate, clock)
            except WirewearError as problem:
                look = no_look(loops[-1], number, self.alarm_rate, clock, str(problem))
            kept[digest] = asdict(look)
            write_text(self.output / JOURNAL, json_text(self.journal, indent=None) + "\n")
        found = kept[digest]
        odds = -inf if found["log_odds"] is None else found["log_odds"]
        return Look(**{**found, "log_odds": odds, "causes": tuple(found["causes"])})


def _digest(loop: MeasuredLoop) -> str:
    found = hashlib.sha256(f"{loop.repeat} {loop.cycle}".encode())
    for channel in (loop.displacement_um, loop.tangential_force_N, loop.normal_force_N):
        found.update(b"" if channel is None else channel.tobytes())
    return found.hexdigest()
