"""Checksums of a record's files as it was written, in comments at the end of experiment.toml.

Other programs pass over them, and records without them are read as they are. A table of numbers that has changed since
is not used; experiment.toml is what people change by hand, so that is told.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from pathlib import Path

from wirewear.base.errors import RecordError
from wirewear.base.reading import read_bytes

_LINE = re.compile(rb"^# sha256 ([0-9a-f]{64}) (\S+)\n", re.MULTILINE)
_LAST = re.compile(rb"^# sha256 ([0-9a-f]{64}) of the text above\n\Z", re.MULTILINE)


def with_checksums(text: str, folder: Path, names: Mapping[str, str]) -> str:
    """The text of experiment.toml with the checksums of files of its folder, by their keys, and its own behind it."""
    lines = [f"# sha256 {hashlib.sha256((folder / name).read_bytes()).hexdigest()} {name}\n" for name in names.values()]
    text += "\n# The files as wirewear wrote them. Whoever changes one on purpose deletes its line.\n" + "".join(lines)
    return text + f"# sha256 {hashlib.sha256(text.encode()).hexdigest()} of the text above\n"


def require_unchanged(table_path: Path) -> tuple[str, ...]:
    """See that a record's tables are as they were written; what is to be told of experiment.toml itself.

    Raises:
        RecordError: a table has changed, or experiment.toml cannot be read.
    """
    data = read_bytes(table_path, RecordError, "TOML file")
    folder = table_path.parent.resolve()
    for found, name in _LINE.findall(data):
        path = table_path.parent / Path(name.decode("utf-8", "replace")).name
        if not path.is_file() or not path.resolve().is_relative_to(folder):
            continue
        if hashlib.sha256(read_bytes(path, RecordError)).hexdigest() != found.decode():
            raise RecordError(
                f"{path} is not as it was written: it is damaged, or was changed; if that was on purpose, delete the "
                f"line of its checksum from {table_path.name}."
            )
    last = _LAST.search(data)
    whole = last is not None and hashlib.sha256(data[: last.start()]).hexdigest() == last[1].decode()
    if whole or b"# sha256 " not in data:
        return ()
    return (f"{table_path.name} is not as it was written: it was changed by hand, or is damaged",)
