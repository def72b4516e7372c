"""All commands: one module for each family, which joins the group when it is imported."""

from wirewear.cli import blind_check, diagnosis, effects, records, studies
from wirewear.cli.group import cli, default_output

__all__ = ["blind_check", "cli", "default_output", "diagnosis", "effects", "records", "studies"]
