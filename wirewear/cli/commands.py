"""All commands: one module for each family, which joins the group when it is imported."""

from wirewear.cli import (
    beginning,
    diagnosis,
    effects,
    interior,
    loops,
    maps,
    materials,
    records,
    resolution,
    results,
    studies,
    sweeps,
)
from wirewear.cli.group import cli, default_output

__all__ = [
    "beginning",
    "cli",
    "default_output",
    "diagnosis",
    "effects",
    "interior",
    "loops",
    "maps",
    "materials",
    "records",
    "resolution",
    "results",
    "studies",
    "sweeps",
]
