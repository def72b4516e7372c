"""Simulator 4, for scoring alone: a cylinder on a flat in plane strain, each an elastic layer on what holds it.

A layer's surface displacement under a wave of pressure or traction: Meijers, Appl. Sci. Res. 18 (1968) 353; Johnson,
Contact Mechanics (1985), section 5.8; for deep layers it is Flamant's half-plane. Its waves are summed to the kernel of
boundary elements, what is left of the half-plane's in closed form.
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from studies.blind.generators.other_simulators.pair import Array, StickingPair

#: Waves of the sum, and the largest wave number times the height, beyond which a layer is a half-plane.
WAVES, DEEP = 4000, 45.0


@dataclass(frozen=True)
class ElasticLayer:
    """A body that is held at a depth."""

    youngs_MPa: float
    poisson: float
    height_mm: float

    def matrix(self, count: int, step_mm: float, *, tractions: bool) -> Array:
        """Displacements (n, n) of cells by even pressures, or tractions, on each [mm/MPa]."""
        away = step_mm * np.arange(float(count))
        half, plane = 0.5 * step_mm, 2.0 * (1.0 - self.poisson**2) / self.youngs_MPa
        over = (_primitive(away + half, self.height_mm) - _primitive(away - half, self.height_mm)) / (2.0 * pi)
        q = (np.arange(WAVES) + 0.5) * DEEP / WAVES
        rest = (self._relative(q, tractions) - (1.0 - np.exp(-q))) / q * DEEP / WAVES / pi
        column = plane * (over + step_mm * np.cos(np.outer(away, q / self.height_mm)) @ rest)
        places = np.arange(count)
        return np.asarray(column[np.abs(places[:, None] - places)])

    def _relative(self, q: Array, tractions: bool) -> Array:
        """Displacement under a wave over that of a half-plane; q is wave number times height."""
        kappa, sign = 3.0 - 4.0 * self.poisson, 1.0 if tractions else -1.0
        return np.asarray(
            (2.0 * kappa * np.sinh(2.0 * q) + sign * 4.0 * q)
            / (2.0 * kappa * np.cosh(2.0 * q) + 4.0 * q**2 + 1.0 + kappa**2)
        )


def _primitive(x: Array, height: float) -> Array:
    """Of ln(1 + h²/x²), the half-plane's kernel with its datum at the depth."""
    return np.asarray(x * np.log1p((height / x) ** 2) + 2.0 * height * np.arctan(x / height))


class Plane:
    """Two bodies by the matrix of their cells, a length deep."""

    def __init__(self, matrix: Array | int, cell_mm2: float) -> None:
        """Nothing is worn yet."""
        self.matrix, self.cell, self.active = np.asarray(matrix), cell_mm2, np.zeros(0, dtype=bool)

    def press(self, gap_mm: Array, load_N: float, local: Array | float) -> tuple[Array, float]:
        """Pressures under a load and the approach, by the set of cells that touch."""
        gap, soft = gap_mm[:, 0], np.broadcast_to(local, gap_mm.shape)[:, 0]
        active = self.active if self.active.any() else gap <= np.quantile(gap, 0.1)
        for _ in range(80):
            rows = np.flatnonzero(active)
            system = np.ones((rows.size + 1, rows.size + 1))
            system[:-1, :-1] = self.matrix[np.ix_(rows, rows)] + np.diag(soft[rows])
            system[:-1, -1], system[-1, -1] = -1.0, 0.0
            solved = np.linalg.solve(system, np.r_[-gap[rows], load_N / self.cell])
            pressure, approach = np.zeros_like(gap), float(solved[-1])
            pressure[rows] = solved[:-1]
            open_mm = gap + self.matrix[:, rows] @ solved[:-1] - approach
            new = (pressure > 0.0) | (~active & (open_mm < -1e-9))
            if (new == active).all():
                break
            active = new
        self.active = active
        return np.maximum(pressure, 0.0)[:, None], approach


class LinePair(StickingPair):
    """A pad that slides over a flat; the pad is driven."""

    def __init__(
        self, shape: Array, steps: tuple[float, float], reach: float, bodies: tuple[ElasticLayer, ElasticLayer]
    ) -> None:
        """Nothing is worn yet."""
        planes = [
            Plane(
                sum(body.matrix(shape.shape[0], steps[0], tractions=tractions) for body in bodies), steps[0] * steps[1]
            )
            for tractions in (False, True)
        ]
        super().__init__(shape, steps, reach, -1, planes[0])
        self.sheared = planes[1]
