"""All commands: importing a module adds its commands to the group."""

from wirewear.app.cli import fit, follow, heat, lab, life, loops, new, records, report, strand, stress, studies, sweeps
from wirewear.app.cli.group import cli, default_output

__all__ = [
    "cli", "default_output", "fit", "follow", "heat", "lab", "life", "loops", "new", "records", "report", "strand",
    "stress", "studies", "sweeps",
]  # fmt: skip
