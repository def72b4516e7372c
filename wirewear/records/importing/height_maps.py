"""Height maps of profilometers: Zygo's points, matrices in texts, and all formats that SurfaceTopography reads.

Lines above a matrix state its scale in the words of any language; a mapping must give what they do not state.
"""

import io
import re
import warnings
import zipfile
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from geometry.arrays import Array
from wirewear.base.delimited import DelimitedLayout, DelimitedText, contents_of, fields_of, read_delimited
from wirewear.base.errors import RecordError
from wirewear.base.guessing import GuessedLayout, guessed_layout
from wirewear.base.memory import require_room
from wirewear.base.units import FIELD_UNITS
from wirewear.records.importing.text_reader import DAMAGED_FILE_ERRORS, reason_of
from wirewear.records.importing.x3p import read_x3p

Map = tuple[Array, Array, Array]  #: Lines x (n_x,), y (n_y,) and heights (n_x, n_y), all in µm.

NARROWEST = 8  #: Tables with fewer columns are points or channels, and no matrix of heights.
EVEN = 0.02  #: Numbers that count lines are even to so many of their own steps.
_WYKO = "Wyko ASCII Data File"
_LENGTHS = FIELD_UNITS["um"]

#: Ends of names of profilometers' files, which SurfaceTopography reads.
MAPS = frozenset(
    (".al3d", ".datx", ".di", ".ezd", ".gwy", ".ibw", ".mnt", ".nid", ".nms", ".npy", ".oir", ".opd", ".opdx", ".os3d")
    + (".plu", ".plux", ".poir", ".sdf", ".spm", ".stp", ".sur", ".vk4", ".vk6", ".vk7", ".wsf", ".x3p", ".zag", ".zmg")
)

#: Lines of a text on which SurfaceTopography is tried before it reads the whole, which takes it 160 bytes a byte.
HEAD_LINES, TEXT_EXPANSION = 200, 160.0

#: No profilometer sees so far, in µm: NanoFocus files state their points' distance in nm where millimetres are read.
WIDEST_um = 1e6
_ZYGO = b"Zygo XYZ Data File"
_ZYGO_LAYOUT = DelimitedLayout(delimiter=None, names_line=False)


@dataclass(frozen=True)
class MapScale:
    """Scale of a map as a mapping states it: spacing of points along x, and along y if different, and unit of heights;
    None if unstated.
    """

    step_um: float | None = None
    step_y_um: float | None = None
    height_unit: str | None = None


@dataclass(frozen=True)
class StatedMap:
    """Map as its file states it: heights (n_x, n_y) in the file's unit, not finite where nothing was measured."""

    heights: Array
    step_um: tuple[float, float] | None  #: Spacing of points along x and y; None if unstated.
    unit_um: float | None  #: Unit of the heights in µm; None if unstated.
    remark: str = ""  #: Further words on its scale.

    @property
    def left_open(self) -> list[str]:
        """Keys that a mapping must give, as the file does not state them."""
        return ["step_um"] * (self.step_um is None) + ["height_unit"] * (self.unit_um is None)

    def scaled(self, file: Path, stated: MapScale) -> Map:
        """Lines x, y and heights in µm, x and y counted from the middle; the mapping's scale takes precedence over the
        file's. file: names the map in messages. Raises RecordError, in one sentence, if neither states the scale, or
        the size is not plausible.
        """
        step = self.step_um if stated.step_um is None else (stated.step_um, stated.step_y_um or stated.step_um)
        unit = self.unit_um if stated.height_unit is None else FIELD_UNITS["um"][stated.height_unit]
        if step is None or unit is None:
            missing = [key for key in self.left_open if getattr(stated, key) is None]
            raise RecordError(f"{file} does not state its scale: the mapping must give {' and '.join(missing)}.")
        x, y = ((np.arange(n) - 0.5 * (n - 1)) * own for n, own in zip(self.heights.shape, step, strict=True))
        if not 0.0 < float(np.ptp(x)) * float(np.ptp(y)) < np.inf:
            raise RecordError(f"{file}: the map must have a finite size above zero along x and y.")
        if (widest := max(float(np.ptp(x)), float(np.ptp(y)))) > WIDEST_um:
            raise RecordError(
                f"{file}: the map would be {1e-6 * widest:.3g} m wide, as no profilometer sees: the file states its "
                "steps in a wrong unit; give step_um, from point to point."
            )
        return x, y, np.where(np.isfinite(self.heights), unit * self.heights, np.nan)


def positive(text: str) -> float | None:
    """Positive number in a text with a decimal point or comma; None for any other text."""
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return None
    return value if 0.0 < value < np.inf else None


Pair = tuple[float, float]


@dataclass(frozen=True)
class Matrix:
    """Text with a matrix of heights: its layout and, None if unstated, its whole size or the distance of points along x
    and y, and the unit of heights.
    """

    guessed: GuessedLayout
    sizes_um: Pair | None = None
    step_um: Pair | None = None
    unit_um: float | None = None

    def read(self, file: Path) -> StatedMap:
        """The map in the text file; its scale is None where the text does not state it. Raises RecordError if a field
        is not a number.
        """
        layout = (self.guessed.tables or (self.guessed.layout,))[0]
        text = read_delimited(file, layout)
        # Numbers need no quotation marks, and are read fast without.
        bare = DelimitedText(file, text.data.replace(b'"', b""), layout) if layout.decimal != layout.delimiter else text
        columns = bare.numbers({str(place): place for place in range(self.guessed.width)}, as_logged=True).columns
        heights = np.stack([columns[str(place)] for place in range(self.guessed.width)])
        heights, places = _without_places(heights, self.guessed.names)
        step = self.step_um
        if step is None and self.sizes_um is not None:
            step = self.sizes_um[0] / heights.shape[0], self.sizes_um[1] / heights.shape[1]
        remark = f"; its first row and column count places, {places[0]:g} and {places[1]:g} apart" if places else ""
        return StatedMap(heights, step, self.unit_um, remark)


def matrix_of(file: Path) -> Matrix | None:
    """The matrix of heights in a text file; None if it holds none, or cannot be read as a text."""
    try:
        guessed = guessed_layout(file)
    except RecordError:
        return None
    numbers = (re.fullmatch(r"[-+]?\d+(?:[.,]\d+)?", name) for name in guessed.names[1:])
    if guessed.width < NARROWEST or not all(numbers):
        return None
    if guessed.names:
        # Places along x are no names.
        layout = replace(guessed.layout, names_line=False, header_lines=guessed.layout.lines_before_rows)
        guessed = replace(guessed, layout=layout, tables=())
    data, _ = contents_of(file)
    text = data.decode(guessed.layout.encoding, errors="replace").splitlines()[: guessed.layout.header_lines]
    if text and text[0].startswith(_WYKO):
        return _of_wyko(guessed, text)
    pixel, unit = _of_pixels([fields_of(line, guessed.layout.delimiter) for line in text])
    sizes, unit_of_values = _of_sizes(text)
    return Matrix(guessed, sizes, pixel, unit if unit_of_values is None else unit_of_values)


def _of_pixels(rows: Sequence[Sequence[str]]) -> tuple[Pair | None, float | None]:
    """Size of a point and unit of heights in the header of a Keyence export."""
    pixel, unit = None, None
    for row in rows:
        if len(row) >= 3 and row[2] in _LENGTHS and (number := positive(row[1])) is not None:
            pixel = pixel or number * _LENGTHS[row[2]]
        elif len(row) >= 2 and row[1] in _LENGTHS:
            unit = _LENGTHS[row[1]]
    return None if pixel is None else (pixel, pixel), unit


def _of_sizes(lines: Sequence[str]) -> tuple[Pair | None, float | None]:
    """Width and height of the map, and unit of heights, in the header of a Gwyddion export in any language."""
    sizes, unit = [], None
    for line in (own for own in lines if own.startswith("#")):
        found = re.search(r"[:=：]\s*(?:([-+\d.,eE]+)\s*)?(\S+)\s*$", line)
        if found is None or found[2] not in _LENGTHS:
            continue
        if found[1] and (number := positive(found[1])) is not None:
            sizes.append(number * _LENGTHS[found[2]])
        elif not found[1]:
            unit = _LENGTHS[found[2]]
    return (sizes[0], sizes[1]) if len(sizes) >= 2 else None, unit


def _of_wyko(guessed: GuessedLayout, lines: Sequence[str]) -> Matrix:
    """Matrix of Wyko's text: the pixel in mm, its shape, and heights in nm, or in waves if the first line's second flag
    is 0.

    As in Gwyddion and SurfaceTopography; the latter does not divide by a whole number of waves (``Mult 6``).
    """
    words = [line.split() for line in lines]
    stated = {own[0]: positive(own[-1]) for own in words if len(own) > 1}
    pixel, aspect, wave = (stated.get(key) for key in ("Pixel_size", "Aspect", "Wavelength"))
    in_nm = words[0][len(_WYKO.split()) + 1 :][1:2] == ["1"]
    unit = 1e-3 if in_nm else None if wave is None else 1e-3 * wave / (stated.get("Mult") or 1.0)
    step = None if pixel is None else (1e3 * pixel * (aspect or 1.0), 1e3 * pixel)
    if rows := stated.get("X"):
        # Intensities may stand below.
        guessed = replace(guessed, layout=replace(guessed.layout, most_rows=int(rows)), tables=())
    return Matrix(guessed, step_um=step, unit_um=unit)


def _without_places(heights: Array, names: Sequence[str]) -> tuple[Array, Pair | None]:
    """Heights (n_x, n_y) without a first row and column of positions, and the steps of these (None if there
    are none).
    """
    if names:
        along = np.array([float(name.replace(",", ".")) for name in names[1:]])
        beside, inside = heights[0], heights[1:]
    else:
        along, beside, inside = heights[1:, 0], heights[0, 1:], heights[1:, 1:]
    steps = [_even_step(line) for line in (along, beside)]
    if None in steps:
        return heights, None
    return inside, (steps[0] or 0.0, steps[1] or 0.0)


def _even_step(places: Array) -> float | None:
    """Step of evenly spaced numbers; None for other numbers."""
    steps = np.diff(places)
    middle = float(np.median(steps)) if steps.size > 1 else 0.0
    even = middle != 0.0 and bool(np.all(np.abs(steps - middle) < EVEN * abs(middle)))
    return abs(middle) if even else None


def is_map(path: Path) -> bool:
    """True if a file is a height map: by the end of its name, or as a matrix in a text that states its scale."""
    if path.suffix.lower() in MAPS:
        return True
    try:
        if path.read_bytes()[: len(_ZYGO)] == _ZYGO:
            return True
        matrix = matrix_of(path)
    except RecordError:
        return False
    return matrix is not None and ((matrix.sizes_um or matrix.step_um) is not None and matrix.unit_um is not None)


def height_map(file: Path, stated: MapScale | None = None) -> Map:
    """Lines x (n_x,), y (n_y,) and heights (n_x, n_y) of a file in µm; NaN where nothing was measured. stated: scale by
    the mapping. Raises RecordError if the file cannot be read, or neither it nor `stated` gives size and unit.
    """
    return stated_map(file).scaled(file, stated or MapScale())


def stated_map(file: Path) -> StatedMap:
    """The map of a file, with the scale that it states. Raises RecordError, in one sentence, if the file cannot be
    read.
    """
    if file.is_file() and file.read_bytes()[: len(_ZYGO)] == _ZYGO:
        return _zygo(file)
    if file.suffix.lower() not in MAPS and (matrix := matrix_of(file)) is not None:
        return matrix.read(file)
    found = _READERS.get(file.suffix.lower(), _by_surface_topography)(file)
    if found.heights.ndim != 2 or min(found.heights.shape) < 3:
        raise RecordError(f"{file}: the map must be two-dimensional.")
    return found


def _of_numpy(file: Path) -> StatedMap:
    """Map from an array of heights (n_x, n_y), without a scale; memory-mapped so that a truncated file is detected."""
    try:
        return StatedMap(np.array(np.load(file, mmap_mode="r"), dtype=np.float64), None, None)
    except DAMAGED_FILE_ERRORS as problem:
        raise _unreadable(file, problem) from None


def _of_x3p(file: Path) -> StatedMap:
    try:
        _require_room(file)
        heights, steps = read_x3p(file)
    except DAMAGED_FILE_ERRORS as problem:
        raise _unreadable(file, problem) from None
    step_um = 1e6 * (steps[0] or 0.0), 1e6 * (steps[1] or 0.0)
    return StatedMap(heights, step_um if min(step_um) > 0.0 else None, 1e6)


def _unreadable(file: Path, problem: Exception) -> RecordError:
    return RecordError(f"{file} cannot be read as a profilometer's map ({reason_of(problem)}).")


def _zygo(file: Path) -> StatedMap:
    """Map in Zygo's XYZ format: columns and rows of the camera, heights in µm, the pixel in metres in line 8."""
    data = file.read_bytes().replace(b"\r\n", b"\n")
    head, _, rest = data.partition(b"\n#\n")
    lines = head.decode("latin-1").split("\n")
    fields = lines[7].split() if len(lines) > 7 else []
    pixel = 1e6 * (positive(fields[6]) or 0.0) if len(fields) > 6 else 0.0
    body = rest.partition(b"\n#")[0]
    text = DelimitedText(file, b"\n" * (len(lines) + 1) + body, _ZYGO_LAYOUT)
    rows = text.numbers({"x": 0, "y": 1, "z": 2}, as_logged=True).columns
    x, y = (rows[name].astype(np.int64) - int(np.nanmin(rows[name])) for name in ("x", "y"))
    shape = int(x.max()) + 1, int(y.max()) + 1
    require_room(file, 16.0 * shape[0] * shape[1], RecordError)
    heights = np.full(shape, np.nan)
    heights[x, y] = rows["z"]
    return StatedMap(heights, (pixel, pixel) if pixel else None, 1.0)


def _by_surface_topography(file: Path) -> StatedMap:
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
            # A format without a mark of its own, which is taken for others: its name alone shows.
            known = "nms" if file.suffix.lower() == ".nms" else None
            reader = open_topography(str(file), format=known)
            channel = reader.default_channel
            sizes = channel.physical_sizes
            # Without a size, it asks for one.
            topography = reader.topography(**{} if sizes else {"physical_sizes": channel.nb_grid_pts})
            heights = np.ma.filled(np.ma.asarray(topography.heights(), dtype=np.float64), np.nan)
            unit = topography.unit
        except (ReadFileError, *DAMAGED_FILE_ERRORS) as problem:
            raise _unreadable(file, _own_reason(file) or problem) from None
    factor = FIELD_UNITS["um"].get(unit)
    if factor is None or sizes is None:
        return StatedMap(heights, None, factor)
    steps = [float(size) * factor / n for n, size in zip(heights.shape, sizes, strict=True)]
    if file.suffix.lower() == ".nms" and max(np.multiply(steps, heights.shape)) > WIDEST_um:
        steps = [1e-6 * step for step in steps]
    return StatedMap(heights, (steps[0], steps[1]), factor)


def _own_reason(file: Path) -> Exception | None:
    """Error of the reader for the format that the file's ending names; None if there is no such reader, or it
    succeeds.
    """
    from SurfaceTopography.IO import readers

    for reader in readers:
        with suppress(RuntimeError):  # what a reader without a usual end of names raises
            if file.suffix.lower().removeprefix(".") in reader.file_extensions():
                break
    else:
        return None
    try:
        reader(str(file))
    except Exception as problem:  # noqa: BLE001
        return problem
    return None


def _require_room(file: Path) -> bytes | None:
    """First lines of a text, on which reading is tried before the whole; None for other files.

    Raises RecordError if the file's contents do not fit into memory.
    """
    data = file.read_bytes()
    if data.startswith(b"PK\x03\x04"):
        with zipfile.ZipFile(io.BytesIO(data)) as parts:
            # A zipped map takes its parts, their numbers in floating point, and a copy of them.
            require_room(file, 4.0 * sum(part.file_size for part in parts.infolist()), RecordError)
        return None
    lines = data[:1_000_000].split(b"\n", HEAD_LINES)
    if b"\0" in data[:1000] or len(lines) <= HEAD_LINES:
        return None
    require_room(file, TEXT_EXPANSION * len(data), RecordError)
    return b"\n".join([*lines[:HEAD_LINES], b""])


#: Readers by the end of a file's name; SurfaceTopography reads all others.
_READERS: dict[str, Callable[[Path], StatedMap]] = {".npy": _of_numpy, ".x3p": _of_x3p}
