"""Work done in a child process that is watched: its time on the processor, its memory, the files it changes.

A child is forked for each piece of work, so that whatever happens to it happens to nothing else. Hangs are judged by
the time that the child takes of a processor, which does not depend on what else the machine does.
"""

import faulthandler
import inspect
import json
import math
import os
import resource
import select
import signal
import site
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

#: Time on a processor that counts as a hang from there on, time that a child may wait in all, and its memory.
LONGEST_s, MOST_WAIT_s, MOST_BYTES = 20.0, 180.0, 4_000_000_000

#: What changes files, and what data may never bring about, by the names of the interpreter's audit events.
CHANGING = ("os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.symlink", "os.link", "os.chmod", "os.truncate")
FORBIDDEN = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "socket.connect",
             "pickle.find_class", "ctypes.dlopen")  # fmt: skip


#: Libraries that packages bring with them are opened again by what counts their threads.
INSTALLED = tuple(str(Path(each)) for each in dict.fromkeys((sys.prefix, *site.getsitepackages())))

#: What is kept of the functions that numba compiled is the program's own, not data.
OWN_UNPICKLING = "solvers.jit_cache"


@dataclass(frozen=True)
class Ending:
    """How a piece of work ended, what is wrong with that, its time on the processor and the most memory it held.

    deeds: what it did that data may not bring about.
    """

    how: str
    wrong: str | None
    cpu_s: float = 0.0
    peak_bytes: int = 0
    deeds: tuple[str, ...] = ()


@dataclass
class Watch:
    """Where files may be written while a reader is at work; what else it did that data may not bring about."""

    allowed: tuple[str, ...] = ()
    found: list[str] = field(default_factory=list)

    def __call__(self, event: str, arguments: tuple[object, ...]) -> None:
        """Look at what the interpreter is about to do (PEP 578)."""
        if event == "pickle.find_class" and _called_from(OWN_UNPICKLING):
            return
        if event == "ctypes.dlopen" and str(arguments[0]).startswith(INSTALLED):
            return
        if event in FORBIDDEN:
            self.found.append(f"{event} {str(arguments)[:100]}")
        elif event in CHANGING or (event == "open" and _writes(arguments)):
            for given in arguments[: 2 if event in ("os.rename", "os.link") else 1]:
                self._changed(event, given)

    def _changed(self, event: str, given: object) -> None:
        # What is opened by its number was opened before.
        if isinstance(given, str | bytes | Path):
            where = Path(os.fsdecode(given)).resolve()
            # A folder that is there already is asked for, not made.
            if not (event == "os.mkdir" and where.is_dir()) and not any(
                where.is_relative_to(one) for one in self.allowed
            ):
                self.found.append(f"{event} {where}")


def _called_from(module: str) -> bool:
    """Whether a function of a module is among those that have not returned."""
    frame: FrameType | None = inspect.currentframe()
    while frame is not None and frame.f_globals.get("__name__") != module:
        frame = frame.f_back
    return frame is not None


def _writes(arguments: tuple[object, ...]) -> bool:
    flags = arguments[2]
    return isinstance(flags, int) and bool(flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT))


def ended_in_child(work: Callable[[], tuple[str, str | None]], folder: Path, writes: Sequence[Path]) -> Ending:
    """Do work in a child that stands in a folder and may write to some places; `work` says how it ended."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        _be_child(work, folder, writes, writing)
    os.close(writing)
    report = _heard(reading, time.monotonic() + MOST_WAIT_s)
    if report is None:
        os.kill(child, signal.SIGKILL)
    _, status, used = os.wait4(child, 0)
    os.close(reading)
    cpu, peak = used.ru_utime + used.ru_stime, 1024 * used.ru_maxrss
    if report is None:
        return Ending("hang", f"no end after {MOST_WAIT_s:g} s, {cpu:.1f} s of them at work", cpu, peak)
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        if number in (signal.SIGXCPU, signal.SIGKILL) and cpu > 0.9 * LONGEST_s:
            return Ending("hang", f"{cpu:.1f} s on the processor", cpu, peak)
        return Ending("crash", f"ended by {signal.Signals(number).name}", cpu, peak)
    if not report:
        return Ending("crash", f"ended with {os.waitstatus_to_exitcode(status)}", cpu, peak)
    how, wrong, deeds = json.loads(report)
    if peak > MOST_BYTES:
        wrong = wrong or f"{1e-9 * peak:.1f} GB of memory"
    return Ending(how, wrong, cpu, peak, tuple(deeds))


def _heard(pipe: int, until: float) -> bytes | None:
    """All that a child writes to a pipe before it closes it; None if it has not by then."""
    report = b""
    while (left := until - time.monotonic()) > 0.0:
        if select.select([pipe], [], [], left)[0]:
            part = os.read(pipe, 65_536)
            if not part:
                return report
            report += part
    return None


def _be_child(work: Callable[[], tuple[str, str | None]], folder: Path, writes: Sequence[Path], writing: int) -> None:
    """Work, report how it ended, and end."""
    try:
        os.chdir(folder)
        seconds = math.ceil(LONGEST_s)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 2))
        most = min(MOST_BYTES, *(one for one in resource.getrlimit(resource.RLIMIT_AS) if one > 0), MOST_BYTES)
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
        # Says where it hangs, whatever it does.
        faulthandler.register(signal.SIGXCPU, all_threads=False, chain=True)
        always = ("/dev/null", os.environ.get("WIREWEAR_CACHE", "/nowhere"))
        watch = Watch((*always, *(str(path.resolve()) for path in writes)))
        sys.addaudithook(watch)
        how, wrong = work()
        os.write(writing, json.dumps([how, wrong, watch.found]).encode())
    except BaseException:  # noqa: BLE001 - nothing of the child may go on in its parent's place
        traceback.print_exc()
        os._exit(1)
    os._exit(0)
