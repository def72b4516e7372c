"""What a contact simulation remembers between increments, what its laws may know of it, and the rig."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from geometry.arrays import Array, BoolArray
from solvers.drive import Drive
from solvers.errors import SolverError


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
class Stroke:
    """Where the holder stood along a stroke from about +amplitude to -amplitude, (m,) each, mm."""

    drive: Array
    holder_x: Array


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
    slip_share: (n,) slip of the primary's nodes over the last increment over the drive's signed motion.
    load_share: what presses the holder down, but for its loading spring, over the test's normal load.
    bulk: (2, 2, 2) displacement gradients of the lower and the upper body's surface by their bulk stress, each in its
    body's axes, see `BulkStress.gradient`.  bulk_step: by how much they changed over the last increment.
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
    load_share: float = 1.0
    bulk: Array = field(default_factory=lambda: np.zeros((2, 2, 2)))
    bulk_step: Array = field(default_factory=lambda: np.zeros((2, 2, 2)))


@dataclass(frozen=True)
class IncrementReport:
    """What one increment did and how well it was solved; all but the drive is nothing where the bodies do not touch.

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
    tangential_force: float = 0.0
    normal_force: float = 0.0
    friction_work: float = 0.0
    iterations: int = 0
    pairings: int = 0
    active: int = 0
    sticking: int = 0
    contact_area: float = 0.0
    max_pressure: float = 0.0
    inner_pressure: float = 0.0
    half_width_x: float = 0.0
    half_width_y: float = 0.0
    force_error: float = 0.0
    penetration: float = 0.0
    complementarity: float = 0.0
    slip_direction_error: float = 0.0
    elastic_slip: float = 0.0


@dataclass(frozen=True)
class FirstGuess:
    """Where an increment is expected to end; units as in `ContactState`."""

    holder_x: float
    overlap_area: float
    traction: Array


@dataclass(frozen=True)
class Guide:
    """What m increments of a cycle ended with.

    phase: (m,) increasing share of the cycle passed since its +amplitude, in (0, 1].  drive, holder_x: (m,), mm.
    overlap_area: (m,), mm².  traction: (m, n, 3), MPa.
    """

    phase: Array
    drive: Array
    holder_x: Array
    overlap_area: Array
    traction: Array

    def at(self, phase: float, drive: float) -> FirstGuess | None:
        """The guess for an increment that ends at a drive, on the stroke to which a phase of the cycle belongs: where
        the holder stood at that drive, and the contact recorded nearest to it. None on a stroke not recorded.
        """
        falling = self.phase <= 0.5
        own = np.flatnonzero(falling if phase <= 0.5 else ~falling)
        if not len(own):
            return None
        nearest = own[int(np.argmin(np.abs(self.drive[own] - drive)))]
        # A stroke starts where the other one ends.
        before = np.flatnonzero(~falling if phase <= 0.5 else falling)[-1:]
        along = np.concatenate([before, own])
        along = along[np.argsort(self.drive[along], kind="stable")]
        return FirstGuess(
            holder_x=float(np.interp(drive, self.drive[along], self.holder_x[along])),
            overlap_area=float(self.overlap_area[nearest]),
            traction=self.traction[nearest],
        )

    def stroke(self, side: float) -> Stroke:
        """Where the holder stood from side x amplitude on to the other end, mirrored if side is -1, as in `wear_path`.

        A stroke that was not recorded is taken to be the mirror image of the other one.
        """
        falling = self.phase <= 0.5
        own = falling if side > 0.0 else ~falling
        if own.any():
            return Stroke(side * self.drive[own], side * self.holder_x[own])
        return Stroke(-side * self.drive, -side * self.holder_x)


def guide_from(phases: Array, states: list[ContactState]) -> Guide:
    """The guide that the states at the given phases of a cycle make."""
    order = np.argsort(phases, kind="stable")
    return Guide(
        phase=phases[order],
        drive=np.array([states[i].drive for i in order]),
        holder_x=np.array([states[i].holder_x for i in order]),
        overlap_area=np.array([states[i].overlap_area for i in order]),
        traction=np.array([states[i].traction for i in order]),
    )


@dataclass(frozen=True)
class Holder:
    """A holder that moves along the motion (x) and the normal (z) and may rotate about a pivot above the contact.

    normal_load_N: load when the bodies have just been pressed together.
    tangential_compliance_mm_per_N: of the spring to ground on the motion axis; 0 is a rigid rig.
    normal_stiffness_N_per_mm: of the loading spring; the load falls by this much per mm that the holder descends
    afterwards; 0 is a dead weight.
    rotational_compliance_rad_per_N_mm: of the spring that resists rotation about y; 0 holds it upright.
    pivot_height_mm: of the pivot above the contact plane.  The load acts through the pivot: when rotation carries the
    contact aside, it pushes it further, which takes normal_load_N times the height off the rotational stiffness.
    play_mm: total width of the free play in series with the springs: the holder floats without force between two stops.
    approach_mm: if given, the holder is lowered by this much after first touch and held there, whatever force that
    takes; normal_load_N is then only the force to be expected, which sets scales.
    Raises SolverError for a load, compliance, stiffness or play that cannot be, as effects may leave it.
    """

    normal_load_N: float
    tangential_compliance_mm_per_N: float = 0.0
    normal_stiffness_N_per_mm: float = 0.0
    rotational_compliance_rad_per_N_mm: float = 0.0
    pivot_height_mm: float = 0.0
    approach_mm: float | None = None
    play_mm: float = 0.0

    def __post_init__(self) -> None:
        if not self.normal_load_N > 0.0:
            raise SolverError(f"the normal load must be positive, but is {self.normal_load_N} N")
        springs = self.tangential_compliance_mm_per_N, self.normal_stiffness_N_per_mm
        if min(*springs, self.rotational_compliance_rad_per_N_mm, self.play_mm) < 0.0:
            raise SolverError("the holder's compliances, loading spring and free play must not be negative")

    @property
    def compliance_at_contact_mm_per_N(self) -> float:
        """Motion of the contact point along x per tangential force, translation and rotation together."""
        return self.tangential_compliance_mm_per_N + self.rotational_compliance_rad_per_N_mm * self.pivot_height_mm**2

    def place_in_play_mm(self, holder_x_mm: float, tilt_rad: float, tangential_force_N: float) -> float:
        """Where the holder stands between the stops: what the springs leave of its motion at the contact."""
        spring = self.tangential_compliance_mm_per_N * tangential_force_N
        return holder_x_mm - self.pivot_height_mm * tilt_rad - spring

    @property
    def tilt_per_motion_rad_per_mm(self) -> float:
        """Rotation of the holder per motion of the contact point along x by tangential force."""
        if self.rotational_compliance_rad_per_N_mm == 0.0 or self.pivot_height_mm == 0.0:
            return 0.0
        return self.rotational_compliance_rad_per_N_mm * self.pivot_height_mm / self.compliance_at_contact_mm_per_N

    def under(self, load_share: float) -> "Holder":
        """The holder under that share of its normal load."""
        return self if load_share == 1.0 else replace(self, normal_load_N=load_share * self.normal_load_N)

    def load_N(self, height_mm: float, pressed_height_mm: float) -> float:
        """Load at the holder's height, given its height when the bodies had just been pressed together."""
        return self.normal_load_N + self.normal_stiffness_N_per_mm * (height_mm - pressed_height_mm)


@dataclass(frozen=True)
class DriveTiming:
    """How fast the drive moves along its stroke; one of amplitude 0 is so slow that its speed counts for nothing."""

    drive: Drive = field(default_factory=lambda: Drive(0.0))
    frequency_Hz: float = 1.0

    def speed_mm_per_s(self, drive_mm: float, *, falling: bool) -> float:
        """Its speed where it is displaced by so much, on its way back or out."""
        amplitude = self.drive.amplitude_mm
        if amplitude == 0.0:
            return 0.0
        return amplitude * self.frequency_Hz * self.drive.waveform.speed(drive_mm / amplitude, falling=falling)


@dataclass(frozen=True)
class LocalState:
    """k nodes of the primary as they face the secondary; nothing is worked out before a law asks for it.

    wear: of both bodies.  of_primary, of_secondary: take a field (n,) of either patch to the nodes, (k,).
    sliding: their speeds (k,), mm/s.  primary_is_upper: which body is which.
    """

    wear: WearState
    of_primary: Callable[[Array], Array]
    of_secondary: Callable[[Array], Array]
    sliding: Callable[[], Array]
    primary_is_upper: bool

    @property
    def speed_mm_per_s(self) -> Array:
        """Sliding speed (k,); 0 where a node sticks."""
        return self.sliding()

    @property
    def energy_mJ_per_mm2(self) -> Array:
        """Friction energy (k,) per plane area that the surfaces have taken so far, as a mean of both."""
        primary, secondary = (energy.ravel() for energy in (self.wear.primary_energy, self.wear.secondary_energy))
        return 0.5 * (self.of_primary(primary) + self.of_secondary(secondary))
