"""Reading of whole files, TOML among them, with one clear sentence if that fails, and where paths lead."""

import codecs
import errno
import hashlib
import json
import os
import re
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from wirewear.base.errors import WirewearError
from wirewear.base.words import shown

#: What the table of a record and the file of a result are called.
TABLE_FILE_NAME, RESULT_FILE_NAME = "experiment.toml", "result.h5"


#: What is written in a value's place by those who do not know TOML, and what it should be.
_HINTS = {
    r"([-+]?\d+),(\d+(?:e[-+]?\d+)?)": r"the decimal sign is a point: \1.\2",
    r"([-+]?)(\.\d+)": r"a number begins with a digit: \g<1>0\2",
    r"T(rue)": r"it is spelled so: t\1",
    r"F(alse)": r"it is spelled so: f\1",
    r"([-+]?\d[\d.]*(?:e[-+]?\d+)?)\s*[^\W\d][^#,]*": r"the unit stands in the key's name: \1",
    r"([^\W\d][\w.-]*(?: [\w.-]+)*)": r'a text stands in quotes: "\1"',
}

#: Delimiters by name; None is any white space.
DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "whitespace": None}
_NO_TEXTS = ("idna", "punycode", "unicode-escape", "raw-unicode-escape", "undefined")
_TOML = ("study file", "sweep file", "TOML file")  #: What is called so is a TOML file.

_MOST_LINKS = 40  #: As many as Linux follows.


def kept_table(path: Path) -> dict[str, Any]:
    """The table of a JSON file that a command keeps for itself; empty where there is none, or a damaged one."""
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError):
        return {}


def read_toml(path: Path, kind: type[WirewearError], what: str = "TOML file") -> dict[str, object]:
    """Tables of a TOML file; `what` names its kind in messages. Raises an error of class `kind` if it cannot be read or
    is not valid TOML.
    """
    return parsed_toml(read_text(path, kind, what), str(path), kind)


def parsed_toml(text: str, where: str, kind: type[WirewearError]) -> dict[str, object]:
    """Tables of a TOML text; `where` names its origin in messages.

    Raises an error of class `kind` if the text is not valid TOML.
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        reason = str(problem)
        raise kind(f"{where} is not valid TOML: {reason[:1].lower()}{reason[1:]}{_hint(text, reason)}.") from None
    except (ValueError, RecursionError):  # what tomllib lets through of overlong integers and deep nesting
        raise kind(f"{where} is not valid TOML: a number is too long or the nesting too deep.") from None


def table_of(tables: Mapping[str, object], name: str) -> Mapping[str, object]:
    """The table of this name within TOML tables; empty if there is none, or something else has the name."""
    found = tables.get(name)
    return found if isinstance(found, Mapping) else {}


def _hint(text: str, reason: str) -> str:
    """Part of a sentence that says how to correct the line that a TOML error names; "" if that is not known."""
    if (at := re.search(r"line (\d+)", reason)) is None:
        return ""
    key, is_given, value = text.splitlines()[int(at[1]) - 1].split("#")[0].partition("=")
    if reason.startswith("Cannot overwrite"):
        return f": {key.strip(' []')} was given before"
    for wrong, right in _HINTS.items():
        if is_given and (found := re.fullmatch(wrong, value.strip())):
            return f"; {found.expand(right).replace(': ', f': {key.strip()} = ', 1)}"
    return ""


def toml_text(tables: Mapping[str, object], prefix: str = "") -> str:
    """TOML text of tables of texts, numbers, lists and tables; prefix: what begins inner tables' names, as "rig."."""
    own = [f"{key} = {spelled(value)}" for key, value in tables.items() if not isinstance(value, Mapping)]
    inner = []
    for key, value in tables.items():
        if isinstance(value, Mapping) and value:
            name = f"{prefix}{key}"
            # What holds tables alone needs no line of its own.
            head = "" if all(isinstance(one, Mapping) and one for one in value.values()) else f"\n[{name}]\n"
            inner.append(f"{head}{toml_text(value, f'{name}.')}")
    return "".join(f"{line}\n" for line in own) + "".join(inner)


def spelled(value: object) -> str:
    """TOML spelling of a text, number, list or table."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {spelled(own)}" for key, own in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(spelled, value)) + "]"
    # JSON spells texts, numbers and lists as TOML does, but for one control character.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def is_encoding_of_text(name: str) -> bool:
    """True if `name` is an encoding that Python knows, for texts and not for packed bytes or host names."""
    try:
        return "1,5".encode(name).decode(name) == "1,5" and codecs.lookup(name).name not in _NO_TEXTS
    except (LookupError, ValueError):
        return False


def read_bytes(path: Path, kind: type[WirewearError], what: str = "file") -> bytes:
    """Contents of an ordinary file; `what` names its kind in messages, such as "study file".

    Raises an error of class `kind` if it does not exist or cannot be read.
    """
    try:
        if path.is_dir():
            raise kind(f"{path} is a folder, where a {what} is needed{_meant(path, what)}.")
        # A pipe or a device may have no end.
        if path.exists() and not path.is_file():
            raise kind(f"{path} is no ordinary file, as a {what} must be.")
        return path.read_bytes()
    except FileNotFoundError:
        raise kind(f"there is no {what} {path}{_meant(path, what)}.") from None
    except (OSError, ValueError) as problem:
        reason = problem.strerror if isinstance(problem, OSError) else problem
        raise kind(f"{shown(str(path))} cannot be read ({reason}).") from None


def _meant(path: Path, what: str) -> str:
    """Part of a sentence naming the file with .toml appended, if a TOML file is needed and that one exists; else ""."""
    if what not in _TOML:
        return ""
    beside = path.parent / f"{path.name}.toml"
    # A name may be empty, as that of the folder one stands in, or too long with an ending.
    with suppress(OSError):
        if path.name and beside.is_file():
            return f", but {beside} is there"
    return ""


def read_text(path: Path, kind: type[WirewearError], what: str = "file") -> str:
    """Text of a file in UTF-8; `what` names its kind in messages. Raises an error of class `kind` if it cannot be read
    or is not text.
    """
    return utf8(read_bytes(path, kind, what), path, kind)


def require_within(path: Path, folder: Path, kind: type[WirewearError], where: str) -> None:
    """Check that a file lies in a folder, after following links.

    Raises an error of class `kind`, with a sentence that begins with `where`, if it does not.
    """
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError):  # links in a circle, and what is no path
        inside = False
    if not inside:
        raise kind(f"{where} {shown(str(path))} leads out of the folder {folder}, which is not followed.")


def with_checksum(table: Mapping[str, object]) -> dict[str, object]:
    """Copy of a table for JSON with the SHA-256 of all other entries under the key `sha256`."""
    rest = {name: item for name, item in table.items() if name != "sha256"}
    return {**rest, "sha256": hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()}


def require_unchanged(table: Mapping[str, object], where: str, kind: type[WirewearError]) -> None:
    """Check a table that was made by `with_checksum` and read from JSON; one without a checksum passes.

    Raises an error of class `kind`, with a sentence that begins with `where`, if the table has changed.
    """
    try:
        whole = "sha256" not in table or with_checksum(table)["sha256"] == table["sha256"]
    except RecursionError:
        whole = False
    if not whole:
        raise kind(f"{where} is not as it was written: it is damaged, or was changed.")


def utf8(data: bytes, path: Path, kind: type[WirewearError]) -> str:
    """Text of bytes in UTF-8, without a byte-order mark. Raises a `kind` of error, naming the line, if it is none."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        line = data.count(b"\n", 0, problem.start) + 1
        raise kind(f"{path}, line {line}: this is not text in UTF-8.") from None


def is_special(path: Path) -> bool:
    """True for a device, pipe or socket, and for a path, as /dev/stdout, that leads to this process's open stream."""
    return open_number(path) is not None or (path.exists() and not path.is_file() and not path.is_dir())


def open_number(path: Path) -> int | None:
    """Descriptor of this process's open stream that a path leads to, as 1 for /dev/stdout; None for other paths."""
    for _ in range(_MOST_LINKS):
        if path.name.isdecimal() and path.parent.resolve() == Path("/proc/self/fd").resolve():
            return int(path.name)
        if not path.is_symlink():
            return None
        path = path.parent / path.readlink()
    return None


def link_followed(path: Path) -> Path:
    """Final target of a symbolic link; the path itself if it is not a link.

    Raises OSError if links form a circle, or one belongs to another user, who could redirect the file.
    """
    for _ in range(_MOST_LINKS):
        if not path.is_symlink():
            return path
        if path.lstat().st_uid not in (os.geteuid(), 0):
            raise PermissionError(errno.EPERM, "it is a link of another user")
        path = path.parent / path.readlink()
    raise OSError(errno.ELOOP, os.strerror(errno.ELOOP))
