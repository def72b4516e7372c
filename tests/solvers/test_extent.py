"""Edge and area of a contact between nodes."""

import numpy as np
import pytest

from geometry import ContactPatch, Flat
from solvers.contact_extent import extent


def patch_of(along: np.ndarray, across: np.ndarray) -> ContactPatch:
    return ContactPatch(along, across, np.arange(along.size * across.size).reshape(along.size, across.size), Flat())


@pytest.mark.parametrize("off", [0.0, 0.11, 0.23])
def test_hertzs_ellipse_has_its_area_and_ends_wherever_the_nodes_lie(off: float) -> None:
    along, across = (0.25 * np.arange(-9, 10) + off for off in (off, 0.5 * off))
    patch = patch_of(along, across)
    x, y = patch.grid().T
    (area,), (edge,) = extent(patch, np.sqrt(np.maximum(1.0 - x**2 - (y / 1.3) ** 2, 0.0))[None])
    assert area == pytest.approx(1.3 * np.pi, rel=0.01)
    assert edge[:, 0] ** 2 + (edge[:, 1] / 1.3) ** 2 == pytest.approx(1.0, abs=0.12)
    assert np.abs(edge).max(axis=0) == pytest.approx([1.0, 1.3], rel=0.03)


def test_a_hole_is_as_wide_as_its_nodes_and_no_pressure_is_no_contact() -> None:
    patch = patch_of(np.linspace(-1.2, 1.2, 61), np.linspace(-1.2, 1.2, 61))
    radius = np.hypot(*patch.grid().T)
    ring = np.where(radius > 0.4, np.sqrt(np.maximum(1.0 - radius**2, 0.0)), 0.0)
    areas, _ = extent(patch, np.stack([ring, 0.0 * ring]))
    assert areas == pytest.approx([0.84 * np.pi, 0.0], rel=0.02)


def test_an_even_pressure_ends_midway_to_the_next_node() -> None:
    patch = patch_of(np.linspace(-1.0, 1.0, 21), np.zeros(1))
    (area,), (edge,) = extent(patch, (np.abs(patch.axial_mm) < 0.55).astype(float)[None])
    assert area == pytest.approx(1.1)
    assert np.sort(edge[:, 0]) == pytest.approx([-0.55, 0.55])
