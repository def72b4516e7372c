"""What a contact simulation remembers between increments, and what it reports of each."""

from dataclasses import dataclass

from geometry.arrays import Array, BoolArray


@dataclass(frozen=True)
class WearState:
    """Worn depth (mm, vertical) and accumulated friction energy per plane area (mJ/mm²) of both patches.

    Each array has the shape (n_a, n_t) of its body's patch; `energy_mJ` is the accumulated total, and the
    volumes are what the wear law has taken from each body.
    """

    primary_depth: Array
    secondary_depth: Array
    primary_energy: Array
    secondary_energy: Array
    energy_mJ: float = 0.0
    primary_volume_mm3: float = 0.0
    secondary_volume_mm3: float = 0.0

    @property
    def depths(self) -> tuple[Array, Array]:
        """Worn depths of the primary and the secondary."""
        return self.primary_depth, self.secondary_depth


@dataclass(frozen=True)
class ContactState:
    """State at the end of an increment; lengths in mm, forces in N.

    drive: displacement of the lower body along x.  holder_x, holder_z: position of the upper body's holder.
    holder_tilt: rotation of the holder about its pivot, rad, positive when it moves the contact towards +x.
    holder_rate: holder's motion per drive's motion over the increment, which tells sticking (1) from sliding.
    overlap_area: plane area on which the undeformed bodies overlap, mm².
    pressed_z: its height when the bodies had just been pressed together (NaN before).
    traction: (n, 3) on the upper body at the primary's nodes, world axes, per plane area.
    primary_force, secondary_force: (n, 3) the tractions as nodal forces of each patch, both with the sign of the force
    on the upper body.
    primary_slid, secondary_slid: (n,) distance that each node of a patch has slid under pressure so far, mm.
    core: (n,) nodes of the primary under pressure that have stuck ever since the bodies were pressed together.
    pressed_ahead: drive less holder_x when they were.
    slip_share: (n,) slip of the primary's nodes over the last increment, as a share of the drive's motion.
    """

    wear: WearState
    drive: float
    holder_x: float
    holder_z: float
    holder_tilt: float
    holder_rate: float
    overlap_area: float
    pressed_z: float
    traction: Array
    primary_force: Array
    secondary_force: Array
    primary_slid: Array
    secondary_slid: Array
    core: BoolArray
    pressed_ahead: float
    slip_share: Array


@dataclass(frozen=True)
class IncrementReport:
    """What one increment did and how well it was solved.

    drive: at its end, mm.  tangential_force, normal_force: on the upper body along x and z, N.  friction_work: mJ.
    iterations: Newton steps.  pairings: times that the surfaces were paired.  active: nodes in contact.
    sticking: of these.  contact_area: mm² in the plane.  max_pressure: at any node, MPa.  inner_pressure: the largest
    away from the contact's rim, MPa, see `solvers.contact.acceptance`.  half_width_x, half_width_y: half extents of the
    contact, mm.
    force_error: |unbalanced force| / normal force.  penetration: largest overlap over the largest elastic displacement.
    complementarity: largest |gap| of nodes that carry pressure, likewise scaled.  slip_direction_error: largest angle
    between friction and slip of nodes that slide, rad.  elastic_slip: largest slip that a penalty formulation allows to
    sticking nodes, likewise scaled; 0 otherwise.
    """

    drive: float
    tangential_force: float
    normal_force: float
    friction_work: float
    iterations: int
    pairings: int
    active: int
    sticking: int
    contact_area: float
    max_pressure: float
    inner_pressure: float
    half_width_x: float
    half_width_y: float
    force_error: float
    penetration: float
    complementarity: float
    slip_direction_error: float
    elastic_slip: float
