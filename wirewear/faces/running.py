"""Studies loaded and run from Python: one or its variants, in memory or into a folder, with a bar of their progress."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from wirewear.base.errors import StudyError
from wirewear.faces.bars import watched
from wirewear.faces.looking import Run
from wirewear.simulation import Observer, run_study, simulate
from wirewear.study import Study, load_study, parse_study


def load(source: str | Path) -> Study:
    """Read a study from a file, or from text that is one: TOML of more than one line.

    Raises:
        StudyError: there is no such file, or it is no valid study; the message is one sentence.
    """
    if isinstance(source, str) and "\n" in source.strip():
        return parse_study(source, "the text given")
    return load_study(source)


def run(
    study: Study,
    *,
    fidelity: str = "standard",
    output: str | Path | None = None,
    resume: bool = False,
    progress: bool = True,
) -> Run:
    """Simulate a study without variants, or one variant of it.

    Without `output` no file is written; with it, the folder is as `wirewear run` leaves it, and `resume` goes on where
    an interrupted run stopped.

    Raises:
        StudyError: the study has variants, of which one must be chosen; or it cannot be discretised or afforded.
        RunError, ResultError: the folder holds another run, or cannot be written.
        SolverError: the contact did not converge, or left the fine patch.
    """
    study = study.alone('run one, as in run(study.variant("{first}")), or all with run_variants(study)')
    label = study.variant_name or study.name
    if output is None:
        if resume:
            raise StudyError("resume = True goes on with a run in a folder: name it as output.")
        with watched(label, shown=progress) as observer:
            return Run.of(simulate(study, fidelity=fidelity, observer=observer))
    with watched(label, shown=progress) as observer:
        results = run_study(
            study, fidelity=fidelity, output=Path(output), resume=resume, observer_of=lambda _: _lent(observer)
        )
    return Run.of(results[0])


def run_variants(
    study: Study, *, fidelity: str = "standard", output: str | Path | None = None, progress: bool = True
) -> dict[str, Run]:
    """Simulate all variants of a study, by their names; with `output`, each in a folder of its own.

    Raises:
        StudyError: the study has no variants; and as `run`.
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
def _lent(observer: Observer) -> Iterator[Observer]:
    """For a run that closes what it is given; its owner closes it."""
    yield observer
