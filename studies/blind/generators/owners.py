"""What owners of rigs know of the scatter between their tests: records that state it, in a share of a batch.

An owner has it from earlier tests on fresh specimens, so that what is stated is an estimate of what the record has.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from studies.blind.generators.cases import Case
from studies.blind.generators.generator import Generator, MadeRecord
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import DISPLACEMENT_ZERO, FORCE_ZERO, Nuisances
from wirewear.records.tables import StatedScatter

#: Earlier tests that an owner has a standard deviation from: of n tests it is off as the root of χ² of n − 1 is.
EARLIER_TESTS = 10

#: A stream of random numbers of its own, so that records which state nothing are the same whatever the share.
_STREAM = 2


@dataclass(frozen=True)
class OwnersWhoKnow:
    """A forward model of wires whose records state the scatter between tests in a share of the cases."""

    model: Generator
    share: float

    @property
    def tier(self) -> str:
        return self.model.tier

    @property
    def description(self) -> str:
        return f"{self.model.description}, the scatter between tests stated in {self.share:.0%} of the records"

    @property
    def library(self) -> Sequence[str]:
        return self.model.library

    @property
    def outside(self) -> Sequence[str]:
        return self.model.outside

    def nominals(self, number: int, random: np.random.Generator) -> Sequence[Nominal]:
        return self.model.nominals(number, random)

    def make(self, case: Case) -> MadeRecord:
        """The record of a case. Raises RunError as the model's does."""
        made, random = self.model.make(case), np.random.default_rng((case.seed, _STREAM))
        if random.random() >= self.share or made.record.tables.length_mm is not None:
            return made
        tables = made.record.tables.model_copy(update={"scatter": estimated(made.nuisances, random)})
        return replace(made, record=replace(made.record, tables=tables))


def estimated(nuisances: Nuisances, random: np.random.Generator) -> StatedScatter:
    """The scatter of a record as its owner knows it from earlier tests, to three digits."""
    known = {
        "friction": nuisances.scatter.friction,
        "normal_load": nuisances.scatter.load,
        "wear": nuisances.scatter.wear,
        "force_zero_N": FORCE_ZERO * nuisances.force_noise_N,
        "displacement_zero_um": DISPLACEMENT_ZERO * nuisances.displacement_noise_um,
    }
    off = np.sqrt(random.chisquare(EARLIER_TESTS - 1, len(known)) / (EARLIER_TESTS - 1))
    stated = {name: float(f"{value * one:.3g}") for (name, value), one in zip(known.items(), off, strict=True)}
    return StatedScatter.model_validate(stated)
