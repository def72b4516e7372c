"""Causes that are in no library: what else goes wrong on rigs, each a change of the world that a test is made in.

The first twenty kinds lie over all seams; the first batches had seven of them. They are in two halves: one to develop a
diagnosis on, one that is drawn first when its code is frozen. Three further sets were written without a look at any
diagnosis; the last two of them are those of `withheld` and `reserved`.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

from studies.blind.generators import instruments
from studies.blind.generators.ageing import Film, Jump
from studies.blind.generators.independent.reserved import RESERVED
from studies.blind.generators.independent.withheld import WITHHELD
from studies.blind.generators.independent.world import World
from wirewear.base.course import Course

Parameters = Mapping[str, float]
Change = Callable[[World, Parameters], World]


def _thermal_gain_drift(world: World, p: Parameters) -> World:
    """The displacement sensor warms up and its gain creeps to another value."""
    gain = Course(1.0, 1.0 + p["gain_change"], p["cycles"])
    return replace(world, sensors=replace(world.sensors, gain=gain))


def _reversal_adhesion(world: World, p: Parameters) -> World:
    """The wires stick at rest: friction overshoots after each reversal and falls back over some length."""
    friction = replace(world.friction, adhesion=p["overshoot"], adhesion_length_mm=1e-3 * p["length_um"])
    return replace(world, friction=friction)


def _velocity_dependent_friction(world: World, p: Parameters) -> World:
    """Friction that changes with the logarithm of the speed."""
    return replace(world, friction=replace(world.friction, velocity_sensitivity=p["per_e_fold"]))


def _clamp_slip(world: World, p: Parameters) -> World:
    """A clamp that slips, with hysteresis, once the force has swung by more than it holds."""
    rig = replace(world.rig, clamp_holds_N=p["holds_N"], clamp_slip_mm_per_N=1e-3 * p["slip_um_per_N"])
    return replace(world, rig=rig)


def _debris_ejection(world: World, p: Parameters) -> World:
    """Debris leaves the scar at once: friction jumps and comes back over further cycles, twice."""
    events = tuple(Jump(p[f"cycle_{i}"], p["factor"], p["recovery_cycles"]) for i in (1, 2))
    return replace(world, friction=replace(world.friction, events=events))


def _bent_guide(world: World, p: Parameters) -> World:
    """The load rises towards both ends of the stroke, as the guide is bent."""
    return replace(world, loading=replace(world.loading, bowl=p["load_rise"]))


def _saturating_force_cell(world: World, p: Parameters) -> World:
    """The force cell reads ever less than it bears."""
    peak = world.friction.course.final * world.loading.load_N
    return replace(world, sensors=replace(world.sensors, force_cubic_per_N2=p["loss_at_plateau"] / peak**2))


def _asymmetric_force_cell(world: World, p: Parameters) -> World:
    """The force cell reads one sign larger than the other."""
    return replace(world, sensors=replace(world.sensors, force_asymmetry=p["asymmetry"]))


def _force_cell_hysteresis(world: World, p: Parameters) -> World:
    """The force cell comes after the force by a play, as a glued or worn flexure does."""
    return replace(world, sensors=replace(world.sensors, force_play_N=p["play_N"]))


def _creeping_force_zero(world: World, p: Parameters) -> World:
    """The zero of the force creeps, as that of a charge amplifier does."""
    return replace(world, sensors=replace(world.sensors, force_zero_N=Course(0.0, p["zero_N"], p["cycles"])))


def _bent_displacement_sensor(world: World, p: Parameters) -> World:
    """The displacement sensor is not straight: right at both ends and the middle, wrong between."""
    return replace(world, sensors=replace(world.sensors, displacement_cubic=p["bend"]))


def _displacement_backlash(world: World, p: Parameters) -> World:
    """The displacement sensor comes after the motion by a play, as one behind a lever does."""
    return replace(world, sensors=replace(world.sensors, displacement_play_mm=1e-3 * p["play_um"]))


def _parallel_spring(world: World, p: Parameters) -> World:
    """A cable or a seal pulls beside the contact, and the force cell bears it, too."""
    return replace(world, sensors=replace(world.sensors, parallel_N_per_mm=p["stiffness_N_per_mm"]))


def _stiffening_holder(world: World, p: Parameters) -> World:
    """A holder that gives way under small forces and stiffens, as a joint that closes does."""
    return replace(world, rig=replace(world.rig, hardening_mm_per_N3=1e-3 * p["hardening_um_per_N3"]))


def _loosening_holder(world: World, p: Parameters) -> World:
    """A holder that comes loose over the test."""
    rig = replace(world.rig, loosening_mm_per_N=1e-3 * p["loosening_um_per_N"], loosening_cycles=p["cycles"])
    return replace(world, rig=rig)


def _slanted_load(world: World, p: Parameters) -> World:
    """The load rises from one end of the stroke to the other, as under a lever that turns."""
    return replace(world, loading=replace(world.loading, slant=p["load_rise"]))


def _slanted_friction(world: World, p: Parameters) -> World:
    """Friction is higher at one end of the stroke, as where a specimen was ground the other way."""
    return replace(world, friction=replace(world.friction, slant=p["rise"]))


def _rippled_friction(world: World, p: Parameters) -> World:
    """Friction waves along the stroke, as across the marks of a file."""
    friction = replace(world.friction, ripple=p["share"], ripple_length_mm=1e-3 * p["length_um"])
    return replace(world, friction=friction)


def _breathing_friction(world: World, p: Parameters) -> World:
    """Friction comes and goes over the test, as debris gathers and leaves."""
    friction = replace(world.friction, breathing=p["share"], breathing_folds=p["folds"])
    return replace(world, friction=friction)


def _severe_wear(world: World, p: Parameters) -> World:
    """For some time in the middle of the test wear is severe, or nearly stops."""
    event = Jump(p["cycle"], p["factor"], p["recovery_cycles"])
    return replace(world, wear=replace(world.wear, events=(event,)))


def _film_breakthrough(world: World, p: Parameters) -> World:
    """Wires wear through a film, of oxide or grease, under which friction is another."""
    return replace(world, friction=replace(world.friction, film=Film(p["share"], p["cycle"], p["abruptness"])))


def _relaxing_load(world: World, p: Parameters) -> World:
    """The spring of the load sets soon after it was tightened, and the load with it."""
    return replace(world, loading=replace(world.loading, relaxing=Course(1.0, 1.0 - p["loss"], p["cycles"])))


def _unequal_wear(world: World, p: Parameters) -> World:
    """One wire is harder than the other, as from another batch, so that the other one wears more."""
    return replace(world, wear=replace(world.wear, moving_share=p["moving_share"]))


def _pressure_dependent_wear(world: World, p: Parameters) -> World:
    """Work wears more, or less, where the pressure is high, as mild wear turns severe (Archard & Hirst 1956)."""
    wear = replace(world.wear, pressure_exponent=p["exponent"], reference_MPa=p["pressure_MPa"])
    return replace(world, wear=wear)


def _one_sided_holder(world: World, p: Parameters) -> World:
    """The holder leans on a shoulder one way and on its grub screw alone the other way, where it gives way."""
    return replace(world, rig=replace(world.rig, one_sided_mm_per_N=1e-3 * p["um_per_N"]))


def _other_gauge(world: World, p: Parameters) -> World:
    """Both wires are of another gauge than stated, as drawn wire is that was taken from the wrong spool."""
    specimens = replace(world.specimens, radius_mm=p["diameter_factor"] * world.specimens.radius_mm)
    return replace(world, specimens=specimens)


def _instrument(name: str, world: World, p: Parameters) -> World:
    """What stands between loop and sensors, as `instruments` has it."""
    return replace(world, instruments=(*world.instruments, instruments.UNSEEN[name](p)))


#: What the first batches drew.
FIRST: dict[str, Change] = {
    "thermal_gain_drift": _thermal_gain_drift,
    "reversal_adhesion": _reversal_adhesion,
    "velocity_dependent_friction": _velocity_dependent_friction,
    "clamp_slip": _clamp_slip,
    "debris_ejection": _debris_ejection,
    "bent_guide": _bent_guide,
    "saturating_force_cell": _saturating_force_cell,
}

#: The half to develop on, over all seams.
DEVELOPMENT: dict[str, Change] = {
    "asymmetric_force_cell": _asymmetric_force_cell,
    "saturating_force_cell": _saturating_force_cell,
    "thermal_gain_drift": _thermal_gain_drift,
    "displacement_backlash": _displacement_backlash,
    "clamp_slip": _clamp_slip,
    "loosening_holder": _loosening_holder,
    "bent_guide": _bent_guide,
    "reversal_adhesion": _reversal_adhesion,
    "debris_ejection": _debris_ejection,
    "parallel_spring": _parallel_spring,
}

#: The half that is drawn first when the code of the diagnosis is frozen.
SEALED: dict[str, Change] = {
    "force_cell_hysteresis": _force_cell_hysteresis,
    "creeping_force_zero": _creeping_force_zero,
    "bent_displacement_sensor": _bent_displacement_sensor,
    "stiffening_holder": _stiffening_holder,
    "slanted_load": _slanted_load,
    "slanted_friction": _slanted_friction,
    "rippled_friction": _rippled_friction,
    "velocity_dependent_friction": _velocity_dependent_friction,
    "breathing_friction": _breathing_friction,
    "severe_wear": _severe_wear,
}

#: Written without a look at any diagnosis, by what goes wrong on rigs.
UNSEEN: dict[str, Change] = {
    **{name: partial(_instrument, name) for name in instruments.UNSEEN},
    "film_breakthrough": _film_breakthrough,
    "relaxing_load": _relaxing_load,
    "unequal_wear": _unequal_wear,
    "pressure_dependent_wear": _pressure_dependent_wear,
    "one_sided_holder": _one_sided_holder,
    "other_gauge": _other_gauge,
}

OUTSIDE: dict[str, Change] = FIRST | DEVELOPMENT | SEALED | UNSEEN | WITHHELD | RESERVED

#: What a batch may draw from.
OUTSIDE_SETS: dict[str, dict[str, Change]] = {
    "first": FIRST,
    "development": DEVELOPMENT,
    "sealed": SEALED,
    "unseen": UNSEEN,
    "withheld": WITHHELD,
    "reserved": RESERVED,
}
