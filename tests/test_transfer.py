"""Transfer of worn depth between patch grids of different grading and extent."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from geometry import ContactPatch, Cylinder
from solvers.transfer import transferred

Array = NDArray[np.float64]

RADIUS_mm = 0.225


def patch(axial: Array, transverse: Array) -> ContactPatch:
    nodes = np.arange(len(axial) * len(transverse)).reshape(len(axial), len(transverse))
    return ContactPatch(axial, transverse, nodes, Cylinder(RADIUS_mm))


def even(half_mm: float, count: int) -> ContactPatch:
    lines = np.linspace(-half_mm, half_mm, count)
    return patch(lines, lines)


def integral(field: Array, on: ContactPatch) -> float:
    return float(field.ravel() @ on.node_areas())


@st.composite
def grids(draw: st.DrawFn, half_mm: float) -> Array:
    """Lines over at least the given half-extent, their spacings up to twenty times different."""
    spacing = np.array(draw(st.lists(st.floats(0.05, 1.0), min_size=2, max_size=12)))
    lines = np.append(0.0, np.cumsum(spacing)) / spacing.sum() - draw(st.floats(0.4, 0.6))
    return np.asarray(lines * half_mm * 2.0 / 0.8 * draw(st.floats(1.0, 1.3)))


@st.composite
def worn(draw: st.DrawFn) -> tuple[ContactPatch, Array]:
    """A patch and any non-negative depth on it."""
    old = patch(draw(grids(0.02)), draw(grids(0.02)))
    return old, draw(arrays(float, old.shape, elements=st.sampled_from([0.0, 0.0, 1e-9, 1e-3, 0.04])))


@pytest.mark.seconds
@settings(max_examples=150)
@given(worn(), grids(0.06), grids(0.06))
def test_any_depth_keeps_its_volume_and_never_becomes_negative(
    given_wear: tuple[ContactPatch, Array], axial: Array, transverse: Array
) -> None:
    old, depth = given_wear
    new = patch(axial, transverse)
    moved = transferred(depth, old, new)
    assert moved.shape == new.shape
    assert moved.min() >= 0.0
    assert integral(moved, new) == pytest.approx(integral(depth, old), rel=1e-12, abs=1e-25)


@given(worn())
def test_a_transfer_to_the_same_grid_changes_nothing(given_wear: tuple[ContactPatch, Array]) -> None:
    old, depth = given_wear
    assert transferred(depth, old, old) == pytest.approx(depth, rel=1e-9, abs=1e-12)


@pytest.mark.seconds
@given(worn(), st.integers(2, 4))
def test_a_finer_grid_that_contains_the_old_lines_shows_the_same_surface(
    given_wear: tuple[ContactPatch, Array], pieces: int
) -> None:
    old, depth = given_wear

    def divided(lines: Array) -> Array:
        count = len(lines) - 1
        return np.interp(np.arange(count * pieces + 1) / pieces, np.arange(count + 1), lines)

    new = patch(divided(old.axial_mm), divided(old.transverse_mm))
    moved = transferred(depth, old, new)
    assert moved[::pieces, ::pieces] == pytest.approx(depth, rel=1e-9, abs=1e-12)


def scar(on: ContactPatch) -> Array:
    a, t = (lines / 0.05 for lines in (on.axial_mm, on.transverse_mm))
    return np.asarray(0.01 * np.outer(np.maximum(1.0 - a**2, 0.0) ** 3, np.maximum(1.0 - t**2, 0.0) ** 3))


def graded(half_mm: float, count: int) -> ContactPatch:
    s = np.linspace(-1.0, 1.0, count)
    lines = half_mm * (0.5 * s + 0.5 * s**3)
    return patch(lines, lines)


def test_a_smooth_scar_arrives_with_second_order_accuracy_on_a_grid_of_other_grading() -> None:
    errors = []
    for count in (33, 65, 129):
        old, new = even(0.06, count), graded(0.07, count + 3)
        squared = (transferred(scar(old), old, new) - scar(new)) ** 2
        errors.append(float(np.sqrt(integral(squared, new) / integral(scar(new) ** 2, new))))
    assert errors[0] < 0.01
    assert errors[0] / errors[1] > 3.4
    assert errors[1] / errors[2] > 3.4


def test_a_planar_scar_keeps_its_area() -> None:
    old, new = (patch(np.linspace(-0.06, 0.06, count), np.zeros(1)) for count in (25, 32))
    depth = scar(even(0.06, 25))[:, 12:13]
    assert integral(transferred(depth, old, new), new) == pytest.approx(integral(depth, old), rel=1e-12)
