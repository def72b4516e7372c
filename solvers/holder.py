"""The rig that holds the upper body: what moves it and what resists."""

from dataclasses import dataclass

from solvers.errors import SolverError


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

    Raises:
        SolverError: a load, approach, compliance, stiffness or play that cannot be.
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
        if self.approach_mm is not None and not self.approach_mm > 0.0:
            raise SolverError(f"the approach must be positive, but is {self.approach_mm} mm")
        springs = (
            self.tangential_compliance_mm_per_N,
            self.normal_stiffness_N_per_mm,
            self.rotational_compliance_rad_per_N_mm,
        )
        if not self.play_mm >= 0.0:
            raise SolverError(f"the holder's free play must not be negative, but is {self.play_mm} mm")
        if min(springs) < 0.0:
            raise SolverError("the holder's compliances and its loading spring's stiffness must not be negative")

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

    def load_N(self, height_mm: float, pressed_height_mm: float) -> float:
        """Load at the holder's height, given its height when the bodies had just been pressed together."""
        return self.normal_load_N + self.normal_stiffness_N_per_mm * (height_mm - pressed_height_mm)
