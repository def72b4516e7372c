"""Forces on a body's contact patch at positions of a recorded cycle: what the stresses inside it follow from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry import BlockGeometry, BodyGeometry, Elastic, GradedAxis, Layering, WireGeometry
from wirewear.base.errors import ResultError
from wirewear.results.checks import FloatArray, float_array, require_finite
from wirewear.results.positions import POSITIONS

IntArray = NDArray[np.int64]

POSITION_COLUMNS = ("phase", "drive_um", "holder_x_um", "holder_z_um", "tangential_force_N")


@dataclass(frozen=True, eq=False)
class ContactForces:
    """Forces on one body at k positions of a cycle, in the order in which they are passed.

    `phase` (k,) is the share of the cycle passed since the end of the stroke at +x, in (0, 1]; `drive_um` (k,) the
    driven body's displacement, `holder_x_um` and `holder_z_um` those of the other's holder, and
    `tangential_force_N` that on the other along x. `nodes` (m,) are those of the patch, in the order of its
    flattened grid, that ever carry force; `force_N` (k, m, 3) acts on the body, in its own axes: along it, across it,
    out of its surface. `geometry` and `material` make a body's mesh anew; a line contact's follows from its study.

    Raises:
        ResultError: arrays do not fit together, or are not finite.
    """

    cycle: int
    body: str
    phase: FloatArray
    drive_um: FloatArray
    holder_x_um: FloatArray
    holder_z_um: FloatArray
    tangential_force_N: FloatArray
    nodes: IntArray
    force_N: FloatArray
    axis_angle_deg: float = 0.0
    geometry: BodyGeometry | None = None
    material: Elastic | None = None

    def __post_init__(self) -> None:
        where = f"contact forces of cycle {self.cycle}"
        columns = {name: float_array(f"{where}: {name}", getattr(self, name), 1) for name in POSITION_COLUMNS}
        columns["force_N"] = float_array(f"{where}: force_N", self.force_N, 3)
        for name, values in columns.items():
            require_finite(f"{where}: {name}", values)
            object.__setattr__(self, name, values)
        wanted = (len(self.phase), len(self.nodes), 3)
        if self.force_N.shape != wanted or any(len(columns[name]) != wanted[0] for name in POSITION_COLUMNS):
            raise ResultError(f"{where}: force_N must have shape {wanted}, not {self.force_N.shape}")

    @property
    def meshed(self) -> tuple[BodyGeometry, Elastic]:
        """What the body's mesh is made of; ResultError of a line contact."""
        if self.geometry is None or self.material is None:
            raise ResultError(f"contact forces of the {self.body} of a line contact say nothing of its mesh")
        return self.geometry, self.material

    def named(self) -> dict[str, int]:
        """The recorded position nearest to each of POSITIONS; just after a reversal is the first one behind it."""
        return named_positions(self.phase)

    def position(self, at: str | int) -> int:
        """The place in this record of a named position, or of one by its number.

        Raises:
            ResultError: there is no such position.
        """
        return position_of(at, self.phase, self.cycle)


def geometry_of(table: Mapping[str, Any]) -> BodyGeometry:
    """A body's geometry from the nested mapping that dataclasses.asdict makes of it.

    Raises:
        ResultError: it is none of this version.
    """
    try:
        axes = {name: GradedAxis(**table[name]) for name in ("axial", "transverse")}
        shape = WireGeometry if "diameter_mm" in table else BlockGeometry
        return shape(**{**table, **axes, "layering": Layering(**table["layering"])})
    except (KeyError, TypeError) as problem:
        raise ResultError(f"a body's geometry of another version of wirewear: {problem}") from problem


def named_positions(phase: FloatArray) -> dict[str, int]:
    """The place in a cycle's positions, (k,) shares passed since its end at +x, nearest to each of POSITIONS.

    Just after a reversal is the first position behind it.
    """
    passed = phase % 1.0
    mid_forward, mid_back = (int(np.argmin(np.abs(passed - at))) for at in (0.75, 0.25))
    end_forward = int(np.argmin(np.minimum(passed, 1.0 - passed)))
    end_back = int(np.argmin(np.abs(passed - 0.5)))
    count = len(passed)
    found = (mid_forward, end_forward, (end_forward + 1) % count, mid_back, end_back, (end_back + 1) % count)
    return dict(zip(POSITIONS, found, strict=True))


def position_of(at: str | int, phase: FloatArray, cycle: int) -> int:
    """The place of a named position, or of one by its number.

    Raises:
        ResultError: there is no such position.
    """
    if isinstance(at, int) or at.isdecimal():
        if 0 <= int(at) < len(phase):
            return int(at)
        raise ResultError(f"there is no position {at}: cycle {cycle} has positions 0 to {len(phase) - 1}.")
    if at not in POSITIONS:
        raise ResultError(f"there is no position {at!r}: choose one of {', '.join(POSITIONS)}, or a number.")
    return named_positions(phase)[at]
