"""Commands on studies: run, refine, mesh, show results, verify the program."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from wirewear.cli.group import cli, default_output, most_memory
from wirewear.cli.study_kinds import load_any_study
from wirewear.errors import ResultError, StudyError
from wirewear.planar import PlanarStudy
from wirewear.planar.rig_stiffness import RigStiffnessStudy
from wirewear.study import FIDELITIES, Study, load_study


@cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=click.Path(path_type=Path))
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option("--variant", metavar="NAME", help="Run this variant of the study only.")
@click.option(
    "--output", metavar="DIR", type=click.Path(path_type=Path), help="Result folder.  [default: runs/<study>]"
)
@click.option("--resume", is_flag=True, help="Continue an interrupted run where its last checkpoint stands.")
@click.option("--jobs", type=click.IntRange(1), help="Variants to run side by side.  [default: one a core]")
@most_memory
def run(
    study_path: Path, fidelity: str, variant: str | None, output: Path | None, resume: bool, jobs: int | None
) -> None:
    """Simulate a study, or each of its variants."""
    folder = output or default_output(study_path)
    match study := load_any_study(study_path):
        case Study():
            chosen = study if variant is None else study.variant(variant)
            _run_wires(chosen, fidelity, folder, resume=resume, jobs=jobs or os.cpu_count() or 1)
        case PlanarStudy():
            _refuse(variant is not None, f"--variant does not apply to {study_path}: planar studies have no variants.")
            _run_planar(study, fidelity, folder, resume=resume)
        case RigStiffnessStudy():
            _refuse(variant is not None, f"--variant does not apply to {study_path}: planar studies have no variants.")
            _refuse(resume, f"--resume does not apply to {study_path}: a rig stiffness study writes no checkpoints.")
            _run_rig_stiffness(study, fidelity, folder)


def _refuse(given: bool, sentence: str) -> None:
    if given:
        raise StudyError(sentence)


def _run_wires(study: Study, fidelity: str, output: Path, *, resume: bool, jobs: int) -> None:
    from rich.console import Console

    from wirewear.results.summary import summary
    from wirewear.results.vtk import FOLDER_NAME, write_time_series
    from wirewear.simulation import ProgressBar, run_study

    results = run_study(study, fidelity=fidelity, output=output, resume=resume, observer_of=ProgressBar, jobs=jobs)
    Console().print(summary(results))
    for result in results:
        if result.path is not None:
            write_time_series(result, result.path.parent / FOLDER_NAME)


def _run_planar(study: PlanarStudy, fidelity: str, output: Path, *, resume: bool) -> None:
    from rich.console import Console

    from wirewear.planar import run_planar_study
    from wirewear.planar.summary import planar_summary
    from wirewear.simulation import ProgressBar

    with ProgressBar(study.name) as bar:
        result = run_planar_study(study, fidelity=fidelity, output=output, resume=resume, observer=bar)
    Console().print(planar_summary(result))
    click.echo(f"results and pictures are in {output}")


def _run_rig_stiffness(study: RigStiffnessStudy, fidelity: str, output: Path) -> None:
    from wirewear.planar.rig_stiffness import run_rig_stiffness_study
    from wirewear.planar.rig_stiffness.summary import rig_stiffness_summary
    from wirewear.study_script import wide_console

    with _progress_of(study.name) as progress:
        result = run_rig_stiffness_study(study, fidelity=fidelity, output=output, progress=progress)
    # The tables need this much also where no terminal states its width.
    wide_console(110).print(rig_stiffness_summary(result))
    click.echo(f"results and pictures are in {output}")


@contextmanager
def _progress_of(name: str) -> Iterator[Callable[[float, str], None]]:
    """A bar on standard error; what is given takes the share that is done, and what is going on."""
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(escape(name), total=1.0)
        yield lambda share, text: bar.update(task, completed=share, description=escape(f"{name}: {text}"))


@cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=click.Path(path_type=Path))
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option("--variant", metavar="NAME", help="The variant of the study to refine, if it has variants.")
@click.option(
    "--output", metavar="DIR", type=click.Path(path_type=Path), help="Result folder.  [default: runs/<study>/converge]"
)
@click.option("--jobs", type=click.IntRange(1), help="Runs side by side.  [default: one a core]")
@most_memory
def converge(study_path: Path, fidelity: str, variant: str | None, output: Path | None, jobs: int | None) -> None:
    """Run a study again with mesh, positions and cycle jumps refined, each by two factors, and print the limits.

    Runs that are complete are not repeated; the table is written to convergence.csv too.
    """
    study = load_study(study_path)
    if variant is not None:
        study = study.variant(variant)

    from wirewear.simulation import ProgressBar, convergence_table, write_convergence
    from wirewear.simulation import converge as run_refined
    from wirewear.study_script import wide_console

    folder = output or default_output(study_path) / "converge"
    rows = run_refined(
        study, fidelity=fidelity, output=folder, observer_of=ProgressBar, jobs=jobs or os.cpu_count() or 1
    )
    written = write_convergence(folder, rows)
    wide_console(150).print(convergence_table(rows))
    click.echo(f"the table is in {written}")


@cli.command()
@click.argument("result_path", metavar="RESULT", type=click.Path(path_type=Path))
@click.option("--output", metavar="DIR", type=click.Path(path_type=Path), help="Picture folder.  [default: beside it]")
def show(result_path: Path, output: Path | None) -> None:
    """Draw the pictures of a result: a file, or the folder of a run."""
    from wirewear.pictures import show as draw

    for picture in draw(result_path, output):
        click.echo(picture)


@cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=click.Path(path_type=Path))
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option(
    "--output", metavar="DIR", type=click.Path(path_type=Path), help="Mesh folder.  [default: runs/<study>/mesh]"
)
@most_memory
def mesh(study_path: Path, fidelity: str, output: Path | None) -> None:
    """Mesh both wires of a study, write them as VTU files and draw them."""
    from wirewear.simulation import write_meshes

    folder = output or default_output(study_path) / "mesh"
    for path in write_meshes(load_study(study_path), fidelity, folder):
        click.echo(path)


@cli.command()
@click.option("--quick", is_flag=True, help="Coarse meshes and wider tolerances.")
@click.option(
    "--json",
    "json_path",
    metavar="FILE",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Write the table there too.",
)
@click.pass_context
def verify(context: click.Context, quick: bool, json_path: Path | None) -> None:
    """Solve the reference problems and compare with closed forms; exit code 1 if any check fails."""
    from rich.console import Console
    from rich.progress import Progress

    from wirewear.study_script import wide_console
    from wirewear.verification import FULL, QUICK, table, write_json
    from wirewear.verification import verify as solve

    if json_path is not None and not json_path.parent.is_dir():
        raise ResultError(f"cannot write '{json_path}': the folder '{json_path.parent}' does not exist")
    level = QUICK if quick else FULL
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("", total=1.0)

        def show_stage(title: str, done: int, of: int) -> None:
            progress.update(task, description=title, completed=done / of)

        rows = solve(level, show_stage)
    wide_console(132).print(table(rows))
    if json_path is not None:
        write_json(json_path, level.name, rows)
    if not all(row.passed for row in rows):
        context.exit(1)
