"""Fields between grid points, as pictures draw them: through every value, never beyond, ending where they vanish."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from PIL import Image

from geometry import build_wire
from tests.synthetic_results import bowl, result
from wirewear.base.errors import ResultError
from wirewear.base.quantity import counted
from wirewear.pictures import evolution_panels, save
from wirewear.pictures.gallery import animation
from wirewear.pictures.mesh import PARTS, round_facets
from wirewear.pictures.smooth import extended, smooth_field, smooth_scar
from wirewear.pictures.style import cycle_axis, new_figure, styled, svg
from wirewear.results import Scar
from wirewear.simulation import discretise
from wirewear.study import load_study

ROOT = Path(__file__).resolve().parent.parent
RADIUS_mm = 0.225

Array = NDArray[np.float64]

RADIUS_um = 73.0


def test_a_moving_picture_has_a_frame_for_each_recorded_cycle(tmp_path: Path) -> None:
    run = result("compliant", 167.0, milestones=(1, 100, 100_000))
    with Image.open(animation(run, tmp_path / "run.gif")) as moving:
        assert getattr(moving, "n_frames", 1) == 3
        seen = []
        for frame in range(3):
            moving.seek(frame)
            seen.append(np.asarray(moving.convert("L"), dtype=float))
    assert min(np.abs(one - other).mean() for one, other in pairwise(seen)) > 0.1
    # The scar of the last frame is the darkest.
    halves = [frame[:, frame.shape[1] // 2 :] for frame in seen]
    assert (halves[2] < 100).sum() > 2 * (halves[0] < 100).sum()


def test_what_is_not_recorded_cannot_be_shown_in_motion(tmp_path: Path) -> None:
    with pytest.raises(ResultError, match="nothing can be shown in motion"):
        animation(replace(result(milestones=(5,)), scars=()), tmp_path / "run.gif")


@pytest.mark.parametrize("ending", ["svg", "pdf"])
def test_pictures_are_drawn_as_vectors_too(ending: str, tmp_path: Path) -> None:
    written = save(lambda: evolution_panels([result("compliant", 167.0)]), tmp_path / f"evolution.{ending}")
    if ending == "svg":
        assert ET.parse(written).getroot().tag.endswith("svg")
    else:
        assert written.read_bytes().startswith(b"%PDF")


def test_an_svg_for_a_page_has_texts_and_is_the_same_each_time() -> None:
    one, other = (svg(lambda: evolution_panels([result("compliant", 167.0)])) for _ in range(2))
    assert one == other
    assert b"worst depth" in one


def test_cycles_are_counted_from_the_first_and_written_as_everywhere() -> None:
    with styled():
        axes = new_figure(3.0).subplots()
        axes.plot([10.0, 100_000.0], [1.0, 2.0])
        cycle_axis(axes)
        assert axes.get_xlim()[0] == 1.0
        assert axes.xaxis.get_major_formatter()(100_000.0) == "100\u2009000"
    assert [counted(number) for number in (999, 9999, 10_000, 1_234_567.2)] == [
        "999",
        "9999",
        "10\u2009000",
        "1\u2009234\u2009567",
    ]


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


def test_neighbouring_facets_share_their_curved_edges(
    facets: tuple[Array, NDArray[np.int_], Array, NDArray[np.int_], NDArray[np.int_]],
) -> None:
    """The middles of all edges: each but those at the gaps left by other surfaces belongs to two facets."""
    _, _, finer, _, edges = facets
    middles = np.round(finer[edges[:, PARTS // 2]], 9)
    _, counts = np.unique(middles, axis=0, return_counts=True)
    assert set(counts) <= {1, 2}
    assert (counts == 2).mean() > 0.9


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
