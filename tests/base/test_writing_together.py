"""Files that belong together are written all or not at all."""

import os
from pathlib import Path

import pytest

from wirewear.base.writing import all_or_none, write_text


def test_what_one_of_several_files_lacks_leaves_all_as_they_were(tmp_path: Path) -> None:
    earlier, new = tmp_path / "loops.csv", tmp_path / "scars.csv"
    earlier.write_text("earlier")

    def half() -> None:
        with all_or_none([earlier, new]) as partials:
            partials[0].write_text("later")
            tmp_path.write_text("no file")

    with pytest.raises(IsADirectoryError):
        half()
    assert earlier.read_text() == "earlier"
    assert [path.name for path in tmp_path.iterdir()] == ["loops.csv"]
    with all_or_none([earlier, new]) as partials:
        for partial in partials:
            partial.write_text("later")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == dict.fromkeys(
        ("loops.csv", "scars.csv"), "later"
    )


def test_a_folder_that_takes_files_but_may_not_be_read_takes_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = os.open

    def unreadable(path: str | os.PathLike[str], *how: int) -> int:
        if Path(path) == tmp_path:
            raise PermissionError(13, "Permission denied")
        return opened(path, *how)

    monkeypatch.setattr(os, "open", unreadable)
    write_text(tmp_path / "note.txt", "text")
    assert (tmp_path / "note.txt").read_text() == "text"
