"""Scars guessed from a laboratory's files: points in texts, with names or without, and profilometers' maps."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from geometry.arrays import Array
from wirewear.base.errors import RecordError
from wirewear.records.importing.guessed_files import GuessedFile, mapped_columns
from wirewear.records.importing.height_maps import MapScale, StatedMap, stated_map
from wirewear.records.importing.mapping import PROFILOMETER
from wirewear.records.importing.profilometry import ASKEW_deg, direction_deg, grid_of_points
from wirewear.records.importing.reader import OPEN
from wirewear.results.scar import called
from wirewear.study.bodies import Body

#: Words in a file's name that tell whose scar it holds.
WORDS = {
    "moving": ("moving", "upper", "oben", "oberer", "beweg", "mobile"),
    "fixed": ("fixed", "lower", "unten", "unterer", "fest", "ruhend", "static"),
    "flat": ("flat", "disc", "disk", "plane", "ebene", "platte", "scheibe", "lower", "unten"),
    "ball": ("ball", "sphere", "kugel", "upper", "oben"),
    "pad": ("pad", "cylinder", "zylinder", "punch", "stempel", "upper", "oben", "oberer"),
    "specimen": ("specimen", "flat", "plane", "probe", "ebene", "platte", "lower", "unten", "unterer"),
}


@dataclass(frozen=True)
class Touching:
    """What touches: tables of a mapping, names of the bodies, what was assumed, and the bodies where known.

    length_mm: of a line contact, which has worn profiles in place of scars.
    """

    tables: Mapping[str, Any]
    names: tuple[str, str]
    remarks: tuple[str, ...] = ()
    bodies: Mapping[str, Body] = field(default_factory=dict)
    length_mm: float | None = None


def scars_of(
    points: Sequence[GuessedFile], maps: Sequence[Path], touching: Touching
) -> tuple[dict[str, Any], list[str]]:
    """The tables `[scars.*]` of texts of points and of maps of such bodies, and what was assumed."""
    scars: dict[str, Any] = {}
    remarks = []
    for text in points:
        if not {"x_um", "y_um"} <= text.columns.keys() or not {"depth_um", "height_um"} & text.columns.keys():
            remarks.append(f"{text.path.name} was left out: neither loops nor a scar were recognised in it")
            continue
        body = body_of(text.path, touching.names, _next(scars, touching), remarks)
        columns, told = mapped_columns(text)
        remarks += told
        if not text.named:
            units = ", ".join(unit.replace("um", "µm") for _, unit in text.columns.values())
            remarks.append(f"{text.path.name} names no columns: they are taken for x, y and height in {units}")
        if body in scars:
            scars[body]["files"] = [*listed(scars[body]["files"]), text.path.name]
            continue
        scars[body] = {"files": text.path.name, **text.spelling, "columns": columns}
        if any(OPEN in own.values() for own in columns.values()):
            continue
        if "height_um" in columns:
            found = text.read(columns)
            surface = grid_of_points(text.path, (found["x_um"], found["y_um"], found["height_um"]))
            scars[body] |= _told(_laid(text.path, body, touching, surface), remarks)
        else:
            scars[body] |= _told(_along_motion(text.path, body), remarks)
    _add_maps(scars, maps, touching, remarks)
    return scars, remarks


def _add_maps(scars: dict[str, Any], maps: Sequence[Path], touching: Touching, remarks: list[str]) -> None:
    for path in maps:
        if (found := map_source(path, remarks)) is None:
            continue
        surface, keys = found
        body = body_of(path, touching.names, _next(scars, touching), remarks)
        if body in scars:
            scars[body]["files"] = [*listed(scars[body]["files"]), path.name]
            continue
        scars[body] = {"files": path.name, **keys}
        if surface.left_open:
            scars[body] |= _told(_along_x(path, body, "once its scale is told, the import sees it"), remarks)
        else:
            scars[body] |= _told(_laid(path, body, touching, surface.scaled(path, MapScale())), remarks)


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


def body_of(path: Path, names: tuple[str, str], otherwise: str, remarks: list[str]) -> str:
    """Whose worn surface a file holds by the words in its name, or with a remark the other one."""
    name = path.stem.lower()
    for body in names:
        if any(word in name for word in WORDS[body]):
            return body
    told = "nothing in its name tells whose surface it holds"
    remarks.append(f"{path.name}: {told}; it is taken for the {called(otherwise)}'s")
    return otherwise


def _next(scars: dict[str, Any], touching: Touching) -> str:
    """The first body without a scar."""
    return touching.names[touching.names[0] in scars]


def _along_motion(path: Path, body: str) -> tuple[dict[str, Any], str]:
    told = f"x is taken to run along the motion; where it runs along the {called(body)}"
    return {"frame": "test"}, f'{path.name}: {told}, write frame = "wire"'


def _along_x(path: Path, body: str, later: str) -> tuple[dict[str, Any], str]:
    told = f"the {called(body)} is taken to run along the map's x; {later}"
    return {"frame": "wire", "axis": "x"}, f"{path.name}: {told}"


def _laid(path: Path, name: str, touching: Touching, surface: tuple[Array, Array, Array]) -> tuple[dict[str, Any], str]:
    """How a body lies in a map of heights, as keys of a mapping: of the ways there are, the nearest; and a remark."""
    if (body := touching.bodies.get(name)) is None:
        return _along_x(path, name, "with --diameter its heights show it")
    if not body.has_axis:
        return _along_motion(path, name)
    found = direction_deg(*surface, body.curvatures_per_mm)
    ways = ((0.0, "x", "wire"), (90.0, "y", "wire"), (body.axis_angle_deg, "x", "test"))
    offs = [abs((found - way[0] + 90.0) % 180.0 - 90.0) for way in ways]
    off, (angle, axis, frame) = min(zip(offs, ways, strict=True), key=lambda one: one[0])
    keys = {"frame": frame} if frame == "test" else {"frame": frame, "axis": axis}
    told = f"{path.name}: by its shape the {called(name)} lies at {found:.0f}° to the map's x"
    if off > ASKEW_deg:
        return (
            keys,
            f"{told}: neither along x or y nor at the stated crossing angle, {angle:g}°: give crossing_angle_deg",
        )
    x_is = "the motion of the test" if frame == "test" else f"the wire, which is its {axis} here"
    return keys, f'{told}: frame = "{frame}", x along {x_is}; `wirewear import --dry-run` draws it'
