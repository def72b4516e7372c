"""MATLAB's files as a mapping's sources: both versions, whole and damaged."""

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from tests.test_import import cycle as cycle_of
from tests.test_import import mapped
from wirewear import RecordError
from wirewear.records.importing import import_record
from wirewear.records.importing.mapping import ColumnMapping, Source
from wirewear.records.importing.sources import read_source

cycle = cycle_of

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
