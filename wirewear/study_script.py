"""What the scripts beside studies share: their arguments, one sentence for every mistake, a console for wide tables."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import click
from rich.console import Console

from wirewear.errors import WirewearError


class _OneSentence(click.ClickException):
    exit_code = 2

    def show(self, file: object = None) -> None:  # noqa: ARG002
        click.echo(f"compare: {self.message}", err=True)


@contextmanager
def one_sentence() -> Iterator[None]:
    """Within it, an error of wirewear or of the file system ends the script with one sentence and exit code 2."""
    try:
        yield
    except (WirewearError, OSError) as error:
        raise _OneSentence(str(error)) from error


def wide_console(width: int = 116) -> Console:
    """A console as wide as tables of figures need, also where no terminal states its width."""
    console = Console()
    console.width = max(console.width, width)
    return console


def comparison_command(compare: Callable[[Path, Path], None]) -> click.Command:
    """The command line RESULT_DIR [--output DIR] of a function of the result's folder and that of its pictures."""

    @click.command(help=compare.__doc__)
    @click.argument("result_dir", type=click.Path(path_type=Path))
    @click.option("--output", type=click.Path(path_type=Path), help="Picture folder.  [default: RESULT_DIR/comparison]")
    def main(result_dir: Path, output: Path | None) -> None:
        with one_sentence():
            compare(result_dir, output or result_dir / "comparison")

    return main
