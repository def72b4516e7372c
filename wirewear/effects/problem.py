"""The contact problem with effects in it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from solvers import ContactProblem, misaligned
from wirewear.effects.effect import Effect
from wirewear.effects.seams import Age, ContactLaw, Loading, Seam, applied


def problem_with(problem: ContactProblem, effects: Sequence[Effect[Any]], age: Age) -> ContactProblem:
    """A nominal problem with effects on holder, loading, contact law and wear law, at an age of the test."""
    if not effects:
        return problem
    holder = applied(effects, Seam.HOLDER, problem.holder, age)
    loading = applied(effects, Seam.LOADING, Loading(holder.normal_load_N), age)
    law = applied(effects, Seam.CONTACT, ContactLaw(problem.friction, problem.layers), age)
    if loading.misalignment_rad != 0.0:
        problem = misaligned(problem, loading.misalignment_rad)
    return replace(
        problem,
        holder=replace(holder, normal_load_N=loading.normal_load_N),
        friction=law.friction,
        layers=law.layers,
        wear=applied(effects, Seam.WEAR, problem.wear, age),
    )
