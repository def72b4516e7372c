"""Writing of files and folders in one step: at any moment others see the old or the new state, never a partial one.

A file is written beside its place under a unique name, synchronised with the disk, and then moved into its place. What
a killed process left is deleted by the next one that writes the file; a kernel lock shows which files are in use.
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import json
import os
import re
import secrets
import shutil
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from glob import escape
from math import isfinite
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from typing import TYPE_CHECKING, overload

from wirewear.base.errors import RunError, WirewearError
from wirewear.base.files import is_special, link_followed, open_number

if TYPE_CHECKING:
    import polars as pl
    from vtkmodules.vtkCommonDataModel import vtkDataObject

_BEGINS_FORMULA = r"^[=+\-@\t\r]"  #: Signs with which spreadsheets let a formula begin: OWASP, "CSV injection".

_BEFORE = ".before."  #: In the name of a folder that is exchanged in two steps.
_AT_WORKING_FOLDER, _SWAP = -100, 2  #: Of renameat2, in Linux's fcntl.h and fs.h.


def json_text(value: object, indent: int | None = 2) -> str:
    """Value as JSON text, null in place of numbers that are not finite; indent: spaces by level, None: one line."""
    return json.dumps(finite(value), indent=indent, ensure_ascii=False, allow_nan=False)


def write_csv(path: Path, table: pl.DataFrame | Sequence[Mapping[str, object]]) -> Path:
    """Write a table (or its rows) as CSV in one step and return its path.

    Text that begins like a formula gets an apostrophe before it.
    Raises OSError if the file cannot be written.
    """
    with in_one_step(path) as partial:
        if isinstance(table, Sequence):
            names = list(dict.fromkeys(name for row in table for name in row))
            lines: list[Iterable[object]] = [names, *([row.get(name) for name in names] for row in table)]
            partial.write_text(
                "".join(",".join(map(_cell, line)) + "\n" for line in lines), encoding="utf-8", newline=""
            )
        else:
            import polars as pl

            # Polars takes no name that is not in UTF-8, but takes any open file.
            with partial.open("wb") as file:
                table.with_columns(pl.col(pl.String).str.replace(_BEGINS_FORMULA, "'$0")).write_csv(file)
    return path


def _cell(value: object) -> str:
    if not isinstance(value, str):
        return "" if value is None else str(value).lower()
    text = re.sub(_BEGINS_FORMULA, r"'\g<0>", value)
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\n\r') else text


@overload
def finite(value: Mapping[str, object]) -> dict[str, object]: ...


@overload
def finite(value: object) -> object: ...


def finite(value: object) -> object:
    """Copy of a value of mappings, sequences (made lists) and plain values, with None for numbers not finite."""
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [finite(one) for one in value]
    return value


def prepared_folder(path: Path) -> Path:
    """Create an output folder if missing, check that files can be written to it, and return it.

    Raises RunError if the folder cannot be created or written to.
    """
    with writing(RunError, f"the output folder {path} cannot be used"):
        path.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=path):
            return path


def usable_folder(path: Path) -> Path:
    """Check that an output folder exists and takes files, or could be created; returns its path. Nothing is left
    behind.

    Raises RunError if it cannot be created or written to.
    """
    with writing(RunError, f"the output folder {path} cannot be used"):
        made = _missing(path)
    try:
        return prepared_folder(path)
    finally:
        for folder in made:
            # Not all may have been made, and somebody else may have put something there meanwhile.
            with suppress(OSError):
                folder.rmdir()


def usable_file(path: Path) -> Path:
    """Check that a file could be written or replaced, its folder being created if missing; returns its path. Nothing is
    left behind or changed.

    Raises RunError if it could not.
    """
    with writing(RunError, f"{path} cannot be written"):
        if is_special(path):
            if (number := open_number(path)) is not None:
                os.close(os.dup(number))
            elif not os.access(path, os.W_OK):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
            return path
        place = link_followed(path)
    usable_folder(place.parent)
    with writing(RunError, f"{path} cannot be written"):
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        # What is too long for a name is found by looking for it, in a folder that is there.
        folder = next(above for above in path.parents if above.is_dir())
        _missing(folder / name_beside(path).name)
    return path


def _missing(path: Path) -> list[Path]:
    """Parts of a path that do not exist, the innermost first. Raises OSError if they cannot exist."""
    try:
        path.stat()
    except FileNotFoundError:
        return [path, *_missing(path.parent)]
    return []


def write_text(path: Path, text: str) -> Path:
    """Write or replace a text file (UTF-8) in one step and return its path. Raises OSError if it cannot be written."""
    return write_bytes(path, text.encode())


def write_bytes(path: Path, data: bytes) -> Path:
    """Write or replace a file in one step and return its path. Raises OSError if it cannot be written."""
    with in_one_step(path) as partial:
        partial.write_bytes(data)
    return path


def write_grid(path: Path, grid: vtkDataObject) -> Path:
    """Write or replace a VTU or VTP file (by the ending) of a VTK grid or points in one step and return its path.

    The contents are built in memory, as VTK's writers end the process if a disk is full.
    Raises OSError if it cannot be written.
    """
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter, vtkXMLUnstructuredGridWriter

    writer = vtkXMLPolyDataWriter() if path.suffix == ".vtp" else vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.SetDataModeToBinary()
    # Of VTK's levels: higher ones take half as much time again for files that are 1 % smaller.
    writer.SetCompressionLevel(1)
    writer.WriteToOutputStringOn()
    writer.Write()
    return write_bytes(path, writer.GetOutputString().encode())


@contextmanager
def in_one_step(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`, with the same ending, that replaces `path` if the enclosed work succeeds.

    Links are followed. A device, a pipe or a stream already open, such as /dev/stdout, stays and receives the contents.
    Raises OSError if the file cannot be written, and RunError if it is special and there is no temporary folder.
    """
    if is_special(path):
        with temporary_folder() as folder:
            made = folder / f"whole{path.suffix}"
            yield made
            sys.stdout.flush()
            number = open_number(path)
            with made.open("rb") as whole, open(path if number is None else os.dup(number), "wb") as special:  # noqa: PTH123 - a number is no path
                shutil.copyfileobj(whole, special)
        return
    path = link_followed(path)
    _remove_abandoned(path)
    partial, holder = _beside(path, folder=False)
    try:
        yield partial
        _synchronise(partial)
        partial.replace(path)
        _synchronise(path.parent)
    finally:
        os.close(holder)
        with suppress(OSError):
            partial.unlink(missing_ok=True)


@contextmanager
def all_or_none(paths: Iterable[Path]) -> Iterator[list[Path]]:
    """Yield temporary paths beside these that replace them together, as in `in_one_step`, if the work succeeds."""
    with ExitStack() as stack:
        yield [stack.enter_context(in_one_step(path)) for path in paths]


@contextmanager
def folder_in_one_step(path: Path, *, in_place_of: Sequence[str] = ()) -> Iterator[Path]:
    """Yield a new folder beside `path`, to be filled, that becomes `path` if the enclosed work succeeds; else it is
    deleted.

    in_place_of: names in `path` that are replaced; all else in it is kept. If empty, `path` must not exist, or be an
    empty folder. Raises OSError if the folder cannot be written, or `path` holds files that cannot stay.
    """
    # The name of "." is that of the folder.
    path = link_followed(path).resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    put_back(path)
    partial, holder = _beside(path, folder=True)
    try:
        yield partial
        for inner in partial.rglob("*"):
            _synchronise(inner)
        if in_place_of and path.is_dir():
            for other in path.iterdir():
                if other.name not in in_place_of:
                    _link(other, partial / other.name)
            shutil.copymode(path, partial)
            _synchronise(partial)
            _exchange(partial, path)
        else:
            _synchronise(partial)
            partial.replace(path)
        _synchronise(path.parent)
    finally:
        os.close(holder)
        shutil.rmtree(partial, ignore_errors=True)


def put_back(path: Path) -> None:
    """Clean up after a process that was killed while exchanging `path`: its previous folder is restored.

    That is needed only where the system cannot exchange folders in one step. Nothing is touched while another process
    works on `path`.
    """
    _remove_abandoned(path)
    if (aside := set_aside(path)) is not None and not [*_partials(path)]:
        aside.rename(path)


def set_aside(path: Path) -> Path | None:
    """The one folder beside `path` that a process killed during an exchange has left as its previous contents; None if
    `path` exists, or there is no such folder or several.
    """
    found = [] if os.path.lexists(path) else [*path.parent.glob(f"{escape(path.name)}{_BEFORE}*")]
    return found[0] if len(found) == 1 else None


def _link(source: Path, target: Path) -> None:
    """Make a hard link to a file, or to all files of a folder; a copy if the file system does not support links."""
    if source.is_dir() and not source.is_symlink():
        shutil.copytree(source, target, symlinks=True, copy_function=lambda own, other: _link(Path(own), Path(other)))
        return
    try:
        os.link(source, target, follow_symlinks=False)
    except OSError:
        shutil.copy2(source, target, follow_symlinks=False)


def _exchange(new: Path, old: Path) -> None:
    """Exchange two folders, in one step if the system can; else in two, restoring the old folder if the second fails.

    If the process is killed in between, `put_back` restores it.
    Raises OSError if they cannot be exchanged.
    """
    rename = getattr(ctypes.CDLL(None), "renameat2", None)
    names = (_AT_WORKING_FOLDER, os.fsencode(new), _AT_WORKING_FOLDER, os.fsencode(old), _SWAP)
    if rename is not None and rename(*names) == 0:
        return
    # A name that nobody takes for abandoned, should the process end between the steps.
    aside = old.with_name(f"{old.name}{_BEFORE}{secrets.token_hex(4)}")
    old.rename(aside)
    try:
        new.rename(old)
    except OSError:
        aside.rename(old)
        raise
    aside.rename(new)


def require_absent(paths: Iterable[Path], kind: type[WirewearError], otherwise: str = ", or --overwrite") -> None:
    """Check that none of these paths exists. Raises an error of class `kind` if one does.

    otherwise: what can be done besides choosing another folder.
    """
    if (there := next((path for path in paths if os.path.lexists(path)), None)) is not None:
        raise kind(f"{there} exists already, and is not overwritten unasked: choose another folder{otherwise}.")


@contextmanager
def temporary_folder(prefix: str = "wirewear-") -> Iterator[Path]:
    """Create a folder in the system's temporary folder and delete it at the end of the context.

    Raises RunError if no temporary folder can be created.
    """
    with writing(RunError, "no temporary folder can be made", "TMPDIR names the folder for them"):
        made = TemporaryDirectory(prefix=prefix)
    with made as name:
        yield Path(name)


@contextmanager
def writing(kind: type[WirewearError], what: str, then: str = "") -> Iterator[None]:
    """Raise OSErrors of the enclosed work as errors of class `kind`, such as ``{what}: no space left on device.``.

    then: what the user can do about it, added to the sentence.
    """
    try:
        yield
    except OSError as error:
        raise kind(f"{what}: {why_not_written(error)}{f'; {then}' if then else ''}.") from error


def why_not_written(error: OSError) -> str:
    """Reason for an OSError in writing, as the end of a sentence, without a full stop."""
    if isinstance(error, FileExistsError):
        nowhere = isinstance(error.filename, str | os.PathLike) and os.path.islink(error.filename)  # noqa: PTH114
        return "it is a link that leads nowhere" if nowhere else "it is a file, not a folder"
    if isinstance(error, NotADirectoryError):
        return "a part of this path is a file, not a folder"
    reason = error.strerror or str(error)
    return reason[:1].lower() + reason[1:]


def _beside(path: Path, *, folder: bool) -> tuple[Path, int]:
    """New empty file or folder beside `path`, and its descriptor, which holds its lock."""
    while True:
        partial = name_beside(path)
        if folder:
            partial.mkdir()
        holder = os.open(partial, os.O_RDONLY if folder else os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        _locked(holder)
        # Before the lock was there, somebody may have taken it for abandoned and deleted it.
        if partial.exists():
            return partial, holder
        os.close(holder)


def name_beside(path: Path) -> Path:
    """Path of a new, unique name in the folder of `path`, with its ending, for a file that is being written."""
    return path.with_name(f".{path.stem}.{secrets.token_hex(4)}.partial{path.suffix}")


def _remove_abandoned(path: Path) -> None:
    """Delete what killed processes left while writing `path`."""
    for left in _partials(path):
        with suppress(OSError):
            holder = os.open(left, os.O_RDONLY | os.O_NOFOLLOW)
            try:
                if _locked(holder) and left.is_dir():
                    shutil.rmtree(left)
                elif _locked(holder):
                    left.unlink()
            finally:
                os.close(holder)


def _partials(path: Path) -> Iterator[Path]:
    """Unfinished files or folders beside `path` that were named by `name_beside`."""
    return path.parent.glob(f".{escape(path.stem)}.*.partial{escape(path.suffix)}")


def _locked(descriptor: int) -> bool:
    """True if this process holds, or could just take, the lock of an open file; the lock ends with the process."""
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _synchronise(path: Path) -> None:
    # One may write to a folder without reading it.
    with suppress(PermissionError):
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
