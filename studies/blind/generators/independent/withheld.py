"""Causes of the withheld set as the independent model has them: by what goes wrong on rigs, not by any diagnosis."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

from studies.blind.generators import withheld_instruments
from studies.blind.generators.ageing import Factor, Film, Growth, Shedding, Steps, Swing
from studies.blind.generators.independent.friction import Joint, MicroslippingJoint, OpeningJoint
from studies.blind.generators.independent.world import World

Parameters = Mapping[str, float]


def _instrument(name: str, world: World, p: Parameters) -> World:
    """What stands between loop and sensors, as `withheld_instruments` has it."""
    return replace(world, instruments=(*world.instruments, withheld_instruments.WITHHELD[name](p)))


def _cracking_flexure(world: World, p: Parameters) -> World:
    """A fatigue crack grows through a leaf of the holder, which gives way ever faster."""
    return replace(world, rig=replace(world.rig, crack_mm_per_N=Growth(1e-3 * p["um_per_N"], p["cycles"], p["power"])))


def _wearing_pivot(world: World, p: Parameters) -> World:
    """The pin of the holder's pivot wears evenly with the cycles, and its play grows from none."""
    return replace(world, rig=replace(world.rig, worn_play_mm=Growth(1e-3 * p["gap_um"], p["cycles"])))


def _opening_joint(world: World, p: Parameters) -> World:
    """A joint of the holder whose screws were tightened too little opens under the largest forces, either way."""
    return _jointed(world, OpeningJoint(p["preload_N"], 1e-3 * p["um_per_N"]))


def _microslipping_joint(world: World, p: Parameters) -> World:
    """Faces of a joint of the holder slip a little at their rims, more the further the force swings."""
    return _jointed(world, MicroslippingJoint(1e-3 * p["um_per_N2"]))


def _shedding_film(world: World, p: Parameters) -> World:
    """A film of transferred metal builds up and is shed at once, again and again (Rigney, Wear 245 (2000) 1)."""
    return _rubbing(world, Shedding(p["share"], p["cycles"]))


def _changing_air(world: World, p: Parameters) -> World:
    """Humidity changes at three moments, and friction with it (Goto & Buckley, Tribology Int. 18 (1985) 237)."""
    return _rubbing(world, Steps(tuple((p[f"cycle_{i}"], p[f"factor_{i}"]) for i in (1, 2, 3))))


def _swinging_load(world: World, p: Parameters) -> World:
    """The frame grows and shrinks with the temperature of the room against the loading spring."""
    swing = Swing(p["share"], p["cycles"], p["phase_rad"])
    return replace(world, loading=replace(world.loading, events=(*world.loading.events, swing)))


def _incubated_wear(world: World, p: Parameters) -> World:
    """A hard coat or oxide wears hardly until it is broken, and the wires as stated afterwards."""
    coat = Film(p["share"], p["cycle"], p["abruptness"])
    return replace(world, wear=replace(world.wear, events=(*world.wear.events, coat)))


def _hard_skin(world: World, p: Parameters) -> World:
    """Drawing has hardened the wires' skin, or annealing softened it, so that wear follows the depth it has reached."""
    return replace(world, wear=replace(world.wear, skin_factor=p["factor"], skin_mm=1e-3 * p["depth_um"]))


def _used_wire(world: World, p: Parameters) -> World:
    """The fixed wire was used before and not turned far enough: the contact lies on the flank of its old scar."""
    specimens = replace(world.specimens, old_scar_mm=1e-3 * p["depth_um"], old_scar_aside_mm=1e-3 * p["aside_um"])
    return replace(world, specimens=specimens)


def _rolled_wire(world: World, p: Parameters) -> World:
    """Rollers that straightened the fixed wire left its section an ellipse, which lies flat or stands on edge."""
    return replace(world, specimens=replace(world.specimens, fixed_crown=p["crown_factor"]))


def _jointed(world: World, joint: Joint) -> World:
    return replace(world, rig=replace(world.rig, joints=(*world.rig.joints, joint)))


def _rubbing(world: World, factor: Factor) -> World:
    return replace(world, friction=replace(world.friction, events=(*world.friction.events, factor)))


#: By name: what each makes of a world, from its parameters.
WITHHELD: dict[str, Callable[[World, Parameters], World]] = {
    **{name: partial(_instrument, name) for name in withheld_instruments.WITHHELD},
    "cracking_flexure": _cracking_flexure,
    "wearing_pivot": _wearing_pivot,
    "opening_joint": _opening_joint,
    "microslipping_joint": _microslipping_joint,
    "shedding_film": _shedding_film,
    "changing_air": _changing_air,
    "swinging_load": _swinging_load,
    "incubated_wear": _incubated_wear,
    "hard_skin": _hard_skin,
    "used_wire": _used_wire,
    "rolled_wire": _rolled_wire,
}
