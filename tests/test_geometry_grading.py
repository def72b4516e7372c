"""Gradings of mesh lines."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry import EdgeGradedAxis, GeometryError, GradedAxis, graded_layers


@st.composite
def axes(draw: st.DrawFn) -> GradedAxis:
    half = draw(st.floats(0.01, 1.0))
    fine = half * draw(st.floats(0.01, 1.0))
    return GradedAxis(
        fine_mm=fine,
        fine_half_extent_mm=half * draw(st.floats(0.01, 1.0)),
        outer_mm=fine * draw(st.floats(1.0, 10.0)),
        half_extent_mm=half,
        growth=draw(st.floats(1.0, 2.0)),
    )


@given(axes())
def test_lines_are_symmetric_to_the_bit_and_end_exactly_on_the_edges(axis: GradedAxis) -> None:
    lines = axis.lines()
    assert np.array_equal(lines, -lines[::-1])
    assert lines[-1] == axis.half_extent_mm
    assert lines[len(lines) // 2] == 0.0
    assert np.all(np.diff(lines) > 0.0)


@given(axes())
def test_elements_are_uniform_in_the_middle_and_grow_outwards_within_their_limit(axis: GradedAxis) -> None:
    sizes = np.diff(axis.half_lines())
    stretch = sizes[0] / axis.fine_mm
    assert abs(axis.half_extent_mm - axis.half_extent_mm / stretch) < 0.71 * sizes.max() / stretch
    fine_count = int(np.ceil(axis.fine_half_extent_mm / axis.fine_mm - 1e-6))
    assert sizes[:fine_count] == pytest.approx(sizes[0])
    ratios = sizes[1:] / sizes[:-1]
    assert np.all(ratios > 1.0 - 1e-9)
    assert np.all(ratios < axis.growth + 1e-9)
    assert sizes.max() <= axis.outer_mm * stretch * (1.0 + 1e-9)


def test_an_extent_of_whole_elements_is_not_stretched() -> None:
    axis = GradedAxis(fine_mm=0.005, fine_half_extent_mm=0.02, outer_mm=0.005, half_extent_mm=0.03)
    assert np.diff(axis.lines()) == pytest.approx(np.full(12, 0.005))


@given(st.floats(1e-3, 1.0), st.floats(1.0, 3.0), st.floats(1e-2, 10.0), st.floats(1.0, 50.0))
def test_layers_fill_their_extent_and_grow_within_their_limit(
    first: float, growth: float, largest: float, multiple: float
) -> None:
    layers = graded_layers(first, growth, largest, first * multiple)
    assert layers.sum() == pytest.approx(first * multiple)
    assert np.all(layers > 0.0)
    stretch = layers[0] / first
    assert layers[1:].max(initial=0.0) <= largest * stretch * (1.0 + 1e-9)


@pytest.mark.parametrize(
    ("changed", "complaint"),
    [
        ({"fine_mm": 0.0}, "0 < fine <= outer"),
        ({"fine_mm": float("nan")}, "0 < fine <= outer"),
        ({"outer_mm": 0.004}, "0 < fine <= outer"),
        ({"fine_half_extent_mm": 0.2}, "inside the patch"),
        ({"fine_half_extent_mm": 0.0}, "inside the patch"),
        ({"growth": 0.9}, "at least 1"),
        ({"fine_mm": 0.11, "outer_mm": 0.11}, "does not fit"),
    ],
)
def test_an_impossible_grading_is_refused_in_one_sentence(changed: dict[str, float], complaint: str) -> None:
    sizes = {"fine_mm": 0.005, "fine_half_extent_mm": 0.02, "outer_mm": 0.01, "half_extent_mm": 0.1} | changed
    with pytest.raises(GeometryError, match=complaint):
        GradedAxis(**sizes)


@pytest.mark.parametrize(
    "sizes", [(0.0, 1.2, 1.0, 1.0), (2.0, 1.2, 2.0, 1.0), (0.1, 0.9, 1.0, 1.0), (0.1, 1.0, 0.0, 1.0)]
)
def test_impossible_layers_are_refused(sizes: tuple[float, float, float, float]) -> None:
    with pytest.raises(GeometryError, match="cannot fill"):
        graded_layers(*sizes)


@given(st.floats(1e-3, 0.02), st.floats(1.0, 10.0), st.floats(0.1, 3.0), st.floats(0.05, 0.5))
def test_lines_that_are_fine_at_the_ends_keep_their_sizes_there_and_in_the_middle(
    fine: float, coarser: float, middle: float, edge: float
) -> None:
    axis = EdgeGradedAxis(fine, coarser * fine, middle, middle + edge)
    lines = axis.half_lines()
    sizes = np.diff(lines)
    assert lines[0] == 0.0
    assert lines[-1] == middle + edge
    assert (sizes > 0.0).all()
    at_edge = lines[:-1] >= middle * (1.0 - 1e-12)
    assert sizes[at_edge].max() <= fine * (1.0 + 1e-9)
    # All layers are stretched together to fill the middle, by less than one of them.
    assert sizes[~at_edge].max() <= 1.5 * coarser * fine


@pytest.mark.parametrize(
    "wrong", [(0.0, 0.1, 1.0, 2.0), (0.2, 0.1, 1.0, 2.0), (0.1, 0.2, 0.05, 2.0), (0.1, 0.2, 2.0, 2.0)]
)
def test_an_edge_graded_axis_that_cannot_be_is_refused(wrong: tuple[float, float, float, float]) -> None:
    with pytest.raises(GeometryError, match="must"):
        EdgeGradedAxis(*wrong)
