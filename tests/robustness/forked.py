"""Commands of wirewear as processes of their own that can be killed, limited, or be somebody else's."""

import ctypes
import importlib
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.robustness.served import Served, load_everything, serve

MOST_s = 600.0


@dataclass(frozen=True)
class Ended:
    """How a command ended: its exit code, negative after a signal; what it said on standard error; how long it took."""

    status: int
    errors: str
    seconds: float

    @property
    def sentence(self) -> bool:
        """Whether it ended by itself in a sentence, and not in a traceback or by a signal."""
        messages = [line for line in self.errors.splitlines() if line.startswith("wirewear: ")]
        return self.status == 2 and bool(messages) and "Traceback" not in self.errors

    @property
    def last_words(self) -> str:
        """The end of what it said."""
        return " ".join(self.errors.split())[-300:]


@dataclass(frozen=True)
class Hardship:
    """What a command meets.

    kill_after_s: it and all that it started are killed then.  most_bytes: no file grows larger.  common: it has no more
    rights than the modes of files give their owner, also where it is root.  modes: what files and folders are set to
    `modes_after_s` after its start.
    """

    kill_after_s: float | None = None
    most_bytes: int | None = None
    common: bool = False
    modes: Mapping[str, int] | None = None
    modes_after_s: float = 0.0


class Commands(Served):
    """The process that commands are forked from; with `whole`, each is a process that loads everything itself."""

    def __init__(self) -> None:
        """Start it."""
        super().__init__(__name__)

    def run(
        self,
        folder: Path,
        arguments: Sequence[str],
        cache: Path,
        hardship: Hardship | None = None,
        *,
        temporary: Path | None = None,
        whole: bool = False,
    ) -> Ended:
        """A command in a folder, with a cache and, where it is given, a folder for temporary files of its own."""
        met = hardship or Hardship()
        asked = {
            "folder": str(folder),
            "arguments": [*arguments],
            "variables": {"WIREWEAR_CACHE": str(cache), **({"TMPDIR": str(temporary)} if temporary else {})},
            "errors": str(folder.parent / f"{folder.name}.errors"),
            "whole": whole,
            **met.__dict__,
        }
        answer = self.ask(asked)
        # A command that is killed at once has not opened the file.
        errors = Path(asked["errors"])
        return Ended(
            answer["status"], errors.read_text("utf-8", "replace") if errors.exists() else "", answer["seconds"]
        )


def _command(asked: Mapping[str, Any]) -> int:
    """In the child: be the command; returns its exit code."""
    os.setsid()
    os.chdir(asked["folder"])
    os.environ.update(asked["variables"])
    nothing = os.open(os.devnull, os.O_RDWR)
    said = os.open(asked["errors"], os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
    for place, own in ((0, nothing), (1, nothing), (2, said)):
        os.dup2(own, place)
    if asked["most_bytes"] is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (asked["most_bytes"],) * 2)
    if asked["common"]:
        give_up_capabilities()
    is_exam = asked["arguments"][0] == "studies.blind"
    module, arguments = "studies.blind.commands" if is_exam else "wirewear.app.cli", asked["arguments"][is_exam:]
    if asked["whole"]:
        os.environ["PYTHONPATH"] = str(Path(__file__).parents[2])
        os.execv(sys.executable, [sys.executable, "-c", f"from {module} import main; main()", *arguments])
    sys.argv = ["wirewear", *arguments]
    try:
        importlib.import_module(module).main()
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    except BaseException:  # noqa: BLE001 - as the interpreter would end
        traceback.print_exc()
        return 1
    return 0


def give_up_capabilities() -> None:
    """Be root no more but by name: capset(2) with no capability, for this process (0) in version 3 of the call."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.capset((ctypes.c_uint32 * 2)(0x20080522, 0), (ctypes.c_uint32 * 6)()) != 0:
        raise OSError(ctypes.get_errno(), "the capabilities of root cannot be given up")


def _ended(asked: Mapping[str, Any]) -> dict[str, Any]:
    """Fork a command, do to it what it is to meet, and wait for its end."""
    started = time.perf_counter()
    process = os.fork()
    if process == 0:
        status = 1
        try:
            status = _command(asked)
            sys.stdout.flush()
            sys.stderr.flush()
        finally:
            os._exit(status)
    kill_after, modes = asked["kill_after_s"], dict(asked["modes"] or {})
    while True:
        found, status = os.waitpid(process, os.WNOHANG)
        passed = time.perf_counter() - started
        if found:
            break
        if modes and passed >= asked["modes_after_s"]:
            for path, mode in modes.items():
                with suppress(OSError):
                    Path(path).chmod(mode)
            modes = {}
        if passed >= (MOST_s if kill_after is None else kill_after):
            _kill(process)
            kill_after = MOST_s
        time.sleep(0.002)
    return {"status": os.waitstatus_to_exitcode(status), "seconds": passed}


def _kill(process: int) -> None:
    """Kill a command and all that it started."""
    try:
        os.killpg(process, signal.SIGKILL)
    except ProcessLookupError:
        # It has not come so far as to lead a group.
        os.kill(process, signal.SIGKILL)


if __name__ == "__main__":
    load_everything()
    serve(_ended)
