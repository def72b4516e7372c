"""Effects that the nominal model lacks, such as a compliant holder: each is a small object that changes one seam of it.

A seam is a place in the model where effects enter, with a description of what it is there: holder, loading, contact
law, wear law, specimens, drive or sensors.
"""

from typing import Any

from wirewear.base.errors import renamed
from wirewear.base.units import Quantity
from wirewear.effects.effect import COLUMNS, AnyEffect, Chain, Effect, Size, UnforeseenError
from wirewear.effects.measurements import Answer, Measurement
from wirewear.effects.parameter import Parameter, Stated, parameter
from wirewear.effects.registry import (
    ENTRY_POINT_GROUP,
    all_effects,
    all_measurements,
    distinguished_by,
    effect_named,
    effects_of_tables,
    splits,
    tables_of_effects,
)
from wirewear.effects.seams import Age, Ageing, ContactLaw, Control, Loading, Seam, Specimens, applied, problem_with

__all__ = [
    "COLUMNS", "ENTRY_POINT_GROUP", "Age", "Ageing", "Answer", "AnyEffect", "Chain", "ContactLaw", "Control", "Effect",
    "Loading", "Measurement", "Parameter", "Quantity", "Seam", "Size", "Specimens", "Stated", "UnforeseenError",
    "all_effects", "all_measurements", "applied", "distinguished_by", "effect_named", "effects_of_tables", "parameter",
    "problem_with", "splits", "tables_of_effects",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name == "told_apart_by":
        renamed("wirewear.effects.told_apart_by", "wirewear.effects.distinguished_by")
        return distinguished_by
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
