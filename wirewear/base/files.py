"""Files read whole, TOML among them, with one sentence for whatever prevents that."""

import codecs
import hashlib
import json
import re
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from wirewear.base.errors import WirewearError, shown

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


def read_toml(path: Path, kind: type[WirewearError], what: str = "TOML file") -> dict[str, object]:
    """The tables of a TOML file. Raises WirewearError, of the given kind, if it cannot be read, or is no valid TOML."""
    return parsed_toml(read_text(path, kind, what), str(path), kind)


def parsed_toml(text: str, where: str, kind: type[WirewearError]) -> dict[str, object]:
    """The tables of a TOML text; `where` names its origin in messages.
    Raises WirewearError, of the given kind, if the text is no valid TOML.
    """
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        reason = str(problem)
        raise kind(f"{where} is not valid TOML: {reason[:1].lower()}{reason[1:]}{_hint(text, reason)}.") from None
    except (ValueError, RecursionError):  # what tomllib lets through of overlong integers and deep nesting
        raise kind(f"{where} is not valid TOML: a number is too long or the nesting too deep.") from None


def table_of(tables: Mapping[str, object], name: str) -> Mapping[str, object]:
    """One of the tables of a TOML file, empty where it has none of that name."""
    found = tables.get(name)
    return found if isinstance(found, Mapping) else {}


def _hint(text: str, reason: str) -> str:
    """What would be right in the line of an error, where it is known."""
    if (at := re.search(r"line (\d+)", reason)) is None:
        return ""
    key, is_given, value = text.splitlines()[int(at[1]) - 1].split("#")[0].partition("=")
    for wrong, right in _HINTS.items():
        if is_given and (found := re.fullmatch(wrong, value.strip())):
            return f"; {found.expand(right).replace(': ', f': {key.strip()} = ', 1)}"
    return ""


def toml_text(tables: Mapping[str, object], prefix: str = "") -> str:
    """Tables of texts, numbers, lists and tables as TOML."""
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
    """A text, number, list or table as a value in TOML."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {spelled(own)}" for key, own in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(spelled, value)) + "]"
    # JSON spells texts, numbers and lists as TOML does, but for one control character.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def is_encoding_of_text(name: str) -> bool:
    """Whether texts are encoded so; Python calls encodings, too, what packs bytes, or spells hosts or its literals."""
    try:
        return "1,5".encode(name).decode(name) == "1,5" and codecs.lookup(name).name not in _NO_TEXTS
    except (LookupError, ValueError):
        return False


def read_bytes(path: Path, kind: type[WirewearError], what: str = "file") -> bytes:
    """The contents of an ordinary file; where there is none, an error of that kind says so.
    Raises WirewearError, of the given kind, if it cannot be read.  what: is needed: "a study file".
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
    """What to say of the file of that name with .toml behind it, where a TOML file is needed."""
    if what not in _TOML:
        return ""
    beside = path.parent / f"{path.name}.toml"
    # A name may be empty, as that of the folder one stands in, or too long with an ending.
    with suppress(OSError):
        if path.name and beside.is_file():
            return f", but {beside} is there"
    return ""


def read_text(path: Path, kind: type[WirewearError], what: str = "file") -> str:
    """The text of a file in UTF-8. Raises WirewearError, of the given kind, if it cannot be read or is no text."""
    return utf8(read_bytes(path, kind, what), path, kind)


def require_within(path: Path, folder: Path, kind: type[WirewearError], where: str) -> None:
    """See that a file lies in a folder, also when links on the way to it are followed.
    Raises WirewearError, of the given kind, if it does not; the sentence beginning with `where`.
    """
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError):  # links in a circle, and what is no path
        inside = False
    if not inside:
        raise kind(f"{where} {shown(str(path))} leads out of the folder {folder}, which is not followed.")


def with_checksum(table: Mapping[str, object]) -> dict[str, object]:
    """A table that becomes JSON, with the SHA-256 of all the rest under `sha256`."""
    rest = {name: item for name, item in table.items() if name != "sha256"}
    return {**rest, "sha256": hashlib.sha256(json.dumps(rest, sort_keys=True).encode()).hexdigest()}


def require_unchanged(table: Mapping[str, object], where: str, kind: type[WirewearError]) -> None:
    """See that a table that was read from JSON is what `with_checksum` made; one without a checksum passes.
    Raises WirewearError, of the given kind, if it has changed since.
    """
    try:
        whole = "sha256" not in table or with_checksum(table)["sha256"] == table["sha256"]
    except RecursionError:
        whole = False
    if not whole:
        raise kind(f"{where} is not as it was written: it is damaged, or was changed.")


def utf8(data: bytes, path: Path, kind: type[WirewearError]) -> str:
    """Bytes of a file as text in UTF-8, without a mark at its beginning.
    Raises WirewearError, of the given kind, if they are no text.
    """
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        line = data.count(b"\n", 0, problem.start) + 1
        raise kind(f"{path}, line {line}: this is not text in UTF-8.") from None
