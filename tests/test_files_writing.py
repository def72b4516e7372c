"""Files are written in one step: killed, crossed or out of space, what was there before is there still."""

import os
import re
import resource
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from wirewear.base.errors import ResultError, RunError
from wirewear.base.writing import folder_in_one_step, usable_file, write_bytes, write_text, writing

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


def test_a_killed_writer_leaves_the_old_file_and_is_cleared(tmp_path: Path, slow_writer: subprocess.Popen[str]) -> None:
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


def test_what_is_no_regular_file_stays_and_is_given_the_text(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.json"
    os.mkfifo(pipe)
    with subprocess.Popen(["cat", str(pipe)], stdout=subprocess.PIPE, text=True) as reader:
        write_text(usable_file(pipe), "written")
        assert reader.communicate()[0] == "written"
    assert pipe.is_fifo()
    assert [one.name for one in tmp_path.iterdir()] == ["pipe.json"]


@pytest.mark.parametrize("exists", [True, False])
def test_a_link_stays_and_what_it_leads_to_is_written(tmp_path: Path, exists: bool) -> None:
    (tmp_path / "elsewhere").mkdir()
    target, first, second = tmp_path / "elsewhere" / "target.txt", tmp_path / "first.txt", tmp_path / "second.txt"
    if exists:
        target.write_text("old")
    first.symlink_to("elsewhere/target.txt")
    second.symlink_to(first)
    write_text(usable_file(second), "new")
    assert target.read_text() == "new"
    assert first.is_symlink()
    assert second.is_symlink()


def test_links_in_a_circle_and_of_others_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    circle, foreign = tmp_path / "circle.txt", tmp_path / "foreign.txt"
    circle.symlink_to(circle)
    foreign.symlink_to(tmp_path / "target.txt")
    with pytest.raises(RunError, match=r"circle\.txt cannot be written: too many levels of symbolic links"):
        usable_file(circle)
    if os.geteuid() == 0:
        os.lchown(foreign, 12345, 12345)
        with pytest.raises(RunError, match=r"foreign\.txt cannot be written: it is a link of another user"):
            usable_file(foreign)
