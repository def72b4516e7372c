"""A laboratory's files of a line contact: a mapping guessed, imported, drawn; a study made of the record."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from geometry import Cylinder, Flat, RoundedFlat
from tests.logger_files import CYLINDER, FLAT, LOAD_N, LENGTH_mm, line_record, write_line_german
from wirewear.base.errors import RecordError
from wirewear.faces import cli
from wirewear.records import check_record, read_record
from wirewear.records.importing import import_record
from wirewear.records.importing.profilometry import levelled


def wirewear(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


OPTIONS = {
    "cylinder": (CYLINDER, ("--radius", 6.0)),
    "rounded flat": (FLAT, ("--face-half-width", 0.3, "--edge-radius", 3.0)),
}


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("face", OPTIONS)
def test_a_guessed_mapping_gives_the_record_that_the_files_were_made_of(tmp_path: Path, face: str) -> None:
    keys, options = OPTIONS[face]
    truth = line_record(keys)
    guessed = wirewear("new", "--mapping", *write_line_german(truth, tmp_path), "--length", LENGTH_mm, *options)
    assert guessed.exit_code == 0, guessed.output
    imported = wirewear("import", tmp_path / "mapping.toml", "--output", tmp_path / "record")
    assert imported.exit_code == 0, imported.output
    record = read_record(tmp_path / "record")
    assert record.tables.pad.profile == truth.tables.pad.profile
    assert record.tables.conditions.normal_load_N == pytest.approx(LOAD_N)
    assert record.tables.conditions.cycles == 1000
    assert record.tables.conditions.frequency_Hz == pytest.approx(4.0, rel=1e-3)
    for own, other in zip(record.loops, truth.loops, strict=True):
        assert (own.repeat, own.cycle) == (other.repeat, other.cycle)
        np.testing.assert_allclose(own.displacement_um, other.displacement_um, atol=1e-3)
        np.testing.assert_allclose(own.tangential_force_N, other.tangential_force_N, atol=1e-3)
    for body in ("pad", "specimen"):
        for made, worn in zip(record.scars_of(body), truth.scars_of(body), strict=True):
            assert made.depth_um.max() == pytest.approx(worn.depth_um.max(), abs=0.08)
            assert made.area_um2 == pytest.approx(worn.area_um2, rel=0.02)
            assert sum(made.edges_um) == pytest.approx(0.0, abs=12.0)
    assert not check_record(record).problems


@pytest.mark.parametrize("face", [Flat(), Cylinder(6.0, curved_along=True), RoundedFlat(0.3, 3.0)])
def test_a_fitted_face_does_not_follow_the_scar_nor_what_is_piled_up_beside_it(face: Flat) -> None:
    x = np.linspace(-600.0, 600.0, 801)
    worn = 3.0 * np.maximum(1.0 - (x / 380.0) ** 2, 0.0) - 0.8 * np.exp(-(((x - 420.0) / 25.0) ** 2))
    own = 1e3 * face.height(np.column_stack([1e-3 * (x + 15.0), 0.0 * x]))
    height = own + 7.0 - 0.004 * x - worn + 0.02 * np.random.default_rng(2).standard_normal(x.size)
    found = levelled(Path("x"), 1, "pad", face, (x, height), subtract=True).depth_um
    np.testing.assert_allclose(found, worn, atol=0.12)
    assert found.min() == pytest.approx(worn.min(), abs=0.1)


MAPPING = """
format = 1
name = "stylus"
[contact]
kind = "cylinder-on-flat"
length_mm = 8.0
[pad]
radius_mm = 6.0
material = "steel"
[specimen]
material = "Ti-6Al-4V"
[conditions]
normal_load_N_per_mm = 20.0
displacement_amplitude_um = 60.0
frequency_Hz = 4.0
cycles = 1000
[stated]
friction = 0.6
[profiles.specimen]
files = "depth.csv"
delimiter = "semicolon"
decimal = ","
[profiles.specimen.columns]
x_um = { column = "x", unit = "mm" }
depth_um = "t"
"""


def mapped(folder: Path, text: str = MAPPING) -> Path:
    (folder / "depth.csv").write_text("x;t\n-0,3;0\n-0,1;1,5\n0;2,0\n0,1;\n0,3;-0,2\n", encoding="utf-8")
    (folder / "mapping.toml").write_text(text, encoding="utf-8")
    return folder / "mapping.toml"


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("normal_load_N_per_mm = 20.0", "", "gives neither of normal_load_N"),
        ("[stated]", "normal_load_N = 160.0\n[stated]", "gives both of normal_load_N"),
        ("radius_mm = 6.0", "", "does not say which face the pad has"),
        ('"cylinder-on-flat"', '"ball"', 'must be "line-contact" or "cylinder-on-flat"'),
        ("length_mm = 8.0", "", "missing key 'length_mm'"),
        ('depth_um = "t"', "", "must give either depth_um or height_um"),
        ('depth_um = "t"', 'height_um = "t"', "needs 20 points"),
        ('depth_um = "t"', 'depth_um = "tiefe"', "tiefe"),
        ('unit = "mm"', 'unit = "N/mm"', "cannot be in 'N/mm'"),
        ('"depth.csv"', '"none.csv"', "there is no file"),
        ('"depth.csv"', '["depth.csv", "depth.csv"]\nname_pattern = "(?P<repeat>)depth"', "no whole numbers"),
        ("[profiles.specimen", "[profiles.specimens", "specimens"),
        (MAPPING[MAPPING.index("[profiles.specimen]") :], "", "maps nothing"),
    ],
)
def test_a_wrong_mapping_is_one_sentence(tmp_path: Path, old: str, new: str, complaint: str) -> None:
    assert old in MAPPING
    with pytest.raises(RecordError, match=complaint) as told:
        import_record(mapped(tmp_path, MAPPING.replace(old, new)))
    assert "\n" not in str(told.value)
