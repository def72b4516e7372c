"""Command line, with standard streams that may be closed or unable to show special signs.

The entry point loads the commands itself, so that an interruption while the program starts is reported in one sentence.
"""

import atexit
import codecs
import gc
import io
import logging
import os
import signal
import sys
import traceback
import unicodedata
from collections.abc import Callable
from contextlib import suppress
from math import inf
from pathlib import Path
from threading import Thread
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wirewear.app.cli.commands import cli, default_output

__all__ = ["cli", "default_output", "main"]


_SHOWS_TRACEBACK = "WIREWEAR_TRACEBACK"  #: The variable that has faults of the program itself shown in full.
_QUIET = "WIREWEAR_QUIET"  #: The variable that has commands say no more than what they find.
SILENCE_s = 1.5  #: A command that has said nothing for so long says that it is at work.


#: Signs that Unicode itself has no plain spelling of.
_PLAIN = {
    "–": "-",
    "—": "-",
    "−": "-",
    "±": "+-",
    "·": "*",
    "×": "x",
    "→": "->",
    "≤": "<=",
    "≥": ">=",
    "≈": "~",
    "µ": "u",
    "°": " deg",
}


def main() -> None:
    """Run the command line: load the commands and execute the one asked for. Exits with 130 if interrupted while
    loading, with 1 after a fault of the program.
    """
    prepare_streams()
    # Whoever ends a command ends it as Ctrl-C does; one that is to outlive its terminal ignores that already.
    for name in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(name) is not signal.SIG_IGN:
            signal.signal(name, signal.default_int_handler)
    if not os.environ.get(_QUIET):
        command = next((word for word in sys.argv[1:] if not word.startswith("-")), "wirewear")
        speak_up(command, only_once=command in ("open", "follow"))  # which wait for a browser and a logger
    # Without a home, matplotlib would speak of its own folders, and so would OpenGL.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    os.environ.setdefault("MESA_SHADER_CACHE_DISABLE", "true")
    # What is loaded here stays: looking through it for garbage, now or later, finds none; nor does it at the end.
    gc.disable()
    try:
        from wirewear.app.cli.commands import cli
    except KeyboardInterrupt:
        sys.stderr.write("wirewear: interrupted; nothing was written.\n")
        sys.exit(130)
    gc.freeze()
    atexit.register(gc.freeze)
    # A run makes and drops thousands of small objects an increment, next to none of them in circles: Python's default
    # of 700 looks for circles all the time.
    gc.set_threshold(50_000)
    gc.enable()
    try:
        cli(prog_name="wirewear")
    except Exception as error:
        if os.environ.get(_SHOWS_TRACEBACK):
            raise
        sys.stderr.write(f"wirewear: {_place_of(error)}\n")
        sys.exit(1)


def speak_up(command: str, silence_s: float = SILENCE_s, *, only_once: bool = False) -> None:
    """Print to standard error that `command` is at work whenever nothing has been printed for `silence_s` seconds.

    On a terminal that is a line which disappears when something else is printed. only_once: never again once anything
    was printed.
    """
    started = last = monotonic()
    line, own, lasting = "", sys.stderr.write, sys.stderr.isatty() and not only_once

    def heard(write: Callable[[str], int]) -> Callable[[str], int]:
        def passed_on(text: str) -> int:
            nonlocal last, line
            # A stream that a pager holds up is no silence.
            last = inf
            if line:
                own(f"\r{' ' * len(line)}\r")
                sys.stderr.flush()
                line = ""
            try:
                return write(text)
            finally:
                last = monotonic()

        return passed_on

    for stream in (sys.stdout, sys.stderr):
        stream.write = heard(stream.write)  # type: ignore[method-assign]

    def watch() -> None:
        nonlocal last, line
        said = f"wirewear: {command} is at work"
        while not (only_once and last > started):
            sleep(min(max(last + silence_s - monotonic(), 0.02), silence_s))
            if monotonic() < last + silence_s:
                continue
            # Of a stream's own buffer the lock could be held when the program ends.
            with suppress(OSError, ValueError):
                os.write(sys.stderr.fileno(), (f"\r{said}" if lasting else f"{said}\n").encode())
            last, line = monotonic(), said if lasting else ""
            said = f"wirewear: {command} is at work, {last + silence_s - started:.0f} s"

    Thread(target=watch, daemon=True).start()


def _place_of(error: BaseException) -> str:
    """Sentence about an unexpected error of the program itself."""
    *_, (frame, line) = traceback.walk_tb(error.__traceback__)
    where = f"{Path(frame.f_code.co_filename).name}, line {line}"
    said = " ".join(str(error).split())
    return (
        f"this should not have happened ({type(error).__name__} in {where}: {said}); "
        f"the same command with {_SHOWS_TRACEBACK}=1 shows all of it: please report that."
    )


def prepare_streams() -> None:
    """Connect closed standard streams to the null device, and make output streams replace signs that they cannot show
    by plain ones.
    """
    codecs.register_error("wirewear.plain", _plainly)
    for descriptor, name in enumerate(("stdin", "stdout", "stderr")):
        stream = getattr(sys, name)
        if stream is None:
            # Else the next file that is opened takes the number, and whatever libraries print goes into it.
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != descriptor:
                os.dup2(opened, descriptor)
                os.close(opened)
            os.set_inheritable(descriptor, True)
            setattr(sys, name, open(descriptor, "w" if descriptor else "r", encoding="utf-8", closefd=False))  # noqa: SIM115 - as long as the program
        elif descriptor and isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="wirewear.plain")


def _plainly(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_plain(sign) for sign in error.object[error.start : error.end]), error.end


def _plain(sign: str) -> str:
    """ASCII for a sign: its usual replacement, its letter without accents, a Greek letter's name, or a
    question mark.
    """
    if sign in _PLAIN:
        return _PLAIN[sign]
    simple = unicodedata.normalize("NFKD", sign).encode("ascii", "ignore").decode()
    name = unicodedata.name(sign, "")
    return simple or (name.rpartition(" ")[2].lower() if name.startswith("GREEK") else "?")


def __getattr__(name: str) -> Any:
    if name in ("cli", "default_output"):
        from wirewear.app.cli import commands

        return getattr(commands, name)
    raise AttributeError(f"module 'wirewear.app.cli' has no attribute {name!r}")
