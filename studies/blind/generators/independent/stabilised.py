"""Jumps over many cycles: the explicit Runge–Kutta–Chebyshev method of second order for problems that smooth.

Wear flattens pressure peaks the faster the sharper they are, as diffusion does, so that an ordinary explicit method is
stable over some hundred cycles only. Stages cost s evaluations and buy a stable step that grows with s².
Source: Sommeijer, Shampine & Verwer, J. Comput. Appl. Math. 88 (1997) 315, eqs. 2.1–2.5.
"""

from __future__ import annotations

from collections.abc import Callable
from math import acosh, ceil, cosh, sinh, sqrt
from typing import Protocol, Self, TypeVar

DAMPING = 2.0 / 13.0


class Vector(Protocol):
    """What can be stepped: a value to which a multiple of a rate can be added."""

    def plus(self, share: float, rate: Self, /) -> Self:
        """This and `share` times `rate`."""
        ...


State = TypeVar("State", bound=Vector)


def stages_needed(step: float, spectral_radius: float) -> int:
    """Least number of stages for which a step is stable."""
    return max(2, ceil(sqrt(1.0 + 1.54 * step * spectral_radius)))


def chebyshev_step(state: State, rate: Callable[[State], State], step: float, stages: int) -> State:
    """The state after one step of an autonomous problem, with at least two stages."""
    w0 = 1.0 + DAMPING / stages**2
    angle = acosh(w0)
    value = [cosh(j * angle) for j in range(stages + 1)]
    first = [j * sinh(j * angle) / sinh(angle) for j in range(stages + 1)]
    second = [
        (j * j * cosh(j * angle) - w0 * j * sinh(j * angle) / sinh(angle)) / sinh(angle) ** 2 for j in range(stages + 1)
    ]
    w1 = first[stages] / second[stages]
    b = [second[max(j, 2)] / first[max(j, 2)] ** 2 for j in range(stages + 1)]
    initial_rate = rate(state)
    older, newer = state, state.plus(b[1] * w1 * step, initial_rate)
    for j in range(2, stages + 1):
        mu, nu = 2.0 * b[j] * w0 / b[j - 1], -b[j] / b[j - 2]
        mu_rate = 2.0 * b[j] * w1 / b[j - 1]
        old_share = -(1.0 - b[j - 1] * value[j - 1]) * mu_rate
        # (1 − µ − ν) y₀ + µ y_(j−1) + ν y_(j−2), spelled with differences.
        following = (
            state.plus(mu, newer)
            .plus(-mu, state)
            .plus(nu, older)
            .plus(-nu, state)
            .plus(mu_rate * step, rate(newer))
            .plus(old_share * step, initial_rate)
        )
        older, newer = newer, following
    return newer
