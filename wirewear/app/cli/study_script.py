"""Parts shared by commands and study scripts: one-sentence errors, wide tables, progress bars."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from inspect import getsourcefile, unwrap
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import Progress, ProgressColumn

from wirewear.base.errors import ResultError, WirewearError
from wirewear.base.writing import why_not_written


class StudyScript(click.Command):
    """Command of a script: expected errors of wirewear, click and files are printed as one sentence that begins with
    the name of the script's file, with exit code 2.
    """

    def __init__(self, name: str | None, *, callback: Callable[..., Any], **attributes: Any) -> None:
        """Name the command after the file of `callback`; `name` is used if there is none."""
        file = getsourcefile(unwrap(callback))
        super().__init__(Path(file).stem if file else name, callback=callback, **attributes)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the arguments, and return those left over."""
        with _one_sentence(ctx):
            return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> object:
        """Run the script and return its result."""
        with _one_sentence(ctx):
            return super().invoke(ctx)


class _OfScript(click.ClickException):
    exit_code = 2

    def __init__(self, script: str | None, message: str) -> None:
        super().__init__(f"{script}: {message}")

    def show(self, file: object = None) -> None:  # noqa: ARG002
        click.echo(self.message, err=True)


@contextmanager
def _one_sentence(context: click.Context) -> Iterator[None]:
    try:
        yield
    except (click.MissingParameter, BrokenPipeError):
        raise
    except click.BadParameter as error:
        raise _OfScript(context.command.name, error.format_message()) from error
    except (WirewearError, ModuleNotFoundError) as error:
        raise _OfScript(context.command.name, str(error)) from error
    except OSError as error:
        reason = f"{error.filename or 'the output'} can be neither read nor written: {why_not_written(error)}."
        raise _OfScript(context.command.name, reason) from error


@contextmanager
def understanding(path: Path, what: str) -> Iterator[None]:
    """Context that converts missing or wrong entries of a file's tables to ResultError, which says that the file `path`
    is no `what`.
    """
    try:
        yield
    except (LookupError, TypeError, ValueError, AttributeError) as problem:
        raise ResultError(f"{path} is no {what} ({type(problem).__name__}: {problem}).") from None


def wide_console(width: int = 116) -> Console:
    """A rich console at least `width` characters wide."""
    console = Console()
    console.width = max(console.width, width)
    return console


def progress_bar(*columns: ProgressColumn) -> Progress:
    """A rich progress bar on standard error that vanishes at its end, and shows nothing without a terminal. columns: of
    the bar; rich's own if none are given.
    """
    console = Console(stderr=True)
    return Progress(*columns, console=console, transient=True, disable=not console.is_interactive)


def comparison_command(compare: Callable[[Path, Path], None]) -> click.Command:
    """The command RESULT_DIR [--output DIR] that calls `compare` with the result's folder and the pictures' folder."""

    @click.command(cls=StudyScript)
    @click.argument("result_dir", type=click.Path(path_type=Path))
    @click.option("--output", type=click.Path(path_type=Path), help="Picture folder.  [default: RESULT_DIR/comparison]")
    @wraps(compare)
    def main(result_dir: Path, output: Path | None) -> None:
        compare(result_dir, output or result_dir / "comparison")

    return main
