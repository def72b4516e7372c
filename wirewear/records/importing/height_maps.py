"""Height maps of profilometers: Zygo's points, matrices in texts, and all formats that SurfaceTopography reads."""

import io
import warnings
import zipfile
from pathlib import Path

import numpy as np

from wirewear.base.budget import require_room
from wirewear.base.delimited import DelimitedLayout, DelimitedText
from wirewear.base.errors import RecordError
from wirewear.base.quantity import FIELD_UNITS
from wirewear.records.importing.map_scale import Map, MapScale, StatedMap, positive
from wirewear.records.importing.matrices import matrix_of
from wirewear.records.importing.reader import DAMAGED_FILE_ERRORS, reason_of

#: Ends of names of profilometers' files, which SurfaceTopography reads.
MAPS = frozenset(
    (".al3d", ".datx", ".di", ".ezd", ".gwy", ".ibw", ".mnt", ".nid", ".nms", ".npy", ".oir", ".opd", ".opdx", ".os3d")
    + (".plu", ".plux", ".poir", ".sdf", ".spm", ".stp", ".sur", ".vk4", ".vk6", ".vk7", ".wsf", ".x3p", ".zag", ".zmg")
)

#: Lines of a text on which SurfaceTopography is tried before it reads the whole, which takes it 160 bytes a byte.
HEAD_LINES, TEXT_EXPANSION = 200, 160.0

#: A zipped map takes its parts, their numbers in floating point, and a copy of them.
ZIP_EXPANSION = 4.0

#: No profilometer sees so far, in µm: NanoFocus files state their points' distance in nm where millimetres are read.
WIDEST_um = 1e6

_ZYGO = b"Zygo XYZ Data File"


def is_map(path: Path) -> bool:
    """Whether a file is a height map: by the end of its name, or as a matrix in a text that states its size."""
    if path.suffix.lower() in MAPS:
        return True
    try:
        if path.read_bytes()[: len(_ZYGO)] == _ZYGO:
            return True
        matrix = matrix_of(path)
    except RecordError:
        return False
    return matrix is not None and matrix.states_scale


def height_map(file: Path, told: MapScale | None = None) -> Map:
    """Lines x (n_x,), y (n_y,) and heights (n_x, n_y), all in µm; NaN where nothing was measured.

    Raises:
        RecordError: the file cannot be read, or neither it nor `told` states its size, which is finite, and unit.
    """
    return stated_map(file).scaled(file, told or MapScale())


def stated_map(file: Path) -> StatedMap:
    """A map with what its file states of its scale.

    Raises:
        RecordError: the file cannot be read; one sentence.
    """
    if file.is_file() and file.read_bytes()[: len(_ZYGO)] == _ZYGO:
        return _zygo(file)
    if file.suffix.lower() not in MAPS and (matrix := matrix_of(file)) is not None:
        return matrix.read(file)
    found = _of_numpy(file) if file.suffix.lower() == ".npy" else _by_surface_topography(file)
    if found.heights.ndim != 2 or min(found.heights.shape) < 3:
        raise RecordError(f"{file}: the map must be two-dimensional.")
    return found


def _of_numpy(file: Path) -> StatedMap:
    """An array of heights (n_x, n_y), which has no scale; mapped, so that a part cut off is seen."""
    try:
        return StatedMap(np.array(np.load(file, mmap_mode="r"), dtype=np.float64), None, None)
    except DAMAGED_FILE_ERRORS as problem:
        raise _unreadable(file, problem) from None


def _unreadable(file: Path, problem: Exception) -> RecordError:
    return RecordError(f"{file} cannot be read as a profilometer's map ({reason_of(problem)}).")


def _zygo(file: Path) -> StatedMap:
    """A map in Zygo's XYZ format: columns and rows of the camera, heights in µm, the pixel in metres in line 8."""
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


_ZYGO_LAYOUT = DelimitedLayout(delimiter=None, names_line=False)


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
            # A format without a mark of its own, which is taken for others: its name alone tells.
            known = "nms" if file.suffix.lower() == ".nms" else None
            reader = open_topography(str(file), format=known)
            channel = reader.default_channel
            sizes = channel.physical_sizes
            # Without a size, it asks for one.
            topography = reader.topography(**{} if sizes else {"physical_sizes": channel.nb_grid_pts})
            heights = np.ma.filled(np.ma.asarray(topography.heights(), dtype=np.float64), np.nan)
            unit = topography.unit
        except (ReadFileError, *DAMAGED_FILE_ERRORS) as problem:
            raise _unreadable(file, problem) from None
    factor = FIELD_UNITS["um"].get(unit)
    if factor is None or sizes is None:
        return StatedMap(heights, None, factor)
    steps = [float(size) * factor / n for n, size in zip(heights.shape, sizes, strict=True)]
    if file.suffix.lower() == ".nms" and max(np.multiply(steps, heights.shape)) > WIDEST_um:
        steps = [1e-6 * step for step in steps]
    return StatedMap(heights, (steps[0], steps[1]), factor)


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
