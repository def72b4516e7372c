"""Everything that is true of one test: specimens, loading, friction, layers, wear, rig, drive and sensors.

Lengths in mm, forces in N, stresses in MPa, energies in mJ, angles in rad, times in s.
"""

from dataclasses import dataclass, field, replace
from math import inf, prod
from typing import Protocol

from studies.blind.generators.ageing import Factor
from studies.blind.generators.independent.friction import Joint
from studies.blind.generators.independent.marks import Groove, Incident
from studies.blind.generators.signals import Instrument
from studies.blind.generators.waveform import Waveform
from wirewear.base.course import Course


@dataclass(frozen=True)
class Specimens:
    """Two wires: the crossing angle's error turns the fixed one; flattening is the approach lost to plasticity.

    `fixed_crown` is the fixed wire's radius at its crown over that of a round one. `old_scar_mm` is the depth of a scar
    that the fixed wire brought along, its middle so far aside across the motion; `grooves` are marks of drawing on it.
    """

    radius_mm: float
    youngs_modulus_MPa: float
    poissons_ratio: float
    crossing_error_rad: float = 0.0
    flattening_mm: float = 0.0
    fixed_crown: float = 1.0
    old_scar_mm: float = 0.0
    old_scar_aside_mm: float = 0.0
    grooves: tuple[Groove, ...] = ()


@dataclass(frozen=True)
class Loading:
    """A load on a guide: drifting, softened by its spring, tilted, and raised towards the stroke's ends by `bowl`.

    `slant` raises it towards one end; `events` are factors over the cycles.
    """

    load_N: float
    spring_N_per_mm: float = 0.0
    drift_per_cycle: float = 0.0
    tilt_rad: float = 0.0
    bowl: float = 0.0
    slant: float = 0.0
    events: tuple[Factor, ...] = ()

    def load_at(self, cycle: float) -> float:
        """Load in the middle of the stroke, before the spring loses any [N]."""
        load = self.load_N * max(1.0 + self.drift_per_cycle * cycle, 0.01)
        return load * prod(event.at(cycle) for event in self.events)


@dataclass(frozen=True)
class Friction:
    """Friction over the cycles, and what departs from dry friction within one.

    `slant` raises it towards one end of the stroke, `ripple` is a wave of a length along it.
    """

    course: Course
    law: str = "dahl"
    events: tuple[Factor, ...] = ()
    velocity_sensitivity: float = 0.0
    adhesion: float = 0.0
    adhesion_length_mm: float = 3e-3
    slant: float = 0.0
    ripple: float = 0.0
    ripple_length_mm: float = 1e-2

    def at(self, cycle: float) -> float:
        """Coefficient at a cycle."""
        value = self.course.at(cycle)
        for event in self.events:
            value *= event.at(cycle)
        return value


@dataclass(frozen=True)
class Layers:
    """Rough layer that wears in, and debris that stays: a share of the worn depth, of some modulus.

    Debris lies as thick as the depth's share, times the depth over the deepest one to the power of `gathering`; it
    grows no thicker than `full_mm`.
    """

    rough_mm: Course = field(default_factory=lambda: Course.constant(0.0))
    retained: float = 0.0
    debris_modulus_MPa: float = 1e4
    gathering: float = 1.0
    full_mm: float = inf


@dataclass(frozen=True)
class Wear:
    """Worn volume per friction work [mm³/mJ], times a factor; the moving wire loses its share.

    It is worn by the pressure over a reference to the power `pressure_exponent`, too. `skin_factor` is a further factor
    at the surfaces of the unworn wires, of which the e-th part is left `skin_mm` below. `slant` raises wear towards one
    end of the stroke.
    """

    coefficient_mm3_per_mJ: float
    moving_share: float = 0.5
    factor: Course = field(default_factory=lambda: Course.constant(1.0))
    events: tuple[Factor, ...] = ()
    pressure_exponent: float = 0.0
    reference_MPa: float = 1.0
    skin_factor: float = 1.0
    skin_mm: float = 1e-3
    slant: float = 0.0

    def factor_at(self, cycle: float) -> float:
        """The factor at a cycle."""
        value = self.factor.at(cycle)
        for event in self.events:
            value *= event.at(cycle)
        return value


class Ageing(Protocol):
    """A part of the rig that does not stay as it was."""

    def mm_per_N(self, cycle: float, /) -> float:
        """What it has come to give way by at a cycle, in series with the contact."""
        ...

    def play_mm(self, cycle: float, /) -> float:
        """How much play it has come to have."""
        ...


@dataclass(frozen=True)
class Rig:
    """What yields between contact and ground.

    `hardening_mm_per_N3` is a holder that stiffens: it gives way by c Q − h Q³; what is `ageing` gives way more over a
    test, and `joints` give way by laws of their own.
    """

    compliance_mm_per_N: float = 0.0
    rotational_compliance_rad_per_N_mm: float = 0.0
    arm_mm: float = 0.0
    play_mm: float = 0.0
    hardening_mm_per_N3: float = 0.0
    ageing: tuple[Ageing, ...] = ()
    joints: tuple[Joint, ...] = ()

    def loose_mm_per_N(self, cycle: float) -> float:
        """What has come loose by a cycle."""
        return sum((part.mm_per_N(cycle) for part in self.ageing), 0.0)

    def aged(self, cycle: float) -> "Rig":
        """The rig with the play that it has by a cycle."""
        return replace(self, play_mm=self.play_mm + sum(part.play_mm(cycle) for part in self.ageing))

    @property
    def series_mm_per_N(self) -> float:
        """Displacement of the holder at the contact per tangential force."""
        return self.compliance_mm_per_N + self.rotational_compliance_rad_per_N_mm * self.arm_mm**2


@dataclass(frozen=True)
class Drive:
    """The stroke, held on the sensor's reading or on the true motion."""

    amplitude_mm: float
    frequency_Hz: float
    cycles: int
    held_on_sensor: bool = True
    waveform: Waveform = field(default_factory=Waveform)
    amplitude_drift: float = 0.0


@dataclass(frozen=True)
class Sensors:
    """From true motion and force to readings, without noise.

    A force cell may read one sign larger than the other (`force_asymmetry`), come after the force by a play
    (`force_play_N`) or have a zero that creeps; a displacement sensor may be bent (`displacement_cubic`, of the asked
    amplitude) or come after the motion by a play; `parallel_N_per_mm` is a spring beside the contact, as of a cable.
    """

    gain: Course = field(default_factory=lambda: Course.constant(1.0))
    linear_mm_per_N: float = 0.0
    quadratic_mm_per_N2: float = 0.0
    crosstalk: float = 0.0
    lag_s: float = 0.0
    force_cubic_per_N2: float = 0.0
    displacement_offset_mm: float = 0.0
    force_offset_N: float = 0.0
    force_asymmetry: float = 0.0
    force_play_N: float = 0.0
    force_zero_N: Course = field(default_factory=lambda: Course.constant(0.0))
    displacement_cubic: float = 0.0
    displacement_play_mm: float = 0.0
    parallel_N_per_mm: float = 0.0


@dataclass(frozen=True)
class World:
    """The truth about one test; `incidents` change the worn wires at once during it."""

    specimens: Specimens
    loading: Loading
    friction: Friction
    wear: Wear
    drive: Drive
    layers: Layers = Layers()
    rig: Rig = Rig()
    sensors: Sensors = Sensors()
    instruments: tuple[Instrument, ...] = ()
    incidents: tuple[Incident, ...] = ()
