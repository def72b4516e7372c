"""How far the gap shrinks once effects are added: on cycles left out of the fit, and in physical units.

S = (G0² − G1²)/(G0² − Gf²), before and after adding effects. G is the root mean square of measured less computed over
all held-out features (`Features`) of all repeats, in standard deviations of one test (noise, scatter of specimens,
solver error, and differences within the record's tolerance). The floor Gf is that of a perfect model: each repeat
against the others' mean, and what models may differ by. A gap that falls below the floor has shrunk as a whole, S = 1.
S is at least −9.99, and 0 if the gap is not above the floor.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.covariance import Covariance, smooth_covariance, whole_sizes
from wirewear.diagnosis.infer.inference import Fit, Problem, fit
from wirewear.diagnosis.infer.weighing import NOTICEABLE
from wirewear.diagnosis.observe.observable import AlongBranch, Scale
from wirewear.diagnosis.observe.reduction import Features, Layout, Observations
from wirewear.diagnosis.surrogate.forward import PredictedLoops
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.results.scar import called

_KNOWN = constants("infer.shrink")

#: Draws of a shrink's interval.
_DRAWS = _KNOWN.count("draws")

#: Left out of profiles that are all there is.
STRETCHES = "every second stretch"

#: Share of the logged cycles, counted from the end, that is left out of the fit.
HELD_OUT_SHARE = _KNOWN.number("held_out_share")

#: An explanation that removes less than this of a gap on held-out cycles is none.
LEAST_SHRINK = _KNOWN.number("least_shrink")

#: Held-out cycles show a gap if it is above so many floors.
CLEAR_GAP = _KNOWN.number("clear_gap")

#: A scar shows one if it differs by so many scatters of one test.
CLEAR_SCAR = _KNOWN.number("clear_scar")

#: Size of the free smooth fit beside which a shrink is set.
_FREE_SIZE = _KNOWN.number("free_size")


@dataclass(frozen=True, eq=False)
class HeldOutScores:
    """Scores of predictions on held-out observables: squared residuals (r, f) of r repeats in f features (means over
    groups of observables, see `Features`), in variances of one test.
    """

    observed: Observations
    covariance: Covariance
    features: Features

    @classmethod
    def of(cls, observed: Observations, covariance: Covariance, test: BoolArray) -> HeldOutScores:
        """Scores of held-out observables, which `test` (n,) marks in the layout of `observed`. covariance: see
        `Covariance`, of `observed`.
        """
        return cls(observed, covariance, Features.of(observed.layout, test))

    def squares(self, predicted: Array) -> Array:
        """Squared residuals (r, f) of predicted values (n,) in variances of one test; NaN if unmeasured."""
        return self._scaled(self.observed.values - predicted)

    def floor(self) -> Array:
        """Squared residuals (r, f) that a perfect model would leave: those of each repeat from the mean of all, plus
        the variance by which solvers differ; 1 for a repeat that has no other beside it.
        """
        values = self.observed.values
        count = np.isfinite(values).sum(axis=0)
        # r/(r−1): each repeat is part of the mean that it is compared with.
        apart = np.sqrt(np.where(count > 1, count / np.maximum(count - 1, 1), 0.0))
        squares = self._scaled((values - np.nanmean(values, axis=0)) * apart)
        for repeat, variance in enumerate(self._variances()):
            solver = self.features.variances(self._of_models, self._seen(repeat)) / variance
            alone = self.features.of_each(count, self._seen(repeat)) < 2.0
            squares[repeat] += np.where(alone, 1.0, solver)
        return squares

    def size(self, squares: Array) -> float:
        """The gap G: root mean square of residuals from their squares (r, f), NaN left out."""
        return float(np.sqrt(np.nanmean(squares)))

    def interval(self, squares: dict[str, Array], seed: int) -> tuple[float, float]:
        """95 % interval of the shrink by bootstrap over repeats and cycles. squares: squared residuals (r, f) by
        "before", "after" and "floor". seed: of the random draws.
        """
        random = np.random.default_rng(seed)
        cycles = np.unique(self.features.cycle)
        sums = {
            name: np.array([[np.nansum(row[self.features.cycle == cycle]) for cycle in cycles] for row in values])
            for name, values in squares.items()
        }
        units = sums["before"].size
        draws = random.integers(0, units, size=(_DRAWS, units))
        b, a, f = (sums[name].ravel()[draws].sum(axis=1) for name in ("before", "after", "floor"))
        share = np.where(b - f > 1e-9, (b - a) / np.where(b - f > 1e-9, b - f, 1.0), 0.0)
        low, high = np.percentile(np.clip(share, -9.99, 1.0), [2.5, 97.5])
        return float(low), float(high)

    @property
    def _of_models(self) -> Array:
        """Covariance (n, n) of what honest models may differ by."""
        return np.asarray(self.covariance.numerical + self.covariance.tolerated)

    def _seen(self, repeat: int) -> BoolArray:
        return np.asarray(np.isfinite(self.observed.values[repeat]))

    def _scaled(self, residual: Array) -> Array:
        rows = [self.features.of_each(row, self._seen(repeat)) for repeat, row in enumerate(residual)]
        return np.stack(rows) ** 2 / np.stack(self._variances())

    def _variances(self) -> list[Array]:
        """Variance (f,) of each repeat's features about a perfect model."""
        between = self.covariance.between + self._of_models
        return [
            self.features.variances(between + np.diag(np.nan_to_num(noise**2)), self._seen(repeat))
            for repeat, noise in enumerate(self.observed.noise)
        ]


def held_out_cycles(loop_cycles: IntArray) -> list[tuple[int, ...]]:
    """Sets of cycles to leave out, best first: the last third, then every second one; empty if there are fewer than two
    cycles, one set for two. A change that only shows early in a test cannot be predicted from the cycles before it, but
    from its neighbours.
    """
    cycles = [int(cycle) for cycle in np.unique(loop_cycles)]
    if len(cycles) < 2:
        return []
    late = tuple(cycles[len(cycles) - max(round(HELD_OUT_SHARE * len(cycles)), 1) :])
    return [late, tuple(cycles[::2])] if len(cycles) > 2 else [late]


@dataclass(frozen=True, eq=False)
class Split:
    """A way to leave observables out of a fit.

    held_out: cycles. test, train: marks (n,) of the observables left out and of those fitted; some are neither. scar:
    body whose scar is left out, `STRETCHES` for profiles, "" if loops are left out.
    """

    held_out: tuple[int, ...]
    test: BoolArray
    train: BoolArray
    scar: str = ""


def splits(layout: Layout) -> Iterator[Split]:
    """Ways to leave something out, best first: late loops, every second loop, the scar of the held body; of profiles
    without loops every second stretch. If there is only one cycle all observables are fitted and scored. Scars never
    score loops: only a fit that knows them can show a rate of wear.
    """
    loops = layout.of_kind(AlongBranch)
    scars = layout.marked(part for part in layout if part.observable.of_scars)
    if scars.all():
        level = np.concatenate([part.sites.level for part in layout])
        order = np.argsort(np.argsort(level, kind="stable"), kind="stable")
        test = order // 2 % 2 == 1
        yield Split((int(layout.cycle.max()),), test, ~test, scar=STRETCHES)
        return
    chosen = held_out_cycles(layout.cycle[loops])
    for place, held in enumerate(chosen):
        test = np.isin(layout.cycle, held) & ~scars
        train = ~test & (layout.cycle < min(held)) if place == 0 else ~test
        if (train & loops).any():
            yield Split(held, test, train)
    if not chosen:
        everything = np.ones(len(layout), dtype=bool)
        yield Split((), everything, everything)
    # Bodies stand in order, the held one last.
    names = dict.fromkeys(name for part in layout if part.observable.of_scars for name in part.sites.body if name)
    if len(names) > 1:
        of_held = scars & layout.of_body(name := [*names][-1])
        yield Split((int(layout.cycle[of_held].max()),), of_held, ~of_held, scar=name)


@dataclass(frozen=True)
class Shrink:
    """Shrink S of the gap by the best explanation, with the numbers behind it.

    before, after, floor: gaps G0, G1 and Gf in standard deviations of one test. interval95: of `shrink`. predicted:
    shrink of the fit to all cycles. held_out: cycles left out. best_wrong_effect, free_smooth_fit: shrinks by an effect
    of another class (None if there is none) and by a fit of any smooth shape. scar_held_out: as `Split.scar`.
    borne_out: False for an explanation of what may be chance, see `_borne_out`.
    """

    before: float
    after: float
    floor: float
    shrink: float
    interval95: tuple[float, float]
    predicted: float
    held_out: tuple[int, ...]
    best_wrong_effect: float | None
    free_smooth_fit: float | None
    scar_held_out: str = ""
    borne_out: bool = True

    @property
    def scar_words(self) -> str:
        """Words for the held-out scars, to stand before a cycle: "scar of the fixed wire, "; "" if none was held
        out.
        """
        if self.scar_held_out == STRETCHES:
            return f"{STRETCHES} of the profiles, "
        return f"scar of the {called(self.scar_held_out)}, " if self.scar_held_out else ""

    @property
    def shows_gap(self) -> bool:
        """True if the gap on held-out data is more than `CLEAR_GAP` times the floor."""
        return self.before > CLEAR_GAP * self.floor

    def leaves_little(self, most: float) -> bool:
        """True if held-out data show a gap and the explanation leaves little of it: (G1² − Gf²)/(G0² − Gf²), the share
        left of what the gap's square has above the floor's, is at most `most` (0 to 1).
        """
        return self.shows_gap and self.shrink >= 1.0 - most

    @property
    def supports(self) -> bool:
        """True if the shrink on held-out data is at least `LEAST_SHRINK`, or they show no gap."""
        return not self.shows_gap or self.shrink >= LEAST_SHRINK


def shrink_of(
    problem: Problem, covariance: Covariance, observed: Observations, best: Fit, wrong: Fit | None, seed: int
) -> Shrink:
    """The shrink by the best explanation, and by placebos: the fit `wrong` (None for none) and a free smooth fit. seed:
    of the bootstrap's draws. Explanations are fitted again without the held-out observables.
    """
    tried = _tried(problem, covariance, observed)
    left_out = tried[-1] if tried[-1].clear else tried[0]
    again = left_out.refit(best)
    scores, after = left_out.scores, left_out.squares_of(again.setup)
    shrink, predicted = left_out.share(after), left_out.share(left_out.squares_of(best.setup))
    free = left_out.base + _free_prediction(problem, covariance, left_out.split.train, left_out.base)
    return Shrink(
        before=left_out.before,
        after=scores.size(after),
        floor=left_out.floor,
        shrink=shrink,
        interval95=scores.interval({**left_out.squares, "after": after}, seed),
        predicted=predicted,
        held_out=left_out.split.held_out,
        best_wrong_effect=None if wrong is None else left_out.share(left_out.squares_of(left_out.refit(wrong).setup)),
        free_smooth_fit=left_out.share(scores.squares(free)),
        scar_held_out=left_out.split.scar,
        borne_out=not best.names or left_out.shows_gap or _borne_out(tried, best, again),
    )


def _tried(problem: Problem, covariance: Covariance, observed: Observations) -> list[_LeftOut]:
    """The record with each part left out in turn, until one shows a gap clearly."""
    tried: list[_LeftOut] = []
    for split in splits(problem.layout):
        tried.append(_LeftOut.of(problem, covariance, observed, split))
        if tried[-1].clear:
            break
    if not tried:
        raise ValueError("a layout without loops leaves nothing to score")
    return tried


def _borne_out(tried: Sequence[_LeftOut], best: Fit, first: Fit) -> bool:
    """Whether an explanation of a gap that no left-out part shows clearly is more than chance: fitted to the rest it
    removes `LEAST_SHRINK` of some part's squared residuals, or the rest speaks for it whichever part is left out.
    first: the explanation fitted without the first part.
    """
    removed, gains = [], []
    for left_out in tried:
        again, none = first if left_out is tried[0] else left_out.refit(best), fit(left_out.known, ())
        after = left_out.scores.size(left_out.squares_of(again.setup))
        removed.append(1.0 - (after / left_out.before) ** 2 if left_out.before > 0.0 else 0.0)
        gains.append(again.log_evidence - none.log_evidence)
    return max(removed) >= LEAST_SHRINK or min(gains) >= NOTICEABLE


@dataclass(frozen=True, eq=False)
class _LeftOut:
    """What is left out of a fit, the gap that it shows, and how explanations fitted to the rest do there."""

    problem: Problem
    known: Problem
    base: Array
    split: Split
    scores: HeldOutScores
    squares: dict[str, Array]

    @classmethod
    def of(cls, problem: Problem, covariance: Covariance, observed: Observations, split: Split) -> _LeftOut:
        """The record with one part left out."""
        base = problem.predicted(problem.setup)
        scores = HeldOutScores.of(observed, covariance, split.test)
        squares = {"before": scores.squares(base), "floor": scores.floor()}
        return cls(problem, problem.part(split.train, covariance), base, split, scores, squares)

    @property
    def before(self) -> float:
        """Size of the gap that the left-out part shows without an explanation."""
        return self.scores.size(self.squares["before"])

    @property
    def floor(self) -> float:
        return self.scores.size(self.squares["floor"])

    @property
    def shows_gap(self) -> bool:
        return self.before > CLEAR_GAP * self.floor

    @property
    def clear(self) -> bool:
        """True for a gap that is not a scar's scatter."""
        return self.shows_gap and self.before > (CLEAR_SCAR if self.split.scar else 0.0)

    def refit(self, one: Fit) -> Fit:
        """The effects of a fit, fitted to the rest of the record alone."""
        return fit(self.known, one.candidates, [one.places]) if one.candidates else one

    def squares_of(self, setup: SurrogateInputs) -> Array:
        """Squared residuals of the left-out part under a setup."""
        return self.scores.squares(self.problem.predicted(setup))

    def share(self, squared: Array) -> float:
        """The shrink: the share of the gap that is closed where these squared residuals are left."""
        return _share(self.before, self.scores.size(squared), self.floor)


def achieved(
    problem: Problem,
    covariance: Covariance,
    observed: Observations,
    before: Shrink,
    loops_at: Callable[[Array], PredictedLoops],
) -> tuple[float, float]:
    """Shrink on the held-out cycles by another simulation, and the gap after it in standard deviations of one test.

    before: shrink by the fast model, which says what is held out. loops_at: gives the simulation's loops at cycles
    (c,).
    """
    layout = problem.layout
    loops = layout.marked(part for part in layout if part.observable.simulated)
    test = loops & (np.isin(layout.cycle, before.held_out) if before.held_out else True)
    values = layout.taken(test).observed(loops_at(layout.taken(test).cycles))
    scores = HeldOutScores.of(observed, covariance, test)
    base = problem.predicted(problem.setup)
    everywhere = base.copy()
    everywhere[test] = values
    gaps = [scores.size(scores.squares(values)) for values in (base, everywhere)]
    return _share(gaps[0], gaps[1], scores.size(scores.floor())), gaps[1]


def _share(before: float, after: float, floor: float) -> float:
    gap = before**2 - floor**2
    return float(np.clip((before**2 - after**2) / gap, -9.99, 1.0)) if gap > 1e-6 else 0.0


def _free_prediction(problem: Problem, covariance: Covariance, train: BoolArray, base: Array) -> Array:
    """Residual that a Gaussian process of any smooth shape, fitted on the training cycles, expects elsewhere."""
    setup = problem.setup
    size = _FREE_SIZE * whole_sizes(setup, problem.layout, base)
    prior = smooth_covariance(problem.layout, size, Scale(setup.amplitude_um, setup.plateau_force_N))
    block = (covariance.total + prior)[np.ix_(train, train)]
    expected: Array = prior[:, train] @ np.linalg.solve(block, (problem.mean - base)[train])
    return expected
