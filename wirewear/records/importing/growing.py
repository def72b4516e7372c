"""A logger's files while they grow, read as a record of what of them is whole."""

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from wirewear.base.errors import RecordError
from wirewear.base.writing import temporary_folder
from wirewear.records.importing.importing import import_record, inputs_of
from wirewear.records.importing.loggers import kind_of
from wirewear.records.importing.text_reader import TextReader, require_mapping
from wirewear.records.values import AnyRecord
from wirewear.test.study import found_from

_TWO_BYTES = (b"\xff\xfe", b"\xfe\xff")  #: With which texts of two bytes a sign begin.


@dataclass(frozen=True)
class GrowingTest:
    """The loops of a mapping whose other files come when the test has ended. home: where bodies' files lie; None for
    the mapping's folder.
    """

    home: Path | None = None

    def tables(self, data: dict[str, object]) -> dict[str, object]:
        """A mapping's tables with no sources but the loops."""
        kept = {key: table for key, table in data.items() if key == "loops" or not _names_files(table)}
        if self.home is not None and isinstance(bodies := kept.get("bodies"), dict):
            kept["bodies"] = found_from(self.home, bodies)
        return kept


def _names_files(table: object) -> bool:
    return isinstance(table, Mapping) and ("files" in table or any(map(_names_files, table.values())))


@dataclass(frozen=True)
class Growth:
    """State of the files of a running test: paths, bytes and times of writing. Equal while nothing is written."""

    files: tuple[tuple[Path, int, int], ...]

    @classmethod
    def of(cls, mapping_path: Path) -> "Growth":
        """The present state. Raises RecordError if the mapping cannot be read, or a file is not there yet."""
        require_mapping(mapping_path)
        found = [(path, path.stat()) for path in inputs_of(mapping_path, GrowingTest())]
        return cls(tuple((path, one.st_size, one.st_mtime_ns) for path, one in found))


def record_so_far(mapping_path: Path, growth: Growth, *, ended: bool = False) -> AnyRecord:
    """The record of a running test's loops. Unless the test has `ended`, the last one may still grow, and a text's last
    line is left out if it is not whole.

    Raises RecordError, in one sentence, if the files cannot be read yet.
    """
    home = mapping_path.parent
    if ended:
        return import_record(mapping_path, GrowingTest())
    with temporary_folder("wirewear-follow-") as folder:
        for path, size, _ in growth.files:
            copy = folder / path.relative_to(home)
            copy.parent.mkdir(parents=True, exist_ok=True)
            if path != mapping_path and kind_of(path) == TextReader.kind:
                with path.open("rb") as file:
                    text = file.read(size)
                end = max(text.rfind(b"\n"), text.rfind(b"\r")) + 1  # of its last whole line
                copy.write_bytes(text[: end + end % 2 if text[:2] in _TWO_BYTES else end])
            else:
                shutil.copyfile(path, copy)
        try:
            return import_record(folder / mapping_path.name, GrowingTest(home.resolve()))
        except RecordError as problem:
            raise RecordError(str(problem).replace(str(folder), str(home))) from None
