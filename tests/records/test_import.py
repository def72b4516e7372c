"""Files as laboratories have them, MATLAB's and profilometers' among them, turned into records by a mapping."""

import os
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from tests.records.loop_files import GERMAN, SAMPLES, FREQUENCY_Hz, german, mapped
from wirewear import RecordError, check_record
from wirewear.records.importing import import_record
from wirewear.records.importing.guessed_conditions import frequency_of
from wirewear.records.importing.loggers import kind_of
from wirewear.records.importing.mapping import ColumnMapping, Source
from wirewear.records.importing.sources import read_source


def test_one_file_a_cycle_with_decimal_commas_other_units_and_encoding(tmp_path: Path, cycle: Any) -> None:
    for number in (2, 10, 100):
        for repeat in (1, 2):
            (tmp_path / f"cycle_{number}_rep{repeat}.txt").write_bytes(german(*cycle).encode("latin-1"))
    record = import_record(mapped(tmp_path, GERMAN))
    assert record.repeats == (1, 2)
    assert record.cycles == (2, 10, 100)
    loop = record.loop(2, 10)
    np.testing.assert_allclose(loop.displacement_um, cycle[1], atol=1e-4)
    np.testing.assert_allclose(loop.tangential_force_N, cycle[2], atol=1e-6)
    assert loop.normal_force_N is None
    assert not check_record(record).problems


def test_a_continuous_log_is_cut_into_cycles_by_frequency_and_its_rest_left_out(tmp_path: Path, cycle: Any) -> None:
    _, displacement, force = cycle
    x, q = np.tile(displacement, 4)[:-40], np.tile(force, 4)[:-40]
    rows = "\n".join(f"{a:.5f}\t{b:.6f}\t0.5" for a, b in zip(x, q, strict=True))
    (tmp_path / "log.tsv").write_text(rows, encoding="utf-8")
    loops = f"""
[loops]
files = "log.tsv"
delimiter = "tab"
names_line = false
sample_rate_Hz = {SAMPLES * FREQUENCY_Hz}
first_cycle = 51
[loops.columns]
displacement_um = 1
tangential_force_N = 2
normal_force_N = {{ column = 3, unit = "V", factor = 4.0 }}
"""
    record = import_record(mapped(tmp_path, loops))
    assert record.cycles == (51, 52, 53)
    assert {loop.time_s.size for loop in record.loops} == {SAMPLES}
    last = record.loop(1, 53)
    np.testing.assert_allclose(last.displacement_um, displacement, atol=1e-4)
    assert last.normal_force_N is not None
    np.testing.assert_allclose(last.normal_force_N, 2.0)
    assert last.time_s[0] == 0.0


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"Weg"', '"Hub"', r"cycle_1_rep1.txt, line 6: there is no column 'Hub' among 'Zeit, Weg, Kraft'"),
        ('"Weg"', '"weg"', r"there is no column 'weg' among 'Zeit, Weg, Kraft'; did you mean 'Weg'\?"),
        ('unit = "mN"', 'unit = "MN"', r"tangential_force_N cannot be in 'MN': the units known there are N, mN, kN"),
        ('unit = "mN", factor = -1.0', 'unit = "V"', r"needs a factor in N per volt"),
        ('decimal = ","', 'decimal = "."', r'line 8, column Weg: .* is no number, or decimal = "," is meant'),
        ("header_lines = 5", "header_lines = 500", r"line 503: there are no numbers below the header"),
        ('"cycle_*.txt"', '"loop_*.txt"', r"there is no file .*loop_\*\.txt"),
        ("_rep(?P<repeat>", "-rep(?P<repeat>", r"does not fit name_pattern"),
        ("name_pattern", "# name_pattern", None),
        ('"latin-1"', '"utf-8"', r"cycle_1_rep1.txt, line \d: this is not text in UTF-8"),
        ('"latin-1"', '"klingon"', r"must be an encoding of text such as"),
        ('"semicolon"', '"pipe"', r'must be one of "comma", "semicolon", "tab", "whitespace", or the sign itself'),
        ("tangential_force_N =", "tangential_force_mN =", r"tangential_force_N"),
        ("[loops.columns]", "[loops.column]", r"line \d+"),
    ],
)  # fmt: skip
def test_mistakes_in_mappings_are_a_sentence(tmp_path: Path, cycle: Any, old: str, new: str, words: str | None) -> None:
    (tmp_path / "cycle_1_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    assert old in GERMAN
    path = mapped(tmp_path, GERMAN.replace(old, new))
    if words is None:
        # Without a pattern the file is cut by its time.
        assert import_record(path).cycles == (1,)
        return
    with pytest.raises(RecordError, match=words) as caught:
        import_record(path)
    assert "\n" not in str(caught.value)


MATLAB = """
[loops]
files = "loops.mat"
kind = "matlab"
[loops.columns]
displacement_um = "test.disp"
tangential_force_N = "test.force"
time_s = "test.time"
cycle = "test.cycles"
"""


def write_matlab(path: Path, variables: dict[str, Any], version: float) -> None:
    """The variables as members of one structure named "test"."""
    if version == 5:
        savemat(path, {"test": variables})
        return
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in variables.items():
            file[f"test/{name}"] = np.atleast_2d(values).T if values.ndim == 2 else values[:, None].T
    # The head by which scipy knows a file of version 7.3.
    data = bytearray(path.read_bytes())
    data[:128] = b"MATLAB 7.3 MAT-file".ljust(124) + bytes([0, 2]) + b"IM"
    path.write_bytes(bytes(data))


@pytest.mark.parametrize("version", [5, 7.3])
def test_matlab_matrices_of_one_column_a_cycle(tmp_path: Path, cycle: Any, version: float) -> None:
    time, displacement, force = cycle
    cycles = np.array([1.0, 10.0, 500.0])
    variables = {
        "time": time,
        "disp": np.outer(displacement, [1.0, 0.99, 0.98]),
        "force": np.outer(force, [1, 1, 1]),
        "cycles": cycles,
    }
    write_matlab(tmp_path / "loops.mat", variables, version)
    record = import_record(mapped(tmp_path, MATLAB))
    assert record.cycles == (1, 10, 500)
    np.testing.assert_allclose(record.loop(1, 500).displacement_um, 0.98 * displacement)
    np.testing.assert_allclose(record.loop(1, 10).time_s, time)


def damaged(data: bytes, seed: int, *, first: int) -> bytes:
    """Cut off somewhere, or with a few bytes from `first` on replaced."""
    random = np.random.default_rng(seed)
    if seed % 3 == 0:
        return data[: random.integers(1, len(data))]
    changed = bytearray(data)
    for place in random.integers(first, len(data), 1 + seed % 8):
        changed[place] = random.integers(256)
    return bytes(changed)


@pytest.mark.parametrize("version", [5, 7.3])
def test_a_damaged_matlab_file_is_read_or_refused_in_one_sentence_with_its_name(tmp_path: Path, version: float) -> None:
    path = tmp_path / "loops.mat"
    write_matlab(path, {"disp": np.arange(40.0).reshape(8, 5), "force": np.ones((8, 5))}, version)
    whole = path.read_bytes()
    source = Source(files=("loops.mat",), kind="matlab")
    wanted = {"displacement_um": ColumnMapping(column="test.disp")}
    # Changed bytes of version 5 can crash scipy itself; files that were cut off are what happens.
    seeds = range(0, 180, 3) if version == 5 else range(180)
    refusals = []
    for seed in seeds:
        path.write_bytes(damaged(whole, seed, first=512))
        try:
            read_source(path, source, wanted)
        except RecordError as refusal:
            refusals.append(str(refusal))
    assert len(refusals) > len(seeds) / 4
    assert all("\n" not in text and str(path) in text for text in refusals)


PROFILE = """
[scars.{wire}]
files = "map.txt"
kind = "profilometer"
axis = "{axis}"
"""


@pytest.mark.parametrize(("wire", "axis"), [("moving", "x"), ("fixed", "x"), ("moving", "y")])
def test_a_map_of_a_tilted_wire_gives_the_depth_of_its_scar(tmp_path: Path, cycle: Any, wire: str, axis: str) -> None:
    """A bowl of 12 µm, 120 µm long and 60 µm wide, in a wire of 225 µm radius, off centre, tilted, turned, noisy."""
    pytest.importorskip("SurfaceTopography.IO", exc_type=ImportError)
    (tmp_path / "cycle_1_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    along, across = np.arange(-250.0, 250.0, 4.0)[:, None], np.arange(-150.0, 150.0, 4.0)[None, :]
    bowl = 12.0 * np.maximum(1.0 - ((along - 30.0) / 120.0) ** 2 - ((across - 10.0) / 60.0) ** 2, 0.0)
    crown = across - 10.0 - 0.01 * along
    height = 7.0 + 0.02 * along + np.sqrt(225.0**2 - crown**2) - bowl
    height += 0.05 * np.random.default_rng(1).standard_normal(height.shape)
    table = height if axis == "x" else height.T
    width, length = table.shape[0] * 4.0, table.shape[1] * 4.0
    header = f"# Channel: Main\n# Width: {width} µm\n# Height: {length} µm\n# Value units: m\n"
    # A loose bit in two numbers, as a file has come with.
    table[3, 3], table[-3, 5] = 2.5e202, -1e38
    text = "\n".join(" ".join(f"{1e-6 * z:.9e}" for z in row) for row in table.T)
    (tmp_path / "map.txt").write_text(header + text + "\n", encoding="utf-8")
    (scar,) = import_record(mapped(tmp_path, GERMAN + PROFILE.format(wire=wire, axis=axis))).scars
    long_side, short_side = (scar.x_um, scar.y_um) if wire == "moving" else (scar.y_um, scar.x_um)
    assert np.ptp(long_side) > np.ptp(short_side)
    depth = scar.depth_um if wire == "moving" else scar.depth_um.T
    assert np.nanpercentile(depth, 99.9) == pytest.approx(12.0, abs=0.5)
    place = np.unravel_index(int(np.nanargmax(depth)), depth.shape)
    assert abs(long_side[place[0]]) < 20.0
    assert abs(short_side[place[1]]) < 12.0


@pytest.mark.seconds
@pytest.mark.parametrize("width", ["inf", "nan", "0.0"])
def test_a_map_of_no_finite_size_is_refused_in_a_sentence(tmp_path: Path, cycle: Any, width: str) -> None:
    (tmp_path / "cycle_1_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    netcdf_file = pytest.importorskip("scipy.io").netcdf_file
    with netcdf_file(tmp_path / "map.nc", "w") as map_of_heights:
        map_of_heights.createDimension("x", 40)
        map_of_heights.createDimension("y", 30)
        for name, size in (("x", float(width)), ("y", 200.0)):
            axis = map_of_heights.createVariable(name, "f8", (name,))
            axis[:] = 0.0
            axis.length, axis.length_unit = size, "um"
        heights = map_of_heights.createVariable("heights", "f8", ("x", "y"))
        heights[:] = 0.0
        heights.length_unit = "um"
    scar = PROFILE.format(wire="moving", axis="x").replace("map.txt", "map.nc")
    with pytest.raises(RecordError, match=r"map\.nc.*(finite size above zero|state its scale|cannot be read)"):
        import_record(mapped(tmp_path, GERMAN + scar))


def test_a_map_that_states_no_scale_is_read_by_what_the_mapping_states(tmp_path: Path, cycle: Any) -> None:
    """A matrix of numpy has neither size nor unit; steps along y are longer."""
    (tmp_path / "cycle_1_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    x, y = np.arange(-200.0, 200.0, 4.0)[:, None], np.arange(-150.0, 150.0, 6.0)[None, :]
    height = np.sqrt(225.0**2 - y**2) - 12.0 * np.maximum(1.0 - (x / 120.0) ** 2 - (y / 60.0) ** 2, 0.0)
    np.save(tmp_path / "map.npy", 1e3 * height)
    source = PROFILE.format(wire="moving", axis="x").replace("map.txt", "map.npy")
    with pytest.raises(
        RecordError, match=r"map\.npy does not state its scale: the mapping must give step_um and height_"
    ):
        import_record(mapped(tmp_path, GERMAN + source))
    with pytest.raises(RecordError, match=r"does not state its scale: the mapping must give height_unit\."):
        import_record(mapped(tmp_path, GERMAN + source + "step_um = 4.0\n"))
    scale = 'step_um = 4.0\nstep_y_um = 6.0\nheight_unit = "nm"\n'
    (scar,) = import_record(mapped(tmp_path, GERMAN + source + scale)).scars
    assert scar.volume_mm3 == pytest.approx(1e-9 * 0.5 * np.pi * 120.0 * 60.0 * 12.0, rel=0.01)


@pytest.mark.parametrize("place", ["files", "file"])
@pytest.mark.parametrize("kind", ["link", "pipe", "link to a device", "nothing"])
def test_a_column_and_a_source_take_only_ordinary_files_of_their_folder(tmp_path: Path, place: str, kind: str) -> None:
    home = tmp_path / "home"
    home.mkdir()
    rows = "displacement_um,tangential_force_N\n" + "".join(f"{k % 7},{k % 5}\n" for k in range(50))
    for path in (home / "loops.csv", tmp_path / "elsewhere.csv"):
        path.write_text(rows, encoding="utf-8")
    other = home / "other.csv"
    if kind == "pipe":
        os.mkfifo(other)
    elif kind.startswith("link"):
        other.symlink_to("/dev/zero" if "device" in kind else tmp_path / "elsewhere.csv")
    files, own = ('"other.csv"', "") if place == "files" else ('"loops.csv"', ', file = "other.csv"')
    path = mapped(
        home,
        f"[loops]\nfiles = {files}\n[loops.columns]\ndisplacement_um = 1\ntangential_force_N = {{ column = 2{own} }}\n",
    )
    with pytest.raises(RecordError, match=r"leads out of the folder|is no ordinary file|there is no file"):
        import_record(path)


def test_a_pipe_is_no_file_of_loops(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "loops.csv")
    with pytest.raises(RecordError, match="is no ordinary file"):
        kind_of(tmp_path / "loops.csv")


@pytest.mark.parametrize("cycles", [1, 2])
@pytest.mark.parametrize("labelled", [True, False])
def test_samples_spread_unevenly_over_a_cycle_show_its_frequency(labelled: bool, cycles: int) -> None:
    even = (np.arange(40 * cycles) + 0.3) / 40.0
    phase = even + 0.08 * np.sin(2.0 * np.pi * even)
    columns = {"time_s": phase / 5.0, "displacement_um": 60.0 * np.cos(2.0 * np.pi * phase)}
    columns |= {"cycle": 1.0 + np.floor(phase)} if labelled else {}
    found, doubt = frequency_of(columns, {})
    assert found == pytest.approx(5.0, rel=1e-3)
    assert doubt == ""
