"""Fields between grid points, as pictures draw them: through every value, never beyond, ending where they vanish."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from tests.synthetic_results import bowl
from wirewear.pictures.smooth import extended, smooth_field, smooth_scar
from wirewear.results import Scar

Array = NDArray[np.float64]

RADIUS_um = 73.0


def cap(count: int, power: float = 1.0, skew: float = 0.0) -> Scar:
    """A round area of that radius on an uneven grid of count² points, its pressure and depth (1 − r²/R²)^power."""
    side = np.linspace(-1.0, 1.0, count)
    line = 120.0 * (side + skew * (side**2 - 1.0))
    r = np.hypot(line[:, None], line[None, :]) / RADIUS_um
    field = np.maximum(1.0 - r**2, 0.0) ** power
    blank = np.zeros_like(field)
    return Scar(1, "fixed", 0.45, 90.0, line, line, 10.0 * field, blank, 500.0 * field, blank)


@pytest.mark.parametrize("skew", [0.0, 0.2])
def test_computed_values_stay_as_they_are(skew: float) -> None:
    scar = cap(21, skew=skew)
    finer = smooth_scar(scar)
    x, y = scar.sliding_coordinates(scar.axial_um[:, None], scar.transverse_um[None, :])
    assert finer.depth_at(x, y) == pytest.approx(scar.depth_um, abs=1e-9)
    axial, transverse, pressure = smooth_field(scar, "pressure_MPa")
    there = scar.pressure_MPa > 0.05 * scar.pressure_MPa.max()
    computed = pressure[np.ix_(np.isin(axial, scar.axial_um), np.isin(transverse, scar.transverse_um))]
    assert computed.shape == scar.pressure_MPa.shape
    assert computed[there].data == pytest.approx(scar.pressure_MPa[there])


@pytest.mark.slow
@given(st.integers(0, 10_000))
def test_nothing_is_drawn_deeper_or_more_highly_pressed_than_it_is(seed: int) -> None:
    scar = cap(9)
    rough = np.random.default_rng(seed).uniform(0.0, 1.0, scar.depth_um.shape) * (scar.depth_um > 0.0)
    scar = replace(scar, depth_um=rough, pressure_MPa=rough)
    depth = smooth_scar(scar).depth_um
    assert depth.min() == 0.0
    assert depth.max() == pytest.approx(rough.max())
    assert float(smooth_field(scar, "pressure_MPa")[2].max()) <= rough.max() * (1.0 + 1e-12)


@pytest.mark.parametrize("count", [17, 33])
def test_a_round_scar_has_a_round_edge(count: int) -> None:
    scar = cap(count)
    finer = smooth_scar(scar)
    spacing = float(np.diff(scar.axial_um).max())
    r = np.hypot(finer.axial_um[:, None], finer.transverse_um[None, :])
    assert float(r[finer.depth_um > 0.0].max()) == pytest.approx(RADIUS_um, abs=0.5 * spacing)
    assert float(r[finer.depth_um == 0.0].min()) == pytest.approx(RADIUS_um, abs=0.5 * spacing)


def test_a_field_that_does_not_vanish_at_its_edge_has_a_round_outline_too() -> None:
    scar = cap(17, power=0.0)
    flat = replace(scar, slip_distance_um=np.where(scar.depth_um > 0.0, 100.0, 0.0))
    r = np.hypot(flat.axial_um[:, None], flat.transverse_um[None, :])
    flat = replace(flat, slip_distance_um=np.where(r < RADIUS_um, 100.0, 0.0))
    axial, transverse, slip = smooth_field(flat, "slip_distance_um")
    shown, spacing = ~np.ma.getmaskarray(slip), float(np.diff(scar.axial_um).max())
    distance = np.hypot(axial[:, None], transverse[None, :])
    assert float(distance[shown].max()) < RADIUS_um + 0.75 * spacing
    assert float(distance[~shown].min()) > RADIUS_um - 0.75 * spacing
    assert slip.min() == slip.max() == 100.0


def test_symmetric_scars_are_drawn_symmetrically() -> None:
    scar = bowl("fixed", 12.0, 80.0, 60.0)
    depth = smooth_scar(scar).depth_um
    assert depth == pytest.approx(depth[::-1], abs=1e-9)
    assert depth == pytest.approx(depth[:, ::-1], abs=1e-9)
    _, _, pressure = smooth_field(scar, "pressure_MPa")
    shown = pressure.filled(-1.0)
    assert shown == pytest.approx(shown[::-1], abs=1e-6)
    assert shown == pytest.approx(shown[:, ::-1], abs=1e-6)


def test_an_unworn_wire_has_nothing_to_draw() -> None:
    scar = cap(11)
    blank = np.zeros_like(scar.depth_um)
    unworn = replace(scar, depth_um=blank, pressure_MPa=blank)
    assert not smooth_scar(unworn).depth_um.any()
    assert smooth_field(unworn, "pressure_MPa")[2].count() == 0


def test_a_plane_is_carried_on_as_a_plane() -> None:
    """It has no bending energy, wherever it is known and however uneven the grid."""
    first, second = np.cumsum(np.linspace(1.0, 2.0, 14)), np.cumsum(np.linspace(3.0, 1.0, 11))
    plane = 2.0 * first[:, None] - 0.5 * second[None, :] + 7.0
    inside = np.zeros_like(plane, dtype=bool)
    inside[4:9, 3:8] = inside[6, 2] = True
    found = extended(first, second, np.where(inside, plane, 0.0), inside)
    band = np.zeros_like(inside)
    band[2:11, 1:10] = True
    assert found[band] == pytest.approx(plane[band], rel=1e-6)
    assert found[~band & ~inside][0] == 0.0
