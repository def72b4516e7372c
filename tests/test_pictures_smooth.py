"""Fields between grid points, as pictures draw them: through every value, never beyond, ending where they vanish."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from geometry import build_wire
from tests.synthetic_results import bowl
from wirewear.pictures.mesh import PARTS, round_facets
from wirewear.pictures.smooth import smooth_field, smooth_scar
from wirewear.results import Scar
from wirewear.simulation import discretise
from wirewear.study import load_study

ROOT = Path(__file__).resolve().parent.parent
RADIUS_mm = 0.225

Array = NDArray[np.float64]

RADIUS_um = 73.0


@pytest.fixture(scope="module")
def facets() -> tuple[Array, NDArray[np.int_], Array, NDArray[np.int_], NDArray[np.int_]]:
    """Points and facets of a wire's side and ends, and what they become."""
    study = load_study(ROOT / "studies" / "steel_wires" / "study.toml")
    mesh = build_wire(discretise(study.variant("compliant"), "quick").moving).mesh
    corners = np.vstack([mesh.surfaces["side"], mesh.surfaces["ends"]])
    return (mesh.points, corners, *round_facets(mesh.points, corners, RADIUS_mm))


def test_a_drawn_wire_is_round_and_keeps_its_corners(
    facets: tuple[Array, NDArray[np.int_], Array, NDArray[np.int_], NDArray[np.int_]],
) -> None:
    points, corners, finer, quads, edges = facets
    assert quads.shape == (len(corners) * PARTS**2, 4)
    grid = finer.reshape(len(corners), PARTS + 1, PARTS + 1, 3)
    for k, place in enumerate(((0, 0), (-1, 0), (-1, -1), (0, -1))):
        assert grid[:, place[0], place[1]] == pytest.approx(points[corners[:, k]])
    radii = np.hypot(points[corners][..., 1], points[corners][..., 2] + RADIUS_mm)
    on_side = (abs(radii - RADIUS_mm) < 1e-6).all(axis=1)
    own = grid[on_side]
    assert np.hypot(own[..., 1], own[..., 2] + RADIUS_mm) == pytest.approx(RADIUS_mm, rel=1e-6)
    assert edges.shape == (4 * len(corners), PARTS + 1)


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


@pytest.mark.seconds
def test_symmetric_scars_are_drawn_symmetrically() -> None:
    scar = bowl("fixed", 12.0, 80.0, 60.0)
    depth = smooth_scar(scar).depth_um
    assert depth == pytest.approx(depth[::-1], abs=1e-9)
    assert depth == pytest.approx(depth[:, ::-1], abs=1e-9)
    _, _, pressure = smooth_field(scar, "pressure_MPa")
    shown = pressure.filled(-1.0)
    assert shown == pytest.approx(shown[::-1], abs=1e-6)
    assert shown == pytest.approx(shown[:, ::-1], abs=1e-6)
