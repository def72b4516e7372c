"""The effects, written again for the independent model: each changes the world that a test is made in.

They carry the names, parameters and units of the diagnosis' contract.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import radians

from studies.blind.causes import all_causes
from studies.blind.generators.independent.world import World
from wirewear.base.course import Course

Parameters = Mapping[str, float]
Change = Callable[[World, Parameters], World]


def changed(world: World, effect: str, parameters: Parameters) -> World:
    """The world with an effect of the library or from outside it. Raises KeyError if there is no such effect."""
    if effect in LIBRARY:
        return LIBRARY[effect](world, parameters)
    return all_causes()[effect](**parameters).in_world(world)


def _tangential_compliance(world: World, p: Parameters) -> World:
    compliance = world.rig.compliance_mm_per_N + 1.0 / p["stiffness_N_per_mm"]
    return replace(world, rig=replace(world.rig, compliance_mm_per_N=compliance))


def _rotational_compliance(world: World, p: Parameters) -> World:
    yielding = 1.0 / p["stiffness_N_mm_per_rad"]
    return replace(world, rig=replace(world.rig, rotational_compliance_rad_per_N_mm=yielding, arm_mm=p["arm_mm"]))


def _free_play(world: World, p: Parameters) -> World:
    return replace(world, rig=replace(world.rig, play_mm=world.rig.play_mm + 1e-3 * p["gap_um"]))


def _friction_offset(world: World, p: Parameters) -> World:
    was = world.friction.course.final
    return replace(world, friction=replace(world.friction, course=world.friction.course.times(p["friction"] / was)))


def _friction_evolution(world: World, p: Parameters) -> World:
    course = Course(p["initial"], p["final"], p["cycles"])
    return replace(world, friction=replace(world.friction, course=course))


def _roughness_compliance(world: World, p: Parameters) -> World:
    return replace(world, layers=replace(world.layers, rough_mm=Course(1e-3 * p["layer_um"], 0.0, p["cycles"])))


def _third_body(world: World, p: Parameters) -> World:
    layers = replace(world.layers, retained=p["retained_fraction"], debris_modulus_MPa=p["modulus_MPa"])
    return replace(world, layers=layers)


def _plasticity(world: World, p: Parameters) -> World:
    return replace(world, specimens=replace(world.specimens, flattening_mm=1e-3 * p["flattening_um"]))


def _crossing_angle_error(world: World, p: Parameters) -> World:
    turned = world.specimens.crossing_error_rad + radians(p["angle_deg"])
    return replace(world, specimens=replace(world.specimens, crossing_error_rad=turned))


def _misalignment(world: World, p: Parameters) -> World:
    return replace(world, loading=replace(world.loading, tilt_rad=world.loading.tilt_rad + radians(p["angle_deg"])))


def _normal_load_drift(world: World, p: Parameters) -> World:
    return replace(world, loading=replace(world.loading, drift_per_cycle=1e-5 * p["fraction_per_100k_cycles"]))


def _wear_rate_offset(world: World, p: Parameters) -> World:
    return replace(world, wear=replace(world.wear, factor=world.wear.factor.times(p["factor"])))


def _wear_rate_evolution(world: World, p: Parameters) -> World:
    factor = Course(p["initial_factor"], p["final_factor"], p["cycles"])
    return replace(world, wear=replace(world.wear, factor=factor))


def _displacement_gain(world: World, p: Parameters) -> World:
    return replace(world, sensors=replace(world.sensors, gain=world.sensors.gain.times(p["gain"])))


def _displacement_load_coupling(world: World, p: Parameters) -> World:
    sensors = replace(
        world.sensors, linear_mm_per_N=1e-3 * p["linear_um_per_N"], quadratic_mm_per_N2=1e-3 * p["quadratic_um_per_N2"]
    )
    return replace(world, sensors=sensors)


def _force_crosstalk(world: World, p: Parameters) -> World:
    return replace(world, sensors=replace(world.sensors, crosstalk=world.sensors.crosstalk + p["coefficient"]))


def _sensor_lag(world: World, p: Parameters) -> World:
    return replace(world, sensors=replace(world.sensors, lag_s=world.sensors.lag_s + p["time_s"]))


LIBRARY: dict[str, Change] = {
    "tangential_compliance": _tangential_compliance,
    "rotational_compliance": _rotational_compliance,
    "free_play": _free_play,
    "friction_offset": _friction_offset,
    "friction_evolution": _friction_evolution,
    "roughness_compliance": _roughness_compliance,
    "third_body": _third_body,
    "plasticity": _plasticity,
    "crossing_angle_error": _crossing_angle_error,
    "misalignment": _misalignment,
    "normal_load_drift": _normal_load_drift,
    "wear_rate_offset": _wear_rate_offset,
    "wear_rate_evolution": _wear_rate_evolution,
    "displacement_gain": _displacement_gain,
    "displacement_load_coupling": _displacement_load_coupling,
    "force_crosstalk": _force_crosstalk,
    "sensor_lag": _sensor_lag,
}
