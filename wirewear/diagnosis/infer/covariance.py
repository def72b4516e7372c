"""How far measurement and model may differ without any gap: noise, scatter between repeats, errors of the solvers.

All are Gaussian and enter as columns: a scatter or a numerical freedom moves the observables along its derivative in
the fast model. What solvers of different mesh, increments and formulation disagree about on gap-free runs sets the
sizes in `NUMERICAL`; a smooth remainder stands for what no freedom describes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from wirewear.diagnosis.model.forward import MIDDLE, SLIDING, Course, simulate
from wirewear.diagnosis.model.numerical import (
    HOOK_REACH,
    LASTING_REACH,
    NUMERICAL,
    PASSING,
    PASSING_REACH,
    PASSING_SYMMETRIC,
    REMAINDER,
    WALL_HEIGHT,
    WALL_PLACE,
)
from wirewear.diagnosis.model.setup import Evolving, Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.layout import Array, Layout
from wirewear.diagnosis.observe.reduction import Observations

#: Standard deviations between tests on fresh specimens that are expected before looking, relative or as named.
SCATTER = {
    "friction": 0.02,
    "load": 0.008,
    "wear": 0.09,
    "amplitude": 0.004,
    "displacement_offset_um": 0.05,
    "force_offset": 0.002,
    "crossing_error_rad": 0.006,
}

#: The expectation counts as so many repeats: three real ones alone would know a scatter within ×0.5 to ×6 only.
PRIOR_REPEATS = 2.0

#: Within a test the stroke wanders by this share, before looking, over this difference of the cycles' logarithm.
DRIFT, DRIFT_REACH = 0.002, 1.5

#: A sensor's zero is the same unknown in all repeats.
SHARED = {"displacement_offset_um": 0.1, "amplitude": 0.001, "force_offset": 0.002}

#: The largest of some hundred noisy samples lies this many standard deviations too high, if another program took it.
PEAK_BIAS = 2.5

#: Forces are known within this share of the plateau: a displacement read on a shelf may lie anywhere on it.
FORCE_ERROR = {"slip": 0.02, "stick": 0.01}


@dataclass(frozen=True, eq=False)
class Covariance:
    """Covariance of the repeats' mean observables, as seen by a model without a gap.

    Attributes:
        mean: (n,) best mean of the repeats.
        total: (n, n) covariance of `mean` less a perfect model's observables, solver error included.
        single: (n,) variance of one repeat against the model, with noise, scatter and solver error.
        numerical: (n, n) covariance of the solver error in it.
        between: (n, n) covariance of one repeat's specimens and zeros.
        scatter: standard deviations between repeats, by name, as estimated.
    """

    mean: Array
    total: Array
    single: Array
    numerical: Array
    between: Array
    scatter: Mapping[str, float]


def moved(setup: Setup, name: str, size: float) -> Setup:
    """The setup with one scatter or numerical freedom moved by so many of its units."""
    if name in ("friction", "wear"):
        old = setup.friction if name == "friction" else setup.wear_um3_per_mJ
        changed = Evolving(old.initial * (1 + size), old.final * (1 + size), old.cycles)
        return replace(setup, friction=changed) if name == "friction" else replace(setup, wear_um3_per_mJ=changed)
    relative = {"load": "load_N", "amplitude": "amplitude_um"}
    if name in relative:
        return replace(setup, **{relative[name]: getattr(setup, relative[name]) * (1.0 + size)})
    if name == "compliance":
        # Solvers hold the wires differently: micrometres per newton beside the rig's own.
        return replace(setup, compliance_um_per_N=setup.compliance_um_per_N + size)
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


def estimate(states: WearStates, setup: Setup, observed: Observations) -> Covariance:
    """The covariance around one setup; the repeats' scatter is estimated from them and the expectation, pooled."""
    layout = observed.layout
    per_repeat = derivatives(states, setup, layout, SCATTER)
    shared = np.column_stack([derivatives(states, setup, layout, SHARED), _peak_bias_N(observed)])
    solver = derivatives(states, setup, layout, NUMERICAL)
    numerical = solver @ solver.T + remainder(states, setup, layout)
    factors = _scatter_factors(observed, per_repeat)
    per_repeat = per_repeat * factors
    scattered = per_repeat @ per_repeat.T + _drift(states, setup, observed)
    precision, weighted = np.zeros((len(layout), len(layout))), np.zeros(len(layout))
    for values, noise in zip(observed.values, observed.noise, strict=True):
        seen = np.flatnonzero(np.isfinite(values))
        block = np.diag(noise[seen] ** 2) + scattered[np.ix_(seen, seen)]
        inverse = np.linalg.inv(block)
        precision[np.ix_(seen, seen)] += inverse
        weighted[seen] += inverse @ values[seen]
    sampling = np.linalg.inv(precision)
    total = sampling + numerical + shared @ shared.T
    noise2 = np.nanmedian(observed.noise**2, axis=0)
    single = noise2 + np.diag(scattered) + np.diag(numerical)
    names = zip(SCATTER.items(), factors, strict=True)
    return Covariance(
        mean=sampling @ weighted,
        total=0.5 * (total + total.T),
        single=single,
        numerical=numerical,
        between=scattered + shared @ shared.T,
        scatter={name: float(size * factor) for (name, size), factor in names},
    )


def with_model_error(
    states: WearStates, nominal: Setup, changed: Setup, layout: Layout, covariance: Covariance, share: float
) -> Covariance:
    """The covariance with a smooth error of that share of the change from one setup to the other."""
    before, after = (layout.observed(simulate(states, setup, layout.cycles)) for setup in (nominal, changed))
    force = nominal.friction.final * nominal.load_N
    change = np.abs(np.nan_to_num(after - before))
    extra = smooth_kernel(layout, share * change, nominal.amplitude_um, force, symmetric=0.8)
    return replace(covariance, total=covariance.total + extra, numerical=covariance.numerical + extra)


def _peak_bias_N(observed: Observations) -> Array:
    """By how much noise may lift every largest force of an evolution, (n,)."""
    noise = float(np.median([loop.sample_noise_N for loop in observed.loops]))
    return np.where(observed.layout.kind == "force", PEAK_BIAS * noise, 0.0)


def _scatter_factors(observed: Observations, per_repeat: Array) -> Array:
    """Factors on `SCATTER` from the repeats' coordinates along its directions, pooled with the expectation."""
    rows: list[Array] = []
    for values, noise in zip(observed.values, observed.noise, strict=True):
        seen = np.isfinite(values)
        centre = np.nanmean(observed.values[:, seen], axis=0)
        design = per_repeat[seen] / noise[seen, None]
        # Each coordinate is a standard normal deviate if the expectation holds.
        normal = design.T @ design / 9.0 + np.eye(design.shape[1])
        rows.append(np.linalg.solve(normal, design.T @ ((values[seen] - centre) / noise[seen]) / 9.0))
    count = len(rows)
    if count < 2:
        return np.ones(per_repeat.shape[1])
    return _pooled((np.stack(rows) ** 2).sum(axis=0), count)


def _pooled(squares: Array, count: int) -> Array:
    """Factors on expected scatters from sums of squared deviates of so many repeats, pooled with the expectation."""
    factors: Array = np.sqrt((PRIOR_REPEATS + squares) / (PRIOR_REPEATS + count - 1))
    return factors


def _drift(states: WearStates, setup: Setup, observed: Observations) -> Array:
    """Covariance (n, n) of one repeat's stroke wandering during the test; its size is estimated like a scatter."""
    layout = observed.layout
    amplitude = layout.kind == "amplitude"
    factor = 1.0
    if (count := len(observed.values)) > 1 and amplitude.any():
        values = np.ma.masked_invalid(observed.values[:, amplitude])
        apart = values - values.mean(axis=0)
        wander = apart - apart.mean(axis=1)[:, None]
        noise2 = np.ma.masked_invalid(observed.noise[:, amplitude] ** 2)
        seen2 = float(np.ma.filled((wander**2).mean() * count / (count - 1) - noise2.mean(), 0.0))
        share2 = max(seen2, 0.0) / (DRIFT * setup.amplitude_um) ** 2
        factor = float(_pooled(np.asarray((count - 1) * share2), count))
    stroke = derivatives(states, setup, layout, {"amplitude": DRIFT * factor})[:, 0]
    covariance: Array = np.outer(stroke, stroke) * _alike(layout, DRIFT_REACH)
    return covariance


def _alike(layout: Layout, reach: float) -> Array:
    """Correlation (n, n) of what changes smoothly over the logarithm of cycles."""
    time = np.log(np.maximum(layout.cycle, 1.0))
    correlation: Array = np.exp(-0.5 * ((time[:, None] - time) / reach) ** 2)
    return correlation


def remainder(states: WearStates, setup: Setup, layout: Layout) -> Array:
    """Covariance (n, n) of solver differences that no numerical freedom describes: smooth along loops and cycles."""
    course = simulate(states, setup, layout.cycles)
    force = float(np.abs(course.tangential_force_N).max(axis=(1, 2)).min())
    rise = course.tangential_force_N[:, 0, -1] - course.tangential_force_N[:, 0, MIDDLE]
    place = np.searchsorted(course.cycles, layout.cycle)
    size = np.zeros(len(layout))
    size[layout.kind == "plateau"] = np.hypot(REMAINDER["slope"] * rise[place], REMAINDER["plateau"] * force)[
        layout.kind == "plateau"
    ]
    # Where a branch turns under another force, the whole stick branch lies elsewhere.
    turned = REMAINDER["tip"] * rise * _stick_compliance_um_per_N(course)
    size[layout.kind == "stick"] = np.hypot(REMAINDER["stick_um"], turned[place])[layout.kind == "stick"]
    values = layout.observed(course)
    for kind in ("amplitude", "normal", "energy", "slip", "force"):
        at = layout.kind == kind
        size[at] = REMAINDER["normal" if kind == "normal" else "relative"] * np.abs(values[at])
    at = layout.kind == "force"
    size[at] = np.hypot(size[at], REMAINDER["slope"] * rise[place][at])
    at = layout.kind == "knee"
    size[at] = np.hypot(REMAINDER["knee"] * force, REMAINDER["knee_slope"] * np.abs(values[at]))
    # How steep a wall begins depends on the elements as soon as there is one, and no more once it is high.
    high = rise / (1.0 + rise / (WALL_HEIGHT * force))
    size[at] = np.hypot(size[at], REMAINDER["knee_wall"] * high[place][at])
    size[layout.kind == "normal_direction"] = 0.3 * REMAINDER["normal"] * setup.load_N
    size[layout.kind == "amplitude"] *= 0.5
    size[layout.kind == "scar"] = REMAINDER["scar"]
    size[layout.kind == "skew"] = REMAINDER["skew"]
    smooth = smooth_kernel(layout, size, setup.amplitude_um, force, symmetric=0.8)
    crossing = _crossing_errors_um(layout, course, force)
    # A drive that repeats itself leaves every branch at the same place of a shelf.
    alike = np.where(layout.kind == "stick", crossing * layout.branch, 0.0)
    covariance: Array = smooth + np.diag(crossing**2) + np.outer(alike, alike) + _hooks(states, setup, layout)
    return covariance


def _hooks(states: WearStates, setup: Setup, layout: Layout) -> Array:
    """Covariance (n, n) of hooks that solvers compute larger or smaller, by a share that changes slowly over cycles.

    In one cycle, ripples of worn surfaces may make the wall at one end of the stroke steeper than that at the other.
    """
    walls = derivatives(states, setup, layout, {"slope_factor": 1.0})[:, 0]
    walls[np.isin(layout.kind, ("scar", "skew"))] = 0.0
    hooks = REMAINDER["hook"] * walls
    # A branch towards +x starts at the left wall.
    place = np.select(
        [layout.kind == "plateau", np.isin(layout.kind, ("stick", "knee"))], [layout.level, -layout.branch], 0.0
    )
    sides = REMAINDER["side"] * walls * np.sign(place)
    covariance: Array = np.outer(hooks, hooks) * _alike(layout, HOOK_REACH)
    covariance += np.outer(sides, sides) * _alike(layout, PASSING_REACH)
    return covariance


def _stick_compliance_um_per_N(course: Course) -> Array:
    """Travel over rise of the branch towards +x until it slides, (n,)."""
    travel, rise = (
        values[:, 0, SLIDING] - values[:, 0, 0] for values in (course.displacement_um, course.tangential_force_N)
    )
    compliance: Array = travel / np.maximum(rise, 1e-9)
    return compliance


def _crossing_errors_um(layout: Layout, course: Course, force_N: float) -> Array:
    """Errors (n,) of displacements read at a force, and of slip amplitudes, read at Q = 0."""
    errors = np.zeros(len(layout))
    for row in np.flatnonzero(np.isin(layout.kind, list(FORCE_ERROR))):
        at = int(np.searchsorted(course.cycles, layout.cycle[row]))
        side = 0 if layout.branch[row] >= 0 else 1
        sign, known = (1, -1)[side], FORCE_ERROR[str(layout.kind[row])] * force_N
        x, q = sign * course.displacement_um[at, side], sign * course.tangential_force_N[at, side]
        low, high = np.interp(layout.level[row] + known * np.array([-1.0, 1.0]), np.maximum.accumulate(q), x)
        errors[row] = (high - low) / np.sqrt(12.0)
    # A slip amplitude is half the sum of two crossings.
    return np.where(layout.kind == "slip", errors / np.sqrt(2.0), errors)


def smooth_kernel(layout: Layout, size: Array, amplitude_um: float, force_N: float, *, symmetric: float) -> Array:
    """A covariance smooth along branches and over the logarithm of cycles, zero between kinds of observables.

    `symmetric` is the correlation of both branches under a turn of the loop by 180°.
    """
    plateau = layout.kind == "plateau"
    along = np.where(plateau, layout.level * layout.branch / amplitude_um / 0.35, layout.level / force_N / 0.6)
    alike = layout.kind[:, None] == layout.kind
    scar = layout.kind == "scar"
    along = np.where(scar, 10.0 * layout.level, along)
    lasting, passing = (_alike(layout, reach) for reach in (LASTING_REACH, PASSING_REACH))
    turned = np.outer(layout.branch, layout.branch) < 0
    # Each branch has its knee at a wall of its own, and ripples are no more alike at both ends than they are lasting.
    lasting_turn = np.where(layout.kind == "knee", 0.0, symmetric)
    passing_turn = np.where(layout.kind == "knee", 0.0, symmetric * PASSING_SYMMETRIC)
    trend = (1.0 - PASSING) * lasting * np.where(turned, -lasting_turn, 1.0)
    trend += PASSING * passing * np.where(turned, -passing_turn, 1.0)
    kernel = trend * np.exp(-0.5 * (along[:, None] - along) ** 2)
    covariance: Array = np.where(alike, np.outer(size, size) * kernel, 0.0)
    # Nothing is known to be smooth to the last digit, and walls least.
    wall = plateau & (np.abs(layout.level) > WALL_PLACE * amplitude_um)
    return covariance + np.diag((np.where(wall, REMAINDER["rough_wall"], REMAINDER["rough"]) * size) ** 2)
