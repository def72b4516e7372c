"""Drives that hold a figure of the loop in place of their amplitude: slip, motion, force, energy or a sensor's reading.

A loop comes as a trace, a simulated cycle, or half of one whose other half is its mirror image; a probe solves one
increment to another displacement (`measures`).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from math import acos, cos, sqrt

import numpy as np

from solvers import ContactState, CycleTrace, SolverError
from solvers.laws.friction_law import Coulomb
from wirewear import reference
from wirewear.effects import Age, ContactLaw, Loading, Seam, applied
from wirewear.loops.sensor import LoopSignals, Sensor
from wirewear.simulation.measures import Probe, friction_work_mJ, is_half, slip_amplitude_mm
from wirewear.test import AnyStudy, Study
from wirewear.test.conditions import held_by
from wirewear.test.gaps import hertz_of

WITHIN = 1e-3  #: A drive is corrected until what it holds is met within this share.
_LEAST, _MOST = 0.3, 3.0  # Of an amplitude: those to be tried next.
_SLOW = 0.5  # A correction is slow if it leaves more of what was lacking, and of an interval that is known.
_PROBED, _GROWS = 1e-3, 1.3  # Of the largest amplitude, by which a contact is moved at first; from try to try.
_FAR = 0.4  # Of an amplitude: as far the next one goes after a slow correction to the same side, or farther.


#: The figure of a cycle, or of half of one whose other half is its mirror image; with a probe if increments are long.
Measure = Callable[[CycleTrace, Probe | None], float]

_OF_MOTION = "motion", "reading"  #: Figures that hold the displacement, or nearly so.

_AGES = 200  # Of a test at which effects are looked at for the least friction.


@dataclass(frozen=True)
class HeldFigure:
    """A figure of the loop, in `unit`, that a drive holds by its amplitude, with which it grows.

    key: the study's key that states `target`. first_mm, largest_mm: first and largest amplitude. measure: the figure of
    a trace. slope: its growth per mm of amplitude where the bodies slide, None for growth in proportion. of_state: the
    figure from a state at the end of a stroke, if that suffices: it can then be met in the first quarter cycle; else
    None.
    """

    key: str
    target: float
    unit: str
    largest_mm: float
    measure: Measure
    slope: Callable[[CycleTrace], float] | None
    first_mm: float
    of_state: Callable[[ContactState], float] | None = None

    @property
    def lacking(self) -> Callable[[ContactState], float] | None:
        """1 - figure / target at a state at the end of a stroke; None if a state does not show the figure."""
        of_state, target = self.of_state, self.target
        return None if of_state is None else lambda state: 1.0 - of_state(state) / target

    def error(self, trace: CycleTrace) -> float:
        """Relative difference of a measured loop's figure from the target: figure / target - 1."""
        return self.measure(trace, None) / self.target - 1.0


def amplitude_from(
    held: HeldFigure, shown_by: Callable[[ContactState], float], moved_to: Callable[[float], ContactState]
) -> float:
    """Amplitude in mm at which a figure that a state shows first meets its target, at most the drive's largest; as in
    `elastic_amplitude_from`.
    """
    from scipy.optimize import brentq

    wanted = _just(held)

    def lacking(place_mm: float) -> float:
        return shown_by(moved_to(place_mm)) - wanted

    low = high = elastic_amplitude_from(held, shown_by, moved_to)
    while (left := lacking(high)) < 0.0:
        # A force equal to friction is reached to its last ten thousandth only long after everything slides.
        nearly = (1.0 - 0.9 * WITHIN) * held.target
        if low < high and left + wanted >= nearly:
            wanted = nearly
            break
        if high >= held.largest_mm:
            return held.largest_mm
        low, high = high, min(_GROWS * high, held.largest_mm)
    if low == high:
        return high
    return float(brentq(lacking, low, high, xtol=1e-6 * high, rtol=0.1 * WITHIN))


def elastic_amplitude_from(
    held: HeldFigure, shown_by: Callable[[ContactState], float], moved_to: Callable[[float], ContactState]
) -> float:
    """Amplitude in mm at which a figure would meet its target if nothing slipped, at most the drive's largest.

    shown_by: the figure of a state. moved_to: the state of the contact moved from mid-stroke to a displacement in mm. A
    small step shows the stiffness of contact and rig together. Friction only softens them, so under a load that stays
    the amplitude is at least this one; slip where a load is low moves the mean force, so the other end may need less.
    """
    wanted, low = _just(held), _PROBED * held.largest_mm
    # Of the largest amplitude: a figure that is there without any motion does not grow with it.
    while (found := shown_by(moved_to(low))) >= 0.5 * wanted and low > 1e-12 * held.largest_mm:
        low *= 0.25 * wanted / found
    return min(low * wanted / max(found, 1e-9 * wanted), held.largest_mm)


def _just(held: HeldFigure) -> float:
    """The target, as nearly as it is met."""
    return held.target * (1.0 - 0.1 * WITHIN)


@dataclass
class AmplitudeSearch:
    """A search for the amplitude that holds a figure, between one too small and one too large."""

    held: HeldFigure
    small_mm: float = 0.0
    large_mm: float = field(default=np.inf)
    _latest: tuple[float, float] | None = None
    _interval_mm: float = field(default=np.inf)
    _tries: int = 0

    def following(self, amplitude_mm: float, trace: CycleTrace, probe: Probe | None = None) -> float | None:
        """The amplitude in mm to try after `amplitude_mm`, from the loop there; None if that holds the figure within
        0.1 %, or nothing nearer is possible.
        probe: refines slip from long increments. Raises SolverError if no amplitude of the drive, or none in 30 tries,
        holds the figure.
        """
        held, found = self.held, self.held.measure(trace, probe)
        lacking, self._tries = held.target - found, self._tries + 1
        if abs(lacking) <= WITHIN * held.target:
            return None
        if self._tries > 30:
            raise SolverError(
                f"no amplitude was found at which the drive holds {held.key} = {held.target:g}: at "
                f"{1e3 * amplitude_mm:.4g} um it comes to {found:.4g} {held.unit}"
            )
        growth = found / amplitude_mm if held.slope is None else held.slope(trace)
        growth = max(growth, 1e-9 * held.target / amplitude_mm)
        # Where both bodies and rig carry much of the motion, the figure is what little is left of the amplitude.
        apart = WITHIN * max(min(held.target / growth, amplitude_mm), WITHIN * amplitude_mm)
        if self.large_mm - self.small_mm <= apart:
            return None  # steps of the figure, where nodes come to slide, are larger than what is wanted
        if lacking > 0.0:
            self.small_mm = max(self.small_mm, amplitude_mm)
        else:
            self.large_mm = min(self.large_mm, amplitude_mm)
        if lacking > 0.0 and amplitude_mm >= held.largest_mm:
            raise SolverError(
                f"the drive cannot hold {held.key} = {held.target:g}: at its largest amplitude, "
                f"{1e3 * held.largest_mm:g} um, it comes to {found:.4g} {held.unit}, with a tangential force of "
                f"{float(np.abs(trace.tangential_force).max()):.4g} N; hold less, or give a larger "
                "displacement_amplitude_um"
            )
        before, self._latest = self._latest, (amplitude_mm, found)
        is_slow = before is None or abs(lacking) > _SLOW * abs(held.target - before[1])
        wanted = self._wanted(amplitude_mm, found, before, growth)
        high = min(self.large_mm, _MOST * amplitude_mm)
        low = max(self.small_mm, _LEAST * amplitude_mm)
        margin = 0.0
        # A figure that hardly grows with the amplitude, as the force of bodies that slide does, leads nowhere.
        if np.isfinite(self.large_mm) and self.small_mm:
            before_mm, self._interval_mm = self._interval_mm, self.large_mm - self.small_mm
            # Of the interval in which the amplitude lies: no guess comes nearer to its ends.
            margin = 0.1 * (high - low)
            if self._interval_mm > _SLOW * before_mm and is_slow:
                return float((self.small_mm * self.large_mm) ** 0.5)
        elif before is not None and is_slow:
            wanted = max(wanted, amplitude_mm / _FAR) if lacking > 0.0 else min(wanted, _FAR * amplitude_mm)
        return float(min(np.clip(wanted, low + margin, high - margin), held.largest_mm))

    def _wanted(self, amplitude_mm: float, found: float, before: tuple[float, float] | None, growth: float) -> float:
        """The amplitude in mm at which the figure would be met if it grew as since the amplitude before, or by `growth`
        per mm. before: amplitude and figure of the previous try.
        """
        lacking = self.held.target - found
        if before is not None and (found - before[1]) * (amplitude_mm - before[0]) > 0.0:
            return amplitude_mm + lacking * (amplitude_mm - before[0]) / (found - before[1])
        return amplitude_mm + lacking / growth


@dataclass(frozen=True)
class SlidingOnset:
    """A contact that just slides as a whole, without its rig: force, slip amplitude, energy of a cycle, and motion, the
    amplitude in µm of the bodies' relative displacement where they are held.
    """

    force_N: float
    slip_um: float
    energy_mJ: float
    moved_um: Callable[[], float]  #: Works out the motion, which most drives need not know.

    @property
    def motion_um(self) -> float:
        return self.moved_um()


def _per_um(_: CycleTrace) -> float:
    return 1e3


@dataclass(frozen=True)
class HeldMeasure:
    """How a quantity that a drive may hold (a key held_... of `Asked`) is measured, in `unit`.

    measure: the quantity from a sensor without lag, a trace and a probe. slides_from: the quantity at which bodies
    begin to slide as a whole, from their onset of sliding and the rig's travel in µm then. slope, of_state: as in
    `HeldFigure`.
    """

    unit: str
    measure: Callable[[Sensor, CycleTrace, Probe | None], float]
    slides_from: Callable[[SlidingOnset, float], float]
    slope: Callable[[CycleTrace], float] | None = _per_um
    of_state: Callable[[ContactState], float] | None = None


def _slip_um(_: Sensor, trace: CycleTrace, probe: Probe | None) -> float:
    return 1e3 * slip_amplitude_mm(trace, probe)


def _apart_um(_: Sensor, trace: CycleTrace, __: Probe | None) -> float:
    """Amplitude in µm of the bodies' relative motion between their holders, half of its range."""
    apart = np.array([state.drive - state.holder_x for state in (trace.start, *trace.states)])
    return 500.0 * float(np.ptp(np.append(apart, -apart) if is_half(trace) else apart))


def _read_um(sensor: Sensor, trace: CycleTrace, _: Probe | None) -> float:
    drive, force, normal = 1e3 * trace.drive, trace.tangential_force, trace.normal_force
    if is_half(trace):
        drive, force, normal = np.append(drive, -drive), np.append(force, -force), np.append(normal, normal)
    return 0.5 * float(
        np.ptp(sensor.read(LoopSignals(np.arange(float(drive.size)), drive, force, normal)).displacement_um)
    )


def _largest_force_N(trace: CycleTrace) -> float:
    return float(np.abs(trace.tangential_force).max())


#: All figures by the second word of their keys.
HELD_FIGURES: Mapping[str, HeldMeasure] = {
    "slip": HeldMeasure("um", _slip_um, lambda onset, _: onset.slip_um),
    "motion": HeldMeasure("um", _apart_um, lambda onset, _: onset.motion_um),
    "reading": HeldMeasure("um", _read_um, lambda onset, carried_um: onset.motion_um + carried_um),
    "tangential": HeldMeasure(
        "N",
        lambda _, trace, __: _largest_force_N(trace),
        lambda onset, _: onset.force_N,
        None,
        lambda state: abs(float(state.primary_force[:, 0].sum())),
    ),
    "energy": HeldMeasure(
        "mJ",
        lambda _, trace, __: friction_work_mJ(trace),
        lambda onset, _: onset.energy_mJ,
        lambda trace: 4.0 * _largest_force_N(trace),
    ),
}


def held_of(study: AnyStudy) -> HeldFigure | None:
    """The figure that a study's drive holds in place of its amplitude; None if it holds the amplitude."""
    stated, largest_um = held_by(study.conditions), study.conditions.displacement_amplitude_um
    if stated is None:
        return None
    holder, figure = study.tables.rig, HELD_FIGURES[stated.figure]
    friction_N = study.contact.friction * holder.normal_load_N
    sensor = replace(applied(study.effects, Seam.SENSOR, Sensor(), Age.new()), lag_s=0.0)
    carried_um = 1e3 * friction_N * holder.compliance_at_contact_mm_per_N
    return HeldFigure(
        stated.key,
        stated.value,
        figure.unit,
        1e-3 * largest_um,
        partial(figure.measure, sensor),
        figure.slope,
        1e-3 * stated.first_um(friction_N, carried_um, largest_um),
        figure.of_state,
    )


def least_friction_N(study: AnyStudy, load_share: float | None = None) -> float:
    """Amplitude in N of the largest tangential force in proportion to the displacement under which nothing slides at
    any age of the test.

    load_share: load over the test's, constant; None: as the load cycle has it. 0 where layers or misalignment change
    where the bodies touch.
    """
    law, loading = ContactLaw(study.contact.friction), Loading(study.conditions.normal_load_N)
    ages = np.linspace(0.0, float(study.conditions.cycles), _AGES if study.effects else 1)
    least = np.inf
    for age in (Age(cycles, 0.0) for cycles in ages):
        aged, loaded = (
            applied(study.effects, Seam.CONTACT, law, age),
            applied(study.effects, Seam.LOADING, loading, age),
        )
        if aged.layers or loaded.misalignment_rad:
            return 0.0
        least = min(least, aged.friction * loaded.normal_load_N)
    return float(least * (study.drive.least_load_per_place if load_share is None else load_share))


def expected_to_stick(
    study: AnyStudy, onset_at: Callable[[float], SlidingOnset], *, under_largest_load: bool = False
) -> bool:
    """True if the drive of a study without programme does not make its contact slide as a whole; under_largest_load:
    True if it would not if the largest load of its cycle stayed.
    onset_at: from a friction force in N, the onset of sliding without the rig.
    """
    friction_N = least_friction_N(study, study.drive.load.largest if under_largest_load else None)
    if friction_N <= 0.0:
        return False
    onset, stated = onset_at(friction_N), held_by(study.conditions)
    rig = applied(study.effects, Seam.HOLDER, study.tables.rig, Age.new())
    carried_um = 1e3 * friction_N * rig.compliance_at_contact_mm_per_N
    if stated is None:
        return bool(study.conditions.displacement_amplitude_um < onset.motion_um + carried_um)
    return bool(stated.value < HELD_FIGURES[stated.figure].slides_from(onset, carried_um))


def round_contact(study: Study, load_N: float) -> tuple[float, float]:
    """Radius in mm of the circle with the area of the fresh contact under a load, and tangential contact modulus G* in
    MPa.
    """
    hertz = hertz_of(load_N, *study.bodies)
    modulus = reference.tangential_contact_modulus(*(body.material for body in study.bodies))
    return (hertz.major_semi_axis_mm * hertz.minor_semi_axis_mm) ** 0.5, modulus


def point_sticks(study: Study, *, under_largest_load: bool = False) -> bool:
    """True if a contact at a point, of a study without programme, is expected to stick in its middle, by Cattaneo and
    Mindlin; under_largest_load: True if it would if the largest load of its cycle stayed.
    The contact between gripped bodies is softer and slides at larger strokes.
    """
    radius, modulus = round_contact(study, study.conditions.drive.load.largest * study.conditions.normal_load_N)

    def onset(friction_N: float) -> SlidingOnset:
        contact = reference.partial_slip_point(friction_N, 1.0, radius, modulus)
        motion = contact.full_slip_displacement_mm
        slip, energy = reference.slip_amplitude(contact, motion), reference.energy_per_cycle(contact, friction_N)
        return SlidingOnset(friction_N, 1e3 * slip, energy, lambda: 1e3 * motion)

    return expected_to_stick(study, onset, under_largest_load=under_largest_load)


def unused_friction(study: AnyStudy) -> float | None:
    """Share (0 to 1) of the largest friction force that the tangential force which a study holds leaves unused.

    None where that is to be seen: the drive holds something else, friction is not Coulomb's alone, or loads change.
    """
    held, plain = study.conditions.held_tangential_force_N, type(study.contact.friction_law) is Coulomb
    if held is None or study.effects or not plain or not study.drive.steady:
        return None
    friction_N = least_friction_N(study)
    return 1.0 - held / friction_N if held < friction_N else None


def core_of_held_force(study: Study) -> float | None:
    """Share (0 to 1) of a fresh contact's axes that sticks for good under the tangential force that a study holds.

    None where that is to be seen, see `unused_friction`. Under a held load it is Cattaneo and Mindlin's; under a held
    approach it is smaller, as wear takes load away, and none is left beyond 1/√3 of what slides at first (Popov 2014).
    """
    unused = unused_friction(study)
    if unused is None:
        return None
    below = sqrt(3.0) * (1.0 - unused)
    if study.conditions.approach_um is None or below > 1.0:
        return float(unused ** (1.0 / 3.0))
    return 2.0 / sqrt(3.0) * cos(acos(-below) / 3.0)


def core_once_worn(study: Study, core: float, compliance_mm_per_N: float) -> float:
    """Share (0 to 1) of a fresh contact's axes that sticks once nothing more wears, of a contact whose share `core`
    sticks at the end of the first loading. compliance_mm_per_N: displacement over tangential force there.

    Under a held load and displacement the core grows: once it carries the load alone, it yields more along the motion
    (Ciavarella and Hills 1999), and less of the displacement is left to slip. Under a held force or approach it
    stays.
    """
    stated = held_by(study.conditions)
    if study.conditions.approach_um is not None or (stated is not None and stated.figure not in _OF_MOTION):
        return core
    radius, modulus = round_contact(study, study.conditions.normal_load_N)
    stiffness = reference.mindlin_stiffness(modulus, radius)
    springs = stiffness * compliance_mm_per_N - 1.5 * (1.0 - core**2) / (1.0 - core**3)
    deeper = (2.0 / core + core**2) / 3.0 - 1.0
    # The core's growth until its annulus has worn off over that of the approach, both over their fresh contact's: rings
    # that wear by Archard under Jäger's slip, 0.099 at Q/µP of 0.6 and 0.098 at 0.8.
    return min(core + 0.098 * deeper / (1.0 + 0.5 * max(springs, 0.0)), 1.0)
