"""What is left of a loop when the model is taken away, with the band in which tests scatter."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from wirewear.diagnosis.model.branches import still_to_come
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.branch import ObservedBranch
from wirewear.diagnosis.observe.measured_loops import ReducedLoop

#: Places on a branch at which forces are compared; standard deviations to each side that hold 95 % of tests.
PLACES, WITHIN = 60, 1.96

#: Branches in the order of a course, by their direction.
DIRECTIONS = (1, -1)


def residuals(
    loops: tuple[ReducedLoop, ...], course: LoopCourse, row: int, scatter: Mapping[str, float], load_N: float
) -> list[dict[str, Array]]:
    """Measured less computed force on both branches of a cycle's loop, against displacement.

    Each is a table of arrays (n,): `displacement_um`, `force_N`, the mean over repeats less the computed force, and
    `band_N`, the half-width of what 95 % of tests differ by.  row: of the course.
    """
    found = []
    for place, sign in enumerate(DIRECTIONS):
        own = [branch for loop in loops for branch in loop.branches if branch.sign == sign]
        x, q = sign * course.displacement_um[row, place], sign * course.tangential_force_N[row, place]
        order = still_to_come(x)
        low = max(float(order[0]), *(float(one.displacement_um.min()) for one in own))
        high = min(float(order[-1]), *(float(one.displacement_um.max()) for one in own))
        at = np.linspace(low, high, PLACES)
        computed = np.interp(at, order, q)
        measured = np.mean([_force_at(one, at) for one in own], axis=0)
        # A bump of the loop counts as correlated noise of its force: samples about their neighbours do not know it.
        noise_N = float(np.mean([loop.sample_noise_N for loop in loops]))
        found.append(
            {
                "displacement_um": sign * at,
                "force_N": sign * (measured - computed),
                "band_N": _band(at, computed, scatter, load_N, noise_N),
            }
        )
    return found


def _force_at(branch: ObservedBranch, at_um: Array) -> Array:
    order = np.argsort(branch.displacement_um, kind="stable")
    return np.asarray(np.interp(at_um, branch.displacement_um[order], branch.force_N[order]))


def _band(at_um: Array, force_N: Array, scatter: Mapping[str, float], load_N: float, noise_N: float) -> Array:
    """Friction and load stretch the force; zeros shift force and displacement; the amplitude stretches the stroke."""

    def size(name: str) -> float:
        return float(scatter.get(name, 0.0))

    stretched = np.hypot(size("friction"), size("load")) * force_N
    moved_um = np.hypot(size("displacement_offset_um"), size("amplitude") * at_um)
    shifted = np.gradient(force_N, at_um) * moved_um
    return np.asarray(WITHIN * np.sqrt(stretched**2 + shifted**2 + (size("force_offset") * load_N) ** 2 + noise_N**2))
