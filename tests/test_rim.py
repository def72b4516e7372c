"""The largest pressure away from a contact's rim."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solvers.contact.acceptance import largest_within


def _band(edge: float, nodes: int = 24) -> np.ndarray:
    """Nodal pressures of a band of uniform pressure 1 from 0 to `edge`: nodes within carry the load of all of it.

    Half of the last node's area, and what of the next ends beyond it, is the last node's.
    """
    line = np.zeros(nodes)
    last = int(edge)
    line[1 : last + 1] = 1.0
    line[last] += edge - last - 0.5
    return line


@given(st.floats(4.5, 16.4))
def test_where_the_rim_falls_between_nodes_does_not_show(edge: float) -> None:
    """Nodal pressures swing between a half and one and a half of the true one."""
    assert largest_within(_band(edge)[:, None]) == pytest.approx(1.0, abs=0.26)
    assert largest_within(np.outer(_band(edge), _band(12.0))) == pytest.approx(1.0, abs=0.26)


def test_the_peak_of_a_smooth_pressure_is_that_of_its_node() -> None:
    x = np.arange(-5, 6) / 4.2
    squared = 1.0 - x[:, None] ** 2 - x**2
    assert largest_within(np.sqrt(np.maximum(squared, 0.0))) == 1.0


def test_a_node_alone_counts_by_what_its_load_comes_to_over_elements() -> None:
    alone = np.zeros((5, 5))
    alone[2, 2] = 8.0
    assert largest_within(alone) == 2.0
    assert largest_within(np.array([[0.0], [3.0], [0.0]])) == 1.5
    assert largest_within(np.zeros((4, 4))) == 0.0
