"""Grids of VTK's: written whole, or an error that a command can say."""

import resource
import signal
from pathlib import Path

import numpy as np
import pytest
import pyvista

from wirewear.base.errors import RunError
from wirewear.base.writing import usable_folder, write_grid


def test_a_grid_that_a_full_disk_refuses_leaves_the_earlier_file(tmp_path: Path) -> None:
    grid = pyvista.ImageData(dimensions=(9, 9, 9)).cast_to_unstructured_grid()
    grid.point_data["depth_um"] = np.random.default_rng(0).random(grid.n_points)
    path = write_grid(tmp_path / "grid.vtu", grid)
    before = path.read_bytes()
    handler, limits = signal.signal(signal.SIGXFSZ, signal.SIG_IGN), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) // 2, limits[1]))
    try:
        with pytest.raises(OSError, match="large"):
            write_grid(path, grid)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
    np.testing.assert_array_equal(pyvista.read(path).point_data["depth_um"], grid.point_data["depth_um"])


def test_a_link_to_nowhere_is_named_as_one_where_a_folder_is_wanted(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "nowhere" / "at all")
    with pytest.raises(RunError, match="link that leads nowhere"):
        usable_folder(tmp_path / "link" / "run")
