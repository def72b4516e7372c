"""How far measurement and model may differ without any gap: noise, scatter between repeats, errors of the solvers.

All are Gaussian. A scatter is a number of the test that differs between repeats, such as friction; a freedom is a
number of the fast model in which solvers differ on runs without a gap. Both enter as columns, the derivatives of the
observables by them. The rest of the solvers' differences is smooth along loops and over cycles; each observable says
how large it is (`Observable.solver_error`). Hooks, the rises of force at the stroke's ends by walls of the scar, differ
as a whole.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from geometry.arrays import Array, IntArray
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.observe.local_lines import OUTLYING
from wirewear.diagnosis.observe.measured_loops import LEAST_NOISE
from wirewear.diagnosis.observe.observable import SLOPE_SHARE, ModelLoops, Scale
from wirewear.diagnosis.observe.reduction import Layout, Observations, Part
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.wear_states import WearStates

#: Standard deviations of what honest models and rigs differ by that a tolerance is: nineteen of twenty stay within it.
WITHIN = 1.96

_HOOKS, _SMOOTH = constants("infer.covariance.hooks"), constants("infer.covariance.smooth")

#: Share of the force that slopes cause by which hooks differ as a whole.
HOOK = _HOOKS.number("whole")

#: Smooth differences are correlated over this difference of the cycles' logarithm.
LASTING_REACH = _SMOOTH.number("lasting_reach")

#: Share of a variance that lasts: the rest passes from one logged cycle to the next, as ripples of worn surfaces do.
LASTING = _SMOOTH.number("lasting")

#: Correlation of both branches of smooth differences under a turn of the loop.
TURNED = _SMOOTH.number("turned")


#: Where scatters and freedoms that are relative stand in a setup.
_RELATIVE = {"friction": "friction_factor", "wear": "wear_factor", "load": "load_factor", "amplitude": "amplitude_um"}

#: Freedoms that every explanation is fitted with, as no straight line follows them: laws of friction from Mindlin's to
#: Dahl's lie far apart, and a contact as soft as its rig yields over much of the stroke.
FITTED = ("micro_slip",)

#: Names of components that are no observable's.
HOOKS, OWN, HELD = "hooks", "own", "held force"
_OF_REPEATABILITY = constants("infer.covariance.repeatability")

#: The expected noise counts as so many numbers.
EXPECTED_NUMBERS = _OF_REPEATABILITY.number("expected_numbers")
_KNOWN = constants("infer.covariance")

#: Standard deviations between tests on fresh specimens that are expected before looking, relative or as named.
SCATTER: Mapping[str, float] = constants("infer.covariance.scatter").all()

#: The expectation counts as so many repeats: three real ones alone would know a scatter within ×0.5 to ×6 only.
PRIOR_REPEATS = _KNOWN.number("prior_repeats")

#: What the owner states of it counts as so many; repeats that would scatter so by less than this chance contradict it.
STATED_REPEATS = _KNOWN.number("stated_repeats")
CONTRADICTED = _KNOWN.number("contradicted")

#: A sensor's zero is the same unknown in all repeats; what its gain may be off by is tolerated.
SHARED: Mapping[str, float] = {name: SCATTER[name] for name in ("displacement_offset_um", "force_offset")}

#: Noise counts for so much more variance where the repeats' scatter is distinguished from it.
NOISE_INFLATION = _KNOWN.number("noise_inflation")


def solver_covariance(states: WearStates, setup: SurrogateInputs, layout: Layout) -> Array:
    """Covariance (n, n) of the solvers' differences at a setup (inputs of the fast model), in the units of the n
    observables.
    """
    freedoms = derivatives(states, setup, layout, states.freedoms)
    covariance: Array = freedoms @ freedoms.T + remainder(states, setup, layout)
    return covariance


def tolerated(states: WearStates, setup: SurrogateInputs, layout: Layout, tolerance: Mapping[str, float]) -> Array:
    """Covariance (n, n) of differences within a record's tolerance, of any smooth shape. tolerance: relative
    differences that count as equal, by the names of `[tolerance]`; 0 if missing.
    """
    size = whole_sizes(setup, layout, np.nan_to_num(layout.computed(states, setup)[0]))
    for part in layout:
        # A tolerated volume says nothing of the shape of a profile, of which solvers have errors of their own.
        known = not (part.observable.of_scars and part.observable.unit == "um")
        size[part.rows] *= tolerance.get(part.observable.tolerance, 0.0) / WITHIN if known else 0.0
    return smooth_covariance(layout, size, Scale(setup.amplitude_um, setup.plateau_force_N))


def whole_sizes(setup: SurrogateInputs, layout: Layout, predicted: Array) -> Array:
    """Size (n,) of the whole quantity of which each observable is a part, such as the full force, at predicted values
    (n,). Relative differences are relative to these sizes.
    """
    whole = [part.observable.whole(setup, predicted[part.rows]) for part in layout]
    return np.concatenate([np.zeros(0), *whole])


def moved(setup: SurrogateInputs, name: str, size: float) -> SurrogateInputs:
    """A copy of the setup with the scatter or numerical freedom `name` changed by `size`: friction, wear, load,
    amplitude and force_offset relatively, others in their own unit.
    """
    if name in _RELATIVE:
        return replace(setup, **{_RELATIVE[name]: getattr(setup, _RELATIVE[name]) * (1.0 + size)})
    if name == "compliance":
        return replace(setup, added_compliance_um_per_N=setup.added_compliance_um_per_N + size)
    if name == "force_offset":
        return replace(setup, force_offset_N=setup.force_offset_N + size * setup.load_N)
    return replace(setup, **{name: getattr(setup, name) + size})


def derivatives(states: WearStates, setup: SurrogateInputs, layout: Layout, sizes: Mapping[str, float]) -> Array:
    """Change of the observables (n, k) by one standard deviation of each of k scatters or freedoms, by central
    differences. sizes: these standard deviations by name, in the unit of `moved`. Observables that are not defined
    change by 0.
    """
    both = layout.computed(
        states, *(moved(setup, name, side * size) for side in (0.5, -0.5) for name, size in sizes.items())
    )
    return np.nan_to_num(both[: len(sizes)] - both[len(sizes) :]).T


def remainder(states: WearStates, setup: SurrogateInputs, layout: Layout) -> Array:
    """Covariance (n, n) of the solvers' differences that no numerical freedom describes: the sum of `components`."""
    return np.asarray(sum(components(states, setup, layout).values(), np.zeros((len(layout), len(layout)))))


def components(states: WearStates, setup: SurrogateInputs, layout: Layout) -> dict[str, Array]:
    """Parts (n, n) of the covariance of `remainder`: of each observable by its name, `HOOKS`, `OWN` and, where a drive
    holds a force, `HELD`.

    An observable's part is smooth over sites and cycles. `HOOKS`: hooks, which differ as a whole. `OWN`: what the
    reading of a loop leaves uncertain.
    """
    loops = ModelLoops(setup, simulate(states, setup, layout.cycles))
    walls = derivatives(states, setup, layout, {"slope_factor": 1.0})[:, 0]
    shape = (len(layout), len(layout))
    found: dict[str, Array] = {OWN: np.zeros(shape)}
    if setup.held == "tangential":
        found[HELD] = _of_held_force(states, setup, layout, loops)
    hooks = walls.copy()
    for part in layout:
        rows, error = part.rows, part.observable.solver_error(loops, part.sites)
        if error.size.any():
            smooth = found.setdefault(part.observable.name, np.zeros(shape))
            smooth[rows, rows] = smooth_block(part, error.size, loops.scale, LASTING)
        if error.own is not None:
            found[OWN][rows, rows] += np.diag(error.own**2)
        if error.common is not None:
            found[OWN][rows, rows] += np.outer(error.common, error.common)
        hooks[rows] *= error.hooked
    found[HOOKS] = HOOK**2 * np.outer(hooks, hooks) * alike(layout.cycle, LASTING_REACH)
    return found


def _of_held_force(states: WearStates, setup: SurrogateInputs, layout: Layout, loops: ModelLoops) -> Array:
    """Covariance (n, n) of what follows from differences in the force at the stroke's ends where walls of the scar
    carry a held force: of all that it would take another stroke to hold.
    """
    rise_N = np.concatenate([loops.rise_N(part.sites) for part in layout])
    slides = np.isin(layout.cycle, layout.cycles[loops.predicted.slip_um > 0.0])
    step = 1e-3 * setup.held_share
    per_N = derivatives(states, setup, layout, {"held_share": step})[:, 0] / (step * setup.amplitude_um)
    size = np.hypot(HOOK, SLOPE_SHARE) * rise_N * slides * per_N
    trend = LASTING * alike(layout.cycle, LASTING_REACH) + (1.0 - LASTING) * (layout.cycle[:, None] == layout.cycle)
    return np.asarray(np.outer(size, size) * trend)


def smooth_covariance(layout: Layout, size: Array, scale: Scale) -> Array:
    """Covariance (n, n) of differences with standard deviations `size` (n,), smooth along branches and over cycles.
    scale: amplitude and force, the units of places along a branch.
    """
    covariance = np.zeros((len(layout), len(layout)))
    for part in layout:
        covariance[part.rows, part.rows] = smooth_block(part, size[part.rows], scale)
    return covariance


def smooth_block(part: Part, size: Array, scale: Scale, lasting: float = 1.0) -> Array:
    """Covariance (m, m) of the m numbers of one observable with standard deviations `size` (m,), smooth along branches.
    lasting: share of the variance that is smooth over the logarithm of cycles; the rest is independent in each cycle.
    """
    sites = part.sites
    smooth = part.observable.smoothness(sites, scale)
    other = np.outer(sites.branch, sites.branch) < 0
    trend = lasting * alike(sites.cycle, LASTING_REACH) * np.where(other, -TURNED * smooth.turned, 1.0)
    trend += (1.0 - lasting) * (sites.cycle[:, None] == sites.cycle) * ~other
    kernel = trend * np.exp(-0.5 * (smooth.along[:, None] - smooth.along) ** 2)
    kernel = np.where(smooth.family[:, None] == smooth.family, kernel, 0.0)
    # Nothing is known to be smooth to the last digit.
    return np.asarray(np.outer(size, size) * kernel + np.diag((smooth.rough * size) ** 2))


def alike(cycle: IntArray, reach: float) -> Array:
    """Correlation (n, n) of what changes smoothly over the logarithm of cycles (n,), Gaussian with the length
    `reach`.
    """
    time = np.log(np.maximum(cycle, 1.0))
    correlation: Array = np.exp(-0.5 * ((time[:, None] - time) / reach) ** 2)
    return correlation


@dataclass(frozen=True)
class NoiseEvidence:
    """Evidence from the differences of repeats on one observable's noise: its variance is 1 + `more`/`weight` times the
    stated one. `weight` is the effective number of values behind it; 0 for no evidence.
    """

    more: float = 0.0
    weight: float = 0.0

    def __add__(self, other: NoiseEvidence) -> NoiseEvidence:
        """Evidence of both together."""
        return NoiseEvidence(self.more + other.more, self.weight + other.weight)

    @property
    def factor(self) -> float:
        """Estimated factor on the stated noise variance; `EXPECTED_NUMBERS` further values are taken to speak for 1."""
        return 1.0 + self.more / (EXPECTED_NUMBERS + self.weight)


def noise_factors(observed: Observations, scattered: Array) -> Array:
    """Estimated factor (n,) on each number's noise variance, the same for all numbers of an observable. scattered: as
    in `noise_evidence`.
    """
    evidence = noise_evidence(observed, scattered)
    factors = [np.repeat(evidence[part.observable.name].factor, len(part.sites)) for part in observed.layout]
    return np.concatenate([np.ones(0), *factors])


def noise_evidence(observed: Observations, scattered: Array) -> dict[str, NoiseEvidence]:
    """Evidence on each observable's noise variance from the differences of repeats, by the observable's name; empty
    evidence for a single repeat.

    scattered: (n, n) covariance of one repeat's specimens and zeros. The difference of a repeat from the mean of those
    before it is normal, of scatter and noise. Given all other numbers, one number has a variance of which the share s
    is noise; its squared deviate indicates a factor of 1 + (square − 1)/s on the noise variance, with weight s².
    """
    evidence = {part.observable.name: NoiseEvidence() for part in observed.layout}
    for seen, apart, noise in _contrasts(observed):
        inverse = np.linalg.inv(noise + scattered[np.ix_(seen, seen)])
        own = np.diag(inverse)
        # A misread number says nothing of the others.
        squares = np.minimum((inverse @ apart) ** 2 / own, OUTLYING**2)
        share = np.sum((inverse @ noise) * inverse, axis=1) / own
        for part in observed.layout:
            here = (seen >= part.rows.start) & (seen < part.rows.stop)
            more, weight = share[here] @ (squares[here] - 1.0), share[here] @ share[here]
            evidence[part.observable.name] += NoiseEvidence(float(more), float(weight))
    return evidence


def _contrasts(observed: Observations) -> Iterator[tuple[NDArray[np.intp], Array, Array]]:
    """For each repeat but the first, where (k,) it and all before it are seen, and its difference (k,) from their mean.

    Differences are scaled so that they scatter as one repeat does; the covariance (k, k) of the noise is that of them.
    """
    for place in range(1, len(observed.values)):
        seen = np.flatnonzero(np.isfinite(observed.values[: place + 1]).all(axis=0))
        if seen.size:
            scale = place / (place + 1.0)
            apart = observed.values[place, seen] - observed.values[:place, seen].mean(axis=0)
            before = sum(observed.noise_covariance(repeat, seen) for repeat in range(place)) / place**2
            yield seen, np.sqrt(scale) * apart, scale * (observed.noise_covariance(place, seen) + before)


@dataclass(frozen=True, eq=False)
class Covariance:
    """Mean of the repeats' observables and its covariance about a model without a gap."""

    mean: Array  #: (n,) best mean of the repeats.
    total: Array  #: (n, n) covariance of `mean` less a perfect model's observables, with all parts below.
    free: Mapping[str, float]  #: Standard deviations, by name, of the k freedoms that every explanation is fitted with.
    moved: Array  #: (n, k) change of the observables by one standard deviation of each of these.
    single: Array  #: (n,) variance of one repeat's observables about the model: noise, scatter, solver error.
    numerical: Array  #: (n, n) the solver error's part.
    tolerated: Array  #: (n, n) the part of differences within the record's tolerance.
    between: Array  #: (n, n) covariance of one repeat's observables by its specimens and sensors' zeros.
    nuisance: Array  #: (n, n) covariance of `mean` by specimens and zeros.
    scatter: Mapping[str, float]  #: Estimated standard deviations between repeats, by name.
    contradicted: tuple[str, ...] = ()  #: Names of the stated scatters that the repeats contradict.


def estimate(states: WearStates, setup: SurrogateInputs, observed: Observations) -> Covariance:
    """The covariance at one setup, with the scatter between repeats as estimated from them and from its expected or
    stated size.
    """
    layout = observed.layout
    stated = observed.stated_scatter
    sizes = {name: max(stated.get(name, size), LEAST_NOISE * size) for name, size in SCATTER.items()}
    per_repeat = derivatives(states, setup, layout, sizes)
    shared = np.column_stack([derivatives(states, setup, layout, {**SHARED, **states.doubts}), observed.common])
    free = {name: states.freedoms[name] for name in FITTED if name in states.freedoms}
    numerical = solver_covariance(states, setup, layout)
    within = tolerated(states, setup, layout, observed.tolerance)
    common = shared @ shared.T
    factors, chances = _scatter_factors(observed, per_repeat, [name in stated for name in sizes])
    per_repeat = per_repeat * factors
    scattered = per_repeat @ per_repeat.T
    known = noise_factors(observed, scattered)
    # About their plain mean: numbers themselves lose more digits in two inverses than they differ by.
    centre = np.nanmean(observed.values, axis=0)
    precision, weighted = np.zeros((len(layout), len(layout))), np.zeros(len(layout))
    for repeat, values in enumerate(observed.values):
        seen = np.flatnonzero(np.isfinite(values))
        block = observed.noise_covariance(repeat, seen, known) + scattered[np.ix_(seen, seen)]
        inverse = np.linalg.inv(block)
        precision[np.ix_(seen, seen)] += inverse
        weighted[seen] += inverse @ (values - centre)[seen]
    sampling = np.linalg.inv(precision)
    total = sampling + numerical + within + common
    single = known * np.nanmedian(observed.noise**2, axis=0) + np.diag(scattered) + np.diag(numerical)
    names = zip(sizes.items(), factors, strict=True)
    return Covariance(
        mean=centre + sampling @ weighted,
        total=0.5 * (total + total.T),
        free=free,
        moved=derivatives(states, setup, layout, free),
        single=single,
        numerical=numerical,
        tolerated=within,
        between=scattered + common,
        nuisance=scattered / len(observed.values) + common,
        scatter={name: float(size * factor) for (name, size), factor in names},
        contradicted=tuple(
            name for name, chance in zip(sizes, chances, strict=True) if name in stated and chance < CONTRADICTED
        ),
    )


def with_model_error(
    states: WearStates,
    nominal: SurrogateInputs,
    changed: SurrogateInputs,
    layout: Layout,
    covariance: Covariance,
    share: float,
    anywhere: float = 0.0,
) -> Covariance:
    """A copy with an added smooth error: `share` of the change of the observables from the setup `nominal` to
    `changed`, and `anywhere` of the largest change along branches, of that unit, in any place of them.
    """
    before, after = layout.computed(states, nominal, changed)
    scale = Scale(nominal.amplitude_um, nominal.plateau_force_N)
    change = np.abs(np.nan_to_num(after - before))
    extra = smooth_covariance(layout, share * change, scale)
    along = [part for part in layout if anywhere and part.observable.of_branches]
    for part in along:
        alike = (change[other.rows].max() for other in along if other.observable.unit == part.observable.unit)
        size = np.full(len(part.sites), anywhere * max(alike))
        extra[part.rows, part.rows] += smooth_block(part, size, scale, LASTING)
    return replace(covariance, total=covariance.total + extra, numerical=covariance.numerical + extra)


def _scatter_factors(observed: Observations, per_repeat: Array, stated: Sequence[bool]) -> tuple[Array, Array]:
    """Factors on sizes from the repeats' coordinates along their directions, pooled with what is expected or stated.

    Also the chance of coordinates as far out as these.
    """
    rows: list[Array] = []
    for values, noise in zip(observed.values, observed.noise, strict=True):
        seen = np.isfinite(values)
        centre = np.nanmean(observed.values[:, seen], axis=0)
        design = per_repeat[seen] / noise[seen, None]
        # Each coordinate is a standard normal deviate if the expectation holds.
        normal = design.T @ design / NOISE_INFLATION + np.eye(design.shape[1])
        rows.append(np.linalg.solve(normal, design.T @ ((values[seen] - centre) / noise[seen]) / NOISE_INFLATION))
    count = len(rows)
    if count < 2:
        return np.ones(per_repeat.shape[1]), np.ones(per_repeat.shape[1])
    squares = (np.stack(rows) ** 2).sum(axis=0)
    prior = np.where(stated, STATED_REPEATS, PRIOR_REPEATS)
    return np.sqrt((prior + squares) / (prior + count - 1)), np.asarray(chdtrc(count - 1, squares))
