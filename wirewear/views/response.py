"""How a material answers: lines of equal tension at the edge of the fresh contact over displacement and load.

Maps of the material's response stand beside those of running conditions since L. Vincent, Y. Berthier, M. C. Dubourg
and M. Godet, Wear 153 (1992) 135: a contact that sticks in its middle cracks where it is overstressed, one that slides
as a whole wears. The stress here is the tension at the trailing edge of the fresh contact, the largest on the surface,
of the half-space in Cattaneo–Mindlin slip. Wear flattens a sliding contact and takes tension off it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wirewear.reference.cattaneo_mindlin import loading_displacement
from wirewear.reference.half_space import partial_slip_stress
from wirewear.views.run_maps import FreshContact

Array = NDArray[np.float64]

#: Shares of the sliding force at which the tension is computed; it begins with a vertical tangent.
SHARES = np.linspace(0.0, 1.0, 61) ** 3

#: Where none is asked for, lines begin at the tension of this share under the lowest load.
FROM_SHARE = 0.5

#: Loads of a line in partial slip; lines at most, where none is asked for.
POINTS, MOST_LINES = 41, 5


@dataclass(frozen=True)
class TensionLine:
    """Displacement amplitudes (n,) in µm and loads (n,) in N at which the edge's tension reaches a value."""

    tension_MPa: float
    displacement_um: Array
    normal_load_N: Array


def edge_tension(contact: FreshContact) -> Array:
    """Largest tension (SHARES) at the trailing edge over the peak pressure, of the body where it is larger.

    From (1 − 2ν)/3 without a tangential force to (1 − 2ν)/3 + µπ(4 + ν)/8 where all slides (Hamilton 1983).
    """
    stick = np.maximum(np.cbrt(1.0 - SHARES), 1e-6)
    found: Array = np.max(
        [
            [
                partial_slip_stress(
                    -1.0,
                    0.0,
                    0.0,
                    contact_radius_mm=1.0,
                    stick_radius_mm=float(centre),
                    peak_pressure_MPa=1.0,
                    friction=contact.friction,
                    poissons_ratio=body.poissons_ratio,
                )[..., 0]
                for centre in stick
            ]
            for body in contact.bodies
        ],
        axis=0,
    )
    return found


def tension_at(contact: FreshContact, displacement_um: float, load_N: float) -> float:
    """The edge's largest tension in MPa in a test of this displacement amplitude and load."""
    point, peak = contact.at(load_N)
    reached = 1e3 * loading_displacement(point, SHARES * point.limit_N) + contact.rig_um_per_N * SHARES * point.limit_N
    return float(peak * np.interp(np.interp(displacement_um, reached, SHARES), SHARES, edge_tension(contact)))


def tension_lines(
    contact: FreshContact, reach_um: float, loads_N: tuple[float, float], tensions_MPa: Sequence[float] = ()
) -> list[TensionLine]:
    """Lines of equal tension up to a displacement, between two loads; those of round values, where none is given.

    Where the contact slides as a whole a line goes on at the same load, as its tension grows no further.
    """
    shape = edge_tension(contact)
    peaks = [contact.at(load)[1] for load in loads_N]
    least = float(np.interp(FROM_SHARE, SHARES, shape))
    values = tensions_MPa or _round_values(peaks[0] * least, peaks[1] * float(shape[-1]))
    return [line for value in values if (line := _line(contact, shape, value, reach_um, loads_N)) is not None]


def _line(
    contact: FreshContact, shape: Array, tension_MPa: float, reach_um: float, loads_N: tuple[float, float]
) -> TensionLine | None:
    reference = contact.at(1.0)[1]
    # The peak pressure grows with the cube root of the load.
    all_slide, none_slides = ((tension_MPa / (reference * float(shape[end]))) ** 3 for end in (-1, 0))
    low, high = max(all_slide, loads_N[0]), min(none_slides, loads_N[1])
    if low >= high:
        return None
    x, y = [], []
    for load in np.geomspace(low, high, POINTS):
        point, peak = contact.at(float(load))
        share = float(np.interp(tension_MPa / peak, shape, SHARES))
        force = share * point.limit_N
        x.append(1e3 * float(loading_displacement(point, force)) + contact.rig_um_per_N * force)
        y.append(float(load))
    if all_slide >= loads_N[0] and reach_um > x[0]:
        x, y = [reach_um, *x], [y[0], *y]
    return TensionLine(tension_MPa, np.array(x), np.array(y))


def _round_values(low: float, high: float) -> list[float]:
    """At most MOST_LINES of 1, 2, 5, 10, ... between two values."""
    first = int(np.floor(np.log10(low)))
    found = [step * 10.0**power for power in range(first, first + 6) for step in (1.0, 2.0, 5.0)]
    return [value for value in found if low <= value <= high][-MOST_LINES:]
