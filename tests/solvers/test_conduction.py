"""Heated surfaces: closed forms of Carslaw & Jaeger for still, oscillating and moving sources."""

import numpy as np
import pytest

from geometry.arrays import Array
from solvers import Conductor, surface_rise

STEEL = Conductor(46.0, 3.6)
PERIOD_s = 1.0 / 3.0


def disc(radius_mm: float, cell_mm: float, count: int) -> Array:
    """(count, count) power per cell of a uniform disc in the middle, in all the flux 1 mW/mm² times its area."""
    places = cell_mm * (np.arange(count) - count // 2)
    inside = (np.hypot(places[:, None], places[None, :]) < radius_mm).astype(float)
    return np.asarray(inside * np.pi * radius_mm**2 / inside.sum())


def test_a_steady_disc_is_as_hot_in_its_middle_and_on_average_as_the_closed_form() -> None:
    radius = 0.05
    power = disc(radius, radius / 30, 81)
    rise = surface_rise(np.repeat(power[None], 8, axis=0), radius / 30, PERIOD_s, STEEL)
    # Carslaw & Jaeger § 10.5: q a / k in the middle, 8 / (3 π) of it on average.
    assert rise[:, 40, 40] == pytest.approx(np.full(8, radius / 46.0), rel=0.005)
    assert rise[0][power > 0.0].mean() == pytest.approx(8.0 / (3.0 * np.pi) * radius / 46.0, rel=0.005)


@pytest.mark.parametrize("order", [1, 3])
def test_under_an_oscillating_flux_a_wide_surface_follows_an_eighth_of_a_period_later(order: int) -> None:
    phase = 2.0 * np.pi * order * np.arange(32) / 32
    depth = np.sqrt(STEEL.diffusivity_mm2_per_s * PERIOD_s / (np.pi * order))
    power = disc(8.0 * depth, depth / 5.0, 91)
    middle = surface_rise(np.cos(phase)[:, None, None] * power, depth / 5.0, PERIOD_s, STEEL)[:, 45, 45]
    # Carslaw & Jaeger § 2.6: amplitude q √(κ / ω) / k.
    flux = power.max() / (depth / 5.0) ** 2
    exact = flux * depth / np.sqrt(2.0) / 46.0 * np.cos(phase - 0.25 * np.pi)
    assert middle == pytest.approx(exact, abs=0.02 * exact.max())


@pytest.mark.first_case
@pytest.mark.parametrize(("peclet", "cells"), [(0.3, 11), (3.0, 17), (20.0, 25)])
def test_a_square_that_moves_is_as_hot_as_its_point_sources_say(peclet: float, cells: int) -> None:
    """Carslaw & Jaeger § 10.7, sources exp(-V (r + x) / (2 κ)) / (2 π k r) over a square; Péclet's number V l / (2 κ)
    of half its side l.
    """
    passed, half, diffusivity, conductivity = 20 + int(max(3.0, 3.0 / peclet) * cells), 0.5 * cells, 0.02, 10.0
    moments = 1024 if passed < 90 else 2048
    power = np.zeros((moments, passed + cells, cells))
    for step in range(passed):
        power[step, step : step + cells] = 1.0
    # It passes once in a period that is long beside its passage; what is left of that at last is all over the place.
    period = moments * half / (2.0 * diffusivity * peclet)
    rise = surface_rise(power, 1.0, period, Conductor(conductivity, conductivity / diffusivity))[:, :, cells // 2]
    step = passed - cells // 2
    found = rise[step, step : step + cells] - rise[-1, passed // 2 : passed // 2 + cells].mean()
    turn = np.linspace(1e-6, np.pi - 1e-6, 4000)
    exact = []
    for at in (np.arange(cells) - cells // 2) / half:
        reach = np.minimum((np.sign(np.cos(turn)) - at) / np.cos(turn), 1.0 / np.sin(turn))
        decay = peclet * (1.0 - np.cos(turn))
        exact.append(half / (np.pi * conductivity) * np.trapezoid(-np.expm1(-decay * reach) / decay, turn))
    assert found.max() == pytest.approx(max(exact), rel=0.02)


def test_the_way_to_the_surroundings_adds_the_mean_power_times_its_resistance() -> None:
    power = disc(0.05, 0.01, 21)[None] * (1.0 + np.cos(2.0 * np.pi * np.arange(16) / 16))[:, None, None]
    with_way = surface_rise(power, 0.01, PERIOD_s, Conductor(46.0, 3.6, 2000.0))
    assert with_way - surface_rise(power, 0.01, PERIOD_s, STEEL) == pytest.approx(2.0 * power[4].sum(), rel=1e-9)
