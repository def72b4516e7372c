"""The command line. Its entry point loads the commands, so that a program interrupted while it starts says so."""

import gc
import logging
import os
import sys
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wirewear.faces.streams import prepare_streams

if TYPE_CHECKING:
    from wirewear.faces.commands import cli, default_output

__all__ = ["cli", "default_output", "main"]

# A run makes and drops thousands of small objects an increment, next to none of them in circles: Python's default of
# 700 looks for circles all the time.
_OBJECTS_BETWEEN_COLLECTIONS = 50_000

#: The variable that has faults of the program itself shown in full.
_SHOWS_TRACEBACK = "WIREWEAR_TRACEBACK"


def main() -> None:
    """Entry point of the console script."""
    prepare_streams()
    # Without a home, matplotlib would speak of its own folders.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    # What is loaded here stays: looking through it for garbage, now or later, finds none.
    gc.disable()
    try:
        from wirewear.faces.commands import cli
    except KeyboardInterrupt:
        sys.stderr.write("wirewear: interrupted; nothing was written.\n")
        sys.exit(130)
    gc.freeze()
    gc.set_threshold(_OBJECTS_BETWEEN_COLLECTIONS)
    gc.enable()
    try:
        cli(prog_name="wirewear")
    except Exception as error:
        if os.environ.get(_SHOWS_TRACEBACK):
            raise
        sys.stderr.write(f"wirewear: {_place_of(error)}\n")
        sys.exit(1)


def _place_of(error: BaseException) -> str:
    """One sentence about a fault of the program itself."""
    *_, (frame, line) = traceback.walk_tb(error.__traceback__)
    where = f"{Path(frame.f_code.co_filename).name}, line {line}"
    said = " ".join(str(error).split())
    return (
        f"this should not have happened ({type(error).__name__} in {where}: {said}); "
        f"the same command with {_SHOWS_TRACEBACK}=1 shows all of it: please report that."
    )


def __getattr__(name: str) -> Any:
    if name in ("cli", "default_output"):
        from wirewear.faces import commands

        return getattr(commands, name)
    raise AttributeError(f"module 'wirewear.faces' has no attribute {name!r}")
