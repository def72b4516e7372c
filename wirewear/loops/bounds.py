"""Bounds that the figures of every loop obey, whatever was measured."""

from dataclasses import replace
from typing import Any

from wirewear.loops.figures import LoopFigures, Measured
from wirewear.loops.opening import MICROJOULE_IN_MILLIJOULE

UNTOLD = "the loop's width at its mid force cannot be told: slip_amplitude is any that its area allows"


def allowed_slip(slip_um: Measured, amplitude_um: Measured, energy_mJ: Measured, force_N: Measured) -> Measured:
    """δ0 between 0 and δa; where it lies farther beyond than noise explains, any that the box of the loop allows.

    `force_N` is the box's half height, the mean of the largest |Q| of both directions.
    """
    slip = bounded(slip_um, amplitude_um.value)
    if slip is not None:
        return slip
    energy_uJ = max(energy_mJ.value, 0.0) / MICROJOULE_IN_MILLIJOULE
    least = min(energy_uJ / max(4.0 * force_N.value, 1e-300), amplitude_um.value)
    return Measured(0.5 * (least + amplitude_um.value), (least, amplitude_um.value))


def within_bounds(found: LoopFigures) -> LoopFigures:
    """The figures with 0 ≤ A ≤ 1, 0 ≤ B ≤ 1 and 0 ≤ E_d/(4Pδ0) ≤ max|Q|/P.

    A loop lies within the box of its stroke and its forces. What noise alone puts beyond a bound is set to the bound;
    what lies farther beyond is left out with a note.
    """
    notes = list(found.notes)
    held: dict[str, Any] = {}
    for name in ("energy_ratio", "system_free_ratio", "friction_energy"):
        figure: Measured | None = getattr(found, name)
        high = found.friction_max.value if name == "friction_energy" and found.friction_max is not None else 1.0
        held[name] = None if figure is None else bounded(figure, high)
        if figure is not None and held[name] is None:
            notes.append(f"{name} as read, {figure.value:.3g}, lies beyond its bound {high:.3g} and is left out")
    return replace(found, notes=tuple(notes), **held)


def bounded(figure: Measured, high: float) -> Measured | None:
    """A figure between 0 and a bound, its interval likewise; None where all its interval lies beyond them.

    The bound itself is measured, so that an interval may end as far beyond it as coarse samples allow.
    """
    begin, end = figure.interval95
    if begin > high * (1.0 + ROUND_OFF) or end < -ROUND_OFF * high:
        return None
    value = min(max(figure.value, 0.0), high)
    return Measured(value, (max(min(begin, value), 0.0), max(min(end, high * (1.0 + ROUND_OFF)), value)))


#: What the arithmetic of a closed loop may pass a bound by: corners that coarse samples cut off are put in.
ROUND_OFF = 5e-3
