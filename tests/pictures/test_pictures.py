"""Pictures: all are drawn off screen, show something, and leave matplotlib's global state alone."""

import dataclasses
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.colors import to_rgb
from matplotlib.image import imread
from numpy.typing import NDArray

from geometry import build_body
from geometry.arrays import Array
from tests.commands import wirewear
from tests.synthetic_results import bowl, result
from wirewear.pictures import loops_by_run, save, scar_sections, scars_from_above, style
from wirewear.pictures.gallery import section_cycles
from wirewear.pictures.mesh import PARTS, PIXELS, DrawnBodies, element_sizes, round_facets, show_bodies
from wirewear.pictures.scar_maps import contact_maps, touched_half_extent
from wirewear.pictures.scar_surfaces import worn_surface
from wirewear.pictures.smooth import smooth_field, smooth_scar
from wirewear.results import Scar, write_result
from wirewear.simulation import discretise
from wirewear.stress.pictures import _spread
from wirewear.test import load_study

EVERY_PICTURE = {"loops.png", "evolution.png", "scars_from_above.png", "sections.png", "scars_3d.png"}


@pytest.fixture(scope="module")
def variants(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    for run in (result("compliant", 167.0), result("rigid")):
        write_result(folder / run.variant / "result.h5", run)
    return folder


@pytest.mark.slow
def test_every_picture_is_drawn_without_an_x_server(variants: Path) -> None:
    """A fresh process without a display, with warnings as errors, draws all of them, each with both runs in it."""
    program = (
        "import sys, pathlib; from wirewear.pictures import show; from wirewear.results import read_results\n"
        "folder = pathlib.Path(sys.argv[1]); show(read_results(folder), folder / 'pictures')"
    )
    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    command = [sys.executable, "-W", "error", "-c", program, str(variants)]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    pictures = sorted((variants / "pictures").iterdir())
    each = {f"{name}_{run}.png" for name in ("scar_series", "contact") for run in ("compliant", "rigid")}
    assert {p.name for p in pictures} == EVERY_PICTURE | each
    for picture in pictures:
        height, width = imread(picture).shape[:2]
        assert width == 1275
        assert height > 400
    folder = variants / "pictures"
    assert shows(folder / "loops.png", *style.cycle_colours(5))
    for name in ("evolution.png", "sections.png"):
        assert shows(folder / name, *style.VARIANT_COLOURS[:2])
    for name in ("scars_from_above.png", "scar_series_rigid.png", "scar_series_compliant.png"):
        assert shows(folder / name, *style.DEPTH_COLOURS(np.linspace(0.0, 1.0, 9)), part=PANELS)
    for run_name in ("compliant", "rigid"):
        # The pressure of the bowls is the same everywhere, as is the distance slid: the top of each scale.
        assert shows(
            folder / f"contact_{run_name}.png", style.PRESSURE_COLOURS(1.0), style.SLIP_COLOURS(1.0), part=PANELS
        )
    # Light changes the pale colours of a surface, not the dark ones of the scar's bottom.
    assert shows(folder / "scars_3d.png", *style.DEPTH_COLOURS([0.875, 1.0]), part=PANELS)


def test_a_map_shows_the_scar_where_it_is() -> None:
    """The moving wire's bowl of half-axes 140 × 95 µm lies along x; the fixed wire's of 90 × 95 µm across it."""
    with style.styled():
        figure = scars_from_above([result()])
    moving, fixed = figure.axes[:2]
    for axes, half_x, half_y in ((moving, 140.0, 95.0), (fixed, 95.0, 90.0)):
        image = axes.images[0]
        values = np.asarray(image.get_array())
        left, right, bottom, top = image.get_extent()
        x = np.linspace(left, right, values.shape[1] + 1)[:-1] + (right - left) / values.shape[1] / 2
        y = np.linspace(bottom, top, values.shape[0] + 1)[:-1] + (top - bottom) / values.shape[0] / 2
        worn_y, worn_x = np.nonzero(values > 0.02 * values.max())
        assert abs(x[worn_x]).max() == pytest.approx(half_x, rel=0.05)
        assert abs(y[worn_y]).max() == pytest.approx(half_y, rel=0.05)


def test_a_map_reaches_as_far_as_the_bodies_press_or_slide_on_each_other() -> None:
    narrow, run = bowl("moving", 12.0, 50.0, 30.0), bowl("moving", 12.0, 140.0, 95.0)
    pressed = np.where(narrow.sampled(run.axial_um, run.transverse_um) > 0.0, 100.0, 0.0)
    assert touched_half_extent([replace(run, pressure_MPa=pressed)]) == touched_half_extent([run])
    assert touched_half_extent([replace(run, slip_distance_um=0.0 * pressed)]) == touched_half_extent([run])


@pytest.mark.parametrize("mm_per_pixel", [0.0003, 0.004])
def test_a_scale_bar_has_its_length_below_a_third_of_the_picture(mm_per_pixel: float) -> None:
    axes = style.new_figure(2.0).subplots()
    show_bodies(axes, DrawnBodies(np.zeros((PIXELS, PIXELS, 3), np.uint8), mm_per_pixel, {}))
    length = float(np.ptp(axes.lines[0].get_xdata()))
    said, unit = axes.texts[0].get_text().split()
    assert float(said) * {"mm": 1.0, "µm": 1e-3}[unit] == pytest.approx(length * mm_per_pixel)
    assert 0.1 < length / PIXELS <= 0.3


def test_sections_show_the_worn_below_the_unworn_profile() -> None:
    """At the crown the moving wire has lost 12 µm, the fixed one 20 µm; its unworn profile is the wire's circle."""
    with style.styled():
        figure = scar_sections([result()], [100_000])
    for axes, depth, sag in zip(figure.axes, (12.0, 20.0), (0.0, 225.0 - (225.0**2 - 100.0**2) ** 0.5), strict=True):
        unworn, worn = axes.lines
        x, circle, profile = (np.asarray(v) for v in (worn.get_xdata(), unworn.get_ydata(), worn.get_ydata()))
        assert np.interp(0.0, x, profile) == pytest.approx(-depth, abs=0.05)
        assert np.interp(100.0, x, circle) == pytest.approx(-sag, abs=0.01)
        assert np.all(profile <= circle)


def test_sections_show_the_last_shared_cycle_and_one_well_seen_beside_it() -> None:
    assert section_cycles([result(), result("rigid", milestones=(1, 100))])[-1] == 100
    assert section_cycles([result(milestones=(1, 10)), result(milestones=(1,))]) == (1,)
    run = result()
    early, last = section_cycles([run])
    assert last == 100_000
    depths = {cycle: run.scar(cycle, "fixed").max_depth_um for cycle in run.scar_cycles()}
    assert depths[early] >= 0.25 * depths[last]
    assert all(depth < 0.25 * depths[last] for cycle, depth in depths.items() if cycle < early)


def test_texts_of_an_svg_are_texts(tmp_path: Path) -> None:
    written = save(lambda: loops_by_run([result()]), tmp_path / "loops.svg").read_text(encoding="utf-8")
    assert "tangential force Q [N]</text>" in written


@pytest.mark.slow
def test_pictures_for_a_journal_are_as_wide_as_one_or_both_of_its_columns(tmp_path: Path) -> None:
    one = tmp_path / "one.h5"
    write_result(one, result())
    widths = []
    for options in (
        ["loops", str(one), "--cycle", "1", "--paper"],
        ["loops", str(one), "--paper"],
        ["loops", str(one)],
    ):
        wirewear(*options, "--output", tmp_path / "loops.png")
        widths.append(imread(tmp_path / "loops.png").shape[1])
    assert widths == [round(600 * style.COLUMN_in), 600 * style.WIDTH_in, 170 * style.WIDTH_in]


def test_slip_is_averaged_over_what_is_moved_between_two_samples() -> None:
    """Points in rows that slide by turns all of an increment and none have slid half of it."""
    scar = result().scar(100_000, "fixed")
    turns = np.where(np.arange(scar.transverse_um.size) % 2 == 0, 50.0, 40.0)
    striped = dataclasses.replace(scar, slip_distance_um=np.where(scar.depth_um > 0.0, turns, 0.0))
    apart = 2.0 * float(np.median(np.diff(scar.transverse_um)))
    spread = [float(np.ptp(smooth_field(striped, "slip_distance_um", over)[2][200, 180:220])) for over in (0.0, apart)]
    assert spread[0] > 5.0 > 4.0 * spread[1]


def test_a_point_that_is_hardly_worn_makes_no_notch_in_a_scar() -> None:
    scar = bowl("fixed", 20.0, 100.0, 100.0)
    middle = scar.transverse_um.size // 2
    row = int(np.flatnonzero(scar.depth_um[:, middle] > 0.0)[-1]) + 1
    touched = scar.depth_um.copy()
    touched[row, middle] = 0.01
    drawn = smooth_scar(dataclasses.replace(scar, depth_um=touched))
    pole = drawn.depth_um[np.searchsorted(drawn.axial_um, scar.axial_um[row]) - 12]
    beside = np.abs(drawn.transverse_um) < 1.5 * np.diff(scar.transverse_um)[middle]
    assert pole[drawn.transverse_um.size // 2] >= 0.95 * pole[beside].max() > 0.0


@pytest.mark.parametrize("angle", [0.0, 60.0, 90.0])
def test_the_worn_surface_is_the_cylinder_minus_the_depth(angle: float) -> None:
    """z = sqrt(R² − t²) − R − depth at every point, in true proportions."""
    scar = bowl("fixed", 20.0, 80.0, 60.0, axis_angle_deg=angle)
    surface = worn_surface(scar, 120.0, 400.0)
    x, y, z = np.asarray(surface.points).T
    axial, transverse = scar.wire_coordinates(x, y)
    np.testing.assert_allclose(z, scar.unworn_height_um(axial, transverse) - surface["depth_um"], atol=1e-9)
    np.testing.assert_allclose(surface["depth_um"], smooth_scar(scar).depth_at(x, y), atol=1e-9)
    assert np.asarray(surface["depth_um"]).max() == pytest.approx(20.0, rel=1e-3)
    assert abs(transverse).max() == pytest.approx(0.94 * 225.0)


ROOT = Path(__file__).parents[2]
RADIUS_mm = 0.225
RADIUS_um = 73.0


@pytest.fixture(scope="module")
def facets() -> tuple[Array, NDArray[np.int_], Array, NDArray[np.int_], NDArray[np.int_]]:
    """Points and facets of a wire's side and ends, and what they become."""
    study = load_study(ROOT / "studies" / "steel_wires" / "study.toml")
    mesh = build_body(discretise(study.variant("compliant"), "quick").moving).mesh
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
    own = grid[(abs(radii - RADIUS_mm) < 1e-6).all(axis=1)]
    assert np.hypot(own[..., 1], own[..., 2] + RADIUS_mm) == pytest.approx(RADIUS_mm, rel=1e-6)
    assert edges.shape == (4 * len(corners), PARTS + 1)


def cap(count: int, power: float = 1.0, skew: float = 0.0) -> Scar:
    """A round area of that radius on an uneven grid, count × (count + 4), its pressure and depth (1 − r²/R²)^power."""
    sides = np.linspace(-1.0, 1.0, count), np.linspace(-1.0, 1.0, count + 4)
    axial, transverse = (120.0 * (side + skew * (side**2 - 1.0)) for side in sides)
    r = np.hypot(axial[:, None], transverse[None, :]) / RADIUS_um
    field = np.maximum(1.0 - r**2, 0.0) ** power
    blank = np.zeros_like(field)
    return Scar(1, "fixed", 0.45, 90.0, axial, transverse, 10.0 * field, blank, 500.0 * field, blank)


@pytest.mark.parametrize("skew", [0.0, 0.2])
def test_computed_values_stay_as_they_are_and_lone_points_are_seen(skew: float) -> None:
    scar = cap(21, skew=skew)
    x, y = scar.sliding_coordinates(scar.axial_um[:, None], scar.transverse_um[None, :])
    assert smooth_scar(scar).depth_at(x, y) == pytest.approx(scar.depth_um, abs=1e-9)
    for lone in (np.ones_like(x), 1.0 * (np.arange(x.size).reshape(x.shape) % 4 == 0)):
        axial, transverse, pressure = smooth_field(replace(scar, pressure_MPa=lone * scar.pressure_MPa), "pressure_MPa")
        there = lone * scar.pressure_MPa > 0.05 * scar.pressure_MPa.max()
        computed = pressure[np.ix_(np.isin(axial, scar.axial_um), np.isin(transverse, scar.transverse_um))]
        assert computed[there].data == pytest.approx(scar.pressure_MPa[there])
    assert not np.ma.getmaskarray(computed)[there].any()


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


LEAST = 1e-4  #: A thin line of a few hundred pixels in a picture of a million.
PANELS = 0.84  #: Colour bars stand to the right of this share of the width.


def share_of(path: Path, colour: object, *, part: float = 1.0) -> float:
    """Share of the pixels in the left `part` of a picture whose red, green and blue are within 0.03 of a colour's."""
    pixels = imread(path)[..., :3]
    pixels = pixels[:, : int(part * pixels.shape[1])]
    near = np.abs(pixels - np.array(to_rgb(colour))).max(axis=-1) < 0.03  # type: ignore[arg-type]
    return float(near.mean())


def shows(path: Path, *colours: object, part: float = 1.0) -> bool:
    """Whether something is drawn in each of these colours."""
    return all(share_of(path, colour, part=part) > LEAST for colour in colours)


def test_the_size_beside_a_mesh_is_said_to_be_that_of_its_elements() -> None:
    axis = {"axial": SimpleNamespace(fine_mm=0.0362), "transverse": SimpleNamespace(fine_mm=0.0117)}
    meshed: Any = SimpleNamespace(geometry=SimpleNamespace(**axis))
    assert element_sizes(meshed) == "elements of 36.2 × 11.7 µm"


def test_bodies_that_have_but_a_place_are_called_by_their_shape_in_pictures() -> None:
    bodies = {"lower": {"shape": "cylinder"}, "upper": {"shape": "tube"}}
    run = dataclasses.replace(result("compliant", 167.0), study={"bodies": bodies})
    assert [run.called(name) for name in bodies] == ["cylinder (lower)", "tube (upper)"]
    assert run.called("moving") == "moving wire"


def test_arrows_of_shear_leave_room_to_see_the_pressure_between_them() -> None:
    places = np.stack(np.meshgrid(*2 * [np.linspace(-20.0, 20.0, 81)]), axis=-1).reshape(-1, 2)
    loaded = np.hypot(*places.T) < 14.0
    drawn = _spread(places, loaded, 28.0 / 12)
    assert loaded[drawn].all()
    assert 80 < len(drawn) < 150
    apart = np.linalg.norm(places[drawn][:, None] - places[drawn], axis=2)
    assert np.median(apart[apart > 0.0].reshape(len(drawn), -1).min(axis=1)) > 1.5


def test_a_map_of_pressure_states_the_load_over_its_area_and_no_value_of_a_node() -> None:
    figure = contact_maps(result("compliant", 167.0), [100_000])
    notes = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert any(note.startswith("mean ") and note.endswith(" MPa") for note in notes)
    assert not any("node" in note for note in notes)
