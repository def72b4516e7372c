"""Sign and plausibility of the normal force of measured loops, which is positive when it presses."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from geometry.arrays import Array, BoolArray
from wirewear.base.errors import RecordError
from wirewear.base.units import FIELD_UNITS
from wirewear.records.values import MeasuredLoop
from wirewear.test.lengths import extent_of

OTHER_UNIT = 4.0  #: A load off by this factor is in another unit: the nearest one, the pound, is 4.45 N.
NOTHING = 0.01  #: A normal force that never reaches this share of the load is a channel that nothing is connected to.

TURNED = (
    "the normal force was negative where it presses, as some load cells count it, and was turned round; in a mapping, "
    "factor = -1 does so"
)

_NAMES = {"mN": "millinewtons", "gf": "gram-force", "kgf": "kilogram-force", "kN": "kilonewtons", "lbf": "pounds"}


def pressing(loops: Sequence[MeasuredLoop]) -> tuple[tuple[MeasuredLoop, ...], tuple[str, ...]]:
    """Loops whose normal force is positive when it presses, and a sentence if its sign was changed.

    The sign is changed in all loops if the force is negative throughout most of them; zeros, where the contact opens,
    count as neither sign.
    """
    extents = _extents(loops)
    known = np.isfinite(extents[:, 0])
    negative = (extents[:, 1] <= NOTHING * -extents[:, 0]) & (extents[:, 0] < 0.0)
    if not known.any() or 2 * np.count_nonzero(negative) <= np.count_nonzero(known):
        return tuple(loops), ()
    return tuple(
        loop if loop.normal_force_N is None else replace(loop, normal_force_N=0.0 - loop.normal_force_N)
        for loop in loops
    ), (TURNED,)


def impossible_loads(
    loops: Sequence[MeasuredLoop], load_N: float, length_mm: float | None = None
) -> Iterator[tuple[str, BoolArray]]:
    """Reasons why the normal force of most loops is impossible, each the beginning of a sentence with marks (n,) of
    these loops. load_N: load that was asked for. length_mm: of a line contact, whose forces may have been logged per
    millimetre; None for contacts at a point.
    """
    low, high = _extents(loops).T
    middle = np.array([median_load_N(loop) for loop in loops])
    known = np.isfinite(middle)
    least, most = np.array([_quantiles(loop.tangential_force_N) for loop in loops]).reshape(-1, 2).T
    one_signed = (least > 0.0) | (most < 0.0)
    exchanged = (low < 0.0) & (high > 0.0) & (np.abs(high + low) < high - low) & one_signed
    largest = np.maximum(np.abs(low), np.abs(high))
    nothing = known & (largest < NOTHING * load_N)
    negative = known & ~exchanged & ~nothing & (high <= NOTHING * largest)
    ratio = np.abs(middle) / load_N
    with np.errstate(divide="ignore", invalid="ignore"):
        foreign = known & ~exchanged & ~nothing & (ratio > 0.0) & (np.abs(np.log(ratio)) > np.log(OTHER_UNIT))
    absent = "leave the column out if it was not measured, and the load asked for stands in for it"
    for wrong, words in (
        (exchanged, "changes its sign while the tangential force never does: the two columns seem exchanged"),
        (nothing, f"is zero where {load_N:g} N were asked for: {absent}"),
        (negative, "is negative where it must press: turn it round, by factor = -1 in a mapping"),
        (foreign, _unit(float(np.median(ratio[foreign])), load_N, length_mm) if foreign.any() else ""),
    ):
        if 2 * np.count_nonzero(wrong) > np.count_nonzero(known):
            yield f"The normal force {words}", wrong


def require_pressing(loops: Sequence[MeasuredLoop], load_N: float, length_mm: float | None = None) -> None:
    """Raise RecordError if the normal force of most loops is impossible; arguments as in `impossible_loads`."""
    for words, _ in impossible_loads(loops, load_N, length_mm):
        raise RecordError(f"{words}.")


def _unit(ratio: float, load_N: float, length_mm: float | None) -> str:
    """Beginning of a sentence on a load wrong by a factor, with the unit that would explain it."""
    known = {f"{name} (unit = {unit!r} in a mapping)": FIELD_UNITS["N"][unit] for unit, name in _NAMES.items()}
    known["newtons where the load asked for is in kilograms"] = 1.0 / FIELD_UNITS["N"]["kgf"]
    known = extent_of(length_mm).units({"the force of a millimetre": 1.0}) | known
    # By what share a load may have been set otherwise, or have changed, and its unit still be recognised.
    fitting = (name for name, newtons in known.items() if abs(np.log(ratio * newtons)) < 0.2)
    return f"is {ratio:.3g} times the {load_N:g} N asked for: it looks like {next(fitting, 'another unit or channel')}"


def _extents(loops: Sequence[MeasuredLoop]) -> Array:
    """The 2 % and 98 % quantiles of each loop's normal force (n, 2), NaN if not measured."""
    return np.array([_quantiles(loop.normal_force_N) for loop in loops]).reshape(-1, 2)


def _quantiles(channel: Array | None) -> tuple[float, float]:
    values = np.empty(0) if channel is None else channel[np.isfinite(channel)]
    if not values.size:
        return np.nan, np.nan
    low, high = np.percentile(values, [2, 98])
    return float(low), float(high)


def median_load_N(loop: MeasuredLoop) -> float:
    """Median of a loop's normal force in N; NaN if not measured."""
    values = np.empty(0) if loop.normal_force_N is None else loop.normal_force_N[np.isfinite(loop.normal_force_N)]
    return float(np.median(values)) if values.size else np.nan
