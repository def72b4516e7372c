"""Covariance of what solvers disagree about on runs without a gap: freedoms of the fast model, and what none describes.

Freedoms move all observables together along their derivative in the fast model. The remainder is smooth along loops and
over cycles; each observable says how large it is (`Observable.solver_error`). Hooks differ as a whole.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from geometry.arrays import Array, IntArray
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.layout import Layout, Part
from wirewear.diagnosis.observe.sites import ModelLoops, Scale

#: Standard deviations of what honest models and rigs differ by that a tolerance is: nineteen of twenty stay within it.
WITHIN = 1.96

_HOOKS, _SMOOTH = constants("model.numerical.hooks"), constants("model.numerical.smooth")

#: Shares of the force that slopes cause by which hooks differ as a whole, and at one end of the stroke from the other.
HOOK, SIDE = _HOOKS.each("whole", "side")

#: Hooks as a whole differ over this difference of the cycles' logarithm.
HOOK_REACH = _HOOKS.number("whole_reach")

#: Share of the remainder's variance that passes from one logged cycle to the next, as ripples of worn surfaces do; both
#: shares are correlated over these differences of the cycles' logarithm.
PASSING = _SMOOTH.number("passing")
PASSING_REACH, LASTING_REACH = _SMOOTH.each("passing_reach", "lasting_reach")

#: Correlation of both branches under a turn of the loop: of solvers' differences, of a free difference.
TURNED, FREE_TURNED = _SMOOTH.each("turned", "free_turned")

#: Ripples are alike at both ends of the stroke by this share of what lasting differences are.
PASSING_TURNED = _SMOOTH.number("passing_turned")


def solver_covariance(states: WearStates, setup: Setup, layout: Layout) -> Array:
    """Covariance (n, n) of the solvers' differences around a setup."""
    freedoms = derivatives(states, setup, layout, states.freedoms)
    covariance: Array = freedoms @ freedoms.T + remainder(states, setup, layout)
    return covariance


def tolerated(states: WearStates, setup: Setup, layout: Layout, tolerance: Mapping[str, float]) -> Array:
    """Covariance (n, n) of differences that are within a record's tolerance, of any smooth shape."""
    predicted = np.nan_to_num(layout.observed(simulate(states, setup, layout.cycles)))
    size = np.zeros(len(layout))
    for part in layout:
        # A tolerated volume says nothing of the shape of a profile, of which solvers have errors of their own.
        if not (part.observable.of_scars and part.observable.unit == "um"):
            whole = part.observable.whole(setup, predicted[part.rows])
            size[part.rows] = tolerance.get(part.observable.tolerance, 0.0) / WITHIN * whole
    return smooth_covariance(layout, size, Scale(setup.amplitude_um, setup.plateau_force_N))


#: Where scatters and freedoms that are relative stand in a setup.
_RELATIVE = {"friction": "friction_factor", "wear": "wear_factor", "load": "load_factor", "amplitude": "amplitude_um"}


def moved(setup: Setup, name: str, size: float) -> Setup:
    """The setup with one scatter or numerical freedom moved by so many of its units."""
    if name in _RELATIVE:
        return replace(setup, **{_RELATIVE[name]: getattr(setup, _RELATIVE[name]) * (1.0 + size)})
    if name == "compliance":
        return replace(setup, added_compliance_um_per_N=setup.added_compliance_um_per_N + size)
    if name == "force_offset":
        return replace(setup, force_offset_N=setup.force_offset_N + size * setup.load_N)
    return replace(setup, **{name: getattr(setup, name) + size})


def derivatives(states: WearStates, setup: Setup, layout: Layout, sizes: Mapping[str, float]) -> Array:
    """Change of the observables (n, k) by one standard deviation of each scatter or freedom, by central differences."""
    columns = []
    for name, size in sizes.items():
        up, down = (
            layout.observed(simulate(states, moved(setup, name, side * size), layout.cycles)) for side in (0.5, -0.5)
        )
        columns.append(up - down)
    return np.nan_to_num(np.stack(columns, axis=1))


def remainder(states: WearStates, setup: Setup, layout: Layout) -> Array:
    """Covariance (n, n) of solver differences that no numerical freedom describes."""
    return np.asarray(sum(components(states, setup, layout).values(), np.zeros((len(layout), len(layout)))))


#: Names of components that are no observable's.
HOOKS, SIDES, OWN = "hooks", "sides", "own"


def components(states: WearStates, setup: Setup, layout: Layout) -> dict[str, Array]:
    """The remainder's parts (n, n): what is smooth of each observable, by its name, and what all have in common.

    `HOOKS` differ as a whole, `SIDES` by the ends of the stroke; `OWN` is what the reading of a loop makes unsure.
    """
    loops = ModelLoops(setup, simulate(states, setup, layout.cycles))
    walls = derivatives(states, setup, layout, {"slope_factor": 1.0})[:, 0]
    shape = (len(layout), len(layout))
    found: dict[str, Array] = {OWN: np.zeros(shape)}
    hooks, sides = walls.copy(), np.zeros(len(layout))
    for part in layout:
        rows, error = part.rows, part.observable.solver_error(loops, part.sites)
        if error.size.any():
            smooth = found.setdefault(part.observable.name, np.zeros(shape))
            smooth[rows, rows] = smooth_block(part, error.size, loops.scale, TURNED)
        if error.own is not None:
            found[OWN][rows, rows] += np.diag(error.own**2)
        if error.common is not None:
            found[OWN][rows, rows] += np.outer(error.common, error.common)
        hooks[rows] *= error.hooked
        if error.wall is not None:
            sides[rows] = hooks[rows] * error.wall
    found[HOOKS] = HOOK**2 * np.outer(hooks, hooks) * alike(layout.cycle, HOOK_REACH)
    # In one cycle, ripples of worn surfaces may make the wall at one end of the stroke steeper than that at the other.
    found[SIDES] = SIDE**2 * np.outer(sides, sides) * alike(layout.cycle, PASSING_REACH)
    return found


def smooth_covariance(layout: Layout, size: Array, scale: Scale) -> Array:
    """Covariance (n, n) of smooth differences of those sizes (n,), as solvers have them."""
    return _blocks(layout, lambda part: smooth_block(part, size[part.rows], scale, TURNED))


def free_covariance(layout: Layout, setup: Setup, predicted: Array, share: float) -> Array:
    """Covariance (n, n) of a difference of any smooth shape, as large as that share of the loop."""
    scale = Scale(setup.amplitude_um, setup.plateau_force_N)

    def block(part: Part) -> Array:
        size = share * part.observable.free_size(setup, predicted[part.rows])
        return smooth_block(part, size, scale, FREE_TURNED)

    return _blocks(layout, block)


def smooth_block(part: Part, size: Array, scale: Scale, turned: float) -> Array:
    """Covariance (m, m) of one observable: smooth along branches and over the logarithm of cycles.

    `turned` is the correlation of both branches under a turn of the loop by 180°.
    """
    sites = part.sites
    smooth = part.observable.smoothness(sites, scale)
    other = np.outer(sites.branch, sites.branch) < 0
    lasting, passing = (alike(sites.cycle, reach) for reach in (LASTING_REACH, PASSING_REACH))
    turned *= smooth.turned
    # Ripples are no more alike at both ends than they are lasting.
    trend = (1.0 - PASSING) * lasting * np.where(other, -turned, 1.0)
    trend += PASSING * passing * np.where(other, -turned * PASSING_TURNED, 1.0)
    kernel = trend * np.exp(-0.5 * (smooth.along[:, None] - smooth.along) ** 2)
    kernel = np.where(smooth.family[:, None] == smooth.family, kernel, 0.0)
    # Nothing is known to be smooth to the last digit.
    return np.asarray(np.outer(size, size) * kernel + np.diag((smooth.rough * size) ** 2))


def alike(cycle: IntArray, reach: float) -> Array:
    """Correlation (n, n) of what changes smoothly over the logarithm of cycles (n,)."""
    time = np.log(np.maximum(cycle, 1.0))
    correlation: Array = np.exp(-0.5 * ((time[:, None] - time) / reach) ** 2)
    return correlation


def _blocks(layout: Layout, block_of: Callable[[Part], Array]) -> Array:
    covariance = np.zeros((len(layout), len(layout)))
    for part in layout:
        covariance[part.rows, part.rows] = block_of(part)
    return covariance
