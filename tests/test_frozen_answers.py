"""The comparison of frozen answers names every difference, and nothing else."""

import json
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from tools.differences import TOLERANCE, tree_differences

FORCE = np.array([1.0, -1.0, 1e-9])


def answers(folder: Path) -> Path:
    """A result, a diagnosis and a record, small."""
    folder.mkdir()
    with h5py.File(folder / "result.h5", "w") as file:
        file.attrs["format"] = 1
        file["loops/0000/tangential_force_N"] = FORCE
        file["quality"] = json.dumps({"force_balance": 2e-9})
        file["timings_s"] = json.dumps({"total": 12.0})
    causes = [{"effect": "free_play", "probability": 0.71}, {"effect": "none", "probability": 0.2}]
    (folder / "diagnosis.json").write_text(json.dumps({"verdict": "explained", "causes": causes, "spans": [1.0, 2.0]}))
    (folder / "loops.csv").write_text("time_s,force_N\n0.0,1.25\n0.1,-1.25\n")
    (folder / "experiment.toml").write_text('name = "a record"\n[stated]\nfriction = 0.62\n')
    return folder


def changed_hdf5(name: str, value: object) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        with h5py.File(folder / "result.h5", "r+") as file:
            del file[name]
            file[name] = value

    return change


def changed_text(name: str, old: str, new: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        text = (folder / name).read_text()
        assert old in text
        (folder / name).write_text(text.replace(old, new))

    return change


def found(tmp_path: Path, change: Callable[[Path], None]) -> list[str]:
    frozen, present = answers(tmp_path / "frozen"), answers(tmp_path / "present")
    change(present)
    return [str(one) for one in tree_differences(frozen, present, TOLERANCE)]


@pytest.mark.parametrize(
    "change",
    [
        lambda _: None,
        changed_hdf5("timings_s", json.dumps({"total": 99.0})),
        # Round-off of the largest entry, though large beside the entry itself.
        changed_hdf5("loops/0000/tangential_force_N", FORCE + np.array([0.0, 0.0, 5e-13])),
    ],
)
def test_times_and_round_off_are_no_differences(tmp_path: Path, change: Callable[[Path], None]) -> None:
    assert found(tmp_path, change) == []


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (
            changed_hdf5("loops/0000/tangential_force_N", FORCE + np.array([0.0, 3e-12, 0.0])),
            r"result.h5: loops/0000/tangential_force_N was -1 and is -0.999999999997 at entry 1 of 3: 3.0e-12",
        ),
        (changed_hdf5("loops/0000/tangential_force_N", FORCE[:2]), "had the shape (3,) and has (2,)"),
        (changed_hdf5("loops/0000/tangential_force_N", FORCE * np.array([1, 1, np.nan])), "not finite in other places"),
        (changed_hdf5("quality", json.dumps({"force_balance": 3e-9})), "result.h5: quality/force_balance was 2e-09"),
        (changed_text("diagnosis.json", "0.71", "0.72"), "diagnosis.json: causes/0/probability was 0.71 and is 0.72"),
        (changed_text("diagnosis.json", "explained", "no_gap"), "verdict was 'explained' and is 'no_gap'"),
        (changed_text("loops.csv", "-1.25", "-1.26"), "loops.csv: force_N was -1.25 and is -1.26 at entry 1 of 2"),
        (changed_text("experiment.toml", "friction", "grip"), "experiment.toml: stated/friction is missing"),
        (lambda folder: (folder / "loops.csv").unlink(), "loops.csv is missing"),
        (lambda folder: (folder / "more.csv").write_text("a\n1\n"), "more.csv is new"),
    ],
)
def test_a_difference_is_named_with_its_file_place_and_size(
    tmp_path: Path, change: Callable[[Path], None], said: str
) -> None:
    sentences = found(tmp_path, change)
    assert any(said in sentence for sentence in sentences), sentences
    assert len(sentences) <= 2
