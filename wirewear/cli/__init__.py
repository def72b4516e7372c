"""The command line: one module for each family of commands, which join the group when they are imported."""

from wirewear.cli import blind_check, diagnosis, effects, records, studies
from wirewear.cli.group import cli, default_output

__all__ = ["blind_check", "cli", "default_output", "diagnosis", "effects", "main", "records", "studies"]


def main() -> None:
    """Entry point of the console script."""
    cli(prog_name="wirewear")
