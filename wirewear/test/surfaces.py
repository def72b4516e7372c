"""Keys of a body's surface in a study: coatings on it, and its shape as measured before the test.

A measured surface is a map: the depth in µm by which the body lies below its unworn shape when the test begins, at the
crossings of lines x along the motion and y across it (y is 0 alone for a line contact).
"""

import zlib
from base64 import b64decode, b64encode
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, PlainValidator, model_validator

from geometry import Elastic, LoweredSurface, Profile
from geometry.arrays import Array
from solvers import Coating, SurfaceLayer
from wirewear.base.errors import RecordError
from wirewear.base.units import FIELD_UNITS, Quantity
from wirewear.base.words import shown
from wirewear.test import keys
from wirewear.test.keys import Table, one_of

LAYERS = "coatings and hard skins on it, the outermost first, each with its thickness_um"  #: Meaning of the key.

Thickness = Annotated[float, PlainValidator(Quantity("um", 1e-3, 1e4))]
WearFactor = Annotated[float, PlainValidator(Quantity("1", 1e-6, 1e6))]


#: Largest number of lines of a kept map in each direction, more than a contact's elements.
MOST_LINES = 240

#: Columns of a table of a surface.
COLUMNS: tuple[str, ...] = ("x_um", "y_um", "depth_um", "height_um")
_OF_HEIGHTS = ("centred_on", "step_um", "height_unit")

#: Keys that hold a map that was read from a file.
KEPT = ("x_um", "y_um", "depths")
_PLACE = Quantity("um", -1e6, 1e6)  #: Unit and range of a line's position and of a depth.

#: Lines that a study may state, each way: what is kept of a file has fewer.
_MOST_STATED = 2_400


class LayerTable(keys.Table):
    """Keys of one layer, such as a coating; without elastic constants of its own it is as elastic as the body."""

    thickness_um: Thickness = Field(description="thickness of the layer", examples=[3.0])
    wear_factor: WearFactor = Field(1.0, description="its wear coefficient over that of the body below all layers")
    friction: keys.Friction | None = Field(
        None, description="coefficient of friction where it lies on the surface; without it that of [contact]"
    )
    youngs_modulus_MPa: keys.YoungsModulus | None = Field(
        None, description="Young's modulus of its own; without it that of the body"
    )
    poissons_ratio: keys.PoissonsRatio | None = Field(
        None, description="Poisson's ratio of its own; without it that of the body"
    )

    def elastic_on(self, body: Elastic) -> Elastic:
        """Its elastic constants on a body."""
        modulus, ratio = self.youngs_modulus_MPa, self.poissons_ratio
        return Elastic(
            body.youngs_modulus_MPa if modulus is None else modulus, body.poissons_ratio if ratio is None else ratio
        )


def layers_of(stated: Sequence[LayerTable], friction: float) -> tuple[SurfaceLayer, ...]:
    """Layers as the solvers take them. friction: coefficient of friction where the contact has no layers."""
    return tuple(
        SurfaceLayer(
            1e-3 * one.thickness_um, one.wear_factor, None if one.friction is None else one.friction / friction
        )
        for one in stated
    )


def coating_of(stated: Sequence[LayerTable], body: Elastic) -> Coating | None:
    """Layers as a body's compliance takes them; None if all are as elastic as the body."""
    layers = tuple((1e-3 * one.thickness_um, one.elastic_on(body)) for one in stated)
    return None if all(material == body for _, material in layers) else Coating(layers, body)


def unfit_layers(stated: Sequence[LayerTable], friction: float) -> str | None:
    """The rest of a message "layers ..." if one states a friction but the contact's `friction` is 0; else None."""
    if friction == 0.0 and any(one.friction is not None for one in stated):
        return "give a friction of their own, which goes with a friction above 0 in [contact] alone"
    return None


def _checked_lines(value: object) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or not 1 <= len(value) <= _MOST_STATED:
        raise ValueError(f"is {shown(value)}, but must be a list of up to {_MOST_STATED} numbers such as [-10, 0, 10]")
    try:
        lines = tuple(float(_PLACE(line)) for line in value)
    except ValueError as problem:
        raise ValueError(f"holds a line that {problem}") from None
    if at := next((pair for pair in pairwise(lines) if pair[1] <= pair[0]), None):
        raise ValueError(f"holds {at[1]:g} after {at[0]:g}, but its lines must be strictly ascending")
    return lines


StatedLines = Annotated[tuple[float, ...], BeforeValidator(_checked_lines)]
Step = Annotated[float, PlainValidator(Quantity("um", 1e-3, 1e3))]


class StatedSurface(Table):
    """Keys of a body's surface as measured: an old scar, or deviations from its nominal form."""

    file: str | None = Field(
        None,
        description="table of x_um, y_um and depth_um below the unworn shape (of a line contact without y_um), or of "
        "height_um, or a profilometer's map; taken over as the keys below",
        examples=["scar_ball.csv"],
    )
    frame: Annotated[Literal["test", "body"], PlainValidator(one_of("test", "body"))] = Field(
        "test", description='what x runs along: "test", the motion, or "body", the body\'s axis'
    )
    centred_on: Annotated[Literal["scar", "map"], PlainValidator(one_of("scar", "map"))] = Field(
        "scar", description="what of heights lies where the bodies first touch: the middle of the scar or of the map"
    )
    step_um: Step | None = Field(None, description="distance of a map's points, where its file does not state it")
    height_unit: Annotated[str, PlainValidator(one_of(*FIELD_UNITS["um"]))] | None = Field(
        None, description="unit of a map's heights, where its file does not state it"
    )
    x_um: StatedLines | None = Field(None, description="lines of the map that was taken over")
    y_um: StatedLines | None = Field(None, description="its lines across; 0 alone of a line contact")
    depths: str | None = Field(None, description="its depths in µm, row by row: 32-bit numbers, deflated, in base64")

    @model_validator(mode="before")
    @classmethod
    def _with_depths(cls, table: Any) -> Any:
        if not isinstance(table, Mapping) or not isinstance(name := table.get("file"), str):
            return table
        given = {key: value for key, value in table.items() if key != "file"}
        try:
            taken = kept_map(*depths_of_table(Path(name)))
        except RecordError as problem:
            raise ValueError(f"gives a file that cannot be taken: {str(problem).rstrip('.')}") from None
        if idle := [key for key in _OF_HEIGHTS if key in given]:
            raise ValueError(
                f"gives {idle[0]}, which is of heights, but the file has depths that are taken as they are"
            )
        return given | taken

    @model_validator(mode="after")
    def _with_map(self) -> Self:
        try:
            x, _, depth = self.map
        except (ValueError, zlib.error):
            x = depth = np.zeros(0)
        if x.size < 2:
            raise ValueError("gives no file, or depths that are not those of its lines")
        for extreme in (depth.min(), depth.max()):
            try:
                _PLACE(float(extreme))
            except ValueError as problem:
                raise ValueError(f"gives depths, one of which {problem}") from None
        return self

    @property
    def map(self) -> tuple[Array, Array, Array]:
        """(x, y, depth): lines x (n_x,) and y (n_y,), and depths (n_x, n_y), all in µm."""
        return _map(self.x_um or (0.0,), self.y_um or (0.0,), self.depths or "")

    def lowering(self, base: Profile, to_map: Array) -> LoweredSurface:
        """The base surface lowered by the map. to_map: (2, 2) turns plane vectors (along, across) to the map's (x, y).
        A profile goes on unchanged across.
        """
        x, y, depth = (1e-3 * values for values in self.map)
        if y.size == 1:
            y, depth = np.array([-1.0, 1.0]), np.repeat(depth, 2, axis=1)
        return LoweredSurface(base, x, y, depth, to_map)

    @property
    def volume_mm3(self) -> float:
        """Volume that the body lacks, at least 0; 0 for a profile, which has no extent across."""
        x, y, depth = self.map
        return max(1e-9 * float(np.trapezoid(np.trapezoid(depth, y, axis=1), x)), 0.0)

    @property
    def area_mm2(self) -> float:
        """Area of the cross-section along the motion, nearest to y = 0, that the body lacks; at least 0."""
        x, y, depth = self.map
        return max(1e-6 * float(np.trapezoid(depth[:, np.abs(y).argmin()], x)), 0.0)


@lru_cache(maxsize=8)
def _map(x: tuple[float, ...], y: tuple[float, ...], depths: str) -> tuple[Array, Array, Array]:
    # No more is inflated than the lines have room for: a small text may hold gigabytes.
    inflating = zlib.decompressobj()
    flat = np.frombuffer(inflating.decompress(b64decode(depths), 4 * len(x) * len(y)), dtype="<f4").astype(float)
    if inflating.decompress(inflating.unconsumed_tail, 1):
        raise ValueError("there are more depths than lines have")
    return np.array(x), np.array(y), flat.reshape(len(x), len(y))


def kept_map(x: Array, y: Array, depth: Array) -> dict[str, object]:
    """A map as a study keeps it, by the keys KEPT: its lines, and its depths compressed, as text. x (n_x,), y (n_y,),
    depth (n_x, n_y): in µm. Neighbouring lines beyond MOST_LINES are averaged; gaps (not finite) get the nearest depth.
    Raises RecordError if the map has no depth.
    """
    from scipy.ndimage import distance_transform_edt

    if not np.isfinite(depth).any():
        raise RecordError("the surface has no depth.")
    nearest = distance_transform_edt(~np.isfinite(depth), return_distances=False, return_indices=True)
    whole = depth[tuple(nearest)]
    groups = [np.array_split(np.arange(line.size), min(line.size, MOST_LINES)) for line in (x, y)]
    lines = [[float(line[group].mean()) for group in own] for line, own in zip((x, y), groups, strict=True)]
    means = np.stack([whole[group].mean(axis=0) for group in groups[0]])
    means = np.stack([means[:, group].mean(axis=1) for group in groups[1]], axis=1)
    text = b64encode(zlib.compress(means.astype("<f4").tobytes(), 9)).decode()
    return dict(zip(KEPT, (*lines, text), strict=True))


def surfaces_in(table: Mapping[str, object], *place: str) -> Iterator[tuple[tuple[str, ...], Mapping[str, object]]]:
    """Yields (path of keys, table) for every table "surface" nested in `table`, whose own path is `place`."""
    for key, value in table.items():
        if key == "surface" and isinstance(value, Mapping):
            yield (*place, key), value
        elif isinstance(value, Mapping):
            yield from surfaces_in(value, *place, key)


def depths_of_table(file: Path) -> tuple[Array, Array, Array]:
    """(x, y, depth): lines x (n_x,) and y (n_y,), and depths (n_x, n_y) in µm of a table file, NaN where missing; y is
    0 alone without a column y_um.
    Raises RecordError if the file cannot be read, is another table, or its points do not lie on a grid.
    """
    from wirewear.base.guessing import known_columns

    columns = known_columns(file, COLUMNS)
    if not {"x_um", "depth_um"} <= columns.keys():
        raise RecordError(
            f"{file} has no columns x_um and depth_um; heights and maps are read where a study is loaded as by "
            "`wirewear run`."
        )
    for name, values in columns.items():
        # A depth may be missing.
        if np.isinf(values).any() or (name != "depth_um" and np.isnan(values).any()):
            raise RecordError(f"{file}: a value of {name} is missing or infinite, but must be a finite number.")
    across = columns.get("y_um", np.zeros_like(columns["x_um"]))
    x, row = np.unique(columns["x_um"], return_inverse=True)
    y, column = np.unique(across, return_inverse=True)
    whole = np.unique(row * y.size + column).size == x.size * y.size == across.size
    if x.size < 2 or not whole or (y.size == 1) != ("y_um" not in columns):
        raise RecordError(f"{file}: its {across.size} points lie on {x.size} × {y.size} lines, which is no whole grid.")
    depth = np.full((x.size, y.size), np.nan)
    depth[row, column] = columns["depth_um"]
    return x, y, depth
