"""Worn depths from measured heights, by fitting and subtracting the unworn surface of a map, or face of a profile.

Levelling is that fit. A form is a deviation of the body's unworn shape from the stated one; the crown is the highest
line or point of a round body.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from geometry import Cylinder, Flat
from geometry.arrays import Array, BoolArray
from wirewear.base.errors import RecordError
from wirewear.records.common_tables import OfTest
from wirewear.records.contact_tables import LineTest
from wirewear.records.importing.height_maps import height_map
from wirewear.records.importing.mapping import PROFILOMETER, PointMapping, ProfileSource, ScarSource
from wirewear.records.importing.sources import columns_of_levels, files_of, numbers_in_name
from wirewear.records.levelling import unworn_surface
from wirewear.records.profiles import MeasuredProfile
from wirewear.records.scars import MeasuredScar, grid_of
from wirewear.records.spikes import without_spikes
from wirewear.records.surface_search import direction_deg
from wirewear.records.surfaces import PROFILES, SCARS
from wirewear.records.unworn_bodies import FaceSurface, RoundSurface
from wirewear.results.scar import called
from wirewear.test.bodies import Body, Wire
from wirewear.test.faces import Face

FEWEST_POINTS = 100  #: Fewer points show no cylinder.


#: Share of a body's radius beyond which its flanks are too steep to be measured; beyond any map of a straight one.
STEEP, BEYOND_um = 0.95, 1e9

DEEPEST_um = 1e4  #: What lies farther below or above a map's middle is a number written for "nothing".

#: A wire that lies farther off than this from where the mapping says is another one: half of the least crossing angle.
ASKEW_deg = 15.0

FEWEST_ON_LINE = 20  #: Fewer points show no face.


@dataclass(frozen=True)
class MapOfBody:
    """Map file of a body's surface in one repeat; source: the mapping's table on it, which states how the body lies in
    it.
    """

    file: Path
    source: ScarSource
    body: Body
    repeat: int

    @property
    def axis_deg(self) -> float:
        """Angle of the body's axis from the map's x: its own in the test's frame, else as the mapping says."""
        if self.source.frame == "test":
            return self.body.axis_angle_deg
        return 90.0 if self.source.axis == "y" else 0.0

    @property
    def crown_unknown(self) -> bool:
        """True if only the scar shows where the body was touched: for any but wires, a small tilt moves the crown
        far.
        """
        return not isinstance(self.body, Wire)

    def require_direction(self, x: Array, y: Array, height: Array) -> None:
        """Raise RecordError if the body lies in its map (n_x, n_y), in µm, at another angle than the mapping says."""
        found = direction_deg(x, y, height, self.body.curvatures_per_mm)
        askew = (found - self.axis_deg + 90.0) % 180.0 - 90.0
        if abs(askew) > ASKEW_deg:
            raise RecordError(
                f"{self.file}: the {called(self.body.name)} lies at {self.axis_deg + askew:.0f}° to the map's x, not "
                f'at {self.axis_deg:.0f}° as the mapping says: give its frame ("test": x along the motion; "wire": x '
                'along its axis, or y with axis = "y"), and the angles of the axes.'
            )


def grid_of_points(file: Path, points: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
    """Lines x (n_x,), y (n_y,) and heights (n_x, n_y) in µm of points, each (n,); interpolated if they lie on no grid.
    Raises RecordError, whose message begins with `file`, if there are fewer than FEWEST_POINTS points.
    """
    x, y, height = (values[np.isfinite(points[0] + points[1])] for values in points)
    if x.size < FEWEST_POINTS:
        raise RecordError(f"{file}: a scar's map of heights needs {FEWEST_POINTS} points, not {x.size}.")
    try:
        return grid_of(0, x, y, height)
    except RecordError:
        return _gridded(x, y, height)


def _gridded(x: Array, y: Array, height: Array) -> tuple[Array, Array, Array]:
    """Points (n,) interpolated to a grid of similar density; NaN outside of them."""
    from scipy.interpolate import griddata

    known = np.isfinite(height)
    x, y, height = x[known], y[known], height[known]
    step = float(np.sqrt(np.ptp(x) * np.ptp(y) / x.size))
    lines = [np.linspace(v.min(), v.max(), max(int(np.ptp(v) / step), 2)) for v in (x, y)]
    places = np.meshgrid(*lines, indexing="ij")
    return lines[0], lines[1], np.asarray(griddata((x, y), height, tuple(places)))


def scar_of(of: MapOfBody, x: Array, y: Array, height: Array, *, form: bool = True) -> MeasuredScar:
    """Scar in a map of heights (n_x, n_y) over lines x (n_x,), y (n_y,) in µm, with its origin in the scar's middle.

    form: True to subtract the body's form with the unworn surface. Raises RecordError if the points are too few, or lie
    beyond the body or at another angle than the mapping says.
    """
    x, y = x - 0.5 * (x[0] + x[-1]), y - 0.5 * (y[0] + y[-1])
    crown, axis_deg, notes = None if of.crown_unknown else 0.0, of.axis_deg, tuple[str, ...]()
    if of.source.subtract_wire:
        height, crown, turn_deg, notes = _levelled(of, x, y, height, form=form)
        if of.source.frame != "test":
            # A body's own frame is that of the body as it lies there.
            axis_deg += turn_deg
    depth, spikes = without_spikes(-height)
    weight = np.maximum(np.nan_to_num(depth), 0.0) ** 2
    places = _along_and_across(x, y, axis_deg)
    along, across = (
        [float(np.sum(weight * one)) / float(weight.sum()) for one in places] if weight.any() else (0.0, 0.0)
    )
    across = across if crown is None else crown
    cosine, sine = np.cos(np.radians(axis_deg)), np.sin(np.radians(axis_deg))
    x, y = x - (along * cosine - across * sine), y - (along * sine + across * cosine)
    askew_deg = 0.0 if of.source.frame == "test" else of.body.axis_angle_deg - axis_deg
    left_out = np.where(spikes, -height, np.nan) if spikes.any() else None
    return MeasuredScar(of.repeat, of.body.name, x, y, depth, left_out, notes).turned(askew_deg)


def _along_and_across(x: Array, y: Array, axis_deg: float) -> Array:
    """Coordinates (2, n_x, n_y) of a grid along an axis at an angle to its x, and across it."""
    cosine, sine = np.cos(np.radians(axis_deg)), np.sin(np.radians(axis_deg))
    return np.stack([x[:, None] * cosine + y[None, :] * sine, y[None, :] * cosine - x[:, None] * sine])


def _levelled(
    of: MapOfBody, x: Array, y: Array, height: Array, *, form: bool
) -> tuple[Array, float | None, float, tuple[str, ...]]:
    """Heights above the unworn surface, the crown's coordinate across its axis (or None), rotation of the axis in
    degrees against the mapping's, and remarks.
    """
    if of.body.face is not None:
        raise RecordError(f"{of.file}: heights of a pad's face cannot be levelled: import its worn depths.")
    radii_um = 500.0 * np.array(of.body.diameters_mm)
    curved, limit = np.isfinite(radii_um), np.minimum(STEEP * radii_um, BEYOND_um)[:, None]
    places = _along_and_across(x, y, of.axis_deg)
    flat = places.reshape(2, -1)
    # A point farther off than the body is thick is none of its surface: a number written for "nothing".
    middle = float(np.median(height[np.isfinite(height)])) if np.isfinite(height).any() else 0.0
    height = np.where(np.abs(height - middle) < min(2.0 * radii_um.min(), DEEPEST_um), height, np.nan)
    known = np.isfinite(height).ravel()
    top = known & (height.ravel() >= (np.percentile(height.ravel()[known], 95) if known.any() else 0.0))
    ridge = np.where(curved, np.median(flat[:, top], axis=1) if known.any() else 0.0, 0.0)
    seen = known & (np.abs(flat - ridge[:, None]) < limit).all(axis=0)
    if np.count_nonzero(seen) < FEWEST_POINTS:
        raise RecordError(
            f"{of.file}: the map must lie within the width of the {called(of.body.name)}, {2.0 * radii_um.min():g} µm, "
            f"and hold {FEWEST_POINTS} points."
        )
    if of.body.has_axis:
        of.require_direction(x, y, height)
    surface = RoundSurface(of.body.curvatures_per_mm, (0.5 * float(np.ptp(flat[0])), 0.5 * float(np.ptp(flat[1]))))
    start = surface.moving(ridge)
    start[0] = np.median(height.ravel()[top])
    found = unworn_surface(surface, places, np.where(seen.reshape(height.shape), height, np.nan), start, form=form)
    steep = (np.abs(surface.beside(found.parameters, flat)) >= limit).any(axis=0).reshape(height.shape)
    unworn = surface.height(found.parameters, flat).reshape(height.shape)
    rest = np.where(steep, np.nan, height - unworn)
    notes = found.remarks(of.file.name, -rest, places, surface, of.body.name if form else "")
    crown = None if of.crown_unknown else float(found.parameters[2] * surface.scales[2])
    return rest, crown, surface.turned_deg(found.parameters), notes


def surfaces_of(
    source: ScarSource | ProfileSource, body: str, home: Path, tables: OfTest
) -> Iterator[MeasuredScar | MeasuredProfile]:
    """Worn surfaces of a body in the files of a source: maps with x along the motion, or profiles.

    home: folder of the mapping. tables: the mapping's. Raises RecordError if a file cannot be read or lacks something,
    or a repeat occurs twice.
    """
    seen: dict[int, Path] = {}
    for place, file in enumerate(files_of(source, home)):
        # Without a pattern, files stand for repeats in their order.
        repeat = numbers_in_name(file, source).get("repeat", source.repeat + place)
        for one in _IN_FILE[tables.worn.name](file, source, body, tables, repeat):
            if one.repeat in seen:
                raise RecordError(
                    f"{file}: [{tables.worn.name}s.{body}] finds repeat {one.repeat} twice, first in "
                    f"{seen[one.repeat].name}: name_pattern or a column must distinguish them."
                )
            seen[one.repeat] = file
            for column in tables.worn.columns:
                values = np.atleast_1d(one.points.get(column.name, one.repeat))
                if (wrong := column.first_wrong(values)) is not None:
                    raise RecordError(
                        f"{file}: {column.name} is {values[wrong]:g} in the {called(body)}'s {tables.worn.name}, where "
                        f"{column.kind} should stand: is a unit of the mapping wrong?"
                    )
            yield one


def _scars_in(file: Path, source: ScarSource, name: str, tables: PointMapping, repeat: int) -> Iterator[MeasuredScar]:
    body = tables.body(name)
    if source.kind == PROFILOMETER:
        yield scar_of(MapOfBody(file, source, body, repeat), *height_map(file, source.scale))
        return
    given, columns = columns_of_levels(file, source, source.columns, f"scars.{name}", repeat)
    for number in np.unique(columns["repeat"]):
        own: BoolArray = columns["repeat"] == number
        x, y, level = (columns[name][own] for name in ("x_um", "y_um", given))
        if given == "height_um":
            yield scar_of(MapOfBody(file, source, body, int(number)), *grid_of_points(file, (x, y, level)))
            continue
        try:
            scar = MeasuredScar.from_points(int(number), name, x, y, level)
            yield scar.turned(body.axis_angle_deg if source.frame == "wire" else 0.0)
        except RecordError as problem:
            raise RecordError(f"{file}: {problem}") from None


def levelled(
    file: Path,
    repeat: int,
    body: str,
    face: Face | Flat,
    heights: tuple[Array, Array],
    *,
    subtract: bool,
    form: bool = True,
) -> MeasuredProfile:
    """Profile of worn depths from positions and heights, both (n,) in µm, with its origin in the scar's middle.

    subtract: fit and subtract the unworn face; else depths are heights below 0. form: subtract the body's form with it.
    Raises RecordError if there are too few points.
    """
    x, height = heights
    if x.size < FEWEST_ON_LINE or np.ptp(x) <= 0.0:
        raise RecordError(
            f"{file}: a profile of heights needs {FEWEST_ON_LINE} points beside one another, not {x.size}."
        )
    middle = 0.5 * (float(x[0]) + float(x[-1]))
    fitted, notes = np.zeros_like(height), tuple[str, ...]()
    if subtract:
        surface = FaceSurface(face, 0.5 * float(np.ptp(x)), not isinstance(face, Cylinder | Flat))
        places = np.stack([(x - middle)[:, None], np.zeros((x.size, 1))])
        start = np.zeros(surface.placing)
        start[0] = np.percentile(height, 90)
        found = unworn_surface(surface, places, height[:, None], start, form=form)
        fitted = surface.height(found.parameters, places[..., 0])
        notes = found.remarks(file.name, (fitted - height)[:, None], places, surface, body if form else "")
    measured = fitted - height
    clean, spikes = without_spikes(measured[:, None])
    depth = clean[:, 0]
    weight = np.maximum(depth, 0.0) ** 2
    scar = float(weight @ x) / float(weight.sum()) if weight.any() else middle
    left_out = np.where(spikes[:, 0], measured, np.nan) if spikes.any() else None
    return MeasuredProfile(repeat, body, x - scar, depth, height, fitted, left_out, notes)


def _profiles_in(
    file: Path, source: ProfileSource, body: str, tables: LineTest, repeat: int
) -> Iterator[MeasuredProfile]:
    face = dict(zip(tables.body_names, (tables.pad.profile, Flat()), strict=True))[body]
    if source.kind == PROFILOMETER:
        heights = _line_of_map(file, source)
        yield levelled(file, repeat, body, face, heights, subtract=source.subtract_face)
        return
    given, columns = columns_of_levels(file, source, source.columns, f"profiles.{body}", repeat, source.step_um)
    for number in np.unique(columns["repeat"]):
        own = (columns["repeat"] == number) & np.isfinite(columns["x_um"]) & np.isfinite(columns[given])
        # Points sorted by position, with the mean of those at the same position.
        places, where, count = np.unique(columns["x_um"][own], return_inverse=True, return_counts=True)
        x, level = places, np.bincount(where, weights=columns[given][own]) / count
        if x.size < 3:
            raise RecordError(f"{file}: the {body}'s profile of repeat {number:g} has fewer than three points.")
        if given == "depth_um":
            yield MeasuredProfile.from_points(int(number), body, x, level)
        else:
            yield levelled(file, int(number), body, face, (x, level), subtract=source.subtract_face)


def _line_of_map(file: Path, source: ProfileSource) -> tuple[Array, Array]:
    """Positions along the motion and mean heights across it, both (n,) in µm."""
    x, y, height = height_map(file, source.scale)
    if source.axis == "y":
        x, height = y, height.T
    known = np.isfinite(height)
    count = known.sum(axis=1)
    line = np.where(known, height, 0.0).sum(axis=1) / np.maximum(count, 1)
    return x[count > 0], line[count > 0]


_IN_FILE: dict[str, Callable[[Path, Any, str, Any, int], Iterator[Any]]] = {
    SCARS.name: _scars_in,
    PROFILES.name: _profiles_in,
}
