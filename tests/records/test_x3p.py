"""X3P maps as different writers leave them: read whatever the spelling, or refused with X3P's own reason."""

import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.comparison.worn_maps import mapping
from wirewear.base.errors import RecordError
from wirewear.records.importing import import_record
from wirewear.records.importing.height_maps import height_map

STEP_um, SHAPE = 8.0, (30, 25)
HEIGHTS_m = 1e-6 * np.arange(float(SHAPE[0] * SHAPE[1])).reshape(SHAPE)
SPACE = 'xmlns:p="http://www.opengps.eu/2008/ISO5436_2"'
AXIS = "<{0}><AxisType>{1}</AxisType><DataType>{2}</DataType><Increment>{3}</Increment><Offset>0</Offset></{0}>"
INDEX = (
    f'<?xml version="1.0" encoding="UTF-8"?>\n<p:ISO5436_2 {SPACE}><Record1><Revision>ISO5436 - 2000</Revision>'
    "<FeatureType>SUR</FeatureType><Axes>"
    + "".join(AXIS.format(*axis) for axis in (("CX", "I", "D", "8e-06"), ("CY", "I", "D", "8e-06")))
    + AXIS.format("CZ", "A", "F", "1")
    + f"</Axes></Record1><Record3><MatrixDimension><SizeX>{SHAPE[0]}</SizeX><SizeY>{SHAPE[1]}</SizeY><SizeZ>1</SizeZ>"
    "</MatrixDimension><DataLink><PointDataLink>bindata/data.bin</PointDataLink></DataLink></Record3></p:ISO5436_2>"
)


def written(path: Path, index: bytes, folder: str = "", data: bytes = HEIGHTS_m.T.astype("<f4").tobytes()) -> Path:
    with zipfile.ZipFile(path, "w") as parts:
        parts.writestr(f"{folder}main.xml", index)
        parts.writestr(f"{folder}bindata/data.bin", data)
    return path


def dashed(text: str) -> str:
    return text.replace("5436 - 2000", "5436 – 2000")


def same(text: str) -> str:
    return text


@pytest.mark.parametrize(
    ("spelled", "encoding", "folder"),
    [
        (same, "utf-8", ""),
        (dashed, "utf-8", ""),
        (dashed, "cp1252", ""),
        (same, "utf-8-sig", "my map/"),
        (lambda text: text.replace(" " + SPACE, ""), "utf-8", ""),
        (lambda text: text.replace("xmlns:p", "xmlns").replace("p:", ""), "utf-8", ""),
        (lambda text: text.replace("bindata/", "bindata\\"), "utf-8", "a/b/"),
    ],
    ids=["standard", "en dash", "en dash in cp1252", "in a folder", "undeclared prefix", "no prefix", "backslash"],
)
def test_x3p_maps_of_any_writer_are_read(
    tmp_path: Path, spelled: Callable[[str], str], encoding: str, folder: str
) -> None:
    x, y, heights = height_map(written(tmp_path / "map.x3p", spelled(INDEX).encode(encoding), folder))
    np.testing.assert_allclose(heights, 1e6 * HEIGHTS_m, rtol=1e-6)
    assert (np.ptp(x), np.ptp(y)) == pytest.approx((29 * STEP_um, 24 * STEP_um))


@pytest.mark.parametrize(("kind", "number"), [("I", "<i2"), ("L", "<i4"), ("D", "<f8")])
def test_x3p_heights_of_every_type_are_scaled_and_points_that_are_not_valid_are_missing(
    tmp_path: Path, kind: str, number: str
) -> None:
    path, steps = tmp_path / "map.x3p", np.arange(HEIGHTS_m.size).reshape(SHAPE)
    text = INDEX.replace("<DataType>F</DataType><Increment>1<", f"<DataType>{kind}</DataType><Increment>2e-09<")
    text = text.replace("</DataLink>", "<ValidPointsLink>bindata/valid.bin</ValidPointsLink></DataLink>")
    written(path, text.encode(), data=steps.T.astype(number).tobytes())
    with zipfile.ZipFile(path, "a") as parts:
        parts.writestr("bindata/valid.bin", np.packbits(steps.T.ravel() != 60, bitorder="little").tobytes())
    _, _, heights = height_map(path)
    np.testing.assert_allclose(heights, np.where(steps == 60, np.nan, 2e-3 * steps))


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("<AxisType>I", "<AxisType>A", "the points of CX do not lie in even steps"),
        ("<SizeX>30", "<SizeX>300000000", "it holds 3000 bytes of heights where 300000000 × 25 points are stated"),
        ("<SizeZ>1", "<SizeZ>4", "it holds 4 layers where one is a map"),
        ("<SizeY>25", "<SizeY>", "gives nothing for Record3/MatrixDimension/SizeY"),
        ("data.bin", "none.bin", "it holds no matrix of heights"),
        ("</p:ISO5436_2>", "", "its main.xml is no XML"),
        ("<Increment>8e-06", "<Increment>", "does not state its scale: the mapping must give step_um"),
        ("<Increment>8e-06", "<Increment>8", r"the map would be 232 m wide, .* give step_um"),
    ],
)
def test_an_x3p_map_that_cannot_be_read_is_refused_with_the_reason_of_its_format(
    tmp_path: Path, old: str, new: str, reason: str
) -> None:
    with pytest.raises(RecordError, match=rf"map\.x3p.*{reason}"):
        height_map(written(tmp_path / "map.x3p", INDEX.replace(old, new).encode()))


def test_a_map_of_another_format_is_refused_with_the_reason_of_its_own_reader(tmp_path: Path) -> None:
    (tmp_path / "map.gwy").write_bytes(bytes(range(256)) * 4)
    with pytest.raises(RecordError, match=r"map\.gwy.*not Gwyddion"):
        height_map(tmp_path / "map.gwy")


@pytest.mark.parametrize(("metres", "said"), [("8", "map would be 232 m wide"), ("8e-3", r"x_um is .*is a unit")])
def test_an_x3p_map_of_impossible_size_makes_no_record_that_check_cannot_read(
    tmp_path: Path, metres: str, said: str
) -> None:
    written(tmp_path / "map.x3p", INDEX.replace("8e-06", metres).encode())
    source = 'kind = "profilometer"\nframe = "test"\nsubtract_wire = false'
    with pytest.raises(RecordError, match=rf"map\.x3p: .*{said}"):
        import_record(mapping(tmp_path, "ball-on-flat", "flat", source, "map.x3p"))
