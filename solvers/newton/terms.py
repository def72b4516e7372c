"""The terms of the compiled equations of one pairing: named tuples of arrays over its k nodes and plain numbers.

Units are mm, N and MPa. A local frame is a node's normal and two tangents, see `Pairing`.
"""

from math import nan
from typing import NamedTuple

import numpy as np

from geometry.arrays import Array, BoolArray
from solvers.contact_conditions import Linearisation
from solvers.jit_cache import compiled, inlined

_HARDLY = 1e-6  # Of the largest pressure: a node under less carries nothing.


class Carried(NamedTuple):
    """Tractions of k nodes in world axes by normal traction p: `per_normal` (k, 3) times p plus `constant` (k, 3)."""

    per_normal: Array
    constant: Array
    shifted: bool  #: True if any entry of `constant` is not zero.


@inlined
def carried_by(nodes: "Nodes", state: "Iterate", laws: "LinearLaws") -> Carried:
    """World tractions of k nodes per normal traction; the linearised law acts where friction's direction is known."""
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
    """The k nodes of a pairing, and the holder's position before the increment. Fields are those of `Pairing` and
    `Linearisation`; old_sheared: (k, 3) displacement of layers by earlier tractions.
    """

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
    """A state of the iteration: tractions, the holder's position, gaps and slips, and the status of the k nodes.

    normal, tangential: (k,) and (k, 2) in local frames, MPa. height, holder_x, tilt: the holder's, mm and rad. gap,
    slip: (k,) and (k, 2), mm. elastic: largest elastic displacement, mm. active: (k,) nodes in contact. touching,
    fresh: their number, and how many of them are not yet known to the compliance. stick: (k,) nodes that stick.
    near_stick: (k,) nodes whose tangential tractions are unknowns, as they stick or slip little. follows: (k,) nodes
    that slip far, with a known direction of friction. verge: (k,) nodes at their limit within round-off, which may
    count as sticking or slipping. direction: (k, 2) unit vectors of friction. augmentation: (k,) MPa per mm of slip.
    limit: (k,) of friction, MPa.
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
    """Friction and layers at k nodes, (k,) each, linearised at pressures; terms of layers are zero without layers."""

    pressure: Array  #: At which is linearised, MPa.
    slope: Array  #: Derivative of friction's limit by pressure.
    offset: Array  #: The tangent of the limit extrapolated to zero pressure, MPa.
    closure: Array  #: The tangent of the layers' closure extrapolated to zero pressure, mm.
    softness: Array  #: Derivative of the closure by pressure, mm per MPa.
    shear: Array  #: Tangential displacement of layers per traction, mm per MPa.
    change: Array  #: Derivative of `shear` by pressure.


class HolderTerms(NamedTuple):
    """The holder's springs, load and pivot, as in `Holder`, and where it is held; `held_mm`, `height_mm` and
    `rigid_x_mm` are NaN unless it is held in that way.
    """

    pivot_mm: float
    normal_load_N: float
    load_N: float  #: Load at the holder's height 0.
    normal_N_per_mm: float
    tangential_mm_per_N: float
    rotational_rad_per_N_mm: float
    #: Compliance of contact and rig, which scales the equation of a holder that floats in its play.
    series_mm_per_N: float
    held_mm: float  #: Position in its free play at which the holder is held.
    height_mm: float  #: Prescribed height.
    rigid_x_mm: float  #: Constant of the equation that a rigid rig sets for the holder's position and tilt.


def nodes_of(system: Linearisation) -> Nodes:
    """The nodes of a linearisation, and the holder's position before the increment."""
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
    """Friction and layers of a linearised system at pressures (k,) in MPa."""
    tangent = system.friction.tangent(pressure)
    shear, change = sheared(system, pressure)
    if system.layers is None:
        none = np.zeros_like(pressure)
        return LinearLaws(pressure, *tangent, none, none, shear, change)
    closure, softness = system.layers.closure(pressure)
    return LinearLaws(pressure, *tangent, closure - softness * pressure, softness, shear, change)


def sheared(system: Linearisation, pressure: Array) -> tuple[Array, Array]:
    """Tangential displacement per traction (k,) in mm/MPa, besides the bodies' own, at pressures (k,) in MPa, and its
    derivative by these: of layers, and of nodes that touch only within the increment.

    Such a node carries tractions in proportion to how far the bodies go on from there along and across its surface.
    They go on by what its own tractions deform; in all they go further by the gap that was there, and along by as much
    more.
    """
    none = np.zeros_like(pressure)
    shear, change = (none, none) if system.layers is None else system.layers.shear_compliance(pressure)
    if system.late is None:
        return shear, change
    return _late_sheared(shear, change, system.late, pressure)


@compiled
def _late_sheared(shear: Array, change: Array, late: Array, pressure: Array) -> tuple[Array, Array]:
    """Compliances (k,) and their derivatives with those of nodes that touch late, see `sheared`."""
    hardly = 0.0
    for one in pressure:
        hardly = max(hardly, _HARDLY * one)
    added, changed = np.empty(len(late)), np.empty(len(late))
    for k in range(len(late)):
        carried = max(pressure[k], hardly)
        carried = carried if carried > 0.0 else 1.0
        added[k], changed[k] = shear[k] + late[k] / carried, change[k] - late[k] / carried**2
    return added, changed


def holder_terms(system: Linearisation, series_mm_per_N: float, held_mm: float | None) -> HolderTerms:
    """Load, springs, lever and play of a system's holder, as numbers for the compiled equations; NaN for none.

    held_mm: where within its free play the holder rests against a stop, None for a holder that floats between the
    stops. series_mm_per_N: compliance of contact and rig in series, by which the equation of a floating holder is
    scaled.
    """
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
