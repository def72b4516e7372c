"""Files that state more than the memory holds, or than they can hold: refused in a sentence before they are read."""

import io
import re
import struct
import tracemalloc
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from tests import strangers_files, strangers_maps
from wirewear.base.delimited import read_delimited
from wirewear.base.errors import RecordError
from wirewear.records.importing.height_maps import height_map
from wirewear.records.importing.mapping import ColumnMapping, Source
from wirewear.records.importing.sources import read_source

HEAD = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM"

BYTES = 15_000_000


def element(kind: int, body: bytes) -> bytes:
    return struct.pack("<II", kind, len(body)) + body


def array(kind: int, dimensions: tuple[int, int], contents: bytes) -> bytes:
    """An array of a class, named x."""
    flags = element(6, struct.pack("<II", kind, 0))
    name = struct.pack("<HH", 1, 1) + b"x\0\0\0"
    return element(14, flags + element(5, struct.pack("<ii", *dimensions)) + name + contents)


def matlab(path: Path) -> None:
    read_source(path, Source(files=(path.name,)), {"displacement_um": ColumnMapping(column="x")})


@pytest.mark.parametrize(
    ("what", "body"),
    [
        ("dimensions that no file holds", array(6, (100_000, 100_000), element(2, bytes(64)))),
        ("a byte each that becomes a number", array(6, (1, BYTES), element(2, bytes(BYTES)))),
        ("cells without end", array(1, (1, 1_000_000), element(14, b"") * 1_000_000)),
    ],
)
def test_a_matlab_file_that_would_fill_the_memory_is_refused_before_it_is_read(
    tmp_path: Path, what: str, body: bytes
) -> None:
    path = tmp_path / "loops.mat"
    path.write_bytes(HEAD + element(15, zlib.compress(body, 9)))
    tracemalloc.start()
    with pytest.raises(RecordError, match=r"loops.mat of .* states contents of .*: it is damaged, or made to fill"):
        matlab(path)
    # As many bytes as the refusal itself looks at, and no more.
    assert tracemalloc.get_traced_memory()[1] < 20e6, what
    tracemalloc.stop()


def zipped(path: Path, names: tuple[str, ...], size: int) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as parts:
        for name in names:
            parts.writestr(name, bytes(size))
    return path


def test_a_zipped_map_and_a_spreadsheet_of_zeros_are_refused_before_they_are_unpacked(tmp_path: Path) -> None:
    refusal = r"of \d+ kB states contents of .*: it is damaged, or made to fill the memory"
    with pytest.raises(RecordError, match=refusal):
        height_map(zipped(tmp_path / "map.x3p", ("main.xml", "bindata/data.bin"), 14_000_000))
    with pytest.raises(RecordError, match=refusal):
        read_delimited(zipped(tmp_path / "book.xlsx", ("xl/workbook.xml", "xl/a.xml", "xl/b.xml"), 36_000_000))


@pytest.mark.seconds
def test_a_large_text_that_is_no_map_is_refused_without_being_read(tmp_path: Path) -> None:
    """SurfaceTopography took 160 bytes a byte, and a second a megabyte."""
    path = tmp_path / "map.txt"
    path.write_text(" ".join(["1.25"] * 300) + "\n" + ("1.25 " * 300 + "\n") * 800, encoding="ascii")
    tracemalloc.start()
    with pytest.raises(RecordError, match=r"map.txt"):
        height_map(path)
    assert tracemalloc.get_traced_memory()[1] < 30e6
    tracemalloc.stop()


@pytest.mark.parametrize("step", [5000.0, 0.005], ids=["nm", "mm"])
def test_a_map_of_nanofocus_is_as_wide_as_its_field_whichever_unit_its_steps_are_in(
    tmp_path: Path, step: float
) -> None:
    """The format says mm; files in public say 312.5 for a field of 160 µm and 512 points."""
    nms = pytest.importorskip("SurfaceTopography.IO.NMS", exc_type=ImportError)
    _, _, heights = strangers_maps.surface()
    low, high = float(heights.min()), float(heights.max())
    data = bytearray(nms._HEADER_SIZE)
    struct.pack_into("<dd", data, nms._OFFSET_Z, low, high)
    struct.pack_into("<IIdd", data, nms._OFFSET_POINTS, strangers_maps.COLUMNS, strangers_maps.ROWS, step, step)
    levels = np.round((heights.T - low) / (high - low) * (2**16 - 2)).astype("<u2")
    stream = io.BytesIO()
    stream.write(bytes(data) + levels.tobytes())
    (tmp_path / "map.nms").write_bytes(stream.getvalue())
    x, y, read = height_map(tmp_path / "map.nms")
    assert np.ptp(x) == pytest.approx(strangers_maps.STEP_um * (strangers_maps.COLUMNS - 1), rel=1e-6)
    assert np.ptp(y) == pytest.approx(strangers_maps.STEP_um * (strangers_maps.ROWS - 1), rel=1e-6)
    np.testing.assert_allclose(read, heights, atol=1e-3)


def test_two_channels_of_one_matlab_matrix_are_asked_for(tmp_path: Path) -> None:
    savemat(tmp_path / "loops.mat", {"hyst": np.stack([strangers_files.X, strangers_files.FORCE], axis=1)})
    source = Source(files=("loops.mat",), kind="matlab")
    both = {name: ColumnMapping(column="hyst") for name in ("displacement_um", "tangential_force_N")}
    asked = "stands for displacement_um and tangential_force_N: say which part of it each one is, such as 'hyst(:,1)'"
    with pytest.raises(RecordError, match=re.escape(asked)):
        read_source(tmp_path / "loops.mat", source, both)
    parts = {name: ColumnMapping(column=f"hyst(:,{place})") for place, name in enumerate(both, 1)}
    read = read_source(tmp_path / "loops.mat", source, parts)
    np.testing.assert_array_equal(read["tangential_force_N"], strangers_files.FORCE)
    with pytest.raises(RecordError, match=r"'hyst\(:,3\)' lies outside of the variable, which is 512 × 2"):
        read_source(tmp_path / "loops.mat", source, {"displacement_um": ColumnMapping(column="hyst(:,3)")})
