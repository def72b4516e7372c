"""Pressures averaged over a length tell a narrow crest from a broad contact, whatever the mesh."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from geometry import Elastic, GradedAxis, WireGeometry
from studies.benchmarks.pressure_peaks import largest_at_nodes
from wirewear import ResultError, largest_mean_pressure_MPa
from wirewear.results import ContactForces


def hertzian(element_mm: float, radius_mm: float = 0.03, load_N: float = 2.0) -> ContactForces:
    """Forces of a Hertzian contact on a mesh of such elements."""
    axis = GradedAxis(element_mm, 0.05, element_mm, 0.05)
    geometry = WireGeometry(0.45, 1.0, axis, axis, 0.07)
    x, y = np.meshgrid(axis.lines(), axis.lines(), indexing="ij")
    pressure = np.sqrt(np.maximum(1.0 - (x**2 + y**2) / radius_mm**2, 0.0)).ravel()
    nodes = np.flatnonzero(pressure)
    force = np.zeros((1, nodes.size, 3))
    force[0, :, 2] = -load_N * pressure[nodes] / pressure.sum()
    one = np.zeros(1)
    steel = Elastic(210_000.0, 0.3)
    return ContactForces(1, "fixed", 90.0, geometry, steel, np.ones(1), one, one, one, one, nodes, force)


def largest_mean(forces: ContactForces, over_um: float) -> float:
    return largest_mean_pressure_MPa(forces.places_um, forces.force_N[:, :, 2], over_um)


@pytest.mark.parametrize("element_mm", [0.005, 0.0025])
def test_a_broad_contact_has_its_own_pressure_at_nodes_and_less_as_a_mean(element_mm: float) -> None:
    forces, peak = hertzian(element_mm), 1.5 * 2.0 / (pi * 0.03**2)
    assert largest_at_nodes(forces) == pytest.approx(peak, rel=0.02)
    # To second order a mean takes half the variance times the curvature, 2/a², from the peak.
    assert largest_mean(forces, 12.0) == pytest.approx(peak * (1.0 - 0.006**2 / 0.03**2), rel=0.02)


def test_means_of_a_single_node_do_not_grow_as_the_mesh_is_refined() -> None:
    coarse, fine = (single(hertzian(element)) for element in (0.005, 0.0025))
    assert largest_at_nodes(fine) == pytest.approx(4.0 * largest_at_nodes(coarse), rel=1e-6)
    assert largest_mean(fine, 15.0) == pytest.approx(largest_mean(coarse, 15.0), rel=1e-6)


def single(forces: ContactForces) -> ContactForces:
    """The whole load at the middle node."""
    middle = int(np.argmin(forces.force_N[0, :, 2]))
    force = np.zeros_like(forces.force_N)
    force[0, middle, 2] = -2.0
    return replace(forces, force_N=force)


def test_the_mean_of_an_even_pressure_is_that_pressure_and_a_single_node_counts_by_its_length() -> None:
    places = np.arange(-200.0, 201.0, 5.0)
    even = np.full((1, places.size), 80.0 * 5e-3)
    assert largest_mean_pressure_MPa(places, even, 20.0) == pytest.approx(80.0, rel=1e-3)
    alone = np.where(places == 0.0, even, 0.0)
    over_20 = largest_mean_pressure_MPa(places, alone, 20.0)
    assert over_20 == pytest.approx(0.4 / (np.sqrt(2.0 * np.pi) * 10e-3), rel=1e-6)
    assert largest_mean_pressure_MPa(places, alone, 40.0) == pytest.approx(0.5 * over_20, rel=1e-6)


def test_a_length_that_is_none_and_forces_on_other_nodes_are_refused() -> None:
    with pytest.raises(ResultError, match="over a positive length, not over 0 µm"):
        largest_mean_pressure_MPa([0.0, 1.0], [[1.0, 1.0]], 0.0)
    with pytest.raises(ResultError, match=r"forces of shape \(1, 3\) are not those on nodes at places of shape \(2,\)"):
        largest_mean_pressure_MPa([0.0, 1.0], [[1.0, 1.0, 1.0]], 10.0)
