"""Values of a finished or running simulation: one loop, the evolution over cycles, and the whole run."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

from wirewear.base.errors import NoColumnError, ResultError
from wirewear.base.quantity import counted
from wirewear.results.checks import (
    FloatArray,
    float_array,
    require_equal_lengths,
    require_finite,
    require_increasing,
)
from wirewear.results.contact_forces import ContactForces
from wirewear.results.scar import Scar, require_wire

#: Columns that every evolution has; one row for each simulated cycle.
EVOLUTION_COLUMNS = (
    "cycle",
    "displacement_amplitude_um",
    "slip_amplitude_um",
    "max_tangential_force_N",
    "dissipated_energy_mJ",
    "normal_force_N",
    "accumulated_energy_J",
    "worn_volume_moving_mm3",
    "worn_volume_fixed_mm3",
    "max_depth_moving_um",
    "max_depth_fixed_um",
    "contact_half_width_um",
    "max_pressure_MPa",
    "jump_cycles",
)

#: What the length of mean pressures is called in a result's settings.
PRESSURE_LENGTH = "pressure_length_um"

#: What a result's settings call the travels of the rig to either side, by springs (µP/K) and play, at the first loop.
SPRING_TRAVEL, PLAY_TRAVEL = "fresh_spring_travel_um", "fresh_play_travel_um"

#: Columns that results of earlier versions lack, which are then NaN: unknown.
LATER_COLUMNS = (
    "mid_stroke_pressure_MPa",
    "mirror_error",
    "max_mean_pressure_MPa",
    "mid_stroke_mean_pressure_MPa",
)

#: What columns are whose names do not say it.
COLUMN_MEANINGS = {
    "max_pressure_MPa": "largest pressure of the cycle at a single node, which grows as the mesh is refined",
    "mid_stroke_pressure_MPa": "median over mid-stroke of the largest at a single node inside the contact's rim",
    "max_mean_pressure_MPa": f"largest mean pressure of the cycle over discs of {PRESSURE_LENGTH} of the settings, "
    "of line contacts over segments",
    "mid_stroke_mean_pressure_MPa": "median over mid-stroke of the largest such mean",
}

T = TypeVar("T")

STATUSES = ("complete", "running", "failed")

#: A logged cycle stands for a wanted one if neither is more than this many times the other.
NEAREST_CYCLE_FACTOR = 2.0


@dataclass(frozen=True, eq=False)
class Loop:
    """One fretting cycle, from mid-stroke towards +x; the last sample does not repeat the first.

    All arrays have shape (n,). `displacement_um` is the drive of the moving wire against ground,
    `relative_displacement_um` that of its holder against the fixed wire's holder; `tangential_force_N` is positive
    when it resists motion in +x; `friction_work_mJ` is cumulated over the loop.

    Raises:
        ResultError: arrays differ in length, are empty or are not finite.
    """

    cycle: int
    time_s: FloatArray
    displacement_um: FloatArray
    relative_displacement_um: FloatArray
    tangential_force_N: FloatArray
    normal_force_N: FloatArray
    friction_work_mJ: FloatArray

    def __post_init__(self) -> None:
        where = f"loop of cycle {self.cycle}"
        columns = {name: float_array(f"{where}: {name}", getattr(self, name), 1) for name in LOOP_COLUMNS}
        require_equal_lengths(where, columns)
        for name, column in columns.items():
            if not column.size:
                raise ResultError(f"{where}: {name} must hold at least one sample")
            require_finite(f"{where}: {name}", column)
            object.__setattr__(self, name, column)


LOOP_COLUMNS = tuple(f.name for f in fields(Loop) if f.name != "cycle")


@dataclass(frozen=True, eq=False)
class Evolution(Mapping[str, FloatArray]):
    """Columns in a fixed order over the cycles, each (n,): `evolution["cycle"]`; n may be 0 before the first.

    A value that a cycle does not define is NaN, except for `cycle`, which increases strictly.

    Raises:
        ResultError: a column of EVOLUTION_COLUMNS is missing, or columns differ in length.
        NoColumnError: there is no such column.
    """

    columns: Mapping[str, FloatArray]

    def __post_init__(self) -> None:
        missing = [name for name in EVOLUTION_COLUMNS if name not in self.columns]
        if missing:
            raise ResultError(f"evolution: column(s) missing: {', '.join(missing)}")
        unknown = np.full(len(self.columns["cycle"]), np.nan)
        every = dict(self.columns) | {name: unknown for name in LATER_COLUMNS if name not in self.columns}
        named = dict.fromkeys([*EVOLUTION_COLUMNS, *LATER_COLUMNS, *every])
        columns = {name: float_array(f"evolution: {name}", every[name], 1) for name in named}
        require_equal_lengths("evolution", columns)
        require_finite("evolution: cycle", columns["cycle"])
        require_increasing("evolution: cycle", columns["cycle"])
        object.__setattr__(self, "columns", columns)

    @classmethod
    def from_rows(cls, rows: Sequence[Mapping[str, float]]) -> "Evolution":
        """Columns from one mapping per simulated cycle; no rows give empty columns."""
        names = list(rows[0]) if rows else [*EVOLUTION_COLUMNS, *LATER_COLUMNS]
        try:
            return cls({name: [row[name] for row in rows] for name in names})  # type: ignore[misc]
        except KeyError as error:
            raise ResultError(f"evolution: column {error} is missing in some rows") from error

    def __getitem__(self, name: str) -> FloatArray:
        if name not in self.columns:
            like = [own for own in self.columns if str(name) in own] or list(self.columns)
            raise NoColumnError(f"evolution has no column {name!r}: there is {', '.join(like)}")
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __len__(self) -> int:
        return len(self.columns)

    def at(self, cycle: float) -> dict[str, float]:
        """The row simulated nearest to `cycle` (within NEAREST_CYCLE_FACTOR).

        Raises:
            ResultError: no simulated cycle is near.
        """
        cycles = [int(c) for c in self["cycle"]]
        index = cycles.index(_nearest_cycle(cycle, cycles, "evolution"))
        return {name: float(column[index]) for name, column in self.items()}


@dataclass(frozen=True, eq=False)
class RunResult:
    """All that one run (one variant of a study) leaves.

    `study` is the resolved study, `settings` what the discretisation came to (mesh sizes, numbers of unknowns),
    `quality` the worst residuals met, `versions` those of the programs used, `timings_s` wall times. `path` is the file
    that it was read from; it is not written. `contact_forces` are missing in files of earlier versions. `label` names
    the run in pictures: its variant, or else its name.

    Raises:
        ResultError: the status is none of complete, running, failed.
    """

    contact_kind: ClassVar[str] = "crossed-wires"

    name: str
    variant: str
    fidelity: str
    status: str
    message: str
    study: Mapping[str, Any]
    loops: tuple[Loop, ...]
    evolution: Evolution
    scars: tuple[Scar, ...]
    settings: Mapping[str, Any]
    quality: Mapping[str, float]
    versions: Mapping[str, str]
    timings_s: Mapping[str, float]
    path: Path | None = None
    contact_forces: tuple[ContactForces, ...] = ()
    label: str = field(init=False)

    def __post_init__(self) -> None:
        if self.status not in STATUSES:
            raise ResultError(f"status must be one of {', '.join(STATUSES)}, not {self.status!r}")
        object.__setattr__(self, "label", self.variant or self.name)

    def loop(self, cycle: float) -> Loop:
        """The loop logged nearest to `cycle` (within NEAREST_CYCLE_FACTOR), or ResultError naming the logged ones."""
        return _nearest(cycle, self.loops, lambda loop: loop.cycle, "loops")

    def scar(self, cycle: float, wire: str) -> Scar:
        """The "moving" or "fixed" wire's scar logged nearest to `cycle`, or ResultError naming the logged ones."""
        require_wire(wire, self.label)
        scars = [scar for scar in self.scars if scar.wire == wire]
        return _nearest(cycle, scars, lambda scar: scar.cycle, f"scars of the {wire} wire")

    def forces(self, cycle: float, wire: str) -> ContactForces:
        """Forces on the "moving" or "fixed" wire logged nearest to `cycle`, or ResultError naming the logged ones."""
        require_wire(wire, self.label)
        forces = [one for one in self.contact_forces if one.wire == wire]
        if not forces:
            raise ResultError(
                f"{self.label}: no contact forces of the {wire} wire are recorded: the run was asked for none "
                "(contact_states in [log]), or is of an earlier version; run it anew"
            )
        return _nearest(cycle, forces, lambda one: one.cycle, f"contact forces of the {wire} wire")

    def scar_cycles(self) -> tuple[int, ...]:
        """Cycles at which both wires' scars are logged, increasing."""
        moving, fixed = ({s.cycle for s in self.scars if s.wire == wire} for wire in ("moving", "fixed"))
        return tuple(sorted(moving & fixed))


def _nearest(cycle: float, items: Sequence[T], cycle_of: Callable[[T], int], what: str) -> T:
    wanted = _nearest_cycle(cycle, [cycle_of(item) for item in items], what)
    return next(item for item in items if cycle_of(item) == wanted)


def _nearest_cycle(cycle: float, logged: Sequence[int], what: str) -> int:
    def distance(other: int) -> float:
        # Half a cycle stands for "before the first", so that cycle 0 has a place on the ratio scale.
        low, high = sorted((max(cycle, 0.5), max(other, 0.5)))
        return high / low

    if not logged or distance(nearest := min(logged, key=distance)) > NEAREST_CYCLE_FACTOR:
        names = ", ".join(counted(c) for c in sorted(set(logged))) or "none"
        raise ResultError(f"{what}: nothing is logged near cycle {cycle:g}; logged cycles are: {names}")
    return nearest
