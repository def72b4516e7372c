"""Columns of a line contact per mm of its length, as its tables for users and its earlier files name them."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from wirewear.results.checks import FloatArray
from wirewear.results.values import extensive, scaled

#: A body's column, the body last; per mm it stands first.
_OF_A_BODY = re.compile(r"(worn_volume|max_depth|left_edge|right_edge)_(pad|specimen)_(mm3|um)$")
_PER_MM = re.compile(r"(pad|specimen)_(worn_area|max_depth|left_edge|right_edge)_(um2|um)$")
_um2_PER_mm2 = 1e6


def per_mm(columns: Mapping[str, FloatArray], length_mm: float) -> dict[str, FloatArray]:
    """Columns of a contact of that length per mm of it; in place of worn volumes stand areas."""
    found = {}
    for name, column in scaled(columns, 1.0 / length_mm).items():
        if own := _OF_A_BODY.match(name):
            what, body, unit = own.groups()
            area = unit == "mm3"
            found[f"{body}_worn_area_um2" if area else f"{body}_{what}_um"] = column * _um2_PER_mm2 if area else column
        else:
            found[f"{name}_per_mm" if extensive(name) else name] = column
    return found


def whole(columns: Mapping[str, FloatArray]) -> dict[str, FloatArray]:
    """Columns per mm as those of a contact of one millimetre."""
    found = {}
    for name, column in columns.items():
        if own := _PER_MM.match(name):
            body, what, unit = own.groups()
            area = unit == "um2"
            new = f"worn_volume_{body}_mm3" if area else f"{what}_{body}_um"
            found[new] = np.asarray(column / _um2_PER_mm2 if area else column)
        else:
            found[name.removesuffix("_per_mm")] = column
    return found
