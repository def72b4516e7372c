"""Everything that is true of one test: specimens, loading, friction, layers, wear, rig, drive and sensors.

Lengths in mm, forces in N, stresses in MPa, energies in mJ, angles in rad, times in s.
"""

from dataclasses import dataclass, field, replace
from math import exp, inf, log, pi, prod, sin

from studies.blind.generators.ageing import Factor, Film, Growth
from studies.blind.generators.independent.friction import Joint
from studies.blind.generators.independent.marks import Groove, Incident
from studies.blind.generators.instruments import Instrument
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

    `slant` raises it towards one end; `relaxing` is a factor over the cycles, of a spring that sets, and `events` are
    further ones.
    """

    load_N: float
    spring_N_per_mm: float = 0.0
    drift_per_cycle: float = 0.0
    tilt_rad: float = 0.0
    bowl: float = 0.0
    slant: float = 0.0
    relaxing: Course = field(default_factory=lambda: Course.constant(1.0))
    events: tuple[Factor, ...] = ()

    def load_at(self, cycle: float) -> float:
        """Load in the middle of the stroke, before the spring loses any [N]."""
        load = self.load_N * max(1.0 + self.drift_per_cycle * cycle, 0.01) * self.relaxing.at(cycle)
        return load * prod(event.at(cycle) for event in self.events)


@dataclass(frozen=True)
class Friction:
    """Friction over the cycles, and what departs from dry friction within one.

    `slant` raises it towards one end of the stroke, `ripple` is a wave of a length along it, `breathing` one over so
    many e-folds of the cycles.
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
    breathing: float = 0.0
    breathing_folds: float = 1.0
    film: Film | None = None

    def at(self, cycle: float) -> float:
        """Coefficient at a cycle."""
        value = self.course.at(cycle)
        for event in self.events:
            value *= event.at(cycle)
        if self.film is not None:
            value *= self.film.at(cycle)
        return value * (1.0 + self.breathing * sin(2.0 * pi * log(max(cycle, 1.0)) / self.breathing_folds))


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


@dataclass(frozen=True)
class Rig:
    """What yields between contact and ground, and a clamp that slips under more than its holding force.

    `hardening_mm_per_N3` is a holder that stiffens: it gives way by c Q − h Q³; `loosening_mm_per_N` comes on over a
    test, 63 % of it after `loosening_cycles`. `one_sided_mm_per_N` gives way under forces of its own sign alone.
    `crack_mm_per_N` and `worn_play_mm` grow over a test; `joints` give way by laws of their own.
    """

    compliance_mm_per_N: float = 0.0
    rotational_compliance_rad_per_N_mm: float = 0.0
    arm_mm: float = 0.0
    play_mm: float = 0.0
    clamp_holds_N: float = 0.0
    clamp_slip_mm_per_N: float = 0.0
    hardening_mm_per_N3: float = 0.0
    loosening_mm_per_N: float = 0.0
    loosening_cycles: float = 1.0
    one_sided_mm_per_N: float = 0.0
    crack_mm_per_N: Growth | None = None
    worn_play_mm: Growth | None = None
    joints: tuple[Joint, ...] = ()

    def loose_mm_per_N(self, cycle: float) -> float:
        """What has come loose by a cycle."""
        cracked = 0.0 if self.crack_mm_per_N is None else self.crack_mm_per_N.at(cycle)
        return self.loosening_mm_per_N * (1.0 - exp(-cycle / self.loosening_cycles)) + cracked

    def aged(self, cycle: float) -> "Rig":
        """The rig with the play that it has by a cycle."""
        if self.worn_play_mm is None:
            return self
        return replace(self, play_mm=self.play_mm + self.worn_play_mm.at(cycle), worn_play_mm=None)

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
