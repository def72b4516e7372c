"""Pictures in other forms: vector files, moving pictures, and meshes whose wires are round."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from geometry import build_wire
from tests.synthetic_results import result
from wirewear.base.errors import ResultError
from wirewear.base.quantity import counted
from wirewear.pictures import evolution_panels, save
from wirewear.pictures.gallery import animation
from wirewear.pictures.mesh import PARTS, round_facets
from wirewear.pictures.style import cycle_axis, new_figure, styled, svg
from wirewear.simulation import discretise
from wirewear.study import load_study

ROOT = Path(__file__).resolve().parent.parent
RADIUS_mm = 0.225

Array = NDArray[np.float64]


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
