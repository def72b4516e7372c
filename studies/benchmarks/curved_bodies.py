"""What the curvature of bodies adds to the energy of loops in partial slip, by boundary elements.

Usage: python -m studies.benchmarks.curved_bodies [--kind "wires at 90°"] [--points 97]

Mindlin and Deresiewicz take both bodies as half-spaces. To the first order in contact radius over the bodies' radii a
point load on a curved surface z = κxx/2 also leaves the stresses of the half-space on that surface; taken away again
they give a displacement that grows with the logarithm of the distance. Normal contact and stick are solved with and
without this part, and with the exact gap of cylinders beside its parabola.
"""

from dataclasses import dataclass
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from studies.study_script import StudyScript
from wirewear import reference
from wirewear.test.gaps import hertz_of

from .partial_slip import KINDS, exact_of, study_of

Array = NDArray[np.float64]

SHARES = (0.15, 0.3, 0.5, 0.7, 0.85, 0.95)
_HALF, _WAVES, _TRIES = 1.3, 64, 60


@dataclass(frozen=True)
class Grid:
    """A grid over the contact ellipse, along its axes; sides of its cells in mm."""

    sides: tuple[float, float]
    points: int

    @property
    def cell_mm2(self) -> float:
        return self.sides[0] * self.sides[1]

    @property
    def places(self) -> tuple[Array, Array]:
        """Middles (n, n) of the cells."""
        line = np.arange(self.points) - 0.5 * (self.points - 1)
        x, y = np.meshgrid(self.sides[0] * line, self.sides[1] * line, indexing="ij")
        return x, y

    def kernel(self, of: Any) -> NDArray[np.complex128]:
        """Transform of a kernel's means over cells; of: its value at x, y."""
        n, (a, b) = 2 * self.points, self.sides
        away = np.where(np.arange(n) <= self.points, np.arange(n), np.arange(n) - n)
        x, y = np.meshgrid(a * away, b * away, indexing="ij")
        means = np.zeros_like(x)
        for part in np.ndindex(4, 4):
            u, v = (np.array(part) - 1.5) / 4.0
            means += of(x + a * u, y + b * v) / 16.0
        within = (np.arange(200) - 99.5) / 200.0
        u, v = np.meshgrid(a * within, b * within, indexing="ij")
        for i, j in np.argwhere((np.abs(x) < 4.5 * a) & (np.abs(y) < 4.5 * b)):
            means[i, j] = of(x[i, j] + u, y[i, j] + v).mean()
        return np.asarray(np.fft.rfft2(a * b * means))

    def displaced(self, kernel: NDArray[np.complex128], traction: Array) -> Array:
        """Displacement (n, n) in mm by tractions in MPa."""
        n = self.points
        return np.fft.irfft2(kernel * np.fft.rfft2(traction, (2 * n, 2 * n)), (2 * n, 2 * n))[:n, :n]

    def solved(self, kernel: NDArray[np.complex128], free: NDArray[np.bool_], wanted: Array, start: Array) -> Array:
        """Tractions where they are free that give the displacement `wanted` there, by conjugate gradients."""
        found = np.where(free, start, 0.0)
        left = np.where(free, wanted - self.displaced(kernel, found), 0.0)
        way, size = left.copy(), float((left**2).sum())
        least = 1e-20 * float((wanted[free] ** 2).sum())
        for _ in range(500):
            if size <= least:
                break
            moved = np.where(free, self.displaced(kernel, way), 0.0)
            step = size / float((way * moved).sum())
            found, left = found + step * way, left - step * moved
            before, size = size, float((left**2).sum())
            way = left + size / before * way
        return found


def by_curvature(field: Array, curvature: Array, angle: Array) -> Array:
    """κ∂∂ of fields (…, n) that depend on the angle (n,) in the plane of waves alone, times the wave number squared."""
    waves = np.fft.fftfreq(angle.size, 1.0 / angle.size)
    once, twice = (np.fft.ifft(factor * np.fft.fft(field)).real for factor in (1j * waves, -(waves**2)))
    sine, cosine = np.sin(angle), np.cos(angle)
    xx = sine**2 * twice + 2.0 * sine * cosine * once
    yy = cosine**2 * twice - 2.0 * sine * cosine * once
    xy = -sine * cosine * twice - np.cos(2.0 * angle) * once
    return np.asarray(curvature[0, 0] * xx + curvature[1, 1] * yy + 2.0 * curvature[0, 1] * xy)


def in_space(of_waves: Array) -> Any:
    """The function of x and y, in units of 1/2πG, whose transform is `of_waves` (n,) over angles by Gk²."""
    parts = np.fft.fft(of_waves) / of_waves.size

    def value(x: Array, y: Array) -> Array:
        turned = np.exp(2j * np.arctan2(y, x))
        harmonics = sum((-1.0) ** m / m * (parts[2 * m] * turned**m).real for m in range(1, 5))
        return np.asarray(harmonics - parts[0].real * np.log(np.hypot(x, y)))

    return value


def curved_parts(curvature: Array, motion: Array, nu: float) -> tuple[Any, Any]:
    """Tangential and normal kernels of the curvature (2, 2) of both bodies together in 1/mm, in units of 1/2πG.

    motion: (2,) direction of tractions and displacements.
    """
    angle: Array = np.asarray(2.0 * np.pi / _WAVES * np.arange(_WAVES), dtype=np.float64)
    n, one = np.array([np.cos(angle), np.sin(angle)]), np.eye(2)[:, :, None]
    along, dyad = motion @ n, n[:, None] * n[None]
    both = n[:, None] * motion[None, :, None] + n[None] * motion[:, None, None]
    # Stresses in the surface under a tangential point load, and the tractions that they leave where it is curved.
    stress = both - 2.0 * nu * dyad * along + 2.0 * nu * one * along
    left = -0.5 * (by_curvature(stress, curvature, angle) * n).sum(axis=1)
    tangential = motion @ left - nu * along * (n * left).sum(axis=0)
    normal = -0.25 * (1.0 - 2.0 * nu) ** 2 * (by_curvature(dyad, curvature, angle) * dyad).sum(axis=(0, 1))
    return in_space(tangential), in_space(normal)


def energies(kind: str, points: int, *, curved: bool, exact: bool = False) -> tuple[Array, Array]:
    """Shares of µP reached and energies in mJ of loops about those at `SHARES`.

    curved: False for half-spaces. exact: True for the gap of cylinders of equal radii at 90°, False for its parabola.
    """
    lower, upper = study_of(kind, 1.0).bodies
    point, material = exact_of(kind), lower.material
    load = point.normal_load_N
    hertz, nu = hertz_of(load, lower, upper), material.poissons_ratio
    major, minor = hertz.major_semi_axis_mm, hertz.minor_semi_axis_mm
    cosine, sine = np.cos(hertz.major_angle_rad), np.sin(hertz.major_angle_rad)
    turn = np.array([[cosine, sine], [-sine, cosine]])
    curvature, motion = turn @ (lower.curvature_per_mm() + upper.curvature_per_mm()) @ turn.T, turn[:, 0]
    grid = Grid((2.0 * _HALF * major / points, 2.0 * _HALF * minor / points), points)
    tangential_part, normal_part = curved_parts(curvature if curved else 0.0 * curvature, motion, nu)
    unit = 1.0 / (2.0 * np.pi * material.shear_modulus_MPa)

    def tangential(x: Array, y: Array) -> Array:
        r = np.hypot(x, y)
        flat = 2.0 * ((1.0 - nu) / r + nu * (motion[0] * x + motion[1] * y) ** 2 / r**3)
        return np.asarray(unit * (flat + tangential_part(x / major, y / major)))

    def normal(x: Array, y: Array) -> Array:
        return np.asarray(unit * (2.0 * (1.0 - nu) / np.hypot(x, y) + normal_part(x / major, y / major)))

    sheared, pressed = grid.kernel(tangential), grid.kernel(normal)
    x, y = grid.places
    gap = 0.5 * (curvature[0, 0] * x**2 + 2.0 * curvature[0, 1] * x * y + curvature[1, 1] * y**2)
    if exact:
        radius = 1.0 / curvature[0, 0]
        gap = 2.0 * radius - np.sqrt(radius**2 - x**2) - np.sqrt(radius**2 - y**2)
    p = pressed_to(load, hertz.approach_mm, grid, pressed, gap)
    found = [
        loop_of(float(place), grid, sheared, point.friction * p)
        for place in reference.loading_displacement(point, np.array(SHARES) * point.limit_N)
    ]
    forces, energy = np.array(found).T
    return forces / point.limit_N, energy / [reference.energy_per_cycle(point, force) for force in forces] - 1.0


def pressed_to(load: float, expected_mm: float, grid: Grid, kernel: NDArray[np.complex128], gap: Array) -> Array:
    """Pressures in MPa under a load in N, whose approach is expected within 3 %."""

    def pressure(approach: float) -> Array:
        found, touches = np.zeros_like(gap), gap < approach
        for _ in range(_TRIES):
            found = grid.solved(kernel, touches, approach - gap, found)
            away = touches & (found < 0.0)
            met = ~touches & (grid.displaced(kernel, found) + gap < approach * (1.0 - 1e-9))
            if not (away | met).any():
                break
            touches, found = (touches & ~away) | met, np.maximum(found, 0.0)
        return found

    tried = [expected_mm * factor for factor in (0.97, 1.03)]
    found = [pressure(one) for one in tried]
    while abs(grid.cell_mm2 * found[-1].sum() / load - 1.0) > 1e-8:
        (before, last), (less, more) = tried[-2:], (grid.cell_mm2 * float(one.sum()) for one in found[-2:])
        tried.append(last + (load - more) * (last - before) / (more - less))
        found.append(pressure(tried[-1]))
    return found[-1]


def loop_of(place_mm: float, grid: Grid, kernel: NDArray[np.complex128], limit: Array) -> tuple[float, float]:
    """Force in N and energy in mJ of a loop of this amplitude; limit: friction times pressure in MPa."""
    touches = limit > 0.0
    sticks, q = touches, np.zeros_like(limit)
    for _ in range(_TRIES):
        slid = np.where(touches & ~sticks, limit, 0.0)
        q = slid + grid.solved(kernel, sticks, place_mm - grid.displaced(kernel, slid), q)
        lost = sticks & (q > limit * (1.0 + 1e-9))
        back = touches & ~sticks & (grid.displaced(kernel, q) > place_mm * (1.0 + 1e-9))
        if not (lost | back).any():
            break
        sticks = (sticks & ~lost) | back
    slip = np.where(touches & ~sticks, place_mm - grid.displaced(kernel, q), 0.0)
    return grid.cell_mm2 * float(q.sum()), 4.0 * grid.cell_mm2 * float((limit * slip).sum())


@click.command(cls=StudyScript)
@click.option("--kind", "kinds", multiple=True, type=click.Choice(tuple(KINDS)), default=tuple(KINDS))
@click.option("--points", type=click.IntRange(31, 301), default=97, show_default=True, help="Cells along an axis.")
def main(kinds: tuple[str, ...], points: int) -> None:
    """Print by how many percent curved bodies, and the exact gap, change energies of loops at each share of µP."""
    click.echo(f"| | {' | '.join(f'{share:g}' for share in SHARES)} |")
    for kind in kinds:
        flat = energies(kind, points, curved=False)
        ways = {"curved": energies(kind, points, curved=True)}
        ways |= {"exact gap": energies(kind, points, curved=False, exact=True)} if kind.endswith("90°") else {}
        rows = {"half spaces": flat[1]} | {
            name: np.interp(SHARES, *found) - np.interp(SHARES, *flat) for name, found in ways.items()
        }
        for name, row in rows.items():
            click.echo(f"| {kind}, {name} | {' | '.join(f'{100.0 * one:+.2f}' for one in row)} |".replace("-", "−"))


if __name__ == "__main__":
    raise SystemExit(main())
