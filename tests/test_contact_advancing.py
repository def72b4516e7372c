"""Increments that Newton's method does not solve at once: they are cut, and no longer led by a guess."""

from typing import Any

import numpy as np
import pytest

from solvers.contact import ContactProblem, advance, advancing, unloaded_state
from solvers.contact.increment import IncrementFailedError
from solvers.errors import NotConvergedError
from solvers.guide import FirstGuess
from tests.bodies import crossed_wires


@pytest.fixture(scope="module")
def problem() -> ContactProblem:
    return crossed_wires(0.02)


def solved(*, longest_mm: float, misleading: bool) -> tuple[Any, list[tuple[float, bool]]]:
    """A stand-in for one increment's solution, which fails beyond a length or by a guess, and its calls."""
    calls: list[tuple[float, bool]] = []

    def solve(_problem: Any, state: Any, drive: float, _cycles: float, **kwargs: Any) -> tuple[Any, Any]:
        guessed = kwargs["expected"] is not None
        calls.append((drive, guessed))
        if (misleading and guessed) or drive - state.drive > longest_mm * (1.0 + 1e-9):
            raise IncrementFailedError("it does not converge")
        return type(state)(drive), None

    return solve, calls


class At:
    """A state of which nothing but the drive counts."""

    def __init__(self, drive: float) -> None:
        self.drive = drive


def test_a_guess_that_leads_astray_is_not_followed_once_the_increment_is_cut(
    monkeypatch: pytest.MonkeyPatch, problem: ContactProblem
) -> None:
    solve, calls = solved(longest_mm=1.0, misleading=True)
    monkeypatch.setattr(advancing, "solve_increment", solve)
    guess = FirstGuess(0.0, 1.0, np.zeros((1, 3)))
    start: Any = At(0.0)
    state, reports = advance(problem, start, 1.0, 0.0, guess)
    assert state.drive == pytest.approx(1.0)
    assert len(reports) == 2
    assert [guessed for _, guessed in calls] == [True, False, False]


def test_an_increment_is_cut_as_far_as_it_needs(monkeypatch: pytest.MonkeyPatch, problem: ContactProblem) -> None:
    solve, _ = solved(longest_mm=0.13, misleading=False)
    monkeypatch.setattr(advancing, "solve_increment", solve)
    start: Any = At(0.0)
    state, reports = advance(problem, start, 1.0, 0.0)
    assert state.drive == pytest.approx(1.0)
    assert len(reports) == 8


def test_an_increment_that_no_cut_helps_fails_with_the_place_and_the_reason(
    monkeypatch: pytest.MonkeyPatch, problem: ContactProblem
) -> None:
    solve, _ = solved(longest_mm=0.0, misleading=False)
    monkeypatch.setattr(advancing, "solve_increment", solve)
    with pytest.raises(NotConvergedError, match=r"at a displacement of 0.000 um, .* 1/256 increment: it does not conv"):
        advance(problem, unloaded_state(problem), 1.0, 0.0)
