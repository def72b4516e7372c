"""Where a test stands among running conditions: the displacement from which it slides, at each normal load.

After O. Vingsbo and S. Söderberg, Wear 126 (1988) 131: partial slip, mixed and gross slip over displacement and
load. The fresh contact slides as a whole from 3µP/(2K) on (Mindlin); a rig in series takes µP/K_rig more.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import radians
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry import Elastic
from wirewear.base.errors import StudyError
from wirewear.reference.cattaneo_mindlin import PartialSlipPoint, partial_slip_point
from wirewear.reference.hertz import contact_modulus, gap_curvatures, hertz_elliptic, tangential_contact_modulus
from wirewear.study import study_from_tables

Array = NDArray[np.float64]

#: Loads of the map, relative to the test's.
LOADS = np.geomspace(0.1, 10.0, 41)

#: A loop of this energy ratio is at the transition (S. Fouvry, P. Kapsa, L. Vincent, Wear 185 (1995) 35).
TRANSITION = 0.2


@dataclass(frozen=True)
class FreshContact:
    """What a study states of two bodies before they wear: materials, gap [1/mm], friction, rig [µm/N], load [N]."""

    bodies: tuple[Elastic, Elastic]
    gap_per_mm: tuple[float, float]
    friction: float
    rig_um_per_N: float
    normal_load_N: float

    @property
    def ball_diameter_mm(self) -> float:
        """Of the ball that leaves as large a gap on a flat; that of wires crossed at right angles is theirs."""
        small, large = self.gap_per_mm
        return float(1.0 / (small * large) ** 0.5)

    def at(self, load_N: float) -> tuple[PartialSlipPoint, float]:
        """Mindlin's contact on the circle of equal area under a load, and its peak pressure in MPa."""
        first, second = self.bodies
        hertz = hertz_elliptic(load_N, *self.gap_per_mm, contact_modulus(first, second))
        modulus = tangential_contact_modulus(first, second)
        return partial_slip_point(load_N, self.friction, hertz.contact_radius_mm, modulus), hertz.peak_pressure_MPa


@dataclass(frozen=True)
class RunningConditions:
    """Loads (n,) in N and the displacement amplitudes (n,) in µm from which the contact and the test slide."""

    normal_load_N: Array
    contact_um: Array
    test_um: Array


def fresh_contact(study: Mapping[str, Any]) -> FreshContact | None:
    """The contact of a resolved study; None where it states too little, or nothing rubs."""
    try:
        stated = study_from_tables(study, "the study")
    except StudyError:
        return None
    friction, rig = stated.contact.friction, stated.holder.tangential_stiffness_N_per_mm
    if friction <= 0.0:
        return None
    first, second = stated.bodies
    crossing = radians(stated.crossing_angle_deg)
    small, large, _ = gap_curvatures(first.curvatures_per_mm, second.curvatures_per_mm, crossing)
    compliance = 0.0 if isinstance(rig, str) else 1e3 / rig
    bodies, load = (first.material, second.material), stated.conditions.normal_load_N
    return FreshContact(bodies, (small, large), friction, compliance, load)


def running_conditions(study: Mapping[str, Any]) -> RunningConditions | None:
    """The transition of a resolved study; None where it states too little, or nothing rubs."""
    contact = fresh_contact(study)
    return None if contact is None else transition(contact, contact.normal_load_N * LOADS)


def transition(contact: FreshContact, loads_N: ArrayLike) -> RunningConditions:
    """The displacements from which a contact, and it together with its rig, slide as a whole."""
    loads = np.asarray(loads_N, dtype=np.float64)
    own = np.array([1e3 * contact.at(float(load))[0].full_slip_displacement_mm for load in loads])
    return RunningConditions(loads, own, own + contact.rig_um_per_N * contact.friction * loads)


def energy_ratio(energy_mJ: Array, amplitude_um: Array, force_N: Array) -> Array:
    """A = E_d/(4 δa Q*): 1 for a rectangle, 0.2 at the transition, 0 for a line; NaN where there is no box."""
    box = 4e-3 * amplitude_um * force_N
    return np.divide(energy_mJ, box, out=np.full_like(energy_mJ, np.nan), where=box > 0.0)
