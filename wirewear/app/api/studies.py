"""Python interface to studies and records: load, run, check, compare, fit, diagnose."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from wirewear.app.api.progress import watched
from wirewear.app.api.run import Run
from wirewear.base.errors import StudyError
from wirewear.base.files import parsed_toml
from wirewear.base.frame import notebook_table
from wirewear.base.words import counted
from wirewear.kinds import any_study, load_any_study
from wirewear.records import AnyRecord, ExperimentRecord, RecordReport, check_record
from wirewear.records import read_record as read_plain
from wirewear.simulation import run_study, simulate
from wirewear.test.any_study import alone

if TYPE_CHECKING:
    from wirewear.comparison.comparison import RecordComparison
    from wirewear.diagnosis import Diagnosed
    from wirewear.diagnosis.fit import FittedTest
    from wirewear.results import RunResult
    from wirewear.test import AnyStudy, LineStudy, Study


@dataclass(frozen=True, eq=False, repr=False)
class Record(ExperimentRecord[Any, Any]):
    """Experiment record with methods to check, compare, fit and diagnose it."""

    @classmethod
    def of(cls, record: AnyRecord) -> Self:
        """An object of this class with the same fields as a record that was read."""
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
        return notebook_table(f"record “{self.name}”", rows, note=" ".join(self.notes))

    def check(self) -> RecordReport:
        """Report on the problems of the record and on the conclusions that it supports."""
        return check_record(self)

    def compare(self, run: RunResult) -> RecordComparison:
        """Comparison with a simulation: loops, evolution, worn surfaces and their differences.

        Raises RecordError if they have nothing in common, or the record's problems forbid conclusions.
        """
        from wirewear.comparison.comparison import compare

        return compare(run, self)

    def fit(
        self,
        *,
        wear_coefficient_mm3_per_J: float | None = None,
        worn_volume_mm3: float | None = None,
        progress: bool = True,
    ) -> FittedTest:
        """Fit friction, rig stiffness, play and wear, each with its interval, and make a study with these values.

        wear_coefficient_mm3_per_J, worn_volume_mm3: coefficient of both bodies together, or the volume that both lost
        in a test, where no scars were measured, as loops do not determine it. progress: show a progress bar.
        Raises RecordError if the record is unsound, none of its loops bounds friction, or none gives its energy;
        StudyError or SolverError if the nominal run of the fast model fails.
        """
        from wirewear.diagnosis.fit import GivenWear, fit_record

        given = GivenWear(wear_coefficient_mm3_per_J, worn_volume_mm3)
        return fit_record(
            self,
            given=None if given == GivenWear() else given,
            observer_of=lambda label: watched(label, shown=progress),
        )

    def diagnose(
        self,
        *,
        model: AnyStudy | None = None,
        further: Sequence[AnyRecord] = (),
        without: Sequence[str] = (),
        progress: bool = True,
    ) -> Diagnosed:
        """Diagnose why record and model disagree; model: None for the study that the record states.

        further: other records of the same rig that update the answer. without: names of effects that are not
        considered. progress: show a progress bar.
        Raises RecordError if the record states too little, has nothing to be diagnosed, or the model is of another
        test; StudyError or SolverError if the model cannot be run, or an effect in `without` does not exist.
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
    """Read and check a record of any kind of contact; its `notes` state tolerable faults. Raises RecordError, in one
    sentence with file, line and column, if the record cannot be read.
    """
    return Record.of(read_plain(folder))


def load(source: str | Path) -> Study | LineStudy:
    """Read a study of any kind of contact from a file, or from TOML text of more than one line.

    Raises StudyError, in one sentence, if there is no such file, or it is no valid study.
    """
    if isinstance(source, str) and "\n" in source.strip():
        study: Study | LineStudy = any_study(parsed_toml(source, "the text given", StudyError), "the text given")
    else:
        study = load_any_study(source)
    return study


def run(
    study: Study | LineStudy,
    *,
    fidelity: str = "standard",
    output: str | Path | None = None,
    resume: bool = False,
    progress: bool = True,
) -> Run:
    """Simulate a study without variants, or one variant of it.

    output: folder that is filled as by `wirewear run`; None to write no file. resume: continue an interrupted run
    there. progress: show a progress bar. Raises StudyError if the study has variants, of which one must be chosen, or
    cannot be discretised or afforded; RunError or ResultError if the folder holds another run, or cannot be written;
    SolverError if the contact did not converge, or left the fine patch.
    """
    study = alone(study, 'run one, as in run(study.variant("{first}")), or all with run_variants(study)')
    label = study.variant_name or study.name
    if output is None:
        if resume:
            raise StudyError("resume = True goes on with a run in a folder: name it as output.")
        with watched(label, shown=progress) as observer:
            return Run.of(simulate(study, fidelity=fidelity, observer=observer))
    with watched(label, shown=progress) as observer:
        results = run_study(
            study, fidelity=fidelity, output=Path(output), resume=resume, observer_of=lambda _: nullcontext(observer)
        )
    return Run.of(results[0])


def run_variants(
    study: Study | LineStudy, *, fidelity: str = "standard", output: str | Path | None = None, progress: bool = True
) -> dict[str, Run]:
    """Simulate all variants of a study and return the runs by the variants' names. output: folder in which each gets a
    folder of its own; None to write no file. progress: True to show it. Raises StudyError if the study has no variants,
    and whatever `run` raises.
    """
    if not study.variant_names:
        raise StudyError(f"the study {study.name!r} has no variants: take run(study).")
    folder = None if output is None else Path(output)
    return {
        name: run(
            study.variant(name), fidelity=fidelity, output=None if folder is None else folder / name, progress=progress
        )
        for name in study.variant_names
    }
