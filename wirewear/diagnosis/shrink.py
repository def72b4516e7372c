"""How far the gap shrinks once effects are added: on cycles left out of the fit, against the repeats' own floor.

S = (G0² − G1²)/(G0² − Gf²). G is the root mean square of measured less computed over all held-out observables of all
repeats, in standard deviations of one test (noise, scatter of specimens, solver error). The floor Gf is that of a
perfect model: each repeat against the others' mean, and the solver error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.covariance import Covariance
from wirewear.diagnosis.forward import Course
from wirewear.diagnosis.inference import Fit, Problem, fit, free_difference
from wirewear.diagnosis.layout import Array
from wirewear.diagnosis.reduction import Observations

#: Share of the logged cycles, counted from the end, that is left out of the fit.
HELD_OUT_SHARE = 0.34

_DRAWS = 400


@dataclass(frozen=True)
class Shrink:
    """Gap before and after in units of scatter, its floor, and the shrink with its 95 % interval.

    `predicted` is the shrink that the fit on all cycles expects. Placebos are None without a gap to shrink.
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


def held_out_cycles(layout_cycles: NDArray[np.int64]) -> tuple[int, ...]:
    """The last third of the cycles; none if there are fewer than two."""
    cycles = np.unique(layout_cycles)
    count = round(HELD_OUT_SHARE * cycles.size) if cycles.size > 2 else cycles.size - 1
    return tuple(int(cycle) for cycle in cycles[cycles.size - max(count, 0) :]) if count > 0 else ()


def shrink_of(
    problem: Problem, covariance: Covariance, observed: Observations, best: Fit, wrong: Fit | None, seed: int
) -> Shrink:
    """The shrink by the best explanation, and that by the best wrong effect and by a free smooth fit."""
    layout = problem.layout
    loop_cycles = layout.cycle[np.isin(layout.kind, ("plateau", "stick"))]
    held = held_out_cycles(loop_cycles)
    test = np.isin(layout.cycle, held) if held else np.ones(len(layout), dtype=bool)
    train = ~np.isin(layout.cycle, held) & (layout.cycle <= (min(held) if held else np.inf))
    if not held or not train.any():
        train = np.ones(len(layout), dtype=bool)
    known = problem.part(train, covariance)

    def predicted(one: Fit) -> Array:
        if not one.candidates:
            return problem.predicted(one.setup)
        refitted = fit(known, one.candidates, [one.coordinates])
        return problem.predicted(refitted.setup)

    base = problem.predicted(problem.setup)
    scores = _Scores(observed, covariance, layout.cycle, test)
    squares = {"before": scores.squares(base), "after": scores.squares(predicted(best)), "floor": scores.floor()}
    before, after, floor = (float(np.sqrt(scores.mean(squares[name]))) for name in ("before", "after", "floor"))
    interval = scores.interval(squares, seed)
    whole = scores.squares(problem.predicted(best.setup))
    free = base + _free_prediction(problem, covariance, train, base)
    return Shrink(
        before=before,
        after=after,
        floor=floor,
        shrink=_share(before, after, floor),
        interval95=interval,
        predicted=_share(before, float(np.sqrt(scores.mean(whole))), floor),
        held_out=held,
        best_wrong_effect=None
        if wrong is None
        else _share(before, float(np.sqrt(scores.mean(scores.squares(predicted(wrong))))), floor),
        free_smooth_fit=_share(before, float(np.sqrt(scores.mean(scores.squares(free)))), floor),
    )


def achieved(
    problem: Problem,
    covariance: Covariance,
    observed: Observations,
    before: Shrink,
    course_at: Callable[[Array], Course],
) -> tuple[float, float]:
    """Shrink and gap on the held-out loops by another simulation, which gives a course at cycles."""
    layout = problem.layout
    loops = np.isin(layout.kind, ("plateau", "stick"))
    test = loops & (np.isin(layout.cycle, before.held_out) if before.held_out else True)
    values = layout.taken(test).observed(course_at(layout.taken(test).cycles))
    everywhere = np.full(len(layout), np.nan)
    everywhere[test] = values
    scores = _Scores(observed, covariance, layout.cycle, test)
    base = problem.predicted(problem.setup)
    gaps = [float(np.sqrt(scores.mean(squares))) for squares in (scores.squares(base), scores.squares(everywhere))]
    floor = float(np.sqrt(scores.mean(scores.floor())))
    return _share(gaps[0], gaps[1], floor), gaps[1]


def _share(before: float, after: float, floor: float) -> float:
    gap = before**2 - floor**2
    return float(np.clip((before**2 - after**2) / gap, -9.99, 1.5)) if gap > 1e-6 else 0.0


@dataclass(frozen=True, eq=False)
class _Scores:
    """Squared residuals of every repeat, in variances of one test, on the held-out observables."""

    observed: Observations
    covariance: Covariance
    cycle: NDArray[np.int64]
    test: NDArray[np.bool_]

    def squares(self, predicted: Array) -> Array:
        """(r, n) with NaN where nothing was measured."""
        values = self.observed.values[:, self.test] - predicted[self.test]
        return values**2 / self.covariance.single[self.test]

    def floor(self) -> Array:
        """The same for a perfect model: repeats against the others' mean, or their expected scatter if alone."""
        values = self.observed.values[:, self.test]
        numerical = self.covariance.numerical[self.test] / self.covariance.single[self.test]
        count = np.isfinite(values).sum(axis=0)
        centre = np.nanmean(values, axis=0)
        # r/(r−1): each repeat is part of the mean that it is compared with.
        apart = (values - centre) * np.where(count > 1, count / np.maximum(count - 1, 1), 0.0)
        alone = np.where(count > 1, 0.0, 1.0 - numerical)
        return np.where(np.isfinite(values), apart**2 / self.covariance.single[self.test] + numerical + alone, np.nan)

    def mean(self, squares: Array) -> float:
        """Mean over all that was measured."""
        return float(np.nanmean(squares))

    def interval(self, squares: dict[str, Array], seed: int) -> tuple[float, float]:
        """95 % interval of the shrink by drawing repeats and cycles anew, as whole loops."""
        random = np.random.default_rng(seed)
        repeats, cycles = squares["before"].shape[0], np.unique(self.cycle[self.test])
        sums = {
            name: np.array(
                [[np.nansum(row[self.cycle[self.test] == cycle]) for cycle in cycles] for row in values]
            ).ravel()
            for name, values in squares.items()
        }
        units = repeats * cycles.size
        draws = random.integers(0, units, size=(_DRAWS, units))
        b, a, f = (sums[name][draws].sum(axis=1) for name in ("before", "after", "floor"))
        share = np.where(b - f > 1e-9, (b - a) / np.where(b - f > 1e-9, b - f, 1.0), 0.0)
        low, high = np.percentile(np.clip(share, -9.99, 1.5), [2.5, 97.5])
        return float(low), float(high)


def _free_prediction(problem: Problem, covariance: Covariance, train: NDArray[np.bool_], base: Array) -> Array:
    """Residual that a Gaussian process of any smooth shape, fitted on the training cycles, expects elsewhere."""
    total = free_difference(problem, covariance.total, 0.1)
    prior = total - covariance.total
    block = total[np.ix_(train, train)]
    expected: Array = prior[:, train] @ np.linalg.solve(block, (problem.mean - base)[train])
    return expected
