"""The scale of a height map: what its file states of it, and what a mapping must say where the file does not."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wirewear.base.errors import RecordError
from wirewear.base.quantity import FIELD_UNITS
from wirewear.records.values import Array

#: Lines x (n_x,), y (n_y,) and heights (n_x, n_y), all in µm.
Map = tuple[Array, Array, Array]


@dataclass(frozen=True)
class MapScale:
    """What a mapping says: distances of points along x, and along y where they differ, and the heights' unit."""

    step_um: float | None = None
    step_y_um: float | None = None
    height_unit: str | None = None


@dataclass(frozen=True)
class StatedMap:
    """A map as its file has it: heights (n_x, n_y) in its unit, not finite where nothing was measured.

    step_um: from point to point along x and y.  unit_um: one unit of the heights.  None where the file does not tell.
    remark: what else it tells of its scale.
    """

    heights: Array
    step_um: tuple[float, float] | None
    unit_um: float | None
    remark: str = ""

    @property
    def left_open(self) -> list[str]:
        """Keys of a mapping that must say what the file does not."""
        return ["step_um"] * (self.step_um is None) + ["height_unit"] * (self.unit_um is None)

    def scaled(self, file: Path, told: MapScale) -> Map:
        """The map in µm about its middle; what a mapping tells goes before what the file states.

        Raises:
            RecordError: neither states the scale, or the size is not finite; one sentence.
        """
        step = self.step_um if told.step_um is None else (told.step_um, told.step_y_um or told.step_um)
        unit = self.unit_um if told.height_unit is None else FIELD_UNITS["um"][told.height_unit]
        if step is None or unit is None:
            missing = [key for key in self.left_open if getattr(told, key) is None]
            raise RecordError(f"{file} does not state its scale: the mapping must give {' and '.join(missing)}.")
        x, y = ((np.arange(n) - 0.5 * (n - 1)) * own for n, own in zip(self.heights.shape, step, strict=True))
        if not 0.0 < float(np.ptp(x)) * float(np.ptp(y)) < np.inf:
            raise RecordError(f"{file}: the map must have a finite size above zero along x and y.")
        return x, y, np.where(np.isfinite(self.heights), unit * self.heights, np.nan)


def positive(text: str) -> float | None:
    """A number above zero with a decimal point or comma; None of any other text."""
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        return None
    return value if 0.0 < value < np.inf else None
