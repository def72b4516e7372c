"""The state of a contact between increments, reports of increments, and the holder (the rig).

The primary is the body whose n patch nodes carry the tractions, the secondary the other one; a patch is the finely
meshed part of a body's surface, of (n_a, n_t) nodes along and across it. World axes: x along the motion, y across, z
upwards.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from geometry.arrays import Array, BoolArray
from solvers.contact_extent import Footprint
from solvers.drive import Drive
from solvers.errors import SolverError


@dataclass(frozen=True)
class WearState:
    """Worn depth (mm, along z) and friction energy per plane area (mJ/mm²) of both patches, each of its patch's shape
    (n_a, n_t); energy_mJ is the friction energy of the whole contact, the volumes are what has worn from each body.
    """

    primary_depth: Array
    secondary_depth: Array
    primary_energy: Array
    secondary_energy: Array
    energy_mJ: float = 0.0
    primary_volume_mm3: float = 0.0
    secondary_volume_mm3: float = 0.0
    #: Depth (n_a, n_t) in mm by which forces have flattened a body that yields; None if it is elastic. It is not wear:
    #: depths, energies and volumes above are without it.
    primary_print: Array | None = None
    secondary_print: Array | None = None  #: Depth likewise of the secondary.
    plastic_mJ: float = 0.0  #: Work that bodies with a pressure limit have taken up in their prints.
    #: Thickness (n_a, n_t) in mm of the primary's debris that is still between the surfaces; None where none leaves: it
    #: is the share of the worn depth that layers retain.
    primary_debris: Array | None = None
    secondary_debris: Array | None = None  #: Thickness likewise of the secondary's debris.
    debris_left_mm3: float = 0.0  #: Volume of the debris of both that has left, where it may.
    #: Rise (n_a, n_t) in K of the primary's temperature by friction, see `solvers.wear_step.warming`; None: not known.
    primary_rise: Array | None = None
    secondary_rise: Array | None = None  #: Rise likewise of the secondary.
    rise_K: float = 0.0  #: Mean rise where the cycle heats both.

    @property
    def depths(self) -> tuple[Array, Array]:
        return self.primary_depth, self.secondary_depth

    @property
    def prints(self) -> tuple[Array | None, Array | None]:
        """Prints, permanent depths by yielding, of (primary, secondary); None for an elastic body."""
        return self.primary_print, self.secondary_print

    @property
    def rises(self) -> tuple[Array, Array] | None:
        """Rises in K of the temperatures of (primary, secondary); None if they are not known."""
        if self.primary_rise is None or self.secondary_rise is None:
            return None
        return self.primary_rise, self.secondary_rise

    def debris(self, retained: float) -> tuple[Array, Array]:
        """Thickness in mm of the debris of (primary, secondary), by the share of worn depths that layers retain."""
        pair = self.primary_debris, self.secondary_debris
        primary, secondary = (
            retained * depth if own is None else own for own, depth in zip(pair, self.depths, strict=True)
        )
        return primary, secondary

    def opened(self, retained: float) -> tuple[Array, Array]:
        """Worn depths in mm of (primary, secondary) less what debris fills of them, see `debris`; without prints."""
        if retained == 0.0 and self.primary_debris is None:
            return self.depths
        primary, secondary = (depth - filled for depth, filled in zip(self.depths, self.debris(retained), strict=True))
        return primary, secondary


@dataclass(frozen=True)
class Stroke:
    """Displacements of the drive and positions of the holder, (m,) each in mm, at the ends of m increments from about
    +amplitude to -amplitude of the drive.
    """

    drive: Array
    holder_x: Array


@dataclass(frozen=True)
class ContactState:
    """State of a contact at the end of an increment; n counts nodes of the patch in question."""

    wear: WearState
    drive: float  #: Displacement of the lower body along x, mm.
    holder_x: float  #: Position of the upper body's holder along x, mm; 0 when the bodies first touch.
    holder_z: float  #: Its height, mm, 0 when the bodies first touch; negative once it has been lowered.
    holder_tilt: float  #: Rotation of the holder about its pivot, rad, positive if it moves the contact towards +x.
    #: Motion of the holder over that of the drive in the increment: near 1 if the contact sticks, near 0 if it slides.
    holder_rate: float
    overlap_area: float  #: Plane area on which the undeformed bodies overlap, mm².
    pressed_z: float  #: Holder's height in mm when the bodies had just been pressed together; NaN before.
    traction: Array  #: (n, 3) on the upper body at the primary's nodes, MPa of plane area, world axes.
    #: (n, 3) the tractions as nodal forces in N on the primary's patch, with the sign of the force on the upper body.
    primary_force: Array
    secondary_force: Array  #: (n, 3) likewise of the secondary.
    primary_slid: Array  #: (n,) distance in mm that each of the primary's nodes has slid under pressure so far.
    secondary_slid: Array  #: (n,) likewise of the secondary's nodes.
    #: (n,) nodes of the primary under pressure that have stuck ever since the bodies were pressed together.
    core: BoolArray
    pressed_ahead: float  #: drive less holder_x when the bodies were pressed together, mm.
    #: (n,) slip length of the primary's nodes in the last increment over the drive's signed motion in it.
    slip_share: Array
    #: (n,) factors on the friction law at nodes, see `solvers.wear_step.grip`; (0,): none.
    grip: Array = field(default_factory=lambda: np.ones(0))
    load_share: float = 1.0  #: Normal load, without the loading spring's part, over the test's normal load.
    #: (2, 2, 2) displacement gradients of the lower and the upper body's surface by their bulk stress, each in its
    #: body's axes, see `BulkStress.gradient`.
    bulk: Array = field(default_factory=lambda: np.zeros((2, 2, 2)))
    #: Change of `bulk` over the last increment.
    bulk_step: Array = field(default_factory=lambda: np.zeros((2, 2, 2)))


@dataclass(frozen=True)
class IncrementReport:
    """Results and residuals of one increment; all but the drive are 0 where the bodies do not touch. Residuals are
    shares, 0 if exact.
    """

    drive: float  #: At its end, mm.
    tangential_force: float = 0.0  #: Force on the upper body along x, N.
    normal_force: float = 0.0  #: Force on the upper body along z, N.
    friction_work: float = 0.0  #: For one cycle, mJ.
    iterations: int = 0  #: Newton steps.
    active: int = 0  #: Nodes in contact.
    sticking: int = 0  #: Nodes in contact that stick.
    max_pressure: float = 0.0  #: At any node, MPa.
    inner_pressure: float = 0.0  #: The largest away from the contact's rim, MPa, see `largest_within`.
    force_error: float = 0.0  #: |unbalanced force| / normal force.
    penetration: float = 0.0  #: Largest overlap over the largest elastic displacement.
    complementarity: float = 0.0  #: Largest |gap| of nodes under pressure over the largest elastic displacement.
    slip_direction_error: float = 0.0  #: Largest angle between friction and slip of nodes that slide, rad.
    #: Largest slip of sticking nodes, which a penalty formulation allows, over the largest elastic displacement.
    elastic_slip: float = 0.0
    footprint: Footprint | None = field(default=None, compare=False, repr=False)  #: Where the bodies touch.

    @property
    def contact_area(self) -> float:
        """Area of contact in the plane, mm²."""
        return self.footprint.area if self.footprint else 0.0

    @property
    def half_width_x(self) -> float:
        """Half of the contact's extent along x, mm."""
        return float(self.footprint.half_widths[0]) if self.footprint else 0.0

    @property
    def half_width_y(self) -> float:
        """Half of its extent along y, mm."""
        return float(self.footprint.half_widths[1]) if self.footprint else 0.0


@dataclass(frozen=True)
class FirstGuess:
    """First guess of the state at the end of an increment: the holder's position (mm), the overlap area (mm²) and
    tractions (n, 3) in MPa, as in `ContactState`.
    """

    holder_x: float
    overlap_area: float
    traction: Array


@dataclass(frozen=True)
class Guide:
    """Holder positions and tractions at the ends of m increments of a cycle, or of one stroke, as first guesses for a
    similar cycle.
    """

    phase: Array  #: (m,) increasing share of the cycle passed since its +amplitude, in (0, 1].
    drive: Array  #: (m,) displacement of the lower body, mm.
    holder_x: Array  #: (m,) position of the upper body's holder, mm.
    overlap_area: Array  #: (m,), mm².
    traction: Array  #: (m, n, 3), MPa.

    def at(self, phase: float, drive: float) -> FirstGuess | None:
        """The guess for an increment that ends at `drive` (mm) on the stroke that `phase` (share of the cycle passed;
        to -amplitude up to 0.5) belongs to; None if that stroke was not recorded.

        The holder's position is interpolated at that drive; area and tractions are those recorded nearest to it.
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
        """The holder's positions along the stroke that starts at +amplitude (`side` 1) or at -amplitude (-1, all signs
        then reversed), as `wear_path` needs. A stroke that was not recorded is taken as the mirror image of the other
        one.
        """
        falling = self.phase <= 0.5
        own = falling if side > 0.0 else ~falling
        if own.any():
            return Stroke(side * self.drive[own], side * self.holder_x[own])
        return Stroke(-side * self.drive, -side * self.holder_x)


def guide_from(phases: Array, states: list[ContactState]) -> Guide:
    """The guide from states at the phases (m,) of a cycle, its shares passed since +amplitude; in any order."""
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

    The load acts through the pivot: when rotation moves the contact aside, the load pushes it further, which reduces
    the rotational stiffness by normal_load_N times the pivot's height.

    Raises SolverError for a load that is not positive, or a negative compliance, stiffness or play.
    """

    normal_load_N: float  #: Load when the bodies have just been pressed together.
    tangential_compliance_mm_per_N: float = 0.0  #: Compliance of the spring to ground along x; 0: a rigid rig.

    #: Stiffness of the loading spring: the load falls by it per mm that the holder descends afterwards; 0: dead weight.
    normal_stiffness_N_per_mm: float = 0.0
    rotational_compliance_rad_per_N_mm: float = 0.0  #: Compliance against rotation about y; 0: it cannot rotate.
    pivot_height_mm: float = 0.0  #: Height of the pivot above the plane of contact.
    #: If given, the holder is lowered by this much after first touch and held there, whatever force that takes;
    #: normal_load_N is then only the force to be expected, which sets scales.
    approach_mm: float | None = None
    #: Total width of the free play in series with the springs: between two stops it floats without force.
    play_mm: float = 0.0
    mass_kg: float = 0.0  #: Mass that moves with it; contact and wear are solved as if it stood still.

    def __post_init__(self) -> None:
        if not self.normal_load_N > 0.0:
            raise SolverError(f"the normal load must be positive, but is {self.normal_load_N} N")
        springs = self.tangential_compliance_mm_per_N, self.normal_stiffness_N_per_mm
        if min(*springs, self.rotational_compliance_rad_per_N_mm, self.play_mm, self.mass_kg) < 0.0:
            raise SolverError("the holder's compliances, loading spring, free play and mass must not be negative")

    @property
    def compliance_at_contact_mm_per_N(self) -> float:
        """Motion of the contact point along x per tangential force: by the spring, and by rotation about the pivot."""
        return self.tangential_compliance_mm_per_N + self.rotational_compliance_rad_per_N_mm * self.pivot_height_mm**2

    def place_in_play_mm(self, holder_x_mm: float, tilt_rad: float, tangential_force_N: float) -> float:
        """Position of the holder between the stops of its free play, 0 in the middle: its motion along x less those by
        tilt and by the spring under the tangential force.
        """
        spring = self.tangential_compliance_mm_per_N * tangential_force_N
        return holder_x_mm - self.pivot_height_mm * tilt_rad - spring

    @property
    def tilt_per_motion_rad_per_mm(self) -> float:
        """Rotation of the holder per motion of the contact point on x by a tangential force; 0 if it cannot rotate."""
        if self.rotational_compliance_rad_per_N_mm == 0.0 or self.pivot_height_mm == 0.0:
            return 0.0
        return self.rotational_compliance_rad_per_N_mm * self.pivot_height_mm / self.compliance_at_contact_mm_per_N

    def under(self, load_share: float) -> "Holder":
        """The holder with its normal load multiplied by `load_share`; approach and springs stay."""
        return self if load_share == 1.0 else replace(self, normal_load_N=load_share * self.normal_load_N)

    def load_N(self, height_mm: float, pressed_height_mm: float) -> float:
        """Load at a height of the holder (mm), given its height when the bodies had just been pressed together: the
        loading spring adds its stiffness times the difference.
        """
        return self.normal_load_N + self.normal_stiffness_N_per_mm * (height_mm - pressed_height_mm)


@dataclass(frozen=True)
class DriveTiming:
    """The drive and its frequency, for sliding speeds; a drive of amplitude 0 stands for a negligible speed."""

    drive: Drive = field(default_factory=lambda: Drive(0.0))
    frequency_Hz: float = 1.0

    def speed_mm_per_s(self, drive_mm: float, *, falling: bool) -> float:
        """Speed of the drive at a displacement `drive_mm`, never negative; falling: on the stroke to -amplitude."""
        amplitude = self.drive.amplitude_mm
        if amplitude == 0.0:
            return 0.0
        return amplitude * self.frequency_Hz * self.drive.waveform.speed(drive_mm / amplitude, falling=falling)
