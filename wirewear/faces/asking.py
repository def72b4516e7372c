"""What people ask of a measured test, of crossed wires and of a line contact alike."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import fields
from typing import TYPE_CHECKING, Generic, Self, TypeVar, cast

from wirewear.base import notebook
from wirewear.faces.bars import watched
from wirewear.records import ExperimentRecord
from wirewear.records.line_values import LineRecord

if TYPE_CHECKING:
    from wirewear.diagnosis import Diagnosed
    from wirewear.fitting import FittedTest
    from wirewear.planar.tables import PlanarStudy
    from wirewear.study import Study

Plain = TypeVar("Plain", bound=ExperimentRecord | LineRecord)


class Asked(ABC, Generic[Plain]):
    """A record that shows, fits and diagnoses itself; of a plain one it has all fields."""

    @classmethod
    def of(cls, record: Plain) -> Self:
        """That record."""
        return cls(**{field.name: getattr(record, field.name) for field in fields(record)})

    @abstractmethod
    def _scars_told(self) -> tuple[str, int]:
        """What is measured of scars, and how much of it there is."""

    @abstractmethod
    def _loops_told(self) -> str:
        """How many loops there are, and at which cycles."""

    @property
    def _plain(self) -> ExperimentRecord | LineRecord:
        return cast("ExperimentRecord | LineRecord", self)

    def __repr__(self) -> str:
        own, (what, count) = self._plain, self._scars_told()
        return (
            f"<{type(self).__name__} {own.name!r}: {len(own.repeats)} repeats, {len(own.loops)} loops at "
            f"{len(own.cycles)} cycles, {count} {what}>"
        )

    def _repr_html_(self) -> str:
        own, (what, count) = self._plain, self._scars_told()
        rows = {"repeats": str(len(own.repeats)), "loops": self._loops_told(), what: str(count)}
        return notebook.table(f"record “{own.name}”", rows, note=" ".join(own.notes))

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
            self._plain,
            given=None if given == GivenWear() else given,
            observer_of=lambda label: watched(label, shown=progress),
        )

    def diagnose(
        self, *, model: Study | PlanarStudy | None = None, without: Sequence[str] = (), progress: bool = True
    ) -> Diagnosed:
        """Why the record and its model disagree; without a model, the one that the record states.

        Raises:
            RecordError: the record states too little, has nothing to be diagnosed, or the model is of another test.
            StudyError, SolverError: the model cannot be run, or there is no effect of a name in `without`.
        """
        from wirewear.diagnosis import diagnose

        return diagnose(
            self._plain,
            model=model,
            left_out=without,
            observer_of=lambda label: watched(label, shown=progress),
        )
