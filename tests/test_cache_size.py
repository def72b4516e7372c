"""The cache of condensed wires does not grow without bound."""

import os
from pathlib import Path

import pytest

from wirewear.base.cache import DEFAULT_GB, allowed_bytes, keep_within, mark_used


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


def test_nothing_goes_while_there_is_room(wires: list[Path]) -> None:
    keep_within(wires[0].parent, 400.0)
    assert all(path.exists() for path in wires)


def test_a_wire_that_is_used_stays(wires: list[Path]) -> None:
    mark_used(wires[0])
    keep_within(wires[0].parent, 200.0)
    assert [path.exists() for path in wires] == [True, False, False, True]


def test_the_newest_wire_stays_even_where_it_alone_is_too_large(wires: list[Path]) -> None:
    keep_within(wires[0].parent, 0.0, newest=wires[1])
    assert [path.exists() for path in wires] == [False, True, False, False]


def test_other_files_stay_and_abandoned_parts_of_wires_go(tmp_path: Path) -> None:
    mine, left = tmp_path / "notes.txt", tmp_path / ".wire-a.npz.1.partial"
    fresh = tmp_path / ".wire-b.npz.2.partial"
    for path in (mine, left, fresh):
        path.write_bytes(bytes(100))
    os.utime(left, (1e9, 1e9))
    keep_within(tmp_path, 0.0)
    assert [path.exists() for path in (mine, left, fresh)] == [True, False, True]


@pytest.mark.parametrize(("said", "gigabytes"), [("2.5", 2.5), ("0", 0.0), ("-1", DEFAULT_GB), ("much", DEFAULT_GB)])
def test_the_size_is_what_the_environment_says(monkeypatch: pytest.MonkeyPatch, said: str, gigabytes: float) -> None:
    monkeypatch.setenv("WIREWEAR_CACHE_GB", said)
    assert allowed_bytes() == pytest.approx(1e9 * gigabytes)
