"""The group of commands, whose foreseeable errors end in one sentence and an exit code, and what they share."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from geometry import GeometryError
from solvers import SolverError
from wirewear import __version__
from wirewear.errors import KeptNothingWarning, WirewearError

INTERRUPTED = 130  # what shells report for a program ended by Ctrl-C


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
                return super().invoke(ctx)
        except (WirewearError, GeometryError, SolverError) as error:
            raise _OneSentence(str(error)) from error
        except KeyboardInterrupt:
            click.echo("wirewear: interrupted; the same command goes on with a batch; give a run --resume.", err=True)
            ctx.exit(INTERRUPTED)


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
