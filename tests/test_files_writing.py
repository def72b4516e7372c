"""Files are written in one step: killed, crossed or out of space, what was there before is there still."""

import os
import re
import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from wirewear.base.errors import ResultError
from wirewear.base.writing import (
    folder_in_one_step,
    write_bytes,
    write_text,
    writing,
)

WRITER = """
import sys
from pathlib import Path
from wirewear.base.writing import in_one_step

with in_one_step(Path(sys.argv[1])) as partial:
    partial.write_text("half of it")
    print("begun", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def slow_writer(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A process that is in the middle of writing result.txt."""
    command = [sys.executable, "-c", WRITER, str(tmp_path / "result.txt")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "begun\n"
        yield process
        process.kill()


def test_a_killed_writer_leaves_the_old_file_and_the_next_one_clears_up(
    tmp_path: Path, slow_writer: subprocess.Popen[str]
) -> None:
    path = tmp_path / "result.txt"
    path.write_text("old")
    slow_writer.kill()
    slow_writer.wait()
    assert path.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 2
    write_text(path, "new")
    assert [file.name for file in tmp_path.iterdir()] == ["result.txt"]
    assert path.read_text() == "new"


def test_a_file_too_large_for_the_disk_leaves_the_old_one(tmp_path: Path) -> None:
    path = tmp_path / "result.bin"
    write_bytes(path, b"old")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10_000, limits[1]))
    try:
        with (
            pytest.raises(ResultError, match=r"^cannot write it: file too large\.$"),
            writing(ResultError, "cannot write it"),
        ):
            write_bytes(path, bytes(20_000))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert path.read_bytes() == b"old"
    assert [file.name for file in tmp_path.iterdir()] == ["result.bin"]


def test_contents_reach_the_disk_before_the_name_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    steps = []
    synchronise, replace = os.fsync, Path.replace

    def fsync(descriptor: int) -> None:
        steps.append(f"sync {Path(f'/proc/self/fd/{descriptor}').readlink().name}")
        synchronise(descriptor)

    def replaced(self: Path, target: Path) -> Path:
        steps.append(f"name {target.name}")
        return replace(self, target)

    monkeypatch.setattr(os, "fsync", fsync)
    monkeypatch.setattr(Path, "replace", replaced)
    write_text(tmp_path / "result.txt", "new")
    assert re.fullmatch(rf"sync \.result\..*\.partial\.txt, name result\.txt, sync {tmp_path.name}", ", ".join(steps))


def test_a_folder_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    target = tmp_path / "case_001"
    with pytest.raises(ValueError, match="embedded"), folder_in_one_step(target) as partial:
        (partial / "loops.csv\0").write_text("half of it")
    assert not list(tmp_path.iterdir())
    with folder_in_one_step(target) as partial:
        (partial / "loops.csv").write_text("all of it")
        assert not target.exists()
    assert (target / "loops.csv").read_text() == "all of it"
    with pytest.raises(OSError, match="not empty"), folder_in_one_step(target) as partial:
        (partial / "loops.csv").write_text("another")
    assert (target / "loops.csv").read_text() == "all of it"
    assert [folder.name for folder in tmp_path.iterdir()] == ["case_001"]
