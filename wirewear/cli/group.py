"""The group of commands, whose foreseeable errors end in one sentence and an exit code, and what they share."""

import errno
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import click

from geometry import GeometryError
from solvers import SolverError
from wirewear import __version__
from wirewear.errors import KeptNothingWarning, WirewearError
from wirewear.files import why_not_written
from wirewear.files.budget import MOST_MEMORY_GB

INTERRUPTED = 130  # what shells report for a program ended by Ctrl-C

#: What can be said of a command that was interrupted.
GOES_ON = {
    "run": "--resume goes on from the last checkpoint",
    "converge": "the same command goes on",
    "blind": "the same command goes on with a batch",
    "diagnose": "nothing was written",
}
WHOLE = "no file is left half written"


class _OneSentence(click.ClickException):
    """An error of ours, shown without usage or traceback."""

    exit_code = 2

    def show(self, file: object = None) -> None:  # noqa: ARG002
        """Print the sentence on standard error."""
        click.echo(f"wirewear: {self.message}", err=True)


class _Commands(click.Group):
    """Commands whose foreseeable errors end in one sentence and an exit code."""

    def invoke(self, ctx: click.Context) -> object:
        """Run the command that was asked for."""
        try:
            with warnings.catch_warnings():
                warnings.showwarning = _warning_shown(warnings.showwarning)
                outcome = super().invoke(ctx)
            # A full disk is to be told in time.
            sys.stdout.flush()
        except (WirewearError, GeometryError, SolverError) as error:
            raise _OneSentence(str(error)) from error
        except KeyboardInterrupt:
            click.echo(f"wirewear: interrupted; {GOES_ON.get(ctx.invoked_subcommand or '', WHOLE)}.", err=True)
            ctx.exit(INTERRUPTED)
        except OSError as error:
            if error.errno == errno.EPIPE:
                raise  # whoever read has seen enough, which click knows
            _give_up_unwritten()
            where = error.filename or "the output"
            raise _OneSentence(f"{where} can be neither read nor written: {why_not_written(error)}.") from error
        return outcome


def _give_up_unwritten() -> None:
    """Leave what standard output does not take: at its end, Python would try again and complain."""
    try:
        sys.stdout.flush()
    except OSError:
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _warning_shown(otherwise: Callable[..., None]) -> Callable[..., None]:
    """Our own warnings as one sentence; others as they were shown."""

    def shown(message: Warning | str, category: type[Warning], *where: Any) -> None:
        if issubclass(category, KeptNothingWarning):
            click.echo(f"wirewear: {message}", err=True)
        else:
            otherwise(message, category, *where)

    return shown


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="wirewear")
def cli() -> None:
    """Simulate the crossed-wire fretting test: contact, friction, wear and the compliance of the rig."""


def _allow_memory(context: click.Context, _parameter: click.Parameter, gigabytes: float | None) -> None:
    """Let the command, and the processes that it starts, use that much."""
    if gigabytes is not None:
        before = os.environ.get(MOST_MEMORY_GB)
        os.environ[MOST_MEMORY_GB] = str(gigabytes)
        context.call_on_close(lambda: _restore(before))


def _restore(before: str | None) -> None:
    os.environ.pop(MOST_MEMORY_GB, None)
    if before is not None:
        os.environ[MOST_MEMORY_GB] = before


#: An option of commands that may ask for more memory than there is.
most_memory = click.option(
    "--most-memory",
    metavar="GB",
    type=click.FloatRange(0.0, min_open=True),
    expose_value=False,
    callback=_allow_memory,
    help="Memory that may be used.  [default: what is free]",
)


@contextmanager
def busy(doing: str) -> Iterator[None]:
    """Say on a terminal's standard error what is going on, for as long as it does."""
    from rich.console import Console

    with Console(stderr=True).status(doing):
        yield


def default_output(study_path: Path) -> Path:
    """Where a study's results go: into runs/, under the file's name, or its folder's if that name is study.toml."""
    full = study_path.resolve()
    return Path("runs") / (full.parent.name if full.stem == "study" and full.parent.name else full.stem)
