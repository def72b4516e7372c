"""The mesh command leaves files that other programs read, and a picture."""

from pathlib import Path

import meshio
import numpy as np
import pytest
from click.testing import CliRunner

from tests.bodies import wire
from tests.picture_pixels import shows
from tests.studies import MINIMAL
from wirewear.faces import cli
from wirewear.pictures.boundary_conditions import HELD_COLOUR, LOAD_COLOUR, MOTION_COLOUR
from wirewear.pictures.colours import GREY
from wirewear.pictures.wire_supports import wire_supports
from wirewear.study import parse_study

STUDIES = Path(__file__).resolve().parent.parent / "studies"


@pytest.mark.slow
def test_the_meshes_of_a_study_are_written_with_their_surfaces_and_drawn(tmp_path: Path) -> None:
    study = tmp_path / "study.toml"
    study.write_text(MINIMAL, encoding="utf-8")
    result = CliRunner().invoke(cli, ["mesh", str(study), "--fidelity", "quick", "--output", str(tmp_path / "mesh")])
    assert result.exit_code == 0, result.output
    for name in ("moving", "fixed"):
        mesh = meshio.read(tmp_path / "mesh" / f"{name}.vtu")
        assert [block.type for block in mesh.cells] == ["hexahedron"]
        contact = mesh.points[mesh.point_data["contact"] == 1.0]
        np.testing.assert_allclose(np.hypot(contact[:, 1], contact[:, 2] + 0.225), 0.225, rtol=1e-9)
        assert not np.any((mesh.point_data["contact"] == 1.0) & (mesh.point_data["grip"] == 1.0))
    assert (tmp_path / "mesh" / "mesh.png").stat().st_size > 50_000
    assert shows(tmp_path / "mesh" / "boundary_conditions.png", HELD_COLOUR, LOAD_COLOUR, MOTION_COLOUR)


def test_sections_of_wires_are_round_and_held_alike_on_both_sides() -> None:
    own = wire(0.02)
    figure = wire_supports(parse_study(MINIMAL, "study.toml"), own, own)
    upper = figure.axes[0].lines[0]
    x, z = (values[np.isfinite(values)] for values in (np.asarray(upper.get_xdata()), np.asarray(upper.get_ydata())))
    radius = own.geometry.radius_mm
    assert x.size > 100
    np.testing.assert_allclose(np.hypot(x, z - radius), radius, rtol=3e-3)
    ends = sorted(float(np.asarray(line.get_xdata())[1]) for line in figure.axes[0].lines if line.get_color() == GREY)
    assert len(ends) > 5
    np.testing.assert_allclose(ends, -np.array(ends[::-1]), atol=0.05 * radius)


def test_a_study_that_cannot_be_meshed_is_refused_in_one_sentence(tmp_path: Path) -> None:
    study = tmp_path / "study.toml"
    study.write_text(MINIMAL + "[mesh]\nscar_half_width_um = 5.0\n", encoding="utf-8")
    result = CliRunner().invoke(cli, ["mesh", str(study), "--output", str(tmp_path)])
    assert result.exit_code == 2
    assert "would leave the finely meshed patch" in result.output


def test_line_contacts_are_drawn_with_what_holds_and_moves_them(tmp_path: Path) -> None:
    study = STUDIES / "cylinder_on_flat" / "study.toml"
    result = CliRunner().invoke(cli, ["mesh", str(study), "--fidelity", "quick", "--output", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert shows(tmp_path / "boundary_conditions.png", HELD_COLOUR, LOAD_COLOUR, MOTION_COLOUR)
    assert [block.type for block in meshio.read(tmp_path / "pad.vtu").cells] == ["quad"]
