"""Guess of a mapping's worn surfaces: whose scar a file holds, and how the body lies in its map of heights."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from geometry.arrays import Array
from wirewear.base.errors import RecordError
from wirewear.base.files import table_of
from wirewear.base.naming import plain
from wirewear.records.importing.guessed_columns import GuessedFile
from wirewear.records.importing.guessed_files import mapped_columns
from wirewear.records.importing.height_maps import MapScale, StatedMap, stated_map
from wirewear.records.importing.mapping import PROFILOMETER
from wirewear.records.importing.profilometry import ASKEW_deg, grid_of_points
from wirewear.records.surface_search import direction_deg
from wirewear.results.scar import called
from wirewear.test.bodies import OPEN, BodiesByOptions, Body
from wirewear.test.kinds import KINDS

_A_LINE = "it is a profile along a line, and contacts at a point need maps of their scars: x, y and height or depth"
_PLANE = ("flat", "plan", "ebene", "platte", "plaque", "placa", "piastra", "lower", "unten")

#: Words in a file's name that show whose scar it holds.
WORDS = {
    "moving": ("moving", "upper", "oben", "oberer", "beweg", "mobile"),
    "fixed": ("fixed", "lower", "unten", "unterer", "fest", "ruhend", "static"),
    "flat": (*_PLANE, "disc", "disk", "scheibe", "disque", "disco"),
    "ball": ("ball", "sphere", "kugel", "bille", "boule", "bola", "sfera", "esfera", "upper", "oben"),
    "pad": ("pad", "cylinder", "zylinder", "punch", "stempel", "upper", "oben", "oberer"),
    "specimen": (*_PLANE, "specimen", "probe", "eprouvette", "probeta", "provino", "unterer"),
}

#: What a map may not state.
_SCALE = {
    "step_um": "how far its points are apart, in µm (with step_y_um, if it is another distance along y)",
    "height_unit": "the unit of its heights, such as um or nm",
}


@dataclass(frozen=True)
class Touching:
    """Bodies in contact: their names, and what the user's options state of them."""

    names: tuple[str, ...]
    stated: BodiesByOptions

    @classmethod
    def of(
        cls, kind: str, known: Mapping[str, object], elastic: Mapping[str, object], of_other: Mapping[str, object]
    ) -> Self:
        """Bodies of the contact `kind` from options by key. elastic, of_other: elastic constants of both bodies, and of
        the pad or ball. Raises RecordError, in one sentence, if something is missing that no file states.
        """
        return cls(KINDS[kind].body_names, KINDS[kind].bodies.by_options(known, elastic, of_other))

    @property
    def bodies(self) -> Mapping[str, Body]:
        """Bodies that the options describe, by name."""
        return {body.name: body for body in self.stated.bodies}


def scars_of(
    points: Sequence[GuessedFile], maps: Sequence[Path], touching: Touching
) -> tuple[dict[str, object], list[str]]:
    """Tables `[scars.*]` of a mapping, by body, for texts with points and for maps, and sentences on assumptions and on
    files left out.
    """
    scars: dict[str, Any] = {}
    remarks = [f"{text.path.name} was left out: there are no bodies" for text in points if not touching.names]
    for text in points if touching.names else ():
        if not {"x_um", "y_um"} <= text.columns.keys() or not {"depth_um", "height_um"} & text.columns.keys():
            line = "x_um" in text.columns and "y_um" not in text.columns
            why = _A_LINE if line else "neither loops nor a scar were recognised in it"
            remarks.append(f"{text.path.name} was left out: {why}")
            continue
        body = body_of(text.path, touching.names, _next(scars, touching), remarks)
        columns, more = mapped_columns(text)
        remarks += more
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
            scars[body] |= _noted(laid(text.path, body, touching, surface), remarks)
        else:
            scars[body] |= _noted(along_motion(text.path, body, touching, depths=True), remarks)
    _add_maps(scars, maps if touching.names else (), touching, remarks)
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
            scars[body] |= _noted(
                along_x(path, body, touching, "once its scale is stated, the import sees it"), remarks
            )
        else:
            scars[body] |= _noted(laid(path, body, touching, surface.scaled(path, MapScale())), remarks)


def map_source(path: Path, remarks: list[str]) -> tuple[StatedMap, dict[str, object]] | None:
    """The map of a file, and a mapping's keys to read it, open if the file does not state its scale; None if it cannot
    be read. A sentence on what is missing is appended to `remarks`.
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


def _noted(found: tuple[dict[str, Any], str], remarks: list[str]) -> dict[str, Any]:
    remarks.append(found[1])
    return found[0]


def listed(files: str | list[str]) -> list[str]:
    """File names as a list, from one name or several."""
    return [files] if isinstance(files, str) else files


def body_of(path: Path, names: Sequence[str], otherwise: str, remarks: list[str]) -> str:
    """Name of the body whose surface a file holds, by words in the file's name; else `otherwise`, and a sentence is
    appended to `remarks`. names: of the bodies in contact.
    """
    name = plain(path.stem)
    for body in names:
        if any(word in name for word in WORDS[body]):
            return body
    message = "nothing in its name shows whose surface it holds"
    remarks.append(f"{path.name}: {message}; it is taken for the {called(otherwise)}'s")
    return otherwise


def _next(scars: dict[str, Any], touching: Touching) -> str:
    return touching.names[touching.names[0] in scars]


def _has_axis(name: str, touching: Touching) -> bool:
    body = touching.bodies.get(name)
    return name in touching.stated.with_axis if body is None else body.has_axis


def along_motion(path: Path, name: str, touching: Touching, *, depths: bool = False) -> tuple[dict[str, object], str]:
    if _has_axis(name, touching):
        otherwise = f'it runs along the {called(name)}, write frame = "wire"'
    elif depths:
        otherwise = "y does, exchange the columns of x_um and y_um"
    else:
        otherwise = 'y does, write frame = "wire" and axis = "y"'
    return {"frame": "test"}, f"{path.name}: x is taken to run along the motion; where {otherwise}"


def along_x(path: Path, name: str, touching: Touching, later: str) -> tuple[dict[str, object], str]:
    if not _has_axis(name, touching):
        return along_motion(path, name, touching)
    message = f"the {called(name)} is taken to run along the map's x; {later}"
    return {"frame": "wire", "axis": "x"}, f"{path.name}: {message}"


def laid(
    path: Path, name: str, touching: Touching, surface: tuple[Array, Array, Array]
) -> tuple[dict[str, object], str]:
    """Keys of a mapping for how the body `name` lies in a map of heights, the nearest of the possible ways, and a
    sentence. path: names the map. touching: the bodies. surface: lines x (n_x,), y (n_y,) and heights (n_x, n_y) in µm.
    """
    if (body := touching.bodies.get(name)) is None:
        return along_x(path, name, touching, "with --diameter its heights show it")
    if not body.has_axis:
        return along_motion(path, name, touching)
    found = direction_deg(*surface, body.curvatures_per_mm)
    ways = ((0.0, "x", "wire"), (90.0, "y", "wire"), (body.axis_angle_deg, "x", "test"))
    offs = [abs((found - way[0] + 90.0) % 180.0 - 90.0) for way in ways]
    off, (_, axis, frame) = min(zip(offs, ways, strict=True), key=lambda one: one[0])
    keys: dict[str, object] = {"frame": frame} if frame == "test" else {"frame": frame, "axis": axis}
    message = f"{path.name}: by its shape the {called(name)} lies at {found:.0f}° to the map's x"
    if off > ASKEW_deg:
        crossing = table_of(touching.stated.tables, "wires")["crossing_angle_deg"]
        return (
            keys,
            f"{message}: neither along x or y nor at the crossing angle, {crossing:g}°: give crossing_angle_deg",
        )
    x_is = "the motion of the test" if frame == "test" else f"the wire, which is its {axis} here"
    return keys, f'{message}: frame = "{frame}", x along {x_is}; `wirewear import --dry-run` draws it'
