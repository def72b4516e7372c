"""What a batch needs of a forward model: each tier has one generator behind this interface."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.cases import Case, TrueEffect
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import Nuisances
from wirewear.records import AnyRecord

Array = NDArray[np.float64]
#: The effects of the diagnosis' contract.
LIBRARY_EFFECTS = (
    "tangential_compliance", "rotational_compliance", "free_play", "friction_offset", "friction_evolution",
    "roughness_compliance", "third_body", "plasticity", "crossing_angle_error", "misalignment", "normal_load_drift",
    "wear_rate_offset", "wear_rate_evolution", "displacement_gain", "displacement_load_coupling", "force_crosstalk",
    "sensor_lag",
)  # fmt: skip

TIERS = ("T0", "T1", "T2")
POINT_TIERS = ("A1", "B1")  #: T1 of wires at other angles and of balls on flats.
LINE_TIERS = ("L1",)  #: Those of line contacts.
OTHERS = "T3"  #: Simulators by others, of wires and of line contacts.


@dataclass(frozen=True, eq=False)
class MadeRecord:
    """A record, the nuisances that it was made with, and what its effect changes: figures over one test's scatter.
    weaker_in_scatter: of two effects, see `weaker_of`; None where it is unknown. Both belong into the key.
    """

    record: AnyRecord
    nuisances: Nuisances
    differences: Mapping[str, float]
    weaker_in_scatter: float | None = None

    @property
    def gap_in_scatter(self) -> float:
        """The largest difference of a figure."""
        return max(self.differences.values(), default=0.0)


class Generator(Protocol):
    """A forward model that makes records of cases."""

    @property
    def tier(self) -> str:
        """Its name among the tiers of docs/blind.md, as T0 or L1."""
        ...

    @property
    def description(self) -> str:
        """What the manifest says about the model; nothing that distinguishes one case from another."""
        ...

    @property
    def library(self) -> Sequence[str]:
        """Effects of the contract that the model can make."""
        ...

    @property
    def outside(self) -> Sequence[str]:
        """Effects of no library that the model can make."""
        ...

    def nominals(self, number: int, random: np.random.Generator) -> Sequence[Nominal]:
        """So many nominal tests, drawn."""
        ...

    def make(self, case: Case) -> MadeRecord:
        """The record of a case; the same for the same case."""
        ...


def weaker_of(
    effects: Sequence[TrueEffect],
    over_scatter: Callable[[Sequence[TrueEffect]], Array],
    together: Array,
    size: Callable[[Array], float] = lambda changes: float(np.abs(changes).max()),
) -> float:
    """Size of what the weaker of two effects changes beyond what the other one does with its numbers fitted again, by
    least squares and linear about the true ones; 0 unless there are two.

    over_scatter: figures (n,) under effects, in scatters of a test. together: those under both.
    """
    found = []
    for alone in effects if len(effects) == 2 else ():
        base = over_scatter((alone,))
        changed = [{**alone.parameters, name: 1.05 * own} for name, own in alone.parameters.items()]
        slopes = np.stack([over_scatter((replace(alone, parameters=one),)) - base for one in changed], axis=1)
        fitted = np.linalg.lstsq(slopes, together - base, rcond=1e-3)[0]
        found.append(size(together - base - slopes @ fitted))
    return round(min(found, default=0.0), 3)
