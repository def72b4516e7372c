"""Group of all commands, which reports expected errors in one sentence with an exit code, and what the
commands share.
"""

import errno
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from math import isfinite
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource
from click.decorators import FC

from wirewear.base.errors import RunError, WirewearError, show_warnings_plainly
from wirewear.base.files import TABLE_FILE_NAME
from wirewear.base.memory import MOST_MEMORY_GB
from wirewear.base.recognising import example
from wirewear.base.units import Quantity
from wirewear.base.writing import usable_file, usable_folder, why_not_written

#: What can be said of a command that was interrupted.
GOES_ON = {
    "run": "--resume goes on from the last checkpoint",
    "converge": "the same command goes on",
    "sweep": "the same command goes on",
    "strand": "the same command goes on",
    "diagnose": "nothing was written",
    "follow": "the same command goes on",
}
WHOLE = "no file is left half written"


#: What stands for click's names of the kinds of numbers.
_NUMBERS = {"float": "number: a point is the decimal sign, as in 0.45", "integer": "whole number, such as 20"}

#: What shows the help of a group that is given no command, from click 8.2 on.
_SHOWS_HELP: tuple[type[Exception], ...] = tuple(
    kind for kind in (getattr(click.exceptions, "NoArgsIsHelpError", None),) if kind is not None
)


class Finite(click.FloatRange):
    """Type of an option: a finite number within a range; NaN is refused."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number. Raises click.BadParameter if it is not finite or not in the range."""
        number = float(super().convert(value, param, ctx))
        if not isfinite(number):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number


class StatedOption(click.types.FloatParamType):
    """Type of an option: a number with the unit and range of a study's key, with a hint if it seems to be in another
    unit.
    """

    name = "number"

    def __init__(self, quantity: Quantity) -> None:
        """Set the unit and range of the number."""
        self.quantity = quantity

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number. Raises click.BadParameter if it is not in the range."""
        try:
            return float(self.quantity(click.FLOAT.convert(value, param, ctx)))
        except ValueError as problem:
            self.fail(f"it {problem}.", param, ctx)


STRENGTH = StatedOption(Quantity("MPa", 5.0, 1e4))  #: Strengths of materials from lead to drawn steel.


class Given(click.Path):
    """Type of an argument: a file or folder to be read, or the name of a bundled example."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: str | os.PathLike[str], param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """The path as it is if it exists, else that of the bundled example of this name, else the path."""
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        return path if path.exists() else example(str(value)) or path


class OutputFolder(click.Path):
    """Type of an option: a folder to be written to, checked before anything is computed."""

    def __init__(self, *, of_record: bool = False) -> None:
        """Accept folders; of_record: True to accept also one that is a record."""
        super().__init__(path_type=Path)
        self.of_record = of_record

    def convert(self, value: str | os.PathLike[str], param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """The folder's path. Raises RunError if it has no name, no files can be written to it, or it is a record and
        must not be.
        """
        if not os.fspath(value):
            raise RunError("the output folder is given without a name: a point stands for the folder that you are in.")
        path = usable_folder(Path(os.fsdecode(super().convert(value, param, ctx))))
        if not self.of_record and (path / TABLE_FILE_NAME).exists():
            raise RunError(f"{path} is a record, whose files are not to be mixed with others: choose another folder.")
        return path


class OutputFile(click.Path):
    """Type of an option: a file to be written, checked before anything is computed."""

    def __init__(self) -> None:
        """Accept any path that is not a folder."""
        super().__init__(dir_okay=False, path_type=Path)

    def convert(self, value: str | os.PathLike[str], param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """The file's path. Raises RunError if it cannot be written."""
        return usable_file(Path(os.fsdecode(super().convert(value, param, ctx))))


class _OneSentence(click.ClickException):
    """Expected error, shown as one sentence without usage or traceback."""

    exit_code = 2

    def show(self, file: object = None) -> None:  # noqa: ARG002
        """Print the message on standard error, after the program's name; `file` is ignored."""
        click.echo(f"wirewear: {self.message}", err=True)


class _Misused(_OneSentence):
    """Wrong use of a command, shown with its usage, except for a wrong value, which is shown as one sentence."""

    def __init__(self, error: click.UsageError) -> None:
        """Take over the message of click's error."""
        said = re.sub(
            r"is not a valid (float|integer)( range)?",
            lambda found: f"is no {_NUMBERS[found[1]]}",
            error.format_message(),
        )
        super().__init__(f"{said[:1].lower()}{said[1:]}")
        wrong_value = isinstance(error, click.BadParameter) and not isinstance(error, click.MissingParameter)
        self._context = None if wrong_value else error.ctx

    def show(self, file: object = None) -> None:
        """Print on standard error the message, after the command's usage unless only a value was wrong."""
        if self._context is not None:
            usage, path = self._context.get_usage(), self._context.command_path
            click.echo(f"{usage}\nTry '{path} --help' for help.\n", err=True)
        super().show(file)


@contextmanager
def _misuse_reported() -> Iterator[None]:
    """Convert click's usage errors inside this context to one-sentence errors."""
    try:
        yield
    except _SHOWS_HELP:
        raise
    except click.UsageError as error:
        raise _Misused(error) from error


@contextmanager
def _unwritten_reported() -> Iterator[None]:
    """Convert errors of reading and writing inside this context, standard output included, to one-sentence errors."""
    try:
        try:
            yield
        finally:
            # A full disk is to be reported in time.
            sys.stdout.flush()
    except OSError as error:
        if error.errno == errno.EPIPE:
            raise  # whoever read has seen enough, which click knows
        _give_up_unwritten()
        where, why = error.filename or "the output", why_not_written(error)
        # What has no number is a library's, in words of its own.
        said = f"{where} can be neither read nor written: {why}" if error.errno else why
        raise _OneSentence(f"{said}.") from error


class _Listed(click.Group):
    """Group whose help lists commands with their whole first sentences."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Add the list of commands to the help."""
        rows = [(name, self.commands[name].get_short_help_str(limit=400)) for name in self.list_commands(ctx)]
        with formatter.section("Commands"):
            formatter.write_dl(rows)


class Commands(_Listed):
    """Group of commands that reports expected errors in one sentence, with exit code 2, and an interruption with
    130.
    """

    group_class = _Listed
    goes_on: Mapping[str, str] = GOES_ON

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the arguments before the command, and return those left over."""
        with _misuse_reported(), _unwritten_reported():
            return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> object:
        """Run the command and return its result. Raises a click exception with one sentence for expected errors."""
        try:
            with warnings.catch_warnings(), _misuse_reported(), _unwritten_reported():
                show_warnings_plainly()
                return super().invoke(ctx)
        except (KeyboardInterrupt, SystemError) as error:
            # What is interrupted within a compiled function comes as a fault of the interpreter's.
            if not _interrupted(error):
                raise
            click.echo(f"wirewear: interrupted; {self.goes_on.get(ctx.invoked_subcommand or '', WHOLE)}.", err=True)
            ctx.exit(130)  # what shells report for a program ended by Ctrl-C
        except WirewearError as error:
            raise _OneSentence(str(error)) from error


def _interrupted(error: BaseException | None) -> bool:
    """True if an error is, or follows from, an interruption, however many compiled functions it passed through."""
    return error is not None and (
        isinstance(error, KeyboardInterrupt) or _interrupted(error.__cause__ or error.__context__)
    )


def _give_up_unwritten() -> None:
    """Redirect standard output to the null device if it cannot be written, so that Python does not complain at
    its end.
    """
    try:
        sys.stdout.flush()
    except OSError:
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="wirewear", prog_name="wirewear")
def cli() -> None:
    """Simulate fretting tests of wires, balls on flats and line contacts, and say why a measured one differs."""


def _allow_memory(context: click.Context, _parameter: click.Parameter, gigabytes: float | None) -> None:
    """Set the memory limit in gigabytes for this command and the processes that it starts."""
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
    type=Finite(0.0, min_open=True),
    expose_value=False,
    callback=_allow_memory,
    help="Memory that may be used.  [default: what is free]",
)


def _draw_for_a_journal(context: click.Context, _: click.Parameter, wanted: bool) -> None:
    from wirewear.pictures.style import on_paper

    if wanted:
        context.with_resource(on_paper())


#: An option of commands that look at recorded cycles of a result.
recorded_cycles = click.option(
    "--cycle", "cycles", type=Finite(0.0), multiple=True, help="May be repeated.  [default: all recorded ones]"
)


#: An option of commands that leave pictures as files.
paper = click.option(
    "--paper",
    is_flag=True,
    expose_value=False,
    callback=_draw_for_a_journal,
    help="Draw for a journal of two columns: its sizes and letters, 600 dots per inch.",
)


#: An option of commands that look at the loops of one block of a record's programme.
of_block = click.option(
    "--block",
    type=click.IntRange(1),
    help="Of a programme, whose loops are looked at.  [default: the longest stroke; diagnose: all]",
)


#: An option of commands whose tasks a cluster can do.
scheduler_option = click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Dask cluster, such as tcp://10.0.0.1:8786, instead of --jobs; its workers must see the same folders.",
)


#: An option of commands that write what may take another's place.
overwrite_record = click.option("--overwrite", is_flag=True, help="Also in place of what was not made in the same way.")


def a_list(*names: str, form: str) -> Callable[[FC], FC]:
    """Decorator that adds an option with a comma-separated list; repeated uses are joined to one text. form: the list's
    form or an example, for the help.
    """
    joined, text = (lambda *given: ",".join(given[-1])), f"Separated by commas: {form}"
    return click.option(*names, metavar="LIST", multiple=True, callback=joined, help=text)


@contextmanager
def busy(doing: str, *, long: bool = False) -> Iterator[None]:
    """Context that shows the text `doing` on standard error while its work is done: on a terminal as a status,
    elsewhere, if `long`, as a line. Runs show their own progress: `wirewear.simulation.ProgressBar`.
    """
    from rich.console import Console

    console = Console(stderr=True)
    if long and not console.is_interactive:
        click.echo(f"wirewear: {doing}", err=True)
    with console.status(doing):
        yield


stage = partial(busy, long=True)  #: A stage of a command that takes long.


def given(option: str) -> bool:
    """True if an option of the present command was given on the command line; option: the name of its parameter."""
    return click.get_current_context().get_parameter_source(option) is ParameterSource.COMMANDLINE


def beside(result_path: Path) -> Path:
    """The folder of a result that is named by its folder or by its file."""
    return result_path if result_path.is_dir() else result_path.parent


def default_output(study_path: Path) -> Path:
    """Default folder for a study's results: runs/ with the name of the file or, if that is study.toml, of its
    folder.
    """
    full = study_path.resolve()
    return Path("runs") / (full.parent.name if full.stem == "study" and full.parent.name else full.stem)
