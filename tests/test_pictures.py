"""Pictures: all are drawn off screen, show something, and leave matplotlib's global state alone."""

import dataclasses
import os
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.image import imread

from tests.picture_pixels import PANELS, share_of, shows
from tests.synthetic_results import bowl, result
from wirewear.base.errors import ResultError
from wirewear.pictures import (
    amplitude_evolution,
    loops_by_cycle,
    loops_by_run,
    save,
    scar_sections,
    scars_from_above,
    show,
)
from wirewear.pictures.colours import DEPTH_COLOURS, PRESSURE_COLOURS, SLIP_COLOURS, VARIANT_COLOURS
from wirewear.pictures.contact_fields import touched_half_extent
from wirewear.pictures.gallery import section_cycles
from wirewear.pictures.scar_surfaces import VIEW, scars_in_3d, worn_surface
from wirewear.pictures.smooth import chosen_cycles, smooth_field, smooth_scar
from wirewear.pictures.style import cycle_colours, cycle_name, round_below, styled
from wirewear.results import Evolution, write_result

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
    program = "import sys, pathlib; from wirewear.pictures import show; show(pathlib.Path(sys.argv[1]))"
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
    assert shows(folder / "loops.png", *cycle_colours(5))
    for name in ("evolution.png", "sections.png"):
        assert shows(folder / name, *VARIANT_COLOURS[:2])
    for name in ("scars_from_above.png", "scar_series_rigid.png", "scar_series_compliant.png"):
        assert shows(folder / name, *DEPTH_COLOURS(np.linspace(0.0, 1.0, 9)), part=PANELS)
    for run_name in ("compliant", "rigid"):
        # The pressure of the bowls is the same everywhere, as is the distance slid: the top of each scale.
        assert shows(folder / f"contact_{run_name}.png", PRESSURE_COLOURS(1.0), SLIP_COLOURS(1.0), part=PANELS)
    # Light changes the pale colours of a surface, not the dark ones of the scar's bottom.
    assert shows(folder / "scars_3d.png", *DEPTH_COLOURS([0.875, 1.0]), part=PANELS)


@pytest.mark.slow
def test_pictures_of_a_run_before_wear_are_drawn(tmp_path: Path) -> None:
    """An unworn pair has no depth to scale colours by, one cycle no curve, and still all pictures come out."""
    run = result(milestones=(1,))
    columns = {name: column[:1] * (0.0 if "depth" in name else 1.0) for name, column in run.evolution.items()}
    unworn = tuple(dataclasses.replace(scar, depth_um=0.0 * scar.depth_um) for scar in run.scars)
    write_result(tmp_path / "result.h5", dataclasses.replace(run, evolution=Evolution(columns), scars=unworn))
    pictures = show(tmp_path / "result.h5", tmp_path / "elsewhere")
    assert {p.name for p in pictures} == EVERY_PICTURE | {"contact.png"}
    assert {p.parent for p in pictures} == {tmp_path / "elsewhere"}
    for name in ("scars_from_above.png", "scars_3d.png"):
        assert not any(share_of(tmp_path / "elsewhere" / name, DEPTH_COLOURS(d), part=PANELS) for d in (0.5, 0.75, 1.0))


def test_a_contact_of_a_single_node_is_drawn_with_what_is_beside_it() -> None:
    scar = result().scar(1, "fixed")
    one = np.zeros_like(scar.pressure_MPa)
    one[tuple(size // 2 for size in one.shape)] = 1.0
    alone = dataclasses.replace(scar, pressure_MPa=one, slip_distance_um=0.0 * one)
    half_x, half_y = touched_half_extent([alone])
    assert 0.0 < half_x < 0.2 * np.abs(scar.axial_um).max()
    assert 0.0 < half_y < 0.2 * np.abs(scar.axial_um).max()


def test_what_is_not_logged_yet_is_left_out(tmp_path: Path) -> None:
    """A run that has loops but no scars gets the pictures of its loops."""
    write_result(tmp_path / "result.h5", dataclasses.replace(result(status="running"), scars=()))
    assert show(tmp_path) == [tmp_path / "pictures" / "loops.png", tmp_path / "pictures" / "evolution.png"]


def test_an_empty_run_has_no_pictures(tmp_path: Path) -> None:
    """The sentence says so, and no folder is left behind."""
    empty = dataclasses.replace(result(status="running"), loops=(), scars=(), evolution=Evolution.from_rows([]))
    write_result(tmp_path / "result.h5", empty)
    with pytest.raises(ResultError, match="nothing is logged yet"):
        show(tmp_path)
    assert not (tmp_path / "pictures").exists()


def test_pictures_that_cannot_be_written_are_one_sentence(tmp_path: Path) -> None:
    """Here a file stands where the folder should."""
    write_result(tmp_path / "result.h5", result())
    (tmp_path / "pictures").write_text("in the way")
    with pytest.raises(ResultError, match=r"cannot write pictures to .*pictures"):
        show(tmp_path)


def test_drawing_leaves_global_settings_alone(tmp_path: Path) -> None:
    """The house style ends with the picture, and pyplot is never loaded for it."""
    before = dict(mpl.rcParams)
    save(lambda: amplitude_evolution([result()]), tmp_path / "a.png")
    assert dict(mpl.rcParams) == before


def test_a_drawn_loop_closes_without_a_knot() -> None:
    """Caps of both its ends would lie on one another, a tick where it begins."""
    drawn = [line for line in loops_by_run([result()]).axes[0].lines if np.size(line.get_xdata()) > 100]
    assert {line.get_solid_capstyle() for line in drawn} == {"butt"}


def test_loops_of_all_runs_share_their_axes() -> None:
    """Panels side by side can be compared by eye; each has one closed line for each chosen cycle."""
    with styled():
        figure = loops_by_run([result("compliant", 167.0), result("rigid")])
    one, other = figure.axes
    assert (one.get_xlim(), one.get_ylim()) == (other.get_xlim(), other.get_ylim())
    for axes in (one, other):
        curves = [line for line in axes.lines if len(np.atleast_1d(line.get_xdata())) > 2]
        assert len(curves) == 5
        for curve in curves:
            x = np.asarray(curve.get_xdata())
            assert x[0] == x[-1]


def test_loops_of_a_cycle_that_was_not_reached_are_refused() -> None:
    """Nothing is drawn in its place."""
    with pytest.raises(ResultError, match="logged cycles are: 1, 100"), styled():
        loops_by_cycle([result(milestones=(1, 100))], [100, 100_000])


def test_maps_have_equal_scales_and_one_colour_scale_for_both_wires() -> None:
    """The colour limits are those of the deepest scar of all."""
    with styled():
        figure = scars_from_above([result("compliant", 167.0), result("rigid")])
    maps = [axes for axes in figure.axes if axes.images]
    assert len(maps) == 4
    assert {axes.images[0].get_clim() for axes in maps} == {(0.0, 20.0)}
    assert {axes.get_aspect() for axes in maps} == {1.0}
    assert figure.axes[-1].get_ylabel() == "worn depth [µm]"


def test_a_map_shows_the_scar_where_it_is() -> None:
    """The moving wire's bowl of half-axes 140 × 95 µm lies along x; the fixed wire's of 90 × 95 µm across it."""
    with styled():
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


def test_sections_show_the_worn_below_the_unworn_profile() -> None:
    """At the crown the moving wire has lost 12 µm, the fixed one 20 µm; its unworn profile is the wire's circle."""
    with styled():
        figure = scar_sections([result()], [100_000])
    for axes, depth, sag in zip(figure.axes, (12.0, 20.0), (0.0, 225.0 - (225.0**2 - 100.0**2) ** 0.5), strict=True):
        unworn, worn = axes.lines
        x, circle, profile = (np.asarray(v) for v in (worn.get_xdata(), unworn.get_ydata(), worn.get_ydata()))
        assert np.interp(0.0, x, profile) == pytest.approx(-depth, abs=0.05)
        assert np.interp(100.0, x, circle) == pytest.approx(-sag, abs=0.01)
        assert np.all(profile <= circle)


def test_sections_are_drawn_of_the_last_shared_cycle_and_of_one_whose_wear_is_well_seen_beside_it() -> None:
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


def test_a_picture_whose_name_has_no_ending_is_a_png(tmp_path: Path) -> None:
    written = save(lambda: loops_by_run([result()]), tmp_path / "loops")
    assert written.read_bytes().startswith(b"\x89PNG")


def test_slip_is_averaged_over_what_is_moved_between_two_samples() -> None:
    """Points in rows that slide by turns all of an increment and none have slid half of it."""
    run = result()
    scar = run.scar(100_000, "fixed")
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
    _, transverse = scar.wire_coordinates(x, y)
    np.testing.assert_allclose(z, scar.unworn_height_um(transverse) - surface["depth_um"], atol=1e-9)
    np.testing.assert_allclose(surface["depth_um"], smooth_scar(scar).depth_at(x, y), atol=1e-9)
    assert np.asarray(surface["depth_um"]).max() == pytest.approx(20.0, rel=1e-3)
    assert abs(transverse).max() == pytest.approx(0.98 * 225.0)


@pytest.mark.slow
def test_the_bottom_of_a_scar_is_drawn_where_it_is_in_space() -> None:
    """The darkest pixels lie around the projection of the crown, sunk by the scar's depth."""
    scars = (bowl("moving", 40.0, 120.0, 75.0), bowl("fixed", 40.0, 80.0, 60.0))
    with styled():
        figure = scars_in_3d([dataclasses.replace(result(), scars=scars)])
    for axes in figure.axes[:2]:
        image = axes.images[0]
        pixels = np.asarray(image.get_array())[..., :3] / 255.0
        left, right, bottom, top = image.get_extent()
        rows, columns = np.nonzero(np.abs(pixels - DEPTH_COLOURS(0.98)[:3]).max(axis=-1) < 0.05)
        assert len(rows) > 100
        x = left + (columns + 0.5) / pixels.shape[1] * (right - left)
        y = top - (rows + 0.5) / pixels.shape[0] * (top - bottom)
        assert (np.median(x), np.median(y)) == pytest.approx(VIEW.project([0.0, 0.0, -40.0]), abs=8.0)


def test_the_view_is_orthographic() -> None:
    """Lengths parallel to the picture keep their length; the eye's direction is a point."""
    np.testing.assert_allclose(
        VIEW.project([7.0 * VIEW.right, 3.0 * VIEW.up, 5.0 * VIEW.eye]), [[7, 0], [0, 3], [0, 0]], atol=1e-12
    )


def test_at_most_six_loops_are_chosen_first_and_last_among_them() -> None:
    """Decades come before what lies between them."""
    logged = [1, 2, 5, 10, 20, 50, 100, 1000, 10_000, 60_000, 100_000]
    assert chosen_cycles(logged) == (1, 10, 100, 1000, 10_000, 100_000)
    assert chosen_cycles([1, 3, 7]) == (1, 3, 7)
    assert len(chosen_cycles(range(1, 100), 4)) <= 4


@pytest.mark.parametrize(("value", "rounded"), [(1.0, 1.0), (99.0, 50.0), (0.3, 0.2), (2.0, 2.0), (0.05, 0.05)])
def test_scale_bars_are_round(value: float, rounded: float) -> None:
    """1, 2 or 5 times a power of ten."""
    assert round_below(value) == pytest.approx(rounded)


def test_long_cycle_numbers_are_grouped() -> None:
    """With thin spaces, from five digits on."""
    assert (cycle_name(1000), cycle_name(100_000)) == ("1000", "100\u2009000")
