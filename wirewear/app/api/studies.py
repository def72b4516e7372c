"""Studies and records to work with from Python: loaded, run, checked, compared, fitted, diagnosed; bars of progress."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from html import escape
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from wirewear.app.api.run import Run
from wirewear.base.errors import StudyError, counted
from wirewear.base.files import parsed_toml
from wirewear.base.notebook import notebook_table
from wirewear.kinds import any_study, load_any_study
from wirewear.records import AnyRecord, ExperimentRecord, RecordReport, check_record
from wirewear.records import read_record as read_plain
from wirewear.simulation import Moment, Observer, ProgressBar, run_study, simulate
from wirewear.test.any_study import alone

if TYPE_CHECKING:
    from wirewear.comparison.comparison import RecordComparison
    from wirewear.diagnosis import Diagnosed
    from wirewear.diagnosis.fit import FittedTest
    from wirewear.results import RunResult
    from wirewear.test import AnyStudy

LEAST_PAUSE_s = 0.3  #: Seconds between two drawings of the bar.


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
        return notebook_table(f"record “{self.name}”", rows, note=" ".join(self.notes))

    def check(self) -> RecordReport:
        """What is wrong with the record, and what it can and cannot support."""
        return check_record(self)

    def compare(self, run: RunResult) -> RecordComparison:
        """The record beside a simulation: loops, evolution, worn surfaces, and what differs.
        Raises RecordError if they have nothing in common, or nothing can be concluded from the record.
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
        """Friction, rig stiffness, play and wear of the test, each with its interval, and a study that has them.

        Loops do not determine the worn volume: where no scars were measured, give the wear coefficient of both bodies
        together, or the volume that both lost in a test.
        Raises RecordError if the record is unsound, none of its loops slides as a whole, or none gives its energy;
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
        model: AnyStudy[Any] | None = None,
        further: Sequence[AnyRecord] = (),
        without: Sequence[str] = (),
        progress: bool = True,
    ) -> Diagnosed:
        """Why the record and its model disagree; without a model, the one that the record states.

        `further` are other measurements of the same rig, which update the answer.
        Raises RecordError if the record states too little, has nothing to be diagnosed, or the model is of another
        test; StudyError or SolverError if the model cannot be run, or there is no effect of a name in `without`.
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
    """Read and check a record of any kind of contact. What can be coped with is kept and reported in `notes`.
    Raises RecordError, in one sentence with file, line and column, if the record cannot be read.
    """
    return Record.of(read_plain(folder))


def in_notebook() -> bool:
    """Whether the program runs in a notebook's kernel."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return type(shell).__name__ == "ZMQInteractiveShell"


class NotebookBar(Observer):
    """A bar that a notebook draws again in its place. Use as a context manager."""

    def __init__(self, label: str) -> None:
        """Prepare a bar with a label; it appears when it is entered."""
        self._label, self._notes = label, list[str]()
        self._handle: Any = None
        self._drawn = -LEAST_PAUSE_s
        self._last = (0.0, "")

    def __enter__(self) -> NotebookBar:
        from IPython.display import HTML, display

        self._handle = display(HTML(self.html()), display_id=True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._draw()

    def stage(self, text: str) -> None:
        """Show what is being prepared."""
        self._last = (0.0, text)
        self._draw()

    def moved(self, moment: Moment) -> None:
        """Show cycles, energy and depth, if the last drawing is long enough ago."""
        depth = f"{moment.max_depth_um:.2f} µm deep"
        self._last = (
            moment.fraction,
            f"cycle {counted(moment.cycle)} of {counted(moment.cycles)}, {moment.energy_J:.3g} J, {depth}",
        )
        if time.monotonic() - self._drawn >= LEAST_PAUSE_s:
            self._draw()

    def logged(self, result: object) -> None:
        """Nothing more to show."""

    def note(self, sentence: str) -> None:
        """Write the sentence below the bar."""
        self._notes.append(sentence)
        self._draw()

    def html(self) -> str:
        """The bar as it stands."""
        share, state = self._last
        notes = "".join(f"<br><small>{escape(note)}</small>" for note in self._notes)
        return f"{escape(self._label)} <progress value='{share:.4f}' max='1'></progress> {escape(state)}{notes}"

    def _draw(self) -> None:
        from IPython.display import HTML

        self._drawn = time.monotonic()
        if self._handle is not None:
            self._handle.update(HTML(self.html()))


@contextmanager
def watched(label: str, *, shown: bool) -> Iterator[Observer]:
    """A bar for a run, where it is to be shown: of the notebook, or of the terminal."""
    if not shown:
        yield Observer()
    elif in_notebook():
        with NotebookBar(label) as bar:
            yield bar
    else:
        with ProgressBar(label) as terminal:
            yield terminal


def load(source: str | Path) -> Any:
    """Read a study of any kind of contact from a file, or from text that is one: TOML of more than one line.
    Raises StudyError, in one sentence, if there is no such file, or it is no valid study.
    """
    if isinstance(source, str) and "\n" in source.strip():
        return any_study(parsed_toml(source, "the text given", StudyError), "the text given")
    return load_any_study(source)


def run(
    study: AnyStudy[Any],
    *,
    fidelity: str = "standard",
    output: str | Path | None = None,
    resume: bool = False,
    progress: bool = True,
) -> Run:
    """Simulate a study without variants, or one variant of it.

    Without `output` no file is written; with it, the folder is as `wirewear run` leaves it, and `resume` goes on where
    an interrupted run stopped.
    Raises StudyError if the study has variants, of which one must be chosen, or cannot be discretised or afforded;
    RunError or ResultError if the folder holds another run, or cannot be written; SolverError if the contact did not
    converge, or left the fine patch.
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
            study, fidelity=fidelity, output=Path(output), resume=resume, observer_of=lambda _: _left_open(observer)
        )
    return Run.of(results[0])


def run_variants(
    study: AnyStudy[Any], *, fidelity: str = "standard", output: str | Path | None = None, progress: bool = True
) -> dict[str, Run]:
    """Simulate all variants of a study, by their names; with `output`, each in a folder of its own.
    Raises StudyError if the study has no variants, and whatever `run` raises.
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


@contextmanager
def _left_open(observer: Observer) -> Iterator[Observer]:
    """For a run that closes what it is given; its owner closes it."""
    yield observer
