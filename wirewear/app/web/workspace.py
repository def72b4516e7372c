"""The workspace of `wirewear open`: a folder, and the steps from a laboratory's files to an answer with what they
print.

A step is one command of the command line, run in the folder as a process of its own. It reads what the steps before it
left there; its options are those of the command. It ends with the workspace, however that ends: its standard input is a
pipe that the system then closes.
"""

import os
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import NamedTemporaryFile
from threading import RLock, Thread

import click

from wirewear.app.cli.group import cli
from wirewear.base.errors import RunError, WirewearError
from wirewear.base.recognising import Held, recognised, require_no_other
from wirewear.base.words import as_sentence, shown
from wirewear.base.writing import prepared_folder

FILES, MAPPING, RECORD, RESULT = "files", "mapping.toml", "record", "result"
CAMPAIGN, CAMPAIGN_MAPPING, CAMPAIGN_TABLE = "campaign", f"campaign/{MAPPING}", "campaign/tests.csv"
FITTED = "fit/study.toml"
_OPENED_RECORD = "{record}"
#: Options that the steps give themselves, or that a page has no use for.
_NOT_ASKED = ("output", "as_json", "mapping", "dry_run", "record_path", "scheduler", "jobs", "overwrite")
_MOST_BYTES_OF_NAME, _MOST_SIGNS = 200, 1_000  #: Of a file's name, which gets a number once put aside; of a value.
_MOST_LINES = 400  #: Lines of what a step prints that are kept.
_SHOWN = (".html", ".png", ".csv", ".h5", ".json", ".svg", ".toml", ".txt", ".vtu")  #: Pages and pictures come first.
_COMING = ".coming."  #: Begins the name of a file until all of it is there.
CHUNK = 1 << 20

AS_STEP = """
try:
    from wirewear.app.cli import main
    from wirewear.app.web.workspace import end_with_input
    end_with_input()
except KeyboardInterrupt:
    print("wirewear: interrupted; nothing was written.")
    raise SystemExit(130)
main()
"""


@dataclass(frozen=True)
class Step:
    """One step.

    name, title: short, and for the page. command, arguments: of the command line; an argument in braces is a place that
    may have been opened elsewhere. needs, leaves: places in the folder that must exist before, and that it makes.
    goes_on: it takes up what it left, which is put aside otherwise.
    """

    name: str
    title: str
    command: str
    arguments: tuple[str, ...]
    needs: tuple[str, ...]
    leaves: tuple[str, ...] = ()
    goes_on: bool = False

    @property
    def options(self) -> list[dict[str, object]]:
        """The command's options: flag, help, and a list of choices or a hint at the value; both None for a switch."""
        return [_described(one) for one in _options_of(self.command)]


STEPS = (
    Step("guess_all", "Guess how the folder's tests are read", "new", ("--mapping", CAMPAIGN), (CAMPAIGN,),
         (CAMPAIGN_MAPPING, CAMPAIGN_TABLE)),
    Step("lab", "Import the folder's tests, side by side", "lab", (CAMPAIGN, "--output", "lab"), (CAMPAIGN_MAPPING,),
         ("lab",), goes_on=True),
    Step("guess", "Guess how the files are read", "new", ("--mapping", "--output", MAPPING), (FILES,), (MAPPING,)),
    Step("look", "Look at the first loop and scars", "import", (MAPPING, "--output", RECORD, "--dry-run"), (MAPPING,),
         ("first_look",)),
    Step("import", "Import them as a record", "import", (MAPPING, "--output", RECORD), (MAPPING,), (RECORD,)),
    Step("check", "Check the record", "check", (_OPENED_RECORD,), (RECORD,)),
    Step("loops", "Analyse its loops", "loops", (_OPENED_RECORD, "--output", "loops.png"), (RECORD,), ("loops.png",)),
    Step("fit", "Fit friction, rig and wear", "fit", (_OPENED_RECORD, "--output", "fit"), (RECORD,), ("fit",)),
    Step("compare", "Compare the fitted run with it", "compare", ("fit/run", _OPENED_RECORD, "--output", "compared"),
         ("fit/run", RECORD), ("compared",)),
    Step("diagnose", "Diagnose what the model lacks", "diagnose", (_OPENED_RECORD, "--output", "diagnosis"), (RECORD,),
         ("diagnosis",)),
    Step("report", "Make the page of a result", "report", ("{result}", "--output", "report"), (RESULT,), ("report",)),
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


class Workspace:
    """A folder with its steps; `places` are the paths of a record and a result that were opened elsewhere, by "record"
    and "result".
    """

    def __init__(self, folder: Path) -> None:
        """Use this folder, which is created if missing and may hold the files of earlier work."""
        self.folder = prepared_folder(folder.resolve())
        self.places: dict[str, Path] = {}
        for left in self.folder.glob(f"{_COMING}*"):
            left.unlink(missing_ok=True)
        self._jobs: dict[str, _Job] = {}
        self._lock = RLock()

    def take(self, path: Path) -> None:
        """Open the record or result at a path, or keep a copy of a file of measured numbers. Raises RunError if it is
        none of these.
        """
        match recognised(path):
            case Held.RECORD:
                self.places[RECORD] = path.resolve() if path.is_dir() else path.resolve().parent
            case Held.RUN:
                self.places[RESULT] = path.resolve()
            case _ if path.is_file():
                with path.open("rb") as file:
                    self.add(path.name, iter(lambda: file.read(CHUNK), b""))
            case _:
                require_no_other(path, RunError)
                raise RunError(f"{path} is no record, result or file of measured numbers.")

    def add(self, name: str, content: bytes | Iterable[bytes], *, of_campaign: bool = False) -> None:
        """Keep a file under its own name, without any folder; an earlier file of that name is put aside.

        of_campaign: it is one of a folder of tests, and keeps the names of folders before its own. Nothing is changed
        unless all of the content arrives. Raises RunError if it is not a name of a file; ValueError if it is too long.
        """
        parts = Path(name.replace("\\", "/")).parts if of_campaign else (Path(name.replace("\\", "/")).name,)
        for own in parts or ("",):
            if not own or own.startswith((".", "/")) or not own.isprintable():
                raise RunError(f"{shown(name)} is no name of a file.")
            if len(os.fsencode(own)) > _MOST_BYTES_OF_NAME:
                raise ValueError(f"the name {shown(name)} is too long: {_MOST_BYTES_OF_NAME} bytes at most.")
        home = self.folder / (CAMPAIGN if of_campaign else FILES)
        self._keep(home.joinpath(*parts), [content] if isinstance(content, bytes) else content)

    def write_mapping(self, text: str) -> None:
        """Keep an edited mapping; the earlier one is put aside."""
        self._keep(self.folder / MAPPING, [text.encode("utf-8")])

    def start(self, name: str, chosen: Mapping[str, object]) -> None:
        """Start the step `name`; its output and files follow in `state`.

        chosen: values of its options by their flags, True for a switch. Raises RunError if there is no such step,
        another one is running, or something that it needs is missing; ValueError if a value is not allowed.
        """
        step = next((one for one in STEPS if one.name == name), None)
        if step is None:
            raise RunError(f"there is no step {shown(name)}.")
        options = _typed(step, chosen)
        with self._lock:
            running = next((one.title for one in STEPS if self._state(one) == "running"), None)
            if running is not None:
                raise RunError(f"wait until this has ended, or stop it: {running}.")
            if not self._ready(step):
                raise RunError(f"{step.needs[0]} is not there yet: go through the steps before.")
            files = [str(path.relative_to(self.folder)) for path in self._files()] if step.needs == (FILES,) else []
            opened = {what: self.places.get(what, what) for what in (RECORD, RESULT)}
            places = [one.format(**opened) for one in step.arguments]
            if name == "diagnose" and not chosen.get("--model") and (self.folder / FITTED).is_file():
                from wirewear.records import read_record

                # A record that states too little for a model of its own has the fitted one.
                places += ["--model", FITTED] if read_record(self.folder / opened[RECORD]).tables.missing else []
            for place in () if step.goes_on else step.leaves:
                self._put_aside(self.folder / place)
            if name == "import":
                self.places.pop(RECORD, None)
            command = [sys.executable, "-c", AS_STEP, step.command, *files, *places, *options]
            process = subprocess.Popen(
                command, cwd=self.folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                text=True, encoding="utf-8", errors="replace", start_new_session=True,
                env={**os.environ, "COLUMNS": "100", "PYTHONIOENCODING": "utf-8", "PYTHONUNBUFFERED": "1",
                     "PYTHONSAFEPATH": "1"},
            )  # fmt: skip
            self._jobs[name] = _Job(process)
        Thread(target=self._follow, args=(step, self._jobs[name]), daemon=True).start()

    def stop(self) -> None:
        """End the running step as Ctrl-C does; nothing happens if none is running."""
        with self._lock:
            for job in self._jobs.values():
                # Once it is reaped, the system may give its number to a group of somebody else.
                if job.process.returncode is None:
                    os.killpg(job.process.pid, signal.SIGINT)

    def state(self) -> dict[str, object]:
        """Plain values for the page: files, mapping, and for each step whether it can start, its state, output, and
        files left.
        """
        mapping = self.folder / MAPPING
        return {
            "folder": str(self.folder),
            "files": [path.name for path in self._files()],
            "opened": {what: str(path) for what, path in self.places.items()},
            "mapping": mapping.read_text(encoding="utf-8", errors="replace") if mapping.is_file() else None,
            "steps": [self._described(step) for step in STEPS if self._concerns(step)],
        }

    def served(self, name: str) -> Path | None:
        """Path of the file in the folder that a page asks for by its relative name; None if it lies outside or does not
        exist.
        """
        with suppress(OSError, RuntimeError):  # names too long, links in a circle
            place = (self.folder / name).resolve()
            return place if place.is_relative_to(self.folder) and place.is_file() else None
        return None

    def _follow(self, step: Step, job: _Job) -> None:
        process = job.process
        for line in process.stdout or ():
            job.lines.append(line.rstrip())
        os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
        with self._lock, process:
            # Both are left once it is reaped.
            pass
        try:
            # Pictures of a first look lie beside the record that is yet to be.
            for picture in self.folder.glob(f"{RECORD}*.png") if step.name == "look" else ():
                picture.replace(prepared_folder(self.folder / step.leaves[0]) / picture.name)
        except (OSError, WirewearError) as problem:
            job.lines.append(as_sentence(f"its pictures stay in {self.folder}: {problem}"))
        job.ended = time.monotonic()

    def _described(self, step: Step) -> dict[str, object]:
        job = self._jobs.get(step.name)
        return {
            "name": step.name,
            "title": step.title,
            "command": step.command,
            "ready": self._ready(step),
            "state": self._state(step),
            "lines": [] if job is None else list(job.lines),
            "seconds": None if job is None else round((job.ended or time.monotonic()) - job.began),
            "left": [str(path.relative_to(self.folder)) for path in self._left(step)][:100],
            "options": step.options,
        }

    def _state(self, step: Step) -> str:
        job = self._jobs.get(step.name)
        if job is not None:
            return job.state
        return "done" if any((self.folder / place).exists() for place in step.leaves) else "idle"

    def _concerns(self, step: Step) -> bool:
        """True unless a step is on a result or a folder of tests, and there is none."""
        return {RESULT: RESULT in self.places, CAMPAIGN: (self.folder / CAMPAIGN).exists()}.get(
            step.needs[0].partition("/")[0], True
        )

    def _ready(self, step: Step) -> bool:
        return all((self.places.get(one) or self.folder / one).exists() for one in step.needs)

    def _files(self) -> list[Path]:
        # What systems keep in folders that they show, such as .DS_Store, is nobody's measurement.
        return sorted(path for path in (self.folder / FILES).glob("*") if not path.name.startswith("."))

    def _left(self, step: Step) -> Iterator[Path]:
        places = [self.folder / place for place in step.leaves]
        found = [path for place in places for path in ([place] if place.is_file() else place.rglob("*"))]
        shown_ones = (path for path in found if path.suffix in _SHOWN and path.is_file())
        yield from sorted(shown_ones, key=lambda path: (_SHOWN.index(path.suffix), path))

    def _keep(self, place: Path, content: Iterable[bytes]) -> None:
        """Write a file, once all of its content is there; another in its place is put aside."""
        with NamedTemporaryFile(dir=self.folder, prefix=_COMING, delete=False) as file:
            coming = Path(file.name)
            try:
                file.writelines(content)
                file.flush()
                os.fsync(file.fileno())
                with self._lock:
                    self._put_aside(place)
                    coming.replace(prepared_folder(place.parent) / place.name)
            finally:
                coming.unlink(missing_ok=True)

    def _put_aside(self, place: Path) -> None:
        """Keep an earlier file or folder of this name under the next number. Whoever calls holds the lock."""
        if os.path.lexists(place):
            earlier = prepared_folder(self.folder / "earlier")
            numbers = [int(number) for path in earlier.iterdir() if (number := path.name.split("_")[0]).isdecimal()]
            place.rename(earlier / f"{max(numbers, default=0) + 1}_{place.name}")


def _options_of(command: str) -> list[click.Option]:
    given = (one for one in cli.commands[command].params if isinstance(one, click.Option))
    return [one for one in given if one.name not in _NOT_ASKED and not one.multiple]


def _described(option: click.Option) -> dict[str, object]:
    choices = list(option.type.choices) if isinstance(option.type, click.Choice) else None
    hint = None if option.is_flag else option.metavar or option.type.name
    return {"flag": option.opts[0], "help": option.help or "", "hint": hint, "choices": choices}


def _typed(step: Step, chosen: Mapping[str, object]) -> list[str]:
    """Options as they are typed; those that the command does not have, and empty ones, are left out.
    Raises ValueError if they are no table of texts and truths, or the command does not take a value.
    """
    if not isinstance(chosen, Mapping):
        raise ValueError(f"options are {shown(chosen)}, but must be a table of values by their flags.")
    typed = []
    for option in _options_of(step.command):
        flag, value = option.opts[0], chosen.get(option.opts[0])
        if value is None or value == "" or value is False:
            continue
        if value is True and option.is_flag:
            typed.append(flag)
        elif isinstance(value, str) and value.isprintable() and len(value) <= _MOST_SIGNS and not option.is_flag:
            typed.append(f"{flag}={value.strip()}")
            if not isinstance(option.type, click.Path):
                try:
                    option.type.convert(value.strip(), option, None)
                except click.BadParameter as problem:
                    raise ValueError(f"{option.opts[0]}: {problem.format_message()}") from None
        else:
            raise ValueError(f"{flag} is {shown(value)}, which it cannot be.")
    return typed


def end_with_input() -> None:
    """End this process and its group when standard input ends, whatever they are at; returns at once.

    A process of its own waits for that: compiled functions let no other thread run before they return.
    """
    step = os.getpid()
    if os.fork():
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # What the step prints ends with the step.
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    while os.read(0, CHUNK):
        pass
    # A step is a group of processes, which is interrupted, and killed if it goes on.
    if os.getppid() == step:
        os.killpg(0, signal.SIGINT)
        for _ in range(30):
            time.sleep(0.1)
            if os.getppid() != step:
                os._exit(0)
    os.killpg(0, signal.SIGKILL)
