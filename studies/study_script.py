"""Commands of study scripts: expected errors are one sentence."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from inspect import getsourcefile, unwrap
from pathlib import Path
from typing import Any

import click

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
