"""Equations solved by the factors of similar ones, against a direct solution."""

import numpy as np
import pytest
from numpy.typing import NDArray

from solvers.wear_step.similar_equations import SimilarEquations

Array = NDArray[np.float64]

COUNT = 240


def matrix(seed: int = 1, change: float = 0.0) -> Array:
    """A dense matrix with a strong diagonal, and one that differs from it by a share."""
    chance = np.random.default_rng(seed)
    first = np.exp(-np.abs(np.subtract.outer(np.arange(COUNT), np.arange(COUNT))) / 20.0) + 0.1 * np.eye(COUNT)
    return np.asarray(first * (1.0 + change * chance.normal(size=first.shape)))


def solved(similar: SimilarEquations, whole: Array, unknowns: NDArray[np.int64], scale: float = 1.0) -> Array | None:
    """The solution on some unknowns, of equations scaled at random."""
    part, rhs = whole[np.ix_(unknowns, unknowns)], np.cos(unknowns)
    chance = np.random.default_rng(len(unknowns))
    row, column = scale * chance.uniform(0.5, 2.0, len(rhs)), chance.uniform(0.5, 2.0, len(rhs))
    scaled = np.asfortranarray(row[:, None] * part * column)
    solution = similar.solution(unknowns, scaled, row * rhs, row, column)
    return None if solution is None else solution * column


@pytest.mark.parametrize("change", [0.0, 1e-4, 1e-2, 1.0])
def test_equations_that_changed_are_solved_whatever_the_change(change: float) -> None:
    similar, every = SimilarEquations(), np.arange(COUNT)
    some, others = np.delete(every, [3, 77]), np.delete(every, [5])
    for unknowns, whole in ((some, matrix()), (others, matrix(2, change)), (every, matrix(3, change))):
        found = solved(similar, whole, unknowns, scale=1.0 + change)
        exact = np.linalg.solve(whole[np.ix_(unknowns, unknowns)], np.cos(unknowns))
        assert found == pytest.approx(exact, rel=1e-7, abs=1e-9 * np.abs(exact).max())


def test_a_small_change_needs_no_new_factors(monkeypatch: pytest.MonkeyPatch) -> None:
    similar, every = SimilarEquations(), np.arange(COUNT)
    assert solved(similar, matrix(), np.delete(every, 7)) is not None
    monkeypatch.setattr("solvers.wear_step.similar_equations.lapack.dgetrf", None)
    assert solved(similar, matrix(2, 1e-6), every) is not None


def test_singular_equations_have_no_solution() -> None:
    assert solved(SimilarEquations(), np.zeros((COUNT, COUNT)), np.arange(COUNT)) is None
