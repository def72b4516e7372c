"""Maps of profilometers as a mapping's sources: the scar of a tilted wire, damaged files, a library that is absent."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.test_import import GERMAN, german, mapped
from tests.test_import import cycle as cycle_of
from wirewear import RecordError
from wirewear.records.importing import import_record

cycle = cycle_of


PROFILE = """
[scars.{wire}]
files = "map.txt"
kind = "profilometer"
axis = "{axis}"
"""


@pytest.mark.parametrize(("wire", "axis"), [("moving", "x"), ("fixed", "x"), ("moving", "y")])
def test_a_profilometer_map_of_a_tilted_wire_gives_the_depth_of_its_scar(
    tmp_path: Path, cycle: Any, wire: str, axis: str
) -> None:
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


def test_a_map_that_states_no_scale_is_read_by_what_the_mapping_tells(tmp_path: Path, cycle: Any) -> None:
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
    told = 'step_um = 4.0\nstep_y_um = 6.0\nheight_unit = "nm"\n'
    (scar,) = import_record(mapped(tmp_path, GERMAN + source + told)).scars
    assert scar.volume_mm3 == pytest.approx(1e-9 * 0.5 * np.pi * 120.0 * 60.0 * 12.0, rel=0.01)
