"""What the compiled equations of one pairing are made of: arrays over its k nodes, and plain numbers."""

from math import nan
from typing import NamedTuple

import numpy as np

from geometry.arrays import Array, BoolArray
from solvers.contact_conditions import Linearisation
from solvers.jit_cache import inlined


class Carried(NamedTuple):
    """World tractions of k nodes: `per_normal` (k, 3) times the normal one, plus `constant` (k, 3)."""

    per_normal: Array
    constant: Array
    shifted: bool  #: Whether any constant is not zero.


@inlined
def carried_by(nodes: "Nodes", state: "Iterate", laws: "LinearLaws") -> Carried:
    """What nodes carry whose friction follows its direction, by the law's tangent; others their normal traction."""
    frames, direction = nodes.frames, state.direction
    per_normal, constant = np.empty((len(frames), 3)), np.zeros((len(frames), 3))
    shifted = False
    for k in range(len(frames)):
        for c in range(3):
            per_normal[k, c] = frames[k, 0, c]
            if state.follows[k]:
                along = direction[k, 0] * frames[k, 1, c] + direction[k, 1] * frames[k, 2, c]
                per_normal[k, c] += laws.slope[k] * along
                constant[k, c] = laws.offset[k] * along
                shifted |= constant[k, c] != 0.0
    return Carried(per_normal, constant, shifted)


class Nodes(NamedTuple):
    """The k nodes of a pairing and where the holder stood before the increment, all as in `Linearisation`."""

    frames: Array
    areas: Array
    gap: Array
    gap_rate: Array
    lever: Array
    old_displacement: Array
    old_sheared: Array
    drive_step: float
    old_holder_x: float
    old_height: float
    old_tilt: float
    paired_holder_x: float


class Iterate(NamedTuple):
    """Tractions (k,) and (k, 2) in local frames, the holder's position, what follows from them, and how nodes stand.

    gap, slip: (k,) and (k, 2).  elastic: largest elastic displacement.  Lengths in mm, tractions in MPa.
    active: (k,) nodes in contact; touching: their number, fresh: that of those whose responses are not known.
    stick, near_stick, follows: (k,) which of them stick, keep tangential unknowns as they are near enough to it, and
    are far from it.  verge: (k,) nodes at their limit but for round-off, which may stick or slip as well.
    direction: (k, 2) of friction.  augmentation: (k,) MPa per mm of slip.  limit: (k,) of friction, MPa.
    """

    normal: Array
    tangential: Array
    height: float
    holder_x: float
    tilt: float
    gap: Array
    slip: Array
    elastic: float
    active: BoolArray
    touching: int
    fresh: int
    stick: BoolArray
    near_stick: BoolArray
    follows: BoolArray
    verge: BoolArray
    direction: Array
    augmentation: Array
    limit: Array


class LinearLaws(NamedTuple):
    """Friction and layers at k nodes, linearised about pressures (k,). Those of layers are zero where there is none."""

    pressure: Array
    slope: Array  #: Of friction's limit.
    offset: Array  #: The limit's value at no pressure.
    closure: Array  #: Of layers, mm at no pressure.
    softness: Array  #: Its slope, mm per MPa.
    shear: Array  #: Tangential displacement of layers per traction.
    change: Array  #: Its derivative by the pressure.


class HolderTerms(NamedTuple):
    """The holder's springs and where it is held, as in `Holder`; NaN stands for what is not held."""

    pivot_mm: float
    normal_load_N: float
    load_N: float  #: At height 0.
    normal_N_per_mm: float
    tangential_mm_per_N: float
    rotational_rad_per_N_mm: float
    series_mm_per_N: float  #: Compliance of contact and rig, which scales the row of a holder that floats.
    held_mm: float  #: Place in its free play.
    height_mm: float  #: Prescribed.
    rigid_x_mm: float  #: Of a rigid rig.


def nodes_of(system: Linearisation) -> Nodes:
    """The nodes of a linearisation."""
    pairing, layers = system.pairing, system.layers
    return Nodes(
        frames=pairing.frames,
        areas=pairing.areas,
        gap=pairing.gap,
        gap_rate=pairing.gap_rate,
        lever=system.lever,
        old_displacement=system.old_displacement,
        old_sheared=np.zeros((len(pairing.nodes), 3)) if layers is None else layers.old_displacement,
        drive_step=system.drive_step,
        old_holder_x=system.old_holder_x,
        old_height=system.old_height,
        old_tilt=system.old_tilt,
        paired_holder_x=system.paired_holder_x,
    )


def linear_laws(system: Linearisation, pressure: Array) -> LinearLaws:
    """Friction and layers of a linearisation about pressures (k,)."""
    tangent = system.friction.tangent(pressure)
    if system.layers is None:
        none = np.zeros_like(pressure)
        return LinearLaws(pressure, *tangent, none, none, none, none)
    closure, softness = system.layers.closure(pressure)
    shear = system.layers.shear_compliance(pressure)
    return LinearLaws(pressure, *tangent, closure - softness * pressure, softness, *shear)


def holder_terms(system: Linearisation, series_mm_per_N: float, held_mm: float | None) -> HolderTerms:
    """The holder of a linearisation, held in its free play or floating."""
    holder, height = system.holder, system.prescribed_height
    rigid = holder.tangential_compliance_mm_per_N == 0.0 and holder.play_mm == 0.0
    return HolderTerms(
        pivot_mm=holder.pivot_height_mm,
        normal_load_N=holder.normal_load_N,
        load_N=holder.load_N(0.0, system.pressed_height),
        normal_N_per_mm=holder.normal_stiffness_N_per_mm,
        tangential_mm_per_N=holder.tangential_compliance_mm_per_N,
        rotational_rad_per_N_mm=holder.rotational_compliance_rad_per_N_mm,
        series_mm_per_N=series_mm_per_N,
        held_mm=nan if held_mm is None else held_mm,
        height_mm=nan if height is None else height,
        rigid_x_mm=holder.pivot_height_mm * system.old_tilt - system.old_holder_x if rigid else nan,
    )
