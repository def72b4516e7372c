"""The rig that holds the upper body: what moves it and what resists."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from solvers.contact_state import ContactState
from solvers.errors import SolverError
from solvers.wear_path import Stroke


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
    order = np.argsort(phases)
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
    Raises SolverError for a load, approach, compliance, stiffness or play that cannot be.
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
