"""Scars guessed from a laboratory's files: points in texts, with names or without, and profilometers' maps."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from wirewear.base.errors import RecordError
from wirewear.records.importing.guessed_files import GuessedFile, mapped_columns
from wirewear.records.importing.height_maps import MapScale, StatedMap, stated_map
from wirewear.records.importing.mapping import PROFILOMETER
from wirewear.records.importing.mistaken import OPEN
from wirewear.records.importing.profilometry import ASKEW_deg, grid_of_points, wire_direction_deg
from wirewear.records.values import Array

#: Words in a file's name that tell whose scar it holds.
WIRE_WORDS = {
    "moving": ("moving", "upper", "oben", "oberer", "beweg", "mobile"),
    "fixed": ("fixed", "lower", "unten", "unterer", "fest", "ruhend", "static"),
}


def scars_of(
    points: Sequence[GuessedFile], maps: Sequence[Path], wires: Mapping[str, Any]
) -> tuple[dict[str, Any], list[str]]:
    """The tables `[scars.*]` of texts of points and of maps of such wires, and what was assumed."""
    scars: dict[str, Any] = {}
    remarks = []
    for text in points:
        if not {"x_um", "y_um"} <= text.columns.keys() or not {"depth_um", "height_um"} & text.columns.keys():
            remarks.append(f"{text.path.name} was left out: neither loops nor a scar were recognised in it")
            continue
        wire = _wire(text.path, scars, remarks)
        columns, told = mapped_columns(text)
        remarks += told
        if not text.named:
            units = ", ".join(unit.replace("um", "µm") for _, unit in text.columns.values())
            remarks.append(f"{text.path.name} names no columns: they are taken for x, y and height in {units}")
        if wire in scars:
            scars[wire]["files"] = [*listed(scars[wire]["files"]), text.path.name]
            continue
        scars[wire] = {"files": text.path.name, **text.spelling, "columns": columns}
        if any(OPEN in own.values() for own in columns.values()):
            continue
        if "height_um" in columns:
            found = text.read(columns)
            surface = grid_of_points(text.path, (found["x_um"], found["y_um"], found["height_um"]))
            scars[wire] |= _told(_laid(text.path, wire, wires, surface), remarks)
        else:
            scars[wire]["frame"] = "test"
            remarks.append(
                f"{text.path.name}: x is taken to run along the motion; where it runs along the {wire} wire, write "
                'frame = "wire"'
            )
    _add_maps(scars, maps, wires, remarks)
    return scars, remarks


def _add_maps(scars: dict[str, Any], maps: Sequence[Path], wires: Mapping[str, Any], remarks: list[str]) -> None:
    for path in maps:
        if (found := map_source(path, remarks)) is None:
            continue
        surface, keys = found
        wire = _wire(path, scars, remarks)
        if wire in scars:
            scars[wire]["files"] = [*listed(scars[wire]["files"]), path.name]
            continue
        scars[wire] = {"files": path.name, **keys}
        if surface.left_open:
            scars[wire] |= _told(_along_x(path, wire, "once its scale is told, the import sees it"), remarks)
        else:
            scars[wire] |= _told(_laid(path, wire, wires, surface.scaled(path, MapScale())), remarks)


def map_source(path: Path, remarks: list[str]) -> tuple[StatedMap, dict[str, Any]] | None:
    """A map, and the keys of a mapping that read it, open where its file does not state its scale; None if unreadable.

    Either is remarked.
    """
    try:
        surface = stated_map(path)
    except RecordError as problem:
        remarks.append(f"{path.name} was left out: {str(problem).removesuffix('.')}")
        return None
    left = surface.left_open
    if left:
        what = " and ".join(_SCALE[key] for key in left)
        remarks.append(f"{path.name} is taken for a map of heights, and does not state {what}{surface.remark}")
    return surface, {"kind": PROFILOMETER, **dict.fromkeys(left, OPEN)}


#: What a map may not state.
_SCALE = {
    "step_um": "how far its points are apart, in µm (with step_y_um, if it is another distance along y)",
    "height_unit": "the unit of its heights, such as um or nm",
}


def _told(found: tuple[dict[str, Any], str], remarks: list[str]) -> dict[str, Any]:
    """The keys that were found; what is said of them goes to the remarks."""
    remarks.append(found[1])
    return found[0]


def listed(files: str | list[str]) -> list[str]:
    """One name or several as a list."""
    return [files] if isinstance(files, str) else files


def _wire(path: Path, scars: dict[str, Any], remarks: list[str]) -> str:
    name = path.stem.lower()
    for wire, words in WIRE_WORDS.items():
        if any(word in name for word in words):
            return wire
    wire = "moving" if "moving" not in scars else "fixed"
    remarks.append(f"{path.name}: nothing in its name tells whose scar it is; it is taken for the {wire} wire's")
    return wire


def _along_x(path: Path, wire: str, later: str) -> tuple[dict[str, Any], str]:
    return {"frame": "wire", "axis": "x"}, f"{path.name}: the {wire} wire is taken to run along the map's x; {later}"


def _laid(
    path: Path, wire: str, wires: Mapping[str, Any], surface: tuple[Array, Array, Array]
) -> tuple[dict[str, Any], str]:
    """How a wire lies in a map of heights, as keys of a mapping: of the ways there are, the nearest; and a remark."""
    if wires["diameter_mm"] == OPEN:
        return _along_x(path, wire, "with --diameter its heights show it")
    found = wire_direction_deg(*surface, 500.0 * wires["diameter_mm"])
    crossing = wires["crossing_angle_deg"] if wire == "fixed" else 0.0
    ways = ((0.0, "x", "wire"), (90.0, "y", "wire"), (crossing, "x", "test"))
    offs = [abs((found - way[0] + 90.0) % 180.0 - 90.0) for way in ways]
    off, (angle, axis, frame) = min(zip(offs, ways, strict=True), key=lambda one: one[0])
    keys = {"frame": frame} if frame == "test" else {"frame": frame, "axis": axis}
    told = f"{path.name}: by its shape the {wire} wire lies at {found:.0f}° to the map's x"
    if off > ASKEW_deg:
        return (
            keys,
            f"{told}: neither along x or y nor at the stated crossing angle, {angle:g}°: give crossing_angle_deg",
        )
    x_is = "the motion of the test" if frame == "test" else f"the wire, which is its {axis} here"
    return keys, f'{told}: frame = "{frame}", x along {x_is}; `wirewear import --dry-run` draws it'
