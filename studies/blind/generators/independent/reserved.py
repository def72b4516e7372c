"""Causes of the reserved set as the independent model has them: by what goes wrong on rigs, not by any diagnosis."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

from studies.blind.generators import reserved_instruments
from studies.blind.generators.ageing import Hanging
from studies.blind.generators.independent.marks import Groove, Incident, Remounted, Spalled
from studies.blind.generators.independent.world import World

Parameters = Mapping[str, float]


def _instrument(name: str, world: World, p: Parameters) -> World:
    """What stands between loop and sensors, as `reserved_instruments` has it."""
    return replace(world, instruments=(*world.instruments, reserved_instruments.RESERVED[name](p)))


def _sticking_slide(world: World, p: Parameters) -> World:
    """The upright slide of the load sticks while the wires sink away from it, and slips after them now and then."""
    hanging = Hanging(p["loss"], p["cycles"])
    return replace(world, loading=replace(world.loading, events=(*world.loading.events, hanging)))


def _lopsided_wear(world: World, p: Parameters) -> World:
    """A draught blows debris off one end of the track, which wears more than the end where it lies and protects."""
    return replace(world, wear=replace(world.wear, slant=p["slant"]))


def _spalled_flake(world: World, p: Parameters) -> World:
    """A crack below the scar comes to the surface, and a flake breaks out (Suh, Wear 25 (1973) 111)."""
    size, place = (1e-3 * p["depth_um"], 1e-3 * p["radius_um"]), (1e-3 * p["x_um"], 1e-3 * p["y_um"])
    return _with_incident(world, Spalled(p["cycle"], *size, *place))


def _remounted_wire(world: World, p: Parameters) -> World:
    """The test is stopped for a look at the scar, and the fixed wire is put back turned a little about its axis."""
    return _with_incident(world, Remounted(p["cycle"], 1e-3 * p["aside_um"]))


def _grooved_wire(world: World, p: Parameters) -> World:
    """The fixed wire was drawn through a chipped die and has a groove along it, where it is to be rubbed."""
    groove = Groove(1e-3 * p["depth_um"], 1e-3 * p["half_width_um"], 1e-3 * p["aside_um"])
    return replace(world, specimens=replace(world.specimens, grooves=(*world.specimens.grooves, groove)))


def _with_incident(world: World, incident: Incident) -> World:
    return replace(world, incidents=(*world.incidents, incident))


#: By name: what each makes of a world, from its parameters.
RESERVED: dict[str, Callable[[World, Parameters], World]] = {
    **{name: partial(_instrument, name) for name in reserved_instruments.RESERVED},
    "sticking_slide": _sticking_slide,
    "lopsided_wear": _lopsided_wear,
    "spalled_flake": _spalled_flake,
    "remounted_wire": _remounted_wire,
    "grooved_wire": _grooved_wire,
}
