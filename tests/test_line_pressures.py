"""Means of a contact's pressure over a length."""

import numpy as np
import pytest

from studies.mccoll2004.pressures import largest_means


def test_the_mean_of_an_even_pressure_is_that_pressure_and_a_single_node_counts_by_its_length() -> None:
    places = np.arange(-200.0, 201.0, 5.0)
    even = np.full((1, places.size), 80.0 * 5e-3)
    assert largest_means(places, even, 20.0) == pytest.approx(80.0, rel=1e-3)
    alone = np.where(places == 0.0, even, 0.0)
    assert largest_means(places, alone, 20.0) == pytest.approx(0.4 / (np.sqrt(2.0 * np.pi) * 10e-3), rel=1e-6)
    assert largest_means(places, alone, 40.0) == pytest.approx(0.5 * largest_means(places, alone, 20.0), rel=1e-6)
