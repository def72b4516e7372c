"""Consoles of commands: wide tables and progress bars."""

from rich.console import Console
from rich.progress import Progress, ProgressColumn


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
