"""What commands and the scripts beside studies share: one sentence for every mistake, wide tables, a progress bar."""

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
    """A script whose foreseeable errors end in one sentence that begins with its file's name, and in exit code 2."""

    def __init__(self, name: str | None, *, callback: Callable[..., Any], **attributes: Any) -> None:
        """The command, which goes by the name of its file."""
        file = getsourcefile(unwrap(callback))
        super().__init__(Path(file).stem if file else name, callback=callback, **attributes)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Read what was typed."""
        with _one_sentence(ctx):
            return super().parse_args(ctx, args)

    def invoke(self, ctx: click.Context) -> object:
        """Run the script."""
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
    """Within it, whatever is looked for in a file's tables and is not there is reported: the file is no `what`.
    Raises ResultError if a key, an entry or a number was missing, or something else stood in its place.
    """
    try:
        yield
    except (LookupError, TypeError, ValueError, AttributeError) as problem:
        raise ResultError(f"{path} is no {what} ({type(problem).__name__}: {problem}).") from None


def wide_console(width: int = 116) -> Console:
    """A console as wide as tables of figures need, also where no terminal states its width."""
    console = Console()
    console.width = max(console.width, width)
    return console


def progress_bar(*columns: ProgressColumn) -> Progress:
    """A bar on standard error that vanishes when it ends; without columns, rich's own.

    None off a terminal: there it would show nothing, and leave an empty line before whatever is said next.
    """
    console = Console(stderr=True)
    return Progress(*columns, console=console, transient=True, disable=not console.is_interactive)


def comparison_command(compare: Callable[[Path, Path], None]) -> click.Command:
    """The command line RESULT_DIR [--output DIR] of a function of the result's folder and that of its pictures."""

    @click.command(cls=StudyScript)
    @click.argument("result_dir", type=click.Path(path_type=Path))
    @click.option("--output", type=click.Path(path_type=Path), help="Picture folder.  [default: RESULT_DIR/comparison]")
    @wraps(compare)
    def main(result_dir: Path, output: Path | None) -> None:
        compare(result_dir, output or result_dir / "comparison")

    return main
