"""Bodies whose condensed stiffness a file gives."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import mmwrite

from geometry import BlockGeometry, Elastic, GeometryError, GradedAxis
from geometry.mesh_files import digest_of
from geometry.own_surface import MeshSource
from geometry.stiffness_files import of_stiffness, read_stiffness
from wirewear.base.errors import StudyError
from wirewear.simulation.point_runs import PointRun
from wirewear.simulation.problem import condensed_body, write_condensed
from wirewear.simulation.workbench import write_meshes
from wirewear.test.study import load_study, point_study

STEEL = Elastic(210e3, 0.3)
BODY = {"youngs_modulus_MPa": 210e3, "poissons_ratio": 0.3}
AXIS = GradedAxis(0.1, 0.1, 0.1, 0.2)
BLOCK = BlockGeometry(0.2, 0.1, 1.5, 1.5, 1.5, AXIS, AXIS, 0.5)


def source(file: Path) -> MeshSource:
    return MeshSource(str(file), digest_of(str(file)), 1.0, "contact", "grip")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    write_condensed(file := tmp_path_factory.mktemp("stiffness") / "ball.npz", BLOCK, STEEL)
    return file


@pytest.mark.parametrize("ending", [".npz", ".mtx"])
def test_a_body_whose_stiffness_is_written_and_read_back_is_the_same_body(written: Path, ending: str) -> None:
    file, built = written.with_suffix(ending), condensed_body(BLOCK, STEEL)
    if ending == ".mtx":
        with np.load(written) as data:
            mmwrite(file, data["stiffness_N_per_mm"], precision=17, symmetry="general")
            names = np.where(np.arange(len(data["nodes_mm"])) < len(data["contact"]), "contact", "grip")
            lines = [
                f"{x!r},{y!r},{z!r},{name}" for (x, y, z), name in zip(data["nodes_mm"].tolist(), names, strict=True)
            ]
        file.with_suffix(".csv").write_text("x_mm,y_mm,z_mm,set\n" + "\n".join(lines))
    geometry = of_stiffness(source(file))
    read = condensed_body(geometry, STEEL)
    np.testing.assert_allclose(read.compliance, built.compliance, atol=1e-10 * built.compliance.max())
    np.testing.assert_allclose(
        read.patch.height(built.patch.grid()), built.patch.height(built.patch.grid()), atol=1e-12
    )
    barrel = geometry.profile.barrel
    np.testing.assert_allclose((barrel.curvature_along_per_mm, barrel.curvature_across_per_mm), (0.2, 0.1), rtol=1e-9)
    if ending == ".npz":
        np.testing.assert_allclose(geometry.layers, BLOCK.layers, rtol=1e-12)


@pytest.mark.slow
def test_a_stiffness_that_a_study_writes_serves_that_study(tmp_path: Path) -> None:
    bodies = {"lower": {"shape": "flat", **BODY}, "upper": {"shape": "ball", "diameter_mm": 6.0, **BODY}}
    tables = {
        "format": 1, "name": "s", "kind": "point-contact", "bodies": bodies, "contact": {"friction": 0.6},
        "conditions": {"normal_load_N": 5.0, "displacement_amplitude_um": 20.0, "frequency_Hz": 3.0, "cycles": 1000},
        "wear": {"energy_wear_coefficient_mm3_per_J": 2e-5},
    }  # fmt: skip
    write_meshes(point_study(tables, "s"), "quick", tmp_path, "npz")
    known = {"shape": "stiffness", "file": str(tmp_path / "lower.npz"), "contact": "contact", "held": "grip", **BODY}
    meshes = PointRun.of(point_study(tables | {"bodies": bodies | {"lower": known}}, "s"), "quick").meshes
    assert (len(meshes.stages), meshes.sticking) == (1, None)


@pytest.mark.parametrize(
    ("spoilt", "says"),
    [
        (lambda data: data["stiffness_N_per_mm"].__setitem__((0, 5), 1e6), "is not symmetric"),
        (lambda data: data["stiffness_N_per_mm"].__setitem__((2, 2), 1e9), "rigid displacement along z"),
        (lambda data: data.update(grip=data["grip"][:2]), "fewer than three"),
        (lambda data: data.update(contact=data["contact"][:-1]), "no grid"),
        (lambda data: data.update(nodes_mm=data["nodes_mm"][1:]), "does not fit"),
        (lambda data: data.pop("grip"), "no set 'grip'"),
    ],
)
def test_what_is_no_stiffness_of_a_body_is_refused_in_a_sentence(
    written: Path, tmp_path: Path, spoilt: object, says: str
) -> None:
    with np.load(written) as archive:
        data = dict(archive)
    spoilt(data)  # type: ignore[operator]
    np.savez(tmp_path / "bad.npz", **data)
    with pytest.raises(GeometryError, match=says):
        of_stiffness(source(tmp_path / "bad.npz"))


def test_a_stiffness_that_is_not_positive_is_refused(written: Path, tmp_path: Path) -> None:
    with np.load(written) as archive:
        data = dict(archive)
    np.savez(tmp_path / "bad.npz", **(data | {"stiffness_N_per_mm": -data["stiffness_N_per_mm"]}))
    assert read_stiffness(source(tmp_path / "bad.npz")).held.size == 3
    with pytest.raises(StudyError, match="not positive definite"):
        condensed_body(of_stiffness(source(tmp_path / "bad.npz")), STEEL)


def test_what_a_result_notes_of_a_bodys_file_is_found_from_any_folder(
    written: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (written.parent / "study.toml").write_text(
        'format = 1\nname = "s"\nkind = "point-contact"\n[bodies.lower]\nshape = "flat"\nmaterial = "steel"\n'
        '[bodies.upper]\nshape = "stiffness"\nfile = "ball.npz"\ncontact = "contact"\nheld = "grip"\n'
        'material = "steel"\n[contact]\nfriction = 0.6\n[conditions]\nnormal_load_N = 1.0\n'
        "displacement_amplitude_um = 2.0\nfrequency_Hz = 1.0\ncycles = 1\n"
    )
    monkeypatch.chdir(written.parent)
    noted = load_study("study.toml").resolved()
    monkeypatch.chdir(tmp_path)
    assert point_study(noted, "result").bodies[1].curvatures_per_mm == pytest.approx((0.2, 0.1))
