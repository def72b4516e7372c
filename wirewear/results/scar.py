"""The worn surface of one body, its scar: a map or, for a line contact, a profile, with figures of it.

The sliding frame has x along the motion and y across it; a body's own frame has an axial and a transverse direction.
Both have their origin at the point of first contact. The first of a test's two bodies is the driven, lower one.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geometry import Barrel
from geometry.arrays import Array, BoolArray, IntArray
from geometry.patch import located
from wirewear.base.errors import ResultError
from wirewear.test.lengths import extent_of

WIRES = ("moving", "fixed")
BODIES = ("pad", "specimen")  #: Bodies of a line contact.

#: Names of bodies in sentences.
_NOUNS = dict.fromkeys(WIRES, "wire")
_CALLED = {body: f"{body} wire" for body in WIRES} | {body: f"{body} body" for body in ("lower", "upper")}

#: Other names by which the driven, lower body and the held, upper one can be given.
_BY_PLACE = (("lower", "driven", "moving"), ("upper", "held", "fixed"))
GRID_COLUMNS = ("axial_um", "transverse_um")
FIELD_COLUMNS = ("depth_um", "energy_density_mJ_per_mm2", "pressure_MPa", "slip_distance_um")
FURTHER_COLUMNS = ("print_um", "debris_um")  #: Fields of bodies that yield, and of debris that flows.

#: A scar's depth is that of its fifth deepest point, its length and width those of sections at a share of their
#: height.
DEEPEST, SCAR_EDGE = 5, 0.25
SCAR_FIGURES = ("volume", "depth", "length", "width")


def float_array(name: str, values: ArrayLike, dimensions: int) -> Array:
    """`values` copied to a read-only float64 array; ResultError, which calls them `name`, if they are not real numbers
    or have another number of dimensions than `dimensions`.
    """
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ResultError(f"{name} must hold real numbers") from error
    if array.ndim != dimensions:
        raise ResultError(f"{name} must have {dimensions} dimension(s), not {array.ndim}")
    array.setflags(write=False)
    return array


def require_finite(name: str, array: Array) -> None:
    """Raise ResultError, which calls the array `name`, unless every entry is a finite number."""
    if not np.isfinite(array).all():
        raise ResultError(f"{name} must be finite everywhere, but {np.count_nonzero(~np.isfinite(array))} are not")


def require_increasing(name: str, array: Array) -> None:
    """Raise ResultError, which calls the array `name`, unless its entries (n,) increase strictly."""
    # Differences of the largest numbers overflow.
    if not (array[1:] > array[:-1]).all():
        raise ResultError(f"{name} must increase strictly")


def require_equal_lengths(where: str, columns: Mapping[str, Array]) -> None:
    """Raise ResultError, which begins with `where`, unless all columns are as long as the first."""
    lengths = {name: column.size for name, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ResultError(
            f"{where}: all columns must be equally long, not {', '.join(f'{k} {n}' for k, n in lengths.items())}"
        )


def crossings(line: Array, section: Array, level: float) -> tuple[float, float]:
    """(first, last): outermost places on `line` (n,) between which the values `section` (n,) exceed `level`,
    interpolated linearly.
    An end of the line where values still exceed the level there; both ends if they exceed it nowhere.
    """
    over = np.flatnonzero(section > level)
    if over.size == 0:
        return float(line[0]), float(line[-1])

    def between(inside: int, outside: int) -> float:
        if not 0 <= outside < line.size:
            return float(line[inside])
        share = (section[inside] - level) / (section[inside] - section[outside])
        return float(line[inside] + share * (line[outside] - line[inside]))

    return between(int(over[0]), int(over[0]) - 1), between(int(over[-1]), int(over[-1]) + 1)


def worn_volume_mm3(x_um: Array, y_um: Array, depth_um: Array) -> float:
    """Worn volume in mm³ of depths (n_x, n_y) in µm at the crossings of lines x (n_x,) and y (n_y,). The integral of
    the bilinear depth over the whole map (trapezoidal rule): noise averages to 0 and piled-up material is subtracted.
    """
    sections_um2 = np.trapezoid(depth_um, y_um, axis=1)
    return 1e-9 * float(np.trapezoid(sections_um2, x_um))


def scar_figures(x_um: Array, y_um: Array, depth_um: Array) -> list[float]:
    """[volume in µm³, depth, length along x, width along y in µm] of a map (n_x, n_y) of depths without NaN.

    Depth is that of the fifth deepest point; length and width are those of the depth integrated across, at a quarter of
    its height. All are 0 if volume or depth is not positive.
    """
    volume, place = 1e9 * worn_volume_mm3(x_um, y_um, depth_um), -min(DEEPEST, depth_um.size)
    deep = float(np.partition(depth_um.ravel(), place)[place])
    if volume <= 0.0 or deep <= 0.0:
        return [0.0, 0.0, 0.0, 0.0]
    along, across = np.trapezoid(depth_um, y_um, axis=1), np.trapezoid(depth_um, x_um, axis=0)
    return [volume, deep, *(_extent(line, np.asarray(own)) for line, own in ((x_um, along), (y_um, across)))]


def _extent(line: Array, section: Array) -> float:
    """Width of a section at `SCAR_EDGE` of its height, in the unit of the line."""
    first, last = crossings(line, section, SCAR_EDGE * float(section.max()))
    return last - first


def body_named(name: str, where: str, bodies: Sequence[str]) -> str:
    """The one of `bodies` (driven, held) that `name` means: its own name, or "lower", "driven", "moving" for the first
    and "upper", "held", "fixed" for the second. Raises ResultError, which begins with `where`, for another name.
    """
    for body, also in zip(bodies, _BY_PLACE, strict=True):
        if name == body or (name in also and name not in bodies):
            return body
    raise ResultError(f"{where}: the body must be one of {', '.join(bodies)}, or lower or upper, not {name!r}")


def figure_volume(volume_mm3: float) -> str:
    """Worn volume as text: in µm³ below 10⁻⁶ mm³, else in 10⁻³ mm³."""
    return f"{1e9 * volume_mm3:.3g} µm³" if volume_mm3 < 1e-6 else f"{1e3 * volume_mm3:.3g}·10⁻³ mm³"


def noun_of(body: str) -> str:
    """The word for a body in columns and messages: "wire" for one of crossed wires, "body" for any other."""
    return _NOUNS.get(body, "body")


def called(body: str) -> str:
    """The name of a body in sentences and headings, such as "moving wire" for "moving"."""
    return _CALLED.get(body, body)


@dataclass(frozen=True, eq=False)
class Scar:
    """A body's scar after `cycle` cycles, on a rectilinear grid in that body's own frame.

    The axial direction is turned by `axis_angle_deg` from the sliding direction x about the common normal z, the
    transverse one by another +90°, for both bodies. `axial_um` (n_a,) and `transverse_um` (n_t,) are the grid's lines.
    Fields (n_a, n_t): worn depth along z (≥ 0), friction energy received per area, and, of that cycle, contact pressure
    at mid-stroke and distance slid under pressure.

    A line contact has a single line across, which stands for all of its `length_mm`; other contacts have None. The
    unworn surface has `diameter_mm` across and `diameter_along_mm` along the axis, infinite where it is straight, as
    for line contacts.

    Raises ResultError if shapes do not match, the grid does not increase, values are not finite, or a depth is
    negative.
    """

    cycle: int
    body: str
    diameter_mm: float
    axis_angle_deg: float
    axial_um: Array
    transverse_um: Array
    depth_um: Array
    energy_density_mJ_per_mm2: Array
    pressure_MPa: Array
    slip_distance_um: Array
    length_mm: float | None = None
    diameter_along_mm: float = float("inf")
    #: Depth (n_a, n_t) of the print that pressure has left, besides the worn depth; None where bodies do not yield.
    print_um: Array | None = None
    #: Thickness (n_a, n_t) of the body's debris that is still between the surfaces, where it may leave; else None.
    debris_um: Array | None = None

    def __post_init__(self) -> None:
        where = f"scar of the {called(self.body)} at cycle {self.cycle}"
        if not self.diameter_mm > 0.0:
            raise ResultError(f"{where}: diameter_mm must be positive, not {self.diameter_mm:g}")
        for name, fewest in zip(GRID_COLUMNS, (2, extent_of(self.length_mm).fewest_across), strict=True):
            line = float_array(f"{where}: {name}", getattr(self, name), 1)
            require_finite(f"{where}: {name}", line)
            require_increasing(f"{where}: {name}", line)
            if line.size < fewest:
                raise ResultError(f"{where}: {name} must have at least two grid lines")
            object.__setattr__(self, name, line)
        shape = (self.axial_um.size, self.transverse_um.size)
        for name in self.field_columns:
            values = float_array(f"{where}: {name}", getattr(self, name), 2)
            if values.shape != shape:
                raise ResultError(f"{where}: {name} must have the shape of the grid {shape}, not {values.shape}")
            require_finite(f"{where}: {name}", values)
            object.__setattr__(self, name, values)
        # Depths may undershoot zero by round-off of an interpolation, not by more.
        if (self.depth_um < -1e-6).any():
            raise ResultError(f"{where}: depth_um must not be negative, but {self.depth_um.min():g} is")

    @property
    def field_columns(self) -> tuple[str, ...]:
        """Names of the attributes that are fields (n_a, n_t) of this scar."""
        return (*FIELD_COLUMNS, *(name for name in FURTHER_COLUMNS if getattr(self, name) is not None))

    @property
    def measured_depth_um(self) -> Array:
        """Depth (n_a, n_t) below the unworn surface, as an instrument measures it: worn depth plus print."""
        return self.depth_um if self.print_um is None else self.depth_um + self.print_um

    @property
    def radius_um(self) -> float:
        """Radius in µm of the unworn surface across the axis."""
        return 500.0 * self.diameter_mm

    @property
    def flanks_um(self) -> tuple[float, float]:
        """(along, across): distances in µm from first contact up to which pictures show the unworn surface, infinite
        where straight; 0.68 of the body's radii, or 0.94 of a cylinder's.
        """
        radii = (500.0 * self.diameter_along_mm, self.radius_um)
        share = 0.94 if max(radii) == float("inf") else 0.68
        return share * radii[0], share * radii[1]

    @property
    def max_depth_um(self) -> float:
        return float(self.depth_um.max())

    @property
    def volume_mm3(self) -> float:
        """Worn volume, without prints; of a line contact over its whole length."""
        return _VOLUMES[extent_of(self.length_mm).worn](self)

    @property
    def area_um2(self) -> float:
        """Worn cross-section of a line contact in µm², the exact integral of the piecewise linear depth."""
        return float(np.trapezoid(self.depth_um[:, 0], self.axial_um))

    def edges_um(self) -> tuple[float, float]:
        """(first, last): x of the ends of a line contact's scar, at 1 % of its largest depth; NaN if nothing is
        worn.
        """
        x, depth = self.axial_um, self.depth_um[:, 0]
        # Depth, relative to the deepest point, that bounds a profile's scar.
        return crossings(x, depth, 0.01 * float(depth.max())) if depth.any() else (float("nan"), float("nan"))

    def wire_coordinates(self, x_um: ArrayLike, y_um: ArrayLike) -> tuple[Array, Array]:
        """(axial, transverse) in µm in the body's own frame of points (x, y) in the sliding frame; shapes broadcast."""
        x, y = np.asarray(x_um, dtype=np.float64), np.asarray(y_um, dtype=np.float64)
        cosine, sine = _cosine_sine(self.axis_angle_deg)
        return x * cosine + y * sine, y * cosine - x * sine

    def sliding_coordinates(self, axial_um: ArrayLike, transverse_um: ArrayLike) -> tuple[Array, Array]:
        """(x, y) in µm in the sliding frame of points in the body's own frame; shapes broadcast."""
        axial, transverse = np.asarray(axial_um, dtype=np.float64), np.asarray(transverse_um, dtype=np.float64)
        cosine, sine = _cosine_sine(self.axis_angle_deg)
        return axial * cosine - transverse * sine, axial * sine + transverse * cosine

    def depth_at(self, x_um: ArrayLike, y_um: ArrayLike) -> Array:
        """Measured depth in µm at points of the sliding frame, bilinear between grid points, 0 outside the grid; shapes
        broadcast. A line contact has the same depth at all y.
        """
        shape = np.broadcast_shapes(np.shape(x_um), np.shape(y_um))
        nodes, weights, _ = self._located(x_um, y_um)
        return np.asarray(np.einsum("ij,ij->i", weights, self.measured_depth_um.ravel()[nodes])).reshape(shape)

    def sampled(self, x_um: ArrayLike, y_um: ArrayLike) -> Array:
        """Measured depth (n_x, n_y) in µm on the grid of lines `x_um` (n_x,) and `y_um` (n_y,) in the sliding frame."""
        return self.depth_at(np.asarray(x_um)[:, None], np.asarray(y_um)[None, :])

    def section_along_motion(self) -> tuple[Array, Array]:
        """(x_um, measured depth_um), each (n,), along y = 0: where that line crosses the grid's, in order of x."""
        if self.transverse_um.size == 1:
            return self.axial_um, self.measured_depth_um[:, 0]
        cosine, sine = _cosine_sine(self.axis_angle_deg)
        crossings = []
        if abs(cosine) > 1e-12:
            crossings.append(self.axial_um / cosine)
        if abs(sine) > 1e-12:
            crossings.append(-self.transverse_um / sine)
        # Neighbouring lines that round-off alone keeps apart are one.
        x: Array = np.unique(np.round(np.concatenate(crossings), 9))
        x = x[self._located(x, 0.0)[2]]
        return x, self.depth_at(x, 0.0)

    def unworn_height_um(self, axial_um: ArrayLike, transverse_um: ArrayLike) -> Array:
        """Height in µm of the unworn surface above its tangent plane at the origin, ≤ 0, at points in the body's own
        frame; shapes broadcast.
        """
        along, across = np.broadcast_arrays(np.asarray(axial_um, float), np.asarray(transverse_um, float))
        barrel = Barrel(2e-3 / self.diameter_along_mm, 2e-3 / self.diameter_mm)
        return barrel.height(np.column_stack([along.ravel(), across.ravel()])).reshape(along.shape)

    def _located(self, x_um: ArrayLike, y_um: ArrayLike) -> tuple[IntArray, Array, BoolArray]:
        """Nodes, weights and inside flags that interpolate at points of the sliding frame, as from
        `ContactPatch.locate`.
        """
        places = [coordinate.ravel() for coordinate in self.wire_coordinates(x_um, y_um)]
        return located(self.axial_um, self.transverse_um, np.column_stack(places))


def _cosine_sine(angle_deg: float) -> tuple[float, float]:
    """Cosine and sine, exact at multiples of 90°, so that a wire across the motion has no round-off tilt."""
    quarter, rest = divmod(angle_deg, 90.0)
    cosine, sine = float(np.cos(np.radians(rest))), float(np.sin(np.radians(rest)))
    for _ in range(int(quarter) % 4):
        cosine, sine = -sine, cosine
    return cosine, sine


#: Worn volumes by what is worn; a line contact's profile stands for all of its length.
_VOLUMES: Mapping[str, Callable[[Scar], float]] = {
    "scars": lambda scar: worn_volume_mm3(scar.axial_um, scar.transverse_um, scar.depth_um),
    "profiles": lambda scar: 1e-6 * scar.area_um2 / extent_of(scar.length_mm).share,
}
