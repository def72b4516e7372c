"""The cache of condensed wires does not grow without bound."""

import os
from pathlib import Path

import pytest

from wirewear.base.cache import keep_within, mark_used


@pytest.fixture
def wires(tmp_path: Path) -> list[Path]:
    """Four wires of 100 bytes, the first one unused for longest."""
    paths = [tmp_path / f"wire-{name}.npz" for name in "dcba"]
    for age, path in enumerate(paths):
        path.write_bytes(bytes(100))
        os.utime(path, (1e9 + age, 1e9 + age))
    return paths


def test_wires_unused_for_longest_go_first(wires: list[Path]) -> None:
    keep_within(wires[0].parent, 250.0)
    assert [path.exists() for path in wires] == [False, False, True, True]


def test_a_wire_that_is_used_stays(wires: list[Path]) -> None:
    mark_used(wires[0])
    keep_within(wires[0].parent, 200.0)
    assert [path.exists() for path in wires] == [True, False, False, True]


def test_other_files_stay_and_abandoned_parts_of_wires_go(tmp_path: Path) -> None:
    mine, left = tmp_path / "notes.txt", tmp_path / ".wire-a.npz.1.partial"
    fresh = tmp_path / ".wire-b.npz.2.partial"
    for path in (mine, left, fresh):
        path.write_bytes(bytes(100))
    os.utime(left, (1e9, 1e9))
    keep_within(tmp_path, 0.0)
    assert [path.exists() for path in (mine, left, fresh)] == [True, False, True]
