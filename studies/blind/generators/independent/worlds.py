"""The world that owners believe in, and the one that a repeat is made in."""

from dataclasses import replace
from math import radians

from studies.blind.generators.cases import Case
from studies.blind.generators.independent.effects import changed
from studies.blind.generators.independent.world import Drive, Friction, Loading, Rig, Specimens, Wear, World
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import Nuisances, SpecimenDraw
from wirewear.base.course import Course


def nominal_world(nominal: Nominal, law: str, *, held_on_sensor: bool) -> World:
    """The test as its owner states it, with the independent model's friction law."""
    stiffness = nominal.stiffness_N_per_mm
    return World(
        specimens=Specimens(nominal.diameter_mm / 2.0, nominal.youngs_modulus_MPa, nominal.poissons_ratio),
        loading=Loading(nominal.load_N, nominal.spring_N_per_mm),
        friction=Friction(Course.constant(nominal.friction), law),
        wear=Wear(1e-3 * nominal.wear_mm3_per_J),
        drive=Drive(1e-3 * nominal.amplitude_um, nominal.frequency_Hz, nominal.cycles, held_on_sensor),
        rig=Rig(0.0 if stiffness is None else 1.0 / stiffness),
    )


def with_effects(world: World, case: Case) -> World:
    """A world with the case's effects."""
    for effect in case.effects:
        world = changed(world, effect.effect, effect.parameters)
    return world


def with_specimens(world: World, draw: SpecimenDraw) -> World:
    """A world with one repeat's specimens and zero errors."""
    turned = world.specimens.crossing_error_rad + radians(draw.angle_deg)
    zeros = replace(
        world.sensors, displacement_offset_mm=1e-3 * draw.displacement_zero_um, force_offset_N=draw.force_zero_N
    )
    return replace(
        world,
        specimens=replace(world.specimens, crossing_error_rad=turned),
        loading=replace(world.loading, load_N=world.loading.load_N * draw.load),
        friction=replace(world.friction, course=world.friction.course.times(draw.friction)),
        wear=replace(world.wear, factor=world.wear.factor.times(draw.wear)),
        sensors=zeros,
    )


def with_drive(world: World, nuisances: Nuisances) -> World:
    """A world with the rig's waveform and drift of amplitude."""
    drive = replace(world.drive, waveform=nuisances.waveform, amplitude_drift=nuisances.amplitude_drift)
    return replace(world, drive=drive)
