"""The evolution of a run: a table with one row for each measured cycle.

A cycle is measured where the run closes a loop without wear; of some, loop, scars and forces are recorded as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from wirewear.base.errors import NoColumnError, ResultError
from wirewear.base.words import counted
from wirewear.results.scar import float_array, require_equal_lengths, require_finite, require_increasing

#: Columns of an evolution of crossed wires; other contacts have their own bodies' names in place of the wires'.
EVOLUTION_COLUMNS = (
    "cycle", "displacement_amplitude_um", "slip_amplitude_um", "max_tangential_force_N", "dissipated_energy_mJ",
    "normal_force_N", "accumulated_energy_J", "worn_volume_moving_mm3", "worn_volume_fixed_mm3", "max_depth_moving_um",
    "max_depth_fixed_um", "contact_half_width_um", "max_pressure_MPa", "jump_cycles",
)  # fmt: skip

#: Beginnings of the columns of one body; the body's name and the unit follow.
OF_A_BODY = ("worn_volume_", "max_depth_")
PRESSURE_LENGTH = "pressure_length_um"  #: Setting of a result with the length over which pressures are averaged.

BULK_WORK = "bulk_work_mJ"  #: The column of tests whose bodies are pulled, bent or twisted.

#: Columns of bodies that yield: volume of the prints and work in them, largest mean pressure over the yield stress.
PLASTIC_VOLUME, PLASTIC_WORK, OVER_YIELD = "print_volume_mm3", "plastic_work_mJ", "mean_pressure_over_yield"

#: Columns of debris that may leave.
DEBRIS_VOLUME, DEBRIS_LEFT, DEBRIS_THICKNESS = "debris_volume_mm3", "debris_left_mm3", "debris_thickness_um"

#: Columns of surfaces that friction warms.
MEAN_RISE, LARGEST_RISE = "mean_rise_K", "largest_rise_K"

#: Columns that results of earlier versions lack, which are then NaN: unknown.
LATER_COLUMNS = ("mid_stroke_pressure_MPa", "mirror_error", "max_mean_pressure_MPa", "mid_stroke_mean_pressure_MPa")

#: Meanings of the columns whose names do not suffice.
COLUMN_MEANINGS = {
    "max_pressure_MPa": "largest pressure of the cycle at a single node, which grows as the mesh is refined",
    "mid_stroke_pressure_MPa": "median over mid-stroke of the largest at a single node inside the contact's rim",
    "max_mean_pressure_MPa": f"largest mean pressure of the cycle over discs of {PRESSURE_LENGTH} of the settings, "
    "of line contacts over segments",
    "mid_stroke_mean_pressure_MPa": "median over mid-stroke of the largest such mean",
    PLASTIC_VOLUME: "volume of the prints that pressure has left on both bodies, beside what has worn",
    PLASTIC_WORK: "work that has gone into the prints",
    OVER_YIELD: "largest mean pressure of the cycle, load over contact area, over the softer body's yield stress",
    DEBRIS_VOLUME: "volume of the debris between the surfaces",
    DEBRIS_LEFT: "volume of the debris that has left the contact",
    DEBRIS_THICKNESS: "largest thicknesses of both bodies' debris together",
    MEAN_RISE: "rise of the temperature by friction, mean over where and when it heats",
    LARGEST_RISE: "such a rise at the warmest place of either body, mean over the cycle likewise",
    BULK_WORK: "work of the bulk stresses on the contact, which a loop's area holds beside the friction work",
}


@dataclass(frozen=True, eq=False)
class Evolution(Mapping[str, Array]):
    """Columns over the measured cycles, each (n,), as `evolution["cycle"]`; n may be 0. COLUMN_MEANINGS explains their
    names.

    A value that is not defined at a cycle is NaN; `cycle` increases strictly. Raises ResultError if a column of
    EVOLUTION_COLUMNS is missing, or columns differ in length; NoColumnError if a column is asked for that does not
    exist.
    """

    columns: Mapping[str, Array]

    def __post_init__(self) -> None:
        missing = [n for n in EVOLUTION_COLUMNS if n not in self.columns and not n.startswith(OF_A_BODY)]
        if missing:
            raise ResultError(f"evolution: column(s) missing: {', '.join(missing)}")
        unknown = np.full(len(self.columns["cycle"]), np.nan)
        every = dict(self.columns) | {name: unknown for name in LATER_COLUMNS if name not in self.columns}
        named = dict.fromkeys(n for n in (*EVOLUTION_COLUMNS, *LATER_COLUMNS, *every) if n in every)
        columns = {name: float_array(f"evolution: {name}", every[name], 1) for name in named}
        require_equal_lengths("evolution", columns)
        require_finite("evolution: cycle", columns["cycle"])
        require_increasing("evolution: cycle", columns["cycle"])
        object.__setattr__(self, "columns", columns)

    @classmethod
    def from_rows(cls, rows: Sequence[Mapping[str, float]]) -> Evolution:
        """The evolution of one mapping from column to value per measured cycle; no rows give empty columns.
        Raises ResultError if a row lacks a column of the first one.
        """
        names = list(rows[0]) if rows else [*EVOLUTION_COLUMNS, *LATER_COLUMNS]
        try:
            return cls({name: [row[name] for row in rows] for name in names})  # type: ignore[misc]
        except KeyError as error:
            raise ResultError(f"evolution: column {error} is missing in some rows") from error

    def __getitem__(self, name: str) -> Array:
        if name not in self.columns:
            like = [own for own in self.columns if str(name) in own] or list(self.columns)
            raise NoColumnError(f"evolution has no column {name!r}: there is {', '.join(like)}")
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    def at(self, cycle: float) -> dict[str, float]:
        """Values by column at the measured cycle nearest to `cycle`, by ratio; ResultError beyond a factor of two."""
        cycles = [int(c) for c in self["cycle"]]
        index = cycles.index(nearest_cycle(cycle, cycles, "evolution"))
        return {name: float(column[index]) for name, column in self.items()}


def nearest_cycle(cycle: float, logged: Sequence[int], what: str) -> int:
    """The one of `logged` nearest to `cycle`, by their ratio; a cycle 0 counts as 0.5. ResultError, which calls what is
    logged `what`, if none is within a factor of two.
    """

    def distance(other: int) -> float:
        # Half a cycle stands for "before the first", so that cycle 0 has a place on the ratio scale.
        low, high = sorted((max(cycle, 0.5), max(other, 0.5)))
        return high / low

    if not logged or distance(nearest := min(logged, key=distance)) > 2.0:
        names = ", ".join(counted(c) for c in sorted(set(logged))) or "none"
        raise ResultError(f"{what}: nothing is logged near cycle {cycle:g}; logged cycles are: {names}")
    return nearest
