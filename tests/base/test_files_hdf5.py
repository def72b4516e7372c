"""HDF5 files that are read back carry a checksum, hold all that they show, and are refused in one sentence if not."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import h5py
import numpy as np
import pytest

from tests import synthetic_results
from wirewear import ResultError, RunResult, read_result, write_result
from wirewear.base.hdf5 import GrowingImage, hdf5_image, opened_hdf5, sealed
from wirewear.simulation.store import CHECKPOINT_FILE_NAME, read_checkpoint

FLIPS = 300


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("written") / "result.h5"
    write_result(path, synthetic_results.result())
    return path


def refused_or(read: Callable[[], RunResult]) -> RunResult | str:
    try:
        return read()
    except ResultError as refused:
        return str(refused)


def flipped(data: bytes, random: Random) -> bytes:
    place = random.randrange(len(data))
    return data[:place] + bytes([data[place] ^ (1 << random.randrange(8))]) + data[place + 1 :]


def test_no_flipped_bit_of_a_result_goes_unseen(written: Path, tmp_path: Path) -> None:
    """On version 8318817, 187 of 300 changed bytes gave another result without a word."""
    data, random = written.read_bytes(), Random(13)
    for _ in range(FLIPS):
        (tmp_path / "result.h5").write_bytes(flipped(data, random))
        found = refused_or(lambda: read_result(tmp_path / "result.h5"))
        assert isinstance(found, str)
        assert found.startswith(f"{tmp_path / 'result.h5'} is ")
        assert "\n" not in found


def test_no_flipped_bit_of_a_checkpoint_goes_unseen(tmp_path: Path) -> None:
    data = hdf5_image(lambda file: file.create_group("state").create_dataset("traction", data=np.arange(3000.0)))
    random = Random(14)
    for _ in range(FLIPS):
        (tmp_path / CHECKPOINT_FILE_NAME).write_bytes(flipped(data, random))
        with pytest.raises(ResultError):
            read_checkpoint(tmp_path)


def test_the_file_of_a_run_that_goes_on_holds_what_one_written_at_once_does(tmp_path: Path) -> None:
    image, whole = GrowingImage(), synthetic_results.result(status="running")
    first = len(whole.scars) // len(whole.loops)
    partial_run = replace(whole, loops=whole.loops[:1], scars=whole.scars[:first], quality={}, message="started")
    for run in (partial_run, whole):
        write_result(tmp_path / "growing.h5", run, image)
        write_result(tmp_path / "at_once.h5", run)
        growing, at_once = (files_of(tmp_path / f"{name}.h5") for name in ("growing", "at_once"))
        np.testing.assert_equal(growing, at_once)


def files_of(path: Path) -> dict[str, Any]:
    """Every array and attribute of an HDF5 file by its place."""
    found: dict[str, Any] = {}

    def note(name: str, item: h5py.Dataset | h5py.Group) -> None:
        found.update({f"{name}@{key}": value for key, value in item.attrs.items()})
        if isinstance(item, h5py.Dataset):
            found[name] = item[()]

    with opened_hdf5(path, ResultError, "result file") as file:
        file.visititems(note)
    return found


def test_a_file_of_format_1_without_checksum_is_still_read(written: Path, tmp_path: Path) -> None:
    path = tmp_path / "old.h5"
    path.write_bytes(written.read_bytes()[: -len(sealed(b""))])
    with pytest.raises(ResultError, match="its checksum is missing"):
        read_result(path)
    with h5py.File(path, "r+") as file:
        file.attrs["format"] = 1
    assert read_result(path).evolution.keys() == read_result(written).evolution.keys()


def linked(file: Any) -> None:
    file["study"] = h5py.ExternalLink("/etc/passwd", "/study")


def kept_elsewhere(file: Any) -> None:
    file.create_dataset("study", (10,), "i1", external=[("/etc/passwd", 0, 10)])


def soft(file: Any) -> None:
    file["study"] = h5py.SoftLink("/header")


def huge(file: Any) -> None:
    file.create_dataset("study", (1 << 40,), "f8", chunks=(1024,))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (linked, "refers to another place by 'study', which is not followed"),
        (soft, "refers to another place by 'study', which is not followed"),
        (kept_elsewhere, "keeps 'study' in another file, which is not followed"),
        (huge, "cannot hold the arrays that it states"),
    ],
)
def test_a_file_that_reaches_beyond_it_is_refused(tmp_path: Path, change: Callable[[Any], None], words: str) -> None:
    path = tmp_path / "result.h5"
    path.write_bytes(hdf5_image(change))
    with pytest.raises(ResultError, match=rf"^{path} .*{words}\.$"):
        read_result(path)


def test_groups_that_lead_back_up_end(tmp_path: Path) -> None:
    def fill(file: Any) -> None:
        file.create_group("a")["up"] = file["/"]

    path = tmp_path / "circle.h5"
    path.write_bytes(hdf5_image(fill))
    with opened_hdf5(path, ResultError, "result file") as file:
        assert list(file) == ["a"]
