"""Height maps of profilometers: matrices in texts, and all formats that SurfaceTopography reads."""

import io
import re
import warnings
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from wirewear.base.budget import require_room
from wirewear.base.delimited import DelimitedLayout, DelimitedText, decoded, fields_of, read_delimited
from wirewear.base.errors import RecordError
from wirewear.base.guessing import GuessedLayout, guessed_layout
from wirewear.base.quantity import FIELD_UNITS
from wirewear.records.importing.damage import DAMAGED_FILE_ERRORS, reason_of
from wirewear.records.values import Array

#: Ends of names of profilometers' files, which SurfaceTopography reads.
MAPS = frozenset(
    (".al3d", ".datx", ".di", ".ezd", ".gwy", ".ibw", ".mnt", ".nid", ".nms", ".npy", ".oir", ".opd", ".opdx", ".os3d")
    + (".plu", ".plux", ".poir", ".sdf", ".spm", ".stp", ".sur", ".vk4", ".vk6", ".vk7", ".wsf", ".x3p", ".zag", ".zmg")
)

#: Tables with fewer columns are points or channels, and no matrix of heights.
NARROWEST = 8

#: Lines of a text on which SurfaceTopography is tried before it reads the whole, which takes it 160 bytes a byte.
HEAD_LINES, TEXT_EXPANSION = 200, 160.0

#: A zipped map takes its parts, their numbers in floating point, and a copy of them.
ZIP_EXPANSION = 4.0

#: No profilometer sees so far, in µm: NanoFocus files state their points' distance in nm where millimetres are read.
WIDEST_um = 1e6

_ZYGO = b"Zygo XYZ Data File"
_LENGTHS = FIELD_UNITS["um"]

#: Width and height of a map in µm by its numbers of columns and rows.
Sizes = Callable[[int, int], tuple[float, float]]

#: Lines x (n_x,), y (n_y,) and heights (n_x, n_y), all in µm.
Map = tuple[Array, Array, Array]


def is_map(path: Path) -> bool:
    """Whether a file is a height map: by the end of its name, or as a matrix in a text that states its size."""
    if path.suffix.lower() in MAPS:
        return True
    try:
        return path.read_bytes()[: len(_ZYGO)] == _ZYGO or _matrix(path) is not None
    except RecordError:
        return False


def height_map(file: Path) -> Map:
    """Lines x (n_x,), y (n_y,) and heights (n_x, n_y), all in µm; NaN where nothing was measured.

    Raises:
        RecordError: the file cannot be read, or does not state its size, which is finite, and unit; one sentence.
    """
    x, y, height = _read(file)
    if not 0.0 < float(np.ptp(x)) * float(np.ptp(y)) < np.inf:
        raise RecordError(f"{file}: the map must have a finite size above zero along x and y.")
    return x, y, np.where(np.isfinite(height), height, np.nan)


def _read(file: Path) -> Map:
    with_head = b"" if not file.is_file() else file.read_bytes()[: len(_ZYGO)]
    if with_head == _ZYGO:
        return _zygo(file)
    if file.suffix.lower() not in MAPS and (matrix := _matrix(file)) is not None:
        return matrix()
    return _by_surface_topography(file)


def _lines(size_um: float, count: int) -> Array:
    """Middles of so many pixels, about the middle of all."""
    return np.asarray((np.arange(count) - 0.5 * (count - 1)) * size_um / count)


def _matrix(file: Path) -> Callable[[], Map] | None:
    """What reads a text as a matrix of heights; None where it is none, or states neither size nor pixel."""
    try:
        guessed = guessed_layout(file)
    except RecordError:
        return None
    if guessed.width < NARROWEST or guessed.names:
        return None
    data, _ = decoded(file)
    text = data.decode(guessed.layout.encoding, errors="replace").splitlines()[: guessed.layout.header_lines]
    rows = [fields_of(line, guessed.layout.delimiter) for line in text]
    found = _of_pixels(rows) or _of_sizes(text)
    if found is None:
        return None
    sizes, unit = found
    return lambda: _read_matrix(file, guessed, sizes, _LENGTHS[unit])


def _of_pixels(rows: Sequence[Sequence[str]]) -> tuple[Sizes, str] | None:
    """Sizes and unit of heights of a Keyence export in any language: a calibration with its unit, and a unit."""
    pixel, unit = None, None
    for row in rows:
        if len(row) >= 3 and row[2] in _LENGTHS and (number := _number(row[1])) is not None:
            pixel = pixel or number * _LENGTHS[row[2]]
        elif len(row) >= 2 and row[1] in _LENGTHS:
            unit = row[1]
    if pixel is None or unit is None:
        return None
    edge = pixel
    return lambda columns, rows: (edge * columns, edge * rows), unit


def _of_sizes(lines: Sequence[str]) -> tuple[Sizes, str] | None:
    """The same of a Gwyddion export: width, height and unit of the values, in this order in every language."""
    sizes, unit = [], ""
    for line in (own for own in lines if own.startswith("#")):
        found = re.search(r"[:=：]\s*(?:([-+\d.,eE]+)\s*)?(\S+)\s*$", line)
        if found is None or found[2] not in _LENGTHS:
            continue
        if found[1] and (number := _number(found[1])) is not None:
            sizes.append(number * _LENGTHS[found[2]])
        elif not found[1]:
            unit = found[2]
    return (lambda _columns, _rows: (sizes[0], sizes[1]), unit) if len(sizes) >= 2 and unit else None


def _number(text: str) -> float | None:
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return None
    return value if 0.0 < value < np.inf else None


def _read_matrix(file: Path, guessed: GuessedLayout, sizes_um: Sizes, factor: float) -> Map:
    text = read_delimited(file, guessed.layout)
    # Numbers need no quotation marks, and are read fast without.
    bare = DelimitedText(file, text.data.replace(b'"', b""), guessed.layout)
    columns = bare.numbers({str(place): place for place in range(guessed.width)}, as_logged=True).columns
    heights = factor * np.stack([columns[str(place)] for place in range(guessed.width)])
    x, y = (_lines(size, count) for size, count in zip(sizes_um(*heights.shape), heights.shape, strict=True))
    return x, y, heights


def _zygo(file: Path) -> Map:
    """A map in Zygo's XYZ format: columns and rows of the camera, heights in µm, the pixel in metres in line 8."""
    data = file.read_bytes().replace(b"\r\n", b"\n")
    head, _, rest = data.partition(b"\n#\n")
    lines = head.decode("latin-1").split("\n")
    fields = lines[7].split() if len(lines) > 7 else []
    pixel = 1e6 * (_number(fields[6]) or 0.0) if len(fields) > 6 else 0.0
    if not pixel:
        raise RecordError(f"{file}, line 8: the map does not state its camera's resolution, so that its size is open.")
    body = rest.partition(b"\n#")[0]
    text = DelimitedText(file, b"\n" * (len(lines) + 1) + body, _ZYGO_LAYOUT)
    rows = text.numbers({"x": 0, "y": 1, "z": 2}, as_logged=True).columns
    x, y = (rows[name].astype(np.int64) - int(np.nanmin(rows[name])) for name in ("x", "y"))
    shape = int(x.max()) + 1, int(y.max()) + 1
    require_room(file, 16.0 * shape[0] * shape[1], RecordError)
    heights = np.full(shape, np.nan)
    heights[x, y] = rows["z"]
    return _lines(pixel * shape[0], shape[0]), _lines(pixel * shape[1], shape[1]), heights


_ZYGO_LAYOUT = DelimitedLayout(delimiter=None, names_line=False)


def _by_surface_topography(file: Path) -> Map:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            from SurfaceTopography.Exceptions import ReadFileError
            from SurfaceTopography.IO import open_topography
        except ImportError:
            raise RecordError(
                f"{file}: profilometer maps are read by SurfaceTopography, which is not installed: pip install "
                "SurfaceTopography."
            ) from None
        try:
            head = _require_room(file)
            if head is not None:
                open_topography(io.BytesIO(head)).topography()
            # A format without a mark of its own, which is taken for others: its name alone tells.
            known = "nms" if file.suffix.lower() == ".nms" else None
            topography = open_topography(str(file), format=known).topography()
            heights = np.ma.filled(np.ma.asarray(topography.heights(), dtype=np.float64), np.nan)
            sizes, unit = topography.physical_sizes, topography.unit
        except (ReadFileError, *DAMAGED_FILE_ERRORS) as problem:
            raise RecordError(f"{file} cannot be read as a profilometer's map ({reason_of(problem)}).") from None
    if unit not in _LENGTHS or sizes is None or heights.ndim != 2 or min(heights.shape) < 3:
        raise RecordError(
            f"{file}: the map must be two-dimensional and tell its size and unit, but its unit is {unit!r}."
        )
    factor = _LENGTHS[unit]
    x, y = (_lines(float(size) * factor, n) for n, size in zip(heights.shape, sizes, strict=True))
    if file.suffix.lower() == ".nms" and max(float(np.ptp(x)), float(np.ptp(y))) > WIDEST_um:
        x, y = 1e-6 * x, 1e-6 * y
    return x, y, factor * heights


def _require_room(file: Path) -> bytes | None:
    """See that a file's contents fit into the memory; the first lines of a text, on which reading is tried.

    Raises:
        RecordError: they do not.
    """
    data = file.read_bytes()
    if data.startswith(b"PK\x03\x04"):
        with zipfile.ZipFile(io.BytesIO(data)) as parts:
            require_room(file, ZIP_EXPANSION * sum(part.file_size for part in parts.infolist()), RecordError)
        return None
    lines = data[:1_000_000].split(b"\n", HEAD_LINES)
    if b"\0" in data[:1000] or len(lines) <= HEAD_LINES:
        return None
    require_room(file, TEXT_EXPANSION * len(data), RecordError)
    return b"\n".join([*lines[:HEAD_LINES], b""])
