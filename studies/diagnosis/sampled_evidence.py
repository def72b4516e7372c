"""Evidence of effects by nested sampling, around the best fit, as a check of Laplace's approximation.

The prior is cut to a box of many posterior deviations about the fit, so that few steps lead to its middle, and its
share of the prior is counted. Where what was sampled reaches a side of the box, all is done again in one twice as wide.
A second, separate best place far outside is not seen.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp, ndtr, ndtri

from wirewear.diagnosis.infer.inference import ADDED, Fit, Problem, applied

Array = NDArray[np.float64]

#: Half width of the box in posterior deviations; the least in deviations of the prior; how often it is widened.
_HALF_WIDTH, _LEAST, _WIDENED = 8.0, 0.5, 3

_AT_SIDES = 0.01  #: Share of the posterior that may lie in the outer twentieths of the box along any coordinate.
_REACH = 4.0  #: Coordinates beyond this are taken as there.


def sampled_log_evidence(problem: Problem, one: Fit, live: int, seed: int) -> float:
    """Log evidence of a fit's effects by nested sampling (dynesty), on the scale of the fits'."""
    deviations = np.sqrt(np.diag(one.spread))
    half = np.maximum(_HALF_WIDTH * deviations, _LEAST)
    for _ in range(_WIDENED):
        found, at_sides = _in_box(problem, one, one.coordinates - half, one.coordinates + half, live, seed)
        if at_sides < _AT_SIDES:
            break
        half = 2.0 * half
    return found - sum(ADDED.get(candidate.name, 0.0) for candidate in one.candidates)


def _in_box(problem: Problem, one: Fit, low: Array, high: Array, live: int, seed: int) -> tuple[float, float]:
    """Log evidence within a box of coordinates, and the share of the posterior at sides that cut the prior."""
    import dynesty

    below, above = ndtr(low), ndtr(high)

    def coordinates(share: Array) -> Array:
        return np.asarray(ndtri(below + share * (above - below)), dtype=np.float64)

    def log_likelihood(z: Array) -> float:
        rest = problem.whitened(applied(one.candidates, problem.setup, np.clip(z, -_REACH, _REACH)))
        return -0.5 * float(rest @ rest)

    random = np.random.default_rng(seed)
    sampler = dynesty.NestedSampler(
        log_likelihood, coordinates, one.coordinates.size, nlive=live, rstate=random, bound="single"
    )
    sampler.run_nested(dlogz=0.5, print_progress=False)
    results = sampler.results
    weights = np.exp(results.logwt - logsumexp(results.logwt))
    place = (results.samples - low) / (high - low)
    cut_below, cut_above = low > -_REACH, high < _REACH
    beyond = ((place < 0.05) & cut_below) | ((place > 0.95) & cut_above)
    log_share = float(np.log(above - below).sum())
    return float(results.logz[-1]) + log_share, float((weights[:, None] * beyond).sum(axis=0).max())
