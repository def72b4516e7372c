"""What elements lack near a loaded node: checked against closed forms of the half-space and by symmetry."""

import numpy as np
import pytest
from numpy.typing import NDArray

from geometry import Elastic
from solvers.facing import facing
from solvers.near_field import Bricks, half_space_response, missing_displacement, reach
from solvers.placement import PlacedBody, place
from solvers.transfer import hat_products
from tests import bodies

Array = NDArray[np.float64]

FINE_mm = 0.004
CROSSED = ((0.0, 1.0), (1.0, 0.0))


def _bodies(angle_rad: float = np.pi / 2) -> tuple[PlacedBody, PlacedBody]:
    """Crossed wires, upper and lower, as the elements answer."""
    body = bodies.condensed_wire(FINE_mm)
    return place(body, upper=True, axis_angle_rad=angle_rad), place(body, upper=False, axis_angle_rad=0.0)


def _pair_along_z(primary: PlacedBody, secondary: PlacedBody, offset_mm: tuple[float, float]) -> Array:
    """How two wires crossed at right angles approach at the primary's nodes by unit forces there, (n, n), mm/N.

    The secondary is shifted by an offset along the primary's axes.
    """
    own, other = primary.patch, secondary.patch
    along = hat_products(own.axial_mm, other.transverse_mm + offset_mm[0])
    across = hat_products(own.transverse_mm, other.axial_mm + offset_mm[1])
    # The secondary's nodes are numbered along its own axis first.
    reached = np.einsum("at,cs->acst", along, across).reshape(own.size, other.size)
    averaged = reached / own.node_areas()[:, None]
    return np.asarray(primary.compliance[2::3, 2::3] + averaged @ secondary.compliance[2::3, 2::3] @ averaged.T)


def _love(x: Array, y: Array, a: float, b: float) -> Array:
    """Mean of 1/r between two rectangles a by b whose centres are (x, y) apart, by its fourth antiderivative."""

    def antiderivative(x: Array, y: Array) -> Array:
        r = np.hypot(x, y)
        first = np.where(y == 0.0, 0.0, x * y**2 * np.arcsinh(x / np.where(y == 0.0, 1.0, np.abs(y))))
        second = np.where(x == 0.0, 0.0, x**2 * y * np.arcsinh(y / np.where(x == 0.0, 1.0, np.abs(x))))
        return np.asarray(0.5 * (first + second) - r**3 / 6.0)

    weights = ((-1, 1), (0, -2), (1, 1))
    total = sum(m * n * antiderivative(x + i * a, y + j * b) for i, m in weights for j, n in weights)
    return np.asarray(total / (a * b) ** 2)


def _error_against_cells(matrix: Array, patch_shape: tuple[int, int], size: tuple[float, float]) -> float:
    """Worst error of the responses about the middle node, less that four elements away, over the closed form's own."""
    n_a, n_t = patch_shape
    middle = (n_a // 2) * n_t + n_t // 2
    i, j = (np.indices((9, 9)) - 4).reshape(2, -1)
    nu, modulus = bodies.STEEL.poissons_ratio, bodies.STEEL.youngs_modulus_MPa
    exact = 2.0 * (1.0 - nu**2) / (np.pi * modulus) * _love(np.asarray(i * size[0]), np.asarray(j * size[1]), *size)
    found = matrix[middle, middle + i * n_t + j]
    rim = np.maximum(np.abs(i), np.abs(j)) == 4
    # The wires' bulk moves all nodes alike.
    found = found - (found - exact)[rim].mean()
    return float(np.abs(found - exact).max() / exact.max())


@pytest.mark.seconds
def test_a_loaded_node_gives_way_as_its_cell_does_between_two_half_spaces() -> None:
    upper, lower = _bodies()
    size = (float(np.diff(upper.patch.axial_mm)[8]), float(np.diff(upper.patch.transverse_mm)[8]))
    h = size[0]
    offsets = [(u * h, v * h) for u in (0.0, 0.25, 0.5, 0.75) for v in (0.0, 0.25, 0.5, 0.75)]
    corrected = facing(upper, lower)
    before, after = (
        _error_against_cells(
            np.mean([_pair_along_z(body, lower, offset) for offset in offsets], axis=0), body.patch.shape, size
        )
        for body in (upper, corrected)
    )
    assert before > 0.2
    assert after < 0.05


@pytest.mark.parametrize("sizes", [((0.004, 0.004), (0.004, 0.004)), ((0.012, 0.005), (0.006, 0.018))])
def test_what_is_lacking_fades_within_a_few_elements_and_is_symmetric(sizes: tuple[tuple[float, float], ...]) -> None:
    own, other = sizes
    bricks = [Bricks(Elastic(210_000.0, 0.3), (0.6 * min(size), 1.3)) for size in sizes]
    near = missing_displacement(bricks[0], own, bricks[1], other, CROSSED)
    a, t = reach(own)
    largest = np.abs(near[a, t]).max()
    x, y = np.meshgrid(np.arange(-a, a + 1) * own[0], np.arange(-t, t + 1) * own[1], indexing="ij")
    far = np.hypot(x, y) > 5.0 * max(own + other)
    assert not far.any() or np.abs(near[far]).max() < 0.01 * largest
    np.testing.assert_allclose(near, near[::-1, ::-1].swapaxes(-1, -2), atol=1e-12 * largest)


def test_waves_on_a_half_space_agree_with_boussinesq_and_cerruti() -> None:
    # Summed over waves, the response to a narrow Gaussian load is that to a point force farther away.
    n, step, width = 256, 0.1, 0.25
    numbers = 2.0 * np.pi * np.fft.fftfreq(n, step)
    kx, ky = (each.ravel() for each in np.meshgrid(numbers, numbers, indexing="ij"))
    material = Elastic(1.0, 0.3)
    spectrum = half_space_response(kx, ky, material) * np.exp(-0.5 * width**2 * (kx**2 + ky**2))[:, None, None]
    found = np.fft.ifft2(spectrum.reshape(n, n, 3, 3), axes=(0, 1)).real / step**2

    def exact(x: float, y: float) -> Array:
        nu, r = 0.3, np.hypot(x, y)
        along = (1.0 + nu) / np.pi * np.array([(1.0 - nu) / r + nu * x**2 / r**3, (1.0 - nu) / r + nu * y**2 / r**3])
        return np.array([*along, (1.0 - nu**2) / (np.pi * r), (1.0 - 2.0 * nu) * (1.0 + nu) * x / (2.0 * np.pi * r**2)])

    def at(i: int, j: int) -> Array:
        u = found[i, j]
        return np.array([u[0, 0], u[1, 1], u[2, 2], u[0, 2]])

    # The mean of a periodic field is lost, so differences are compared.
    difference = exact(1.5, 0.0) - exact(3.0, 0.0)
    np.testing.assert_allclose(at(15, 0) - at(30, 0), difference, rtol=0.05)


def test_the_corrected_compliance_is_symmetric_and_positive_definite() -> None:
    for angle in (np.pi / 2, 1.0):
        upper, lower = _bodies(angle)
        for one, other in ((upper, lower), (lower, upper)):
            compliance = facing(one, other).compliance
            np.testing.assert_allclose(compliance, compliance.T, atol=1e-14)
            assert np.linalg.eigvalsh(compliance)[0] > 0.0
