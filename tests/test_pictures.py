"""Pictures: all are drawn off screen, show something, and leave matplotlib's global state alone."""

import dataclasses
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from tests.picture_pixels import PANELS, shows
from tests.synthetic_results import bowl, result
from wirewear.pictures import (
    loops_by_run,
    save,
    scar_sections,
    scars_from_above,
)
from wirewear.pictures.colours import DEPTH_COLOURS, PRESSURE_COLOURS, SLIP_COLOURS, VARIANT_COLOURS
from wirewear.pictures.gallery import section_cycles
from wirewear.pictures.scar_surfaces import worn_surface
from wirewear.pictures.smooth import smooth_field, smooth_scar
from wirewear.pictures.style import cycle_colours, styled
from wirewear.results import write_result

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
