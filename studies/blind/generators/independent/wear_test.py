"""A whole test of the independent model: contact, friction loop and wear from the first cycle to the last."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import isinf, pi

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.independent.foundation import (
    Bodies,
    Contact,
    Foundation,
    Grid,
    Load,
    Shapes,
    force_moments,
    friction_work,
    slopes,
    solve_contact,
)
from studies.blind.generators.independent.loop import ForceTable, TrueLoop, chebyshev_step, stages_needed
from studies.blind.generators.independent.marks import befallen, next_cycle
from studies.blind.generators.independent.sensing import driven_loop
from studies.blind.generators.independent.world import Layers, World

Array = NDArray[np.float64]

#: Half-columns of the grid, and its half-width over that of the scar which the stated wear would dig.
POINTS, MARGIN = 24, 1.1
GROWTH = 1.3  #: Largest growth of the cycle number in one jump.
#: Foundation stiffness as a multiple of E*/a: what gives Hertz's load and radius together in a fresh contact, and what
#: a half-space yields on average under the even pressure of a worn one (Johnson, Contact Mechanics, eq. 3.29).
FRESH_FOUNDATION, WORN_FOUNDATION = 16.0 / (3.0 * pi), 3.0 * pi / 16.0
#: What the gripped wires yield besides the half-space, times E·D: a seventh of the fresh steel contact's compliance.
BULK_YIELD = 5.7
#: A rough layer's tangential over its normal stiffness (Mindlin's ratio for a Poisson's ratio of 0.3).
ROUGH_RATIO = 0.82
#: Debris lies thickest where the scar is deepest; no more than this share stays, or the scar would close.
MOST_RETAINED = 0.45
SEVERE_WITHIN = (0.05, 20.0)  #: Wear that depends on the pressure does so within these multiples of the reference.


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The test at a cycle: its closed loop, both shapes, load range, and friction work done so far [mJ]."""

    cycle: int
    loop: TrueLoop
    shapes: Shapes
    worn_mm3: float


@dataclass(frozen=True, eq=False)
class _State:
    """Contact solved at a wear state, with what follows from it."""

    contact: Contact
    foundation: Foundation
    slope: Array
    loop: TrueLoop
    radius_mm: float


def grid_of(world: World, points: int = POINTS) -> Grid:
    """A grid for the scar that the wear coefficient and a loop without losses would dig."""
    drive, wear = world.drive, world.wear
    energy = 4.0 * world.friction.course.final * world.loading.load_N * drive.amplitude_mm * drive.cycles
    volume = wear.coefficient_mm3_per_mJ * max(wear.factor.initial, wear.factor.final) * energy
    radius = world.specimens.radius_mm
    scar = (4.0 * radius * volume / pi) ** 0.25
    fresh = (0.75 * world.loading.load_N * radius / _contact_modulus(world)) ** (1.0 / 3.0)
    return Grid.around(min(MARGIN * scar + fresh, 0.9 * radius), 1.08 * drive.amplitude_mm, points)


def snapshots(world: World, cycles: Sequence[int], points: int = POINTS, growth: float = GROWTH) -> Iterator[Snapshot]:
    """The test at each of the cycles, increasing; jumps between them are of second order at a fixed stroke.
    Raises ArithmeticError if the world's contact does not slip, or nothing carries its load.
    """
    grid = grid_of(world, points)
    wires = world.specimens
    bodies = Bodies(grid, wires.radius_mm, wires.crossing_error_rad, world.loading.tilt_rad, wires.fixed_crown)
    shapes = _flattened(world, bodies)
    fresh = _fresh_radius(world)
    reference = _reference_approach(world, bodies, shapes, fresh)
    state, now, worn = _solve(world, bodies, shapes, 0.0, fresh, reference, None), 0.0, 0.0
    start = 0.0
    for cycle in cycles:
        while now < cycle:
            due = next_cycle(world.incidents, now)
            step = min(max((growth - 1.0) * (now - start), 1.0), cycle - now, due - now)
            before = shapes
            shapes = _jump(world, bodies, shapes, now, step, state, reference)
            worn += _volume(grid, shapes) - _volume(grid, before)
            happens = step == due - now
            now = due if happens else now + step
            if happens:
                # What is new wears fast again: steps grow again.
                shapes, start = befallen(world.incidents, due, grid, shapes), due
            state = _solve(world, bodies, shapes, now, state.radius_mm, reference, state.contact.approach_mm)
        yield Snapshot(cycle, state.loop, shapes, worn)


def _contact_modulus(world: World) -> float:
    return world.specimens.youngs_modulus_MPa / (2.0 * (1.0 - world.specimens.poissons_ratio**2))


def _fresh_radius(world: World) -> float:
    hertz = (0.75 * world.loading.load_N * world.specimens.radius_mm / _contact_modulus(world)) ** (1.0 / 3.0)
    return float((hertz**2 + world.specimens.flattening_mm * world.specimens.radius_mm) ** 0.5)


def _flattened(world: World, bodies: Bodies) -> Shapes:
    """Each wire gives way by half the overlap of the unworn shapes, the moving one along its whole stroke."""
    grid = bodies.grid
    above_touch = bodies.distance_mm - bodies.distance_mm.min(axis=(0, 2))[None, :, None]
    overlap = np.maximum(world.specimens.flattening_mm - above_touch, 0.0)
    moving = np.zeros((grid.y_mm.size, grid.moving_x_mm.size))
    places = grid.positions_mm.size
    for place in np.flatnonzero(np.abs(grid.positions_mm) <= world.drive.amplitude_mm):
        start = places - 1 - place
        window = moving[:, start : start + grid.x_mm.size]
        np.maximum(window, 0.5 * overlap[:, place, :], out=window)
    fixed = 0.5 * overlap[:, places // 2, :]
    for groove in world.specimens.grooves:
        fixed = np.maximum(fixed, groove.depth_mm(grid))
    return Shapes(np.maximum(fixed, _old_scar(world, bodies)) if world.specimens.old_scar_mm else fixed, moving)


def _old_scar(world: World, bodies: Bodies) -> Array:
    """Depth [mm] of what another wire has worn out of the fixed one before (n_y, n_x): a second crossed cylinder's."""
    x, y = bodies.grid.x_mm[None, :], bodies.grid.y_mm[:, None]
    aside = y - world.specimens.old_scar_aside_mm
    return np.maximum(world.specimens.old_scar_mm - (x**2 + aside**2) / (2.0 * bodies.radius_mm), 0.0)


def _foundation(world: World, shapes: Shapes, radius_mm: float) -> Foundation:
    fresh = min(_fresh_radius(world) / radius_mm, 1.0)
    multiple = WORN_FOUNDATION + (FRESH_FOUNDATION - WORN_FOUNDATION) * fresh
    stiffness = multiple * _contact_modulus(world) / radius_mm
    retained = min(world.layers.retained, MOST_RETAINED)
    if retained == 0.0:
        return Foundation(stiffness)
    depth = shapes.fixed
    return Foundation(stiffness, _bed(world.layers, retained, depth), world.layers.debris_modulus_MPa)


def _bed(layers: Layers, retained: float, depth_mm: Array) -> Array:
    """How thick debris lies [mm], (n_y, n_x) as the worn depth."""
    gathered = (depth_mm / max(float(depth_mm.max()), 1e-9)) ** layers.gathering
    bed = retained * depth_mm * gathered
    return bed if isinf(layers.full_mm) else layers.full_mm * -np.expm1(-bed / layers.full_mm)


def _load(world: World, bodies: Bodies, cycle: float, reference_mm: float) -> Load:
    share = bodies.grid.positions_mm / world.drive.amplitude_mm
    along = world.loading.bowl * (share**2 - 1.0 / 3.0) + world.loading.slant * share
    at_positions = world.loading.load_at(cycle) * (1.0 + along)
    return Load(at_positions, world.loading.spring_N_per_mm, reference_mm)


def _reference_approach(world: World, bodies: Bodies, shapes: Shapes, radius_mm: float) -> float:
    """Approach at which the spring carries the asked load: that of the fresh contact in mid-stroke [mm]."""
    free = Load(np.full(bodies.grid.positions_mm.size, world.loading.load_N), 0.0, 0.0)
    contact = solve_contact(bodies, shapes, _foundation(world, shapes, radius_mm), free)
    return float(contact.approach_mm[contact.approach_mm.size // 2])


def _solve(
    world: World,
    bodies: Bodies,
    shapes: Shapes,
    cycle: float,
    radius_mm: float,
    reference_mm: float,
    start_mm: Array | None,
) -> _State:
    load = _load(world, bodies, cycle, reference_mm)
    weights = bodies.grid.path_weights(-0.8 * world.drive.amplitude_mm, 0.8 * world.drive.amplitude_mm)
    for _ in range(2):  # The foundation's stiffness follows the contact's size.
        foundation = _foundation(world, shapes, radius_mm)
        contact = solve_contact(bodies, shapes, foundation, load, start_mm)
        radius_mm, start_mm = contact.effective_radius_mm(bodies.grid, weights), contact.approach_mm
    slope = slopes(bodies, shapes)
    moments = force_moments(bodies, contact, slope)
    table = ForceTable(
        bodies.grid.positions_mm,
        moments,
        contact.load_N,
        world.friction.at(cycle),
        _stick_stiffness(world, radius_mm),
        _layer_compliance(world, foundation, contact, cycle, radius_mm),
        cycle,
    )
    return _State(contact, foundation, slope, driven_loop(world, table, cycle), radius_mm)


def _stick_stiffness(world: World, radius_mm: float) -> float:
    """Tangential stiffness of the contact [N/mm]: Mindlin's 2 G* a, and the gripped wires' bulk in series."""
    wires = world.specimens
    shear = wires.youngs_modulus_MPa / (2.0 * (1.0 + wires.poissons_ratio))
    mindlin = 2.0 * radius_mm * 2.0 * shear / (2.0 - wires.poissons_ratio)
    return 1.0 / (1.0 / mindlin + BULK_YIELD / (wires.youngs_modulus_MPa * 2.0 * wires.radius_mm))


def _layer_compliance(world: World, foundation: Foundation, contact: Contact, cycle: float, radius_mm: float) -> float:
    """Compliance of roughness and debris in shear [mm/N]; roughness stiffens with the load it carries."""
    layers = world.layers
    load = float(contact.load_N[contact.load_N.size // 2])
    rough = layers.rough_mm.at(cycle) / (ROUGH_RATIO * load)
    if foundation.layer is None:
        return rough
    pressure = contact.pressure[:, contact.load_N.size // 2, :]
    thickness = float(np.average(foundation.layer, weights=pressure))
    return rough + thickness / (layers.debris_modulus_MPa / 2.6 * pi * radius_mm**2)


def _jump(
    world: World, bodies: Bodies, shapes: Shapes, cycle: float, step: float, state: _State, reference_mm: float
) -> Shapes:
    """Shapes after a jump of `step` cycles, friction and wear taken at its middle."""
    middle = cycle + 0.5 * step
    friction = world.friction.at(middle)
    slip = _slip_range(world, state, friction)
    weights = bodies.grid.path_weights(*slip) * _slanted(world, bodies.grid)
    per_work = world.wear.coefficient_mm3_per_mJ * world.wear.factor_at(middle)
    share = world.wear.moving_share
    steepness = friction_work(Contact(np.ones_like(state.slope), *_rest(state)), state.slope, friction)
    load = _load(world, bodies, middle, reference_mm)
    approach = state.contact.approach_mm

    def rate(now: Shapes) -> Shapes:
        nonlocal approach
        foundation = _foundation(world, now, state.radius_mm)
        contact = solve_contact(bodies, now, foundation, load, approach)
        approach = contact.approach_mm
        severe = contact.pressure * _severity(world, contact.pressure)
        recession = severe * steepness * (per_work * weights)[None, :, None]
        fixed, moving = recession.sum(axis=1), bodies.grid.gathered(recession)
        if world.wear.skin_factor != 1.0:
            fixed, moving = fixed * _skin(world, now.fixed), moving * _skin(world, now.moving)
        return Shapes((1.0 - share) * fixed, share * moving)

    # Every point of the fixed wire is rubbed along the whole path at most.
    radius = (
        state.foundation.stiffness
        * per_work
        * float(weights.sum())
        * float(steepness.max(initial=0.0, where=state.contact.pressure > 0.0))
    )
    if world.wear.pressure_exponent:
        radius *= (1.0 + world.wear.pressure_exponent) * float(np.max(_severity(world, state.contact.pressure)))
    radius *= max(world.wear.skin_factor, 1.0)
    return chebyshev_step(shapes, rate, step, stages_needed(step, radius))


def _severity(world: World, pressure: Array) -> Array | float:
    """Factor on wear that follows the pressure (n_y, n_p, n_x); 1 where it does not."""
    if world.wear.pressure_exponent == 0.0:
        return 1.0
    return np.asarray(np.clip(pressure / world.wear.reference_MPa, *SEVERE_WITHIN) ** world.wear.pressure_exponent)


def _slanted(world: World, grid: Grid) -> Array:
    """Factor on wear at each position of the stroke (n_p,)."""
    return np.asarray(1.0 + world.wear.slant * np.clip(grid.positions_mm / world.drive.amplitude_mm, -1.0, 1.0))


def _skin(world: World, depth_mm: Array) -> Array:
    """Factor on wear at a depth below the unworn surface."""
    return np.asarray(1.0 + (world.wear.skin_factor - 1.0) * np.exp(-depth_mm / world.wear.skin_mm))


def _rest(state: _State) -> tuple[Array, Array]:
    return state.contact.approach_mm, state.contact.load_N


def _slip_range(world: World, state: _State, friction: float) -> tuple[float, float]:
    """Stroke positions between which the wires slide: the reach less the contact's elastic part."""
    low, high = state.loop.reach_mm
    lost = 0.75 * friction * float(state.contact.load_N.mean()) / _stick_stiffness(world, state.radius_mm)
    return low + lost, high - lost


def _volume(grid: Grid, shapes: Shapes) -> float:
    return float(grid.spacing_mm**2 * (shapes.fixed.sum() + shapes.moving.sum()))
