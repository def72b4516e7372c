"""Worn depths from heights: of a wire's map the unworn cylinder is fitted and subtracted, of a line the unworn face."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from geometry import Cylinder, Flat
from wirewear.base.errors import RecordError
from wirewear.planar.tables import Face
from wirewear.records.importing.height_maps import height_map
from wirewear.records.importing.mapping import PROFILOMETER, Mapping, ProfileSource, ScarSource
from wirewear.records.importing.sources import columns_of_levels, files_of, numbers_in_name
from wirewear.records.line_tables import LineTest
from wirewear.records.surfaces import PROFILES, SCARS, Array, MeasuredProfile, MeasuredScar
from wirewear.records.tables import RecordWires

#: Points that the fitted cylinder is sought on, at most; a map has often millions.
MOST_POINTS = 20_000

#: Points that a wire's direction is sought on; rounds in which a fit settles on what is not worn.
FEWER_POINTS, ROUNDS = 2_000, 5

#: Noise of unworn points hardly exceeds this many deviations; nothing is known better than this of a height.
FAR, FINEST_um = 3.0, 1e-3

#: What lies within so many sizes of the scar is not taken to be unworn, if more than a share of the map is left.
ABOUT, LEAST_UNWORN = 1.25, 0.2

#: Fewer points tell no cylinder.
FEWEST_POINTS = 100


#: Share of the wire's radius beyond which its flanks are too steep to be measured.
STEEP = 0.95

#: A wire that lies farther off than this from where the mapping says is another one: half of the least crossing angle.
ASKEW_deg = 15.0


@dataclass(frozen=True)
class MapOfWire:
    """Whose surface a file holds: the `wire` of a repeat's test, and how the mapping says that it lies there."""

    file: Path
    source: ScarSource
    wires: RecordWires
    wire: str
    repeat: int

    @property
    def axis_deg(self) -> float:
        """Direction of the wire's axis from the map's x, as the mapping says."""
        if self.source.frame == "test":
            return self.wires.axis_angle_deg(self.wire)
        return 90.0 if self.source.axis == "y" else 0.0


def scar_of_map(of: MapOfWire) -> MeasuredScar:
    """The scar of a height map in any format that SurfaceTopography reads; the origin is put at the scar's middle.

    Raises:
        RecordError: SurfaceTopography cannot read the file, or the map lacks its size or unit.
    """
    return _scar(of, *height_map(of.file, of.source.scale))


def scar_of_heights(of: MapOfWire, points: tuple[Array, Array, Array]) -> MeasuredScar:
    """The scar of points x, y, height (n,) in µm; points off a grid are laid on one as dense as they are.

    Raises:
        RecordError: the points are too few, or lie beyond the wire.
    """
    return _scar(of, *grid_of_points(of.file, points))


def grid_of_points(file: Path, points: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
    """Lines x (n_x,), y (n_y,) and heights (n_x, n_y) of points (n,) in µm, as `height_map` has them.

    Raises:
        RecordError: the points are too few.
    """
    x, y, height = (values[np.isfinite(points[0] + points[1])] for values in points)
    if x.size < FEWEST_POINTS:
        raise RecordError(f"{file}: a scar's map of heights needs {FEWEST_POINTS} points, not {x.size}.")
    try:
        grid = MeasuredScar.from_points(0, "", x, y, height)
    except RecordError:
        return _gridded(x, y, height)
    return grid.x_um, grid.y_um, np.array(grid.depth_um)


def _gridded(x: Array, y: Array, height: Array) -> tuple[Array, Array, Array]:
    """Points (n,) interpolated onto a grid that has about as many; NaN outside of what they enclose."""
    from scipy.interpolate import griddata

    known = np.isfinite(height)
    x, y, height = x[known], y[known], height[known]
    step = float(np.sqrt(np.ptp(x) * np.ptp(y) / x.size))
    lines = [np.linspace(v.min(), v.max(), max(int(np.ptp(v) / step), 2)) for v in (x, y)]
    places = np.meshgrid(*lines, indexing="ij")
    return lines[0], lines[1], np.asarray(griddata((x, y), height, tuple(places)))


def _scar(of: MapOfWire, x: Array, y: Array, height: Array) -> MeasuredScar:
    x, y = x - 0.5 * (x[0] + x[-1]), y - 0.5 * (y[0] + y[-1])
    crown, axis_deg = 0.0, of.axis_deg
    if of.source.subtract_wire:
        height, crown, turn_deg = _unrolled(of, x, y, height)
        if of.source.frame != "test":
            # A wire's own frame is that of the wire as it lies there.
            axis_deg += turn_deg
    depth = -height
    cosine, sine = np.cos(np.radians(axis_deg)), np.sin(np.radians(axis_deg))
    weight = np.maximum(np.nan_to_num(depth), 0.0) ** 2
    along = x[:, None] * cosine + y[None, :] * sine
    middle = float(np.sum(weight * along)) / float(weight.sum()) if weight.any() else 0.0
    x, y = x - (middle * cosine - crown * sine), y - (middle * sine + crown * cosine)
    askew_deg = 0.0 if of.source.frame == "test" else of.wires.axis_angle_deg(of.wire) - axis_deg
    return MeasuredScar(of.repeat, of.wire, x, y, depth).turned(askew_deg)


def _unrolled(of: MapOfWire, x: Array, y: Array, height: Array) -> tuple[Array, float, float]:
    """Height above the unworn cylinder, the crown's place across its axis, and by how much [deg] the axis is turned.

    Least squares with a loss that counts points far below the surface for little: what is worn does not pull the fit.
    """
    radius_um = 500.0 * of.wires.diameter_mm
    cosine, sine = np.cos(np.radians(of.axis_deg)), np.sin(np.radians(of.axis_deg))
    along, across = x[:, None] * cosine + y[None, :] * sine, y[None, :] * cosine - x[:, None] * sine
    # A point farther off than the wire is thick is none of its surface: a spike, or a number written for "nothing".
    middle = float(np.median(height[np.isfinite(height)])) if np.isfinite(height).any() else 0.0
    height = np.where(np.abs(height - middle) < 2.0 * radius_um, height, np.nan)
    known = np.isfinite(height)
    top = float(np.percentile(height[known], 95)) if known.any() else 0.0
    ridge = float(np.median(across[known & (height >= top)])) if known.any() else 0.0
    seen = np.flatnonzero((known & (np.abs(across - ridge) < STEEP * radius_um)).ravel())
    if seen.size < FEWEST_POINTS:
        raise RecordError(
            f"{of.file}: the map must lie within the wire's width, {2.0 * radius_um:g} µm, and hold "
            f"{FEWEST_POINTS} points."
        )
    askew = (wire_direction_deg(x, y, height, radius_um) - of.axis_deg + 90.0) % 180.0 - 90.0
    if abs(askew) > ASKEW_deg:
        raise RecordError(
            f"{of.file}: the {of.wire} wire lies at {of.axis_deg + askew:.0f}° to the map's x, not at "
            f'{of.axis_deg:.0f}° as the mapping says: give its frame ("test": x along the motion; "wire": x along the '
            'wire, or y with axis = "y"), and crossing_angle_deg.'
        )
    chosen = seen[:: max(seen.size // MOST_POINTS, 1)]
    at_u, at_v, z = along.ravel()[chosen], across.ravel()[chosen], height.ravel()[chosen]
    length, width = float(np.ptp(at_u)), float(np.ptp(at_v))
    extent = np.array([1.0, width, 1.0 / length, width / length])

    def cylinder(parameters: Array, u: Array, v: Array) -> Array:
        level, crown, tilt, turn = parameters * extent
        beside = np.clip(v - crown - turn * u, -radius_um, radius_um)
        surface: Array = level + tilt * u + np.sqrt(radius_um**2 - beside**2) - radius_um
        return surface

    start = np.array([float(np.nanpercentile(z, 99)), ridge / width, 0.0, 0.0])
    fit = least_squares(lambda p: z - cylinder(p, at_u, at_v), start, loss="cauchy", f_scale=1.0)
    found = least_squares(lambda p: z - cylinder(p, at_u, at_v), fit.x, loss="cauchy", f_scale=0.2).x
    for _ in range(ROUNDS):
        bare = _unworn(at_u, at_v, z - cylinder(found, at_u, at_v))
        found = least_squares(lambda p, u, v, h: h - cylinder(p, u, v), found, args=(at_u[bare], at_v[bare], z[bare])).x
    crown, turn = float(found[1] * extent[1]), float(found[3] * extent[3])
    steep = np.abs(across - crown - turn * along) > STEEP * radius_um
    return np.where(steep, np.nan, height - cylinder(found, along, across)), crown, float(np.degrees(np.arctan(turn)))


def _unworn(u: Array, v: Array, rest: Array) -> NDArray[np.bool_]:
    """Points (n,) that are neither worn nor piled up, by what is left of their heights.

    Neither are those about the scar: its edge is shallower than the noise, and would pull the surface down.
    """
    noise = FAR * deviation(rest)
    near, worn = np.abs(rest) < noise, rest < -noise
    if not worn.any():
        return near
    inside = np.ones_like(near)
    for line in (u, v):
        low, high = np.percentile(line[worn], (2.0, 98.0))
        inside &= np.abs(line - 0.5 * (low + high)) < 0.5 * ABOUT * (high - low)
    outside = near & ~inside
    return outside if np.count_nonzero(outside) > LEAST_UNWORN * near.size else near


def deviation(rest_um: Array) -> float:
    """Standard deviation of a rest (n,) by its median, so that outliers do not count."""
    return max(1.4826 * float(np.median(np.abs(rest_um - np.median(rest_um)))), FINEST_um)


def wire_direction_deg(x: Array, y: Array, height: Array, radius_um: float) -> float:
    """Direction [deg] from x, of (−90°, 90°], of the axis of a wire of that radius with this surface (n_x, n_y).

    That about which a parabola and a plane leave the least, by the median: no scar on less than half of the map counts.
    """
    places = [place.ravel() for place in np.meshgrid(x - x.mean(), y - y.mean(), indexing="ij")]
    known = np.flatnonzero(np.isfinite(height.ravel()))
    known = known[:: max(known.size // FEWER_POINTS, 1)]
    u, v, z = places[0][known], places[1][known], height.ravel()[known]
    plane = np.column_stack([np.ones_like(u), u, v])

    def left(angle_deg: float) -> float:
        across = v * np.cos(np.radians(angle_deg)) - u * np.sin(np.radians(angle_deg))
        flat = z + across**2 / (2.0 * radius_um)
        rest = flat - plane @ np.linalg.lstsq(plane, flat, rcond=None)[0]
        for _ in range(ROUNDS):
            keep = np.abs(rest) <= np.median(np.abs(rest))
            rest = flat - plane @ np.linalg.lstsq(plane[keep], flat[keep], rcond=None)[0]
        return float(np.median(np.abs(rest)))

    return float(min(np.arange(-85.0, 91.0, 5.0), key=left))


def surfaces_of(
    source: ScarSource | ProfileSource, body: str, home: Path, tables: Any
) -> Iterator[MeasuredScar | MeasuredProfile]:
    """The worn surfaces of a body that a source's files hold: maps with x along the motion, or profiles.

    Raises:
        RecordError: a file cannot be read or lacks something, or a repeat is there twice.
    """
    seen: dict[int, Path] = {}
    for place, file in enumerate(files_of(source, home)):
        # Without a pattern, files stand for repeats in their order.
        repeat = numbers_in_name(file, source).get("repeat", source.repeat + place)
        for one in _IN_FILE[tables.worn.name](file, source, body, tables, repeat):
            if one.repeat in seen:
                raise RecordError(
                    f"{file}: [{tables.worn.name}s.{body}] finds repeat {one.repeat} twice, first in "
                    f"{seen[one.repeat].name}: name_pattern or a column must tell them apart."
                )
            seen[one.repeat] = file
            yield one


def _scars_in(file: Path, source: ScarSource, wire: str, tables: Mapping, repeat: int) -> Iterator[MeasuredScar]:
    wires = tables.wires
    if source.kind == PROFILOMETER:
        yield scar_of_map(MapOfWire(file, source, wires, wire, repeat))
        return
    given, columns = columns_of_levels(file, source, source.columns, f"scars.{wire}", repeat)
    for number in np.unique(columns["repeat"]):
        own: NDArray[np.bool_] = columns["repeat"] == number
        x, y, level = (columns[name][own] for name in ("x_um", "y_um", given))
        if given == "height_um":
            yield scar_of_heights(MapOfWire(file, source, wires, wire, int(number)), (x, y, level))
            continue
        try:
            scar = MeasuredScar.from_points(int(number), wire, x, y, level)
            yield scar.turned(wires.axis_angle_deg(wire) if source.frame == "wire" else 0.0)
        except RecordError as problem:
            raise RecordError(f"{file}: {problem}") from None


#: Fewer points tell no face.
FEWEST_ON_LINE = 20

#: Shares of a profile at either end that are taken to be unworn at first.
MARGIN = 0.15


def levelled(
    file: Path, repeat: int, body: str, face: Face | Flat, heights: tuple[Array, Array], *, subtract: bool
) -> MeasuredProfile:
    """The worn depth of heights over places, both (n,) in µm, their zero at the scar's middle.

    The ends are taken to be unworn. From there the fit goes on to all points beside the scar, of which those that lie
    far off count for little: what is worn or piled up does not pull it. Along a cylinder level and tilt suffice, as a
    shift of its crown is a tilt; a flat's edges are sought, too.

    Raises:
        RecordError: there are too few points.
    """
    x, height = heights
    if x.size < FEWEST_ON_LINE or np.ptp(x) <= 0.0:
        raise RecordError(
            f"{file}: a profile of heights needs {FEWEST_ON_LINE} points beside one another, not {x.size}."
        )
    middle = 0.5 * (float(x[0]) + float(x[-1]))
    fitted = _fitted_face(face, x - middle, height) if subtract else np.zeros_like(height)
    depth = fitted - height
    weight = np.maximum(depth, 0.0) ** 2
    scar = float(weight @ x) / float(weight.sum()) if weight.any() else middle
    return MeasuredProfile(repeat, body, x - scar, depth, height, fitted)


def _fitted_face(face: Face | Flat, x: Array, height: Array) -> Array:
    """The unworn surface (n,) under heights at places x from the middle."""
    half = 0.5 * float(np.ptp(x))
    shifts = not isinstance(face, Cylinder | Flat)

    def surface(parameters: Array, at: Array) -> Array:
        level, tilt, aside = parameters
        places = 1e-3 * (at - (aside * half if shifts else 0.0))
        shape = 1e3 * face.height(np.column_stack([places, np.zeros_like(places)]))
        return np.asarray(level + tilt * at / half + shape)

    def fit(chosen: NDArray[np.bool_], start: Array, scale: float) -> Array:
        def off(parameters: Array) -> Array:
            return np.asarray(surface(parameters, x[chosen]) - height[chosen])

        return np.asarray(least_squares(off, start, loss="cauchy", f_scale=scale).x)

    ends = np.abs(x) >= (1.0 - 2.0 * MARGIN) * half
    line = np.polyfit(x[ends] / half, height[ends] - surface(np.zeros(3), x[ends]), 1)
    start = np.array([line[1], line[0], 0.0])
    rough = deviation(height[ends] - surface(start, x[ends]))
    start = fit(ends, start, rough)
    rough = deviation(height[ends] - surface(start, x[ends]))
    left, right = MeasuredProfile(0, "", x, surface(start, x) - height).edges_um
    bare = np.abs(x - 0.5 * (left + right)) > 0.5 * ABOUT * (right - left)
    # A scar that leaves too little beside it is only told from what is not worn by its depth.
    return surface(fit(bare if np.mean(bare) > LEAST_UNWORN else np.ones_like(bare), start, rough), x)


def _profiles_in(
    file: Path, source: ProfileSource, body: str, tables: LineTest, repeat: int
) -> Iterator[MeasuredProfile]:
    face = dict(zip(tables.bodies, (tables.pad.profile, Flat()), strict=True))[body]
    if source.kind == PROFILOMETER:
        heights = _line_of_map(file, source)
        yield levelled(file, repeat, body, face, heights, subtract=source.subtract_face)
        return
    given, columns = columns_of_levels(file, source, source.columns, f"profiles.{body}", repeat, source.step_um)
    for number in np.unique(columns["repeat"]):
        own = (columns["repeat"] == number) & np.isfinite(columns["x_um"]) & np.isfinite(columns[given])
        x, level = _in_order(columns["x_um"][own], columns[given][own])
        if x.size < 3:
            raise RecordError(f"{file}: the {body}'s profile of repeat {number:g} has fewer than three points.")
        if given == "depth_um":
            yield MeasuredProfile(int(number), body, x, level)
        else:
            yield levelled(file, int(number), body, face, (x, level), subtract=source.subtract_face)


def _in_order(x: Array, level: Array) -> tuple[Array, Array]:
    """Points by their place; of several in one place the mean."""
    places, where, count = np.unique(x, return_inverse=True, return_counts=True)
    return places, np.bincount(where, weights=level) / count


def _line_of_map(file: Path, source: ProfileSource) -> tuple[Array, Array]:
    """Places along the motion and the mean height across it, both (n,) in µm."""
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
