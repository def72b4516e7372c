"""A record to work with, of any kind of contact: one that checks, compares, fits and diagnoses itself."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from wirewear.base import notebook
from wirewear.base.quantity import counted
from wirewear.faces.running import watched
from wirewear.records import AnyRecord, ExperimentRecord, RecordReport, check_record
from wirewear.records import read_record as read_plain

if TYPE_CHECKING:
    from wirewear.diagnosis import Diagnosed
    from wirewear.fitting import FittedTest
    from wirewear.planar.tables import PlanarStudy
    from wirewear.results import RunResult
    from wirewear.study import Study
    from wirewear.views.comparison import RecordComparison


@dataclass(frozen=True, eq=False, repr=False)
class Record(ExperimentRecord[Any, Any]):
    """An experiment record with what people ask of it."""

    @classmethod
    def of(cls, record: AnyRecord) -> Self:
        """That record."""
        return cls(**{field.name: getattr(record, field.name) for field in fields(record)})

    def __repr__(self) -> str:
        return (
            f"<{type(self).__name__} {self.name!r}: {len(self.repeats)} repeats, {len(self.loops)} loops at "
            f"{len(self.cycles)} cycles, {len(self.scars)} {self.tables.worn.name}s>"
        )

    def _repr_html_(self) -> str:
        cycles = ", ".join(map(counted, self.cycles[:12])) + (" …" if len(self.cycles) > 12 else "")
        loops = f"{len(self.loops)} at the cycles {cycles}" if self.loops else "none"
        rows = {"repeats": str(len(self.repeats)), "loops": loops, f"{self.tables.worn.name}s": str(len(self.scars))}
        return notebook.table(f"record “{self.name}”", rows, note=" ".join(self.notes))

    def check(self) -> RecordReport:
        """What is wrong with the record, and what it can and cannot support."""
        return check_record(self)

    def compare(self, run: RunResult) -> RecordComparison:
        """The record beside a simulation: loops, evolution, worn surfaces, and what differs.

        Raises:
            RecordError: they have nothing in common, or nothing can be concluded from the record.
        """
        from wirewear.views.comparison import compare

        return compare(run, self)

    def fit(
        self,
        *,
        wear_coefficient_mm3_per_J: float | None = None,
        worn_volume_mm3: float | None = None,
        progress: bool = True,
    ) -> FittedTest:
        """Friction, rig stiffness, play and wear of the test, each with its interval, and a study that has them.

        Loops do not tell the worn volume: where no scars were measured, give the wear coefficient of both bodies
        together, or the volume that both lost in a test.

        Raises:
            RecordError: the record is unsound, none of its loops slides as a whole, or none tells its energy.
            StudyError, SolverError: the nominal run of the fast model fails.
        """
        from wirewear.fitting import GivenWear, fit_record

        given = GivenWear(wear_coefficient_mm3_per_J, worn_volume_mm3)
        return fit_record(
            self,
            given=None if given == GivenWear() else given,
            observer_of=lambda label: watched(label, shown=progress),
        )

    def diagnose(
        self,
        *,
        model: Study | PlanarStudy | None = None,
        further: Sequence[AnyRecord] = (),
        without: Sequence[str] = (),
        progress: bool = True,
    ) -> Diagnosed:
        """Why the record and its model disagree; without a model, the one that the record states.

        `further` are other measurements of the same rig, which update the answer.

        Raises:
            RecordError: the record states too little, has nothing to be diagnosed, or the model is of another test.
            StudyError, SolverError: the model cannot be run, or there is no effect of a name in `without`.
        """
        from wirewear.diagnosis import diagnose

        return diagnose(
            self,
            model=model,
            further=further,
            left_out=without,
            observer_of=lambda label: watched(label, shown=progress),
        )


def read_record(folder: str | Path) -> Record:
    """Read and check a record of any kind of contact. What can be coped with is kept and told in `notes`.

    Raises:
        RecordError: the record cannot be read; one sentence with file, line and column.
    """
    return Record.of(read_plain(folder))
