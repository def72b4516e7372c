"""What `wirewear open` works on: a folder, the steps from a laboratory's files to an answer, and what they print.

A step is one command of the command line, run as a process of its own in the folder. It is given what the steps before
it left there; its options are those of the command.
"""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock, Thread
from typing import Any

import click

from wirewear.base.errors import RunError
from wirewear.base.reading import Held, recognised
from wirewear.base.writing import prepared_folder, write_bytes, write_text
from wirewear.faces.group import cli

FILES, MAPPING, RECORD, RESULT = "files", "mapping.toml", "record", "result"
FITTED = "fit/study.toml"
_OPENED_RECORD = "{record}"
#: Options that the steps give themselves, or that a page has no use for.
_NOT_ASKED = ("output", "as_json", "mapping", "dry_run", "record_path", "scheduler", "jobs")
_MOST_LINES = 400  #: Lines of what a step prints that are kept.
_SHOWN = (".html", ".png")


@dataclass(frozen=True)
class Step:
    """One command: its name there, arguments, what it needs beforehand, and what it leaves, as places in the folder.

    An argument in braces is a place that may have been opened elsewhere.
    """

    name: str
    title: str
    command: str
    arguments: tuple[str, ...]
    needs: tuple[str, ...]
    leaves: str

    @property
    def options(self) -> list[dict[str, Any]]:
        """What can be chosen: flag, help, and a list of choices, or a hint at the value; a flag has neither."""
        return [_described(one) for one in _options_of(self.command)]


STEPS = (
    Step("guess", "Guess how the files are read", "new", ("--mapping", "--output", MAPPING), (FILES,), MAPPING),
    Step("look", "Look at the first loop and scars", "import", (MAPPING, "--output", RECORD, "--dry-run"), (MAPPING,),
         "first_look"),
    Step("import", "Import them as a record", "import", (MAPPING, "--output", RECORD), (MAPPING,), RECORD),
    Step("check", "Check the record", "check", (_OPENED_RECORD,), (RECORD,), ""),
    Step("loops", "Analyse its loops", "loops", (_OPENED_RECORD, "--output", "loops.png"), (RECORD,), "loops.png"),
    Step("fit", "Fit friction, rig and wear", "fit", (_OPENED_RECORD, "--output", "fit"), (RECORD,), "fit"),
    Step("compare", "Compare the fitted run with it", "compare", ("fit/run", _OPENED_RECORD, "--output", "compared"),
         ("fit/run", RECORD), "compared"),
    Step("diagnose", "Diagnose what the model lacks", "diagnose", (_OPENED_RECORD, "--output", "diagnosis"), (RECORD,),
         "diagnosis"),
    Step("report", "Make the page of a result", "report", ("{result}", "--output", "report"), (RESULT,), "report"),
)  # fmt: skip


@dataclass(eq=False)
class _Job:
    """A step that runs, or has run."""

    process: "subprocess.Popen[str]"
    lines: deque[str] = field(default_factory=lambda: deque(maxlen=_MOST_LINES))
    began: float = field(default_factory=time.monotonic)
    ended: float | None = None

    @property
    def state(self) -> str:
        """running, done, or failed; a check that finds problems is done."""
        if self.ended is None:
            return "running"
        return "done" if self.process.returncode in (0, 1) else "failed"


class Desk:
    """The folder with its steps; `places` are where records and results lie that were opened and not made here."""

    def __init__(self, folder: Path) -> None:
        """A folder that may hold what was done before."""
        self.folder = prepared_folder(folder.resolve())
        self.places: dict[str, Path] = {}
        self._jobs: dict[str, _Job] = {}
        self._lock = Lock()

    def take(self, path: Path) -> None:
        """Open what lies at a path. Raises RunError unless it is a record, a result, or a file of measured numbers."""
        match recognised(path):
            case Held.RECORD:
                self.places[RECORD] = path.resolve() if path.is_dir() else path.resolve().parent
            case Held.RUN:
                self.places[RESULT] = path.resolve()
            case _ if path.is_file():
                self.add(path.name, path.read_bytes())
            case _:
                raise RunError(f"{path} is no record, result or file of measured numbers.")

    def add(self, name: str, content: bytes) -> None:
        """Keep a file under its own name, which names no other folder; another of that name is put aside."""
        place = self.folder / FILES / Path(name.replace("\\", "/")).name
        if not place.name or place.name.startswith("."):
            raise RunError(f"{name!r} is no name of a file.")
        self._put_aside(place)
        write_bytes(prepared_folder(place.parent) / place.name, content)

    def write_mapping(self, text: str) -> None:
        """Keep a mapping as it was edited; the one before is put aside."""
        self._put_aside(self.folder / MAPPING)
        write_text(self.folder / MAPPING, text)

    def start(self, name: str, chosen: Mapping[str, Any]) -> None:
        """Begin a step with options by their flags. Raises RunError while another runs, or what it needs is missing."""
        step = next((one for one in STEPS if one.name == name), None)
        if step is None:
            raise RunError(f"there is no step {name!r}.")
        with self._lock:
            running = next((one.title for one in STEPS if self._state(one) == "running"), None)
            if running is not None:
                raise RunError(f"wait until this has ended, or stop it: {running}.")
            if not self._ready(step):
                raise RunError(f"{step.needs[0]} is not there yet: go through the steps before.")
            if step.leaves:
                self._put_aside(self.folder / step.leaves)
            files = [str(path.relative_to(self.folder)) for path in self._files()] if step.needs == (FILES,) else []
            if name == "import":
                self.places.pop(RECORD, None)
            opened = {what: self.places.get(what, what) for what in (RECORD, RESULT)}
            places = [one.format(**opened) for one in step.arguments]
            if name == "diagnose" and not chosen.get("--model") and (self.folder / FITTED).is_file():
                from wirewear.records import read_record

                # A record that states too little for a model of its own has the fitted one.
                places += ["--model", FITTED] if read_record(self.folder / opened[RECORD]).tables.missing else []
            command = [sys.executable, "-m", "wirewear", step.command, *files, *places, *_typed(step, chosen)]
            process = subprocess.Popen(
                command, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                text=True, encoding="utf-8", errors="replace", start_new_session=True,
                env={**os.environ, "COLUMNS": "100", "PYTHONIOENCODING": "utf-8", "PYTHONUNBUFFERED": "1"},
            )  # fmt: skip
            self._jobs[name] = _Job(process)
        Thread(target=self._follow, args=(step, self._jobs[name]), daemon=True).start()

    def stop(self) -> None:
        """End what runs, as Ctrl-C does."""
        for job in self._jobs.values():
            if job.ended is None:
                with suppress(ProcessLookupError):
                    os.killpg(job.process.pid, signal.SIGINT)

    def state(self) -> dict[str, Any]:
        """All that a page shows: files, mapping, and of each step whether it can begin, what it said and left."""
        mapping = self.folder / MAPPING
        return {
            "folder": str(self.folder),
            "files": [path.name for path in self._files()],
            "opened": {what: str(path) for what, path in self.places.items()},
            "mapping": mapping.read_text(encoding="utf-8") if mapping.is_file() else None,
            "steps": [self._told(step) for step in STEPS if RESULT not in step.needs or RESULT in self.places],
        }

    def served(self, name: str) -> Path | None:
        """The file of the folder that a page asks for; None for what lies outside, or is none."""
        place = (self.folder / name).resolve()
        return place if place.is_relative_to(self.folder) and place.is_file() else None

    def _follow(self, step: Step, job: _Job) -> None:
        with job.process as process:
            for line in process.stdout or ():
                job.lines.append(line.rstrip())
        if step.name == "look":
            # Its pictures lie beside the record that is yet to be.
            for picture in self.folder.glob(f"{RECORD}*.png"):
                shutil.move(picture, prepared_folder(self.folder / step.leaves) / picture.name)
        job.ended = time.monotonic()

    def _told(self, step: Step) -> dict[str, Any]:
        job = self._jobs.get(step.name)
        left = [] if not step.leaves else [str(path.relative_to(self.folder)) for path in self._left(step)]
        return {
            "name": step.name,
            "title": step.title,
            "ready": self._ready(step),
            "state": self._state(step),
            "lines": [] if job is None else list(job.lines),
            "seconds": None if job is None else round((job.ended or time.monotonic()) - job.began),
            "left": left,
            "options": step.options,
        }

    def _state(self, step: Step) -> str:
        job = self._jobs.get(step.name)
        if job is not None:
            return job.state
        return "done" if step.leaves and (self.folder / step.leaves).exists() else "idle"

    def _ready(self, step: Step) -> bool:
        return all((self.places.get(one) or self.folder / one).exists() for one in step.needs)

    def _files(self) -> list[Path]:
        return sorted((self.folder / FILES).glob("*"))

    def _left(self, step: Step) -> Iterator[Path]:
        place = self.folder / step.leaves
        found = [place] if place.is_file() else sorted(place.rglob("*"), key=lambda path: (path.suffix, path))
        return (path for path in found if path.suffix in _SHOWN)

    def _put_aside(self, place: Path) -> None:
        """What is to be made anew is never lost."""
        if place.exists():
            earlier = prepared_folder(self.folder / "earlier")
            shutil.move(place, earlier / f"{sum(1 for _ in earlier.iterdir()) + 1}_{place.name}")


def _options_of(command: str) -> list[click.Option]:
    given = (one for one in cli.commands[command].params if isinstance(one, click.Option))
    return [one for one in given if one.name not in _NOT_ASKED and not one.multiple]


def _described(option: click.Option) -> dict[str, Any]:
    choices = list(option.type.choices) if isinstance(option.type, click.Choice) else None
    hint = None if option.is_flag else option.metavar or option.type.name
    return {"flag": option.opts[0], "help": option.help or "", "hint": hint, "choices": choices}


def _typed(step: Step, chosen: Mapping[str, Any]) -> list[str]:
    """Options as they are typed; those that the command does not have, and empty ones, are left out."""
    typed = []
    for option in _options_of(step.command):
        value = chosen.get(option.opts[0])
        if option.is_flag and value is True:
            typed.append(option.opts[0])
        elif not option.is_flag and isinstance(value, str) and value.strip():
            typed.append(f"{option.opts[0]}={value.strip()}")
    return typed
