"""All commands: one module for each family, which joins the group when it is imported."""

from wirewear.faces import beginning, interior, life, loops, records, studies, sweeps
from wirewear.faces.group import cli, default_output

__all__ = ["beginning", "cli", "default_output", "interior", "life", "loops", "records", "studies", "sweeps"]
