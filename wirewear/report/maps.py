"""Where a test stands among running conditions: the displacement from which it slides, at each normal load.

After O. Vingsbo and S. Söderberg, Wear 126 (1988) 131: partial slip, mixed and gross slip over displacement and
load. The fresh contact slides as a whole from 3µP/(2K) on (Mindlin); a rig in series takes µP/K_rig more.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry import Elastic
from wirewear.reference.cattaneo_mindlin import partial_slip_point
from wirewear.reference.elasticity import tangential_contact_modulus
from wirewear.reference.hertz import hertz_crossed_cylinders

Array = NDArray[np.float64]

#: Loads of the map, relative to the test's.
LOADS = np.geomspace(0.1, 10.0, 41)

#: A loop of this energy ratio is at the transition (S. Fouvry, P. Kapsa, L. Vincent, Wear 185 (1995) 35).
TRANSITION = 0.2


@dataclass(frozen=True)
class RunningConditions:
    """Loads (n,) in N and the displacement amplitudes (n,) in µm from which the contact and the test slide."""

    normal_load_N: Array
    contact_um: Array
    test_um: Array


def running_conditions(study: Mapping[str, Any]) -> RunningConditions | None:
    """The transition of a resolved study; None where it states too little, or nothing rubs."""
    try:
        wires, holder = study["wires"], study.get("holder", {})
        friction, load = float(study["contact"]["friction"]), float(study["conditions"]["normal_load_N"])
        moving, fixed = ({**wires, **wires.get(own, {})} for own in ("moving", "fixed"))
        first, second = (Elastic(one["youngs_modulus_MPa"], one["poissons_ratio"]) for one in (moving, fixed))
        radius_mm, other_mm = (0.5 * one["diameter_mm"] for one in (moving, fixed))
        angle = wires.get("crossing_angle_deg", 90.0)
    except (KeyError, TypeError):
        return None
    if friction <= 0.0:
        return None
    loads, modulus, contact = load * LOADS, tangential_contact_modulus(first, second), []
    for one in loads:
        hertz = hertz_crossed_cylinders(float(one), radius_mm, other_mm, angle, first=first, second=second)
        assumed = partial_slip_point(float(one), friction, hertz.contact_radius_mm, modulus)
        contact.append(1e3 * assumed.full_slip_displacement_mm)
    rig = holder.get("tangential_stiffness_N_per_mm", "rigid")
    lost = 0.0 * loads if rig == "rigid" else 1e3 * friction * loads / float(rig)
    return RunningConditions(loads, np.array(contact), np.array(contact) + lost)


def energy_ratio(energy_mJ: Array, amplitude_um: Array, force_N: Array) -> Array:
    """A = E_d/(4 δa Q*): 1 for a rectangle, 0.2 at the transition, 0 for a line; NaN where there is no box."""
    box = 4e-3 * amplitude_um * force_N
    return np.divide(energy_mJ, box, out=np.full_like(energy_mJ, np.nan), where=box > 0.0)
