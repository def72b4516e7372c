"""The command line. Its entry point loads the commands, so that a program interrupted while it starts says so."""

import gc
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wirewear.cli.commands import cli, default_output

__all__ = ["cli", "default_output", "main"]

# A run makes and drops thousands of small objects an increment, next to none of them in circles: Python's default of
# 700 looks for circles all the time.
_OBJECTS_BETWEEN_COLLECTIONS = 50_000


def main() -> None:
    """Entry point of the console script."""
    # What is loaded here stays: looking through it for garbage, now or later, finds none.
    gc.disable()
    try:
        from wirewear.cli.commands import cli
    except KeyboardInterrupt:
        sys.stderr.write("wirewear: interrupted; nothing was written.\n")
        sys.exit(130)
    gc.freeze()
    gc.set_threshold(_OBJECTS_BETWEEN_COLLECTIONS)
    gc.enable()
    cli(prog_name="wirewear")


def __getattr__(name: str) -> Any:
    if name in ("cli", "default_output"):
        from wirewear.cli import commands

        return getattr(commands, name)
    raise AttributeError(f"module 'wirewear.cli' has no attribute {name!r}")
