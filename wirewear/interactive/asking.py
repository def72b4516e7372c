"""What people ask of a measured test, of crossed wires and of a line contact alike."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

from wirewear.interactive.bars import watched

if TYPE_CHECKING:
    from wirewear.diagnosis import Diagnosed
    from wirewear.fitting import FittedTest
    from wirewear.line_records import LineRecord
    from wirewear.planar.tables import PlanarStudy
    from wirewear.records import ExperimentRecord
    from wirewear.study import Study


class Asked:
    """A record that fits and diagnoses itself."""

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
            cast("ExperimentRecord | LineRecord", self),
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
            cast("ExperimentRecord | LineRecord", self),
            model=model,
            left_out=without,
            observer_of=lambda label: watched(label, shown=progress),
        )
