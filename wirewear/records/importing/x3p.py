"""Reader of X3P, the format of ISO 25178-72: a zipped XML index with a matrix of heights, all lengths in metres.

Writers differ in spelling of the revision, encoding and namespaces of the index, and folder of the contents.
"""

import re
import zipfile
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree as ET

import numpy as np

from geometry.arrays import Array
from wirewear.base.errors import RecordError
from wirewear.base.words import shown

INDEX = "main.xml"

#: How numbers of each type of the standard stand in the matrix.
_TYPES = {"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}

_PREFIX = re.compile(r"(</?|\s)[\w.-]+:(?=[\w.-]+[\s=>/])")
_DECLARATION = re.compile(r"^\s*<\?xml[^>]*\?>")


def read_x3p(file: Path) -> tuple[Array, tuple[float | None, float | None]]:
    """Heights (n_x, n_y) in metres, NaN where invalid, and the steps along x and y in metres, each None if unstated.
    Raises RecordError, in one sentence, if the file holds no matrix of heights, and zipfile's errors if it is damaged.
    """
    with zipfile.ZipFile(file) as parts:
        names = {name: PurePosixPath(name.replace("\\", "/").lower()) for name in parts.namelist()}
        index = min((name for name in names if names[name].name == INDEX), key=len, default=None)
        if index is None:
            raise _refused(file, f"{INDEX} is missing among {shown(', '.join(names))}")
        root = _parsed(file, parts.read(index))
        size = [_whole(file, root, f"Record3/MatrixDimension/Size{axis}") for axis in "XYZ"]
        if size[2] != 1:
            raise _refused(file, f"it holds {size[2]} layers where one is a map")
        for axis in ("CX", "CY"):
            if (kind := _text(root, f"Record1/Axes/{axis}/AxisType") or "I") != "I":
                raise _refused(file, f"the points of {axis} do not lie in even steps (AxisType {shown(kind)})")
        kind = (_text(root, "Record1/Axes/CZ/DataType") or "D").upper()
        if kind not in _TYPES:
            raise _refused(file, f"its heights are of the unknown type {shown(kind)}")
        data = _linked(parts, names, index, _text(root, "Record3/DataLink/PointDataLink"))
        count, each = size[0] * size[1], np.dtype(_TYPES[kind])
        if data is None or len(data) < count * each.itemsize:
            held = "no matrix of heights" if data is None else f"{len(data)} bytes of heights"
            raise _refused(file, f"it holds {held} where {size[0]} × {size[1]} points are stated")
        heights = np.frombuffer(data, each, count).astype(np.float64)
        valid = _linked(parts, names, index, _text(root, "Record3/DataLink/ValidPointsLink"))
        if valid is not None and 8 * len(valid) >= count:
            heights[np.unpackbits(np.frombuffer(valid, np.uint8), count=count, bitorder="little") == 0] = np.nan
    factor, offset = _number(root, "CZ", "Increment"), _number(root, "CZ", "Offset")
    heights = heights * (factor or 1.0) + (offset or 0.0)
    return heights.reshape(size[1], size[0]).T, (_number(root, "CX", "Increment"), _number(root, "CY", "Increment"))


def _refused(file: Path, reason: str) -> RecordError:
    return RecordError(f"{file} cannot be read as an X3P map: {reason}.")


def _parsed(file: Path, data: bytes) -> ET.Element:
    """Root of the index, with namespaces removed from its tags."""
    try:
        root = ET.fromstring(data)
    except (ET.ParseError, ValueError) as problem:
        # Bytes that are not of the stated encoding, or prefixes that are not declared.
        try:
            text = data.decode("utf-8")
        except UnicodeDecodeError:
            text = data.decode("cp1252", "replace")
        try:
            root = ET.fromstring(_PREFIX.sub(r"\1", _DECLARATION.sub("", text.lstrip("\ufeff"))))
        except (ET.ParseError, ValueError):
            raise _refused(file, f"its {INDEX} is no XML ({problem})") from None
    for element in root.iter():
        element.tag = str(element.tag).rpartition("}")[2]
    return root


def _text(root: ET.Element, place: str) -> str:
    return (root.findtext(place) or "").strip()


def _whole(file: Path, root: ET.Element, place: str) -> int:
    text = _text(root, place)
    if not re.fullmatch(r"\d{1,9}", text) or int(text) == 0:
        raise _refused(file, f"its {INDEX} gives {shown(text) if text else 'nothing'} for {place}")
    return int(text)


def _number(root: ET.Element, axis: str, name: str) -> float | None:
    """Finite number of an axis; None if there is none."""
    try:
        value = float(_text(root, f"Record1/Axes/{axis}/{name}").replace(",", "."))
    except ValueError:
        return None
    return value if np.isfinite(value) else None


def _linked(parts: zipfile.ZipFile, names: dict[str, PurePosixPath], index: str, link: str) -> bytes | None:
    """Contents of a part that the index links to, beside it or by its name anywhere; None if there is no such part."""
    if not link:
        return None
    wanted = PurePosixPath(link.replace("\\", "/").lower())
    beside = names[index].parent / wanted
    found = [name for name, own in names.items() if own == beside] or [
        name for name, own in names.items() if own.name == wanted.name
    ]
    return parts.read(found[0]) if found else None
