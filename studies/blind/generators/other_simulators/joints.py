"""Simulator 5: a joint as many springs in parallel, each with a slider (Iwan, J. Appl. Mech. 33 (1966) 893).

The sliders' limits are spread evenly about their mean, so that a loop's knee is round.
"""

import numpy as np

from studies.blind.generators.other_simulators.pair import Array, Layer, Pair

SLIDERS = 40  #: Sliders that are followed one by one where the load varies in the cycle.


class OneCell:
    """Rigid bodies that touch over one cell of a square millimetre: pressure [MPa] is the load [N], approach 0 mm."""

    def press(self, gap_mm: Array, load_N: float, local: Array | float) -> tuple[Array, float]:  # noqa: ARG002
        """Pressures [MPa] of the gaps' shape, equal to the load in N, and an approach of 0 mm."""
        return np.full_like(gap_mm, load_N), 0.0


class Sliders(Pair):
    """A joint of given stiffness; `spread` is the largest difference of a slider's limit from their mean, over it."""

    def __init__(self, stiffness_N_per_mm: float, spread: float, reach_mm: float) -> None:
        """No bodies are known: a single cell stands for both."""
        super().__init__(np.zeros((1, 1)), (1.0, 1.0), reach_mm, 1, OneCell())
        self.stiffness, self.limits = stiffness_N_per_mm, (1.0 - spread, 1.0 + spread)

    def settle(self, load_N: float, layer: Layer) -> None:
        """A joint remains as it is."""

    def lag_mm(self, friction: float, load_N: float) -> float:
        """Displacement of the springs when all sliders slip."""
        return friction * load_N / self.stiffness

    def stroke(self, way_mm: Array, half_mm: float, friction: float, load_N: float) -> Array:
        """Friction over its limit along a stroke that begins at a reversal (Masing's rule)."""
        first = np.append(0.5 * way_mm, half_mm) / self.lag_mm(friction, load_N)
        low, high = self.limits
        # Of sliders between `low` and `reached` the limit, of the others the springs' displacement.
        reached = np.clip(first, low, high)
        share = np.where(first < low, first, (0.5 * (reached**2 - low**2) + reached * (high - reached)) / (high - low))
        return np.asarray(2.0 * share[:-1] - share[-1])

    def under(self, way_mm: Array, friction: float, load_N: Array) -> Array:
        """Friction over its limit of the moment along a stroke after one in which all has slid, under loads (n,).

        No limit grows faster than the springs are pulled, so that what slips goes on to the stroke's end.
        """
        low, high = self.limits
        limits = low + (high - low) * (np.arange(SLIDERS) + 0.5) / SLIDERS
        most = friction * load_N[:, None] * limits
        pulled = np.minimum(self.stiffness * way_mm[:, None] - most[0], most)
        return np.asarray(pulled.mean(axis=1) / (friction * load_N))
