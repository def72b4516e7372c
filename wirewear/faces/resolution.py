"""Commands that look at resolution: refine a study, mesh its bodies, verify the program."""

import os
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import click

from wirewear.faces.group import OutputFile, OutputFolder, cli, default_output, most_memory, scheduler_option
from wirewear.study import FIDELITIES


@cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=click.Path(path_type=Path))
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option("--variant", metavar="NAME", help="The variant of the study to refine, if it has variants.")
@click.option("--output", metavar="DIR", type=OutputFolder(), help="Result folder.  [default: runs/<study>/converge]")
@click.option("--jobs", type=click.IntRange(1), help="Runs side by side.  [default: one a core]")
@scheduler_option
@most_memory
def converge(
    study_path: Path, fidelity: str, variant: str | None, output: Path | None, jobs: int | None, scheduler: str | None
) -> None:
    """Run a study again with mesh, positions and cycle jumps refined, each by two factors, and print the limits.

    Runs that are complete are not repeated; the table is written to convergence.csv too.
    """
    from wirewear.base.cluster import engine_of
    from wirewear.faces.study_script import wide_console
    from wirewear.kinds import kind_of, load_any_study
    from wirewear.simulation import ProgressBar, convergence_table, write_convergence
    from wirewear.simulation import converge as refine

    study = load_any_study(study_path)
    if variant is not None:
        study = study.variant(variant)
    folder = output or default_output(study_path) / "converge"
    engine = None if scheduler is None else engine_of(scheduler=scheduler)
    asked: dict[str, Any] = {
        "fidelity": fidelity,
        "output": folder if scheduler is None else folder.resolve(),
        "observer_of": ProgressBar,
        "jobs": jobs or os.cpu_count() or 1,
        "engine": engine,
    }
    # A scheduler that does not answer is to be told before bodies are condensed.
    with nullcontext() if engine is None else engine.held():
        rows = refine(study, kind_of(study).refined, **asked)
    written = write_convergence(folder, rows)
    wide_console(150).print(convergence_table(rows))
    click.echo(f"the table is in {written}")


@cli.command()
@click.argument("study_path", metavar="STUDY.toml", type=click.Path(path_type=Path))
@click.option("--fidelity", type=click.Choice(FIDELITIES), default="standard", show_default=True)
@click.option("--output", metavar="DIR", type=OutputFolder(), help="Mesh folder.  [default: runs/<study>/mesh]")
@most_memory
def mesh(study_path: Path, fidelity: str, output: Path | None) -> None:
    """Mesh both bodies of a study, write them as VTU files and draw them and what holds them."""
    from wirewear.base.writing import usable_folder
    from wirewear.kinds import kind_of, load_any_study

    folder = usable_folder(output or default_output(study_path) / "mesh")
    study = load_any_study(study_path)
    for path in kind_of(study).write_meshes(study, fidelity, folder):
        click.echo(path)


@cli.command()
@click.option("--quick", is_flag=True, help="Coarse meshes and wider tolerances.")
@click.option("--json", "json_path", metavar="FILE", type=OutputFile(), help="Write the table there too.")
@click.pass_context
def verify(context: click.Context, quick: bool, json_path: Path | None) -> None:
    """Solve the reference problems and compare with closed forms; exit code 1 if any check fails."""
    from wirewear.faces.study_script import progress_bar, wide_console
    from wirewear.verification import FULL, QUICK, table, write_json
    from wirewear.verification import verify as solve

    level = QUICK if quick else FULL
    with progress_bar() as progress:
        task = progress.add_task("", total=1.0)

        def show_stage(title: str, done: int, of: int) -> None:
            progress.update(task, description=title, completed=done / of)

        rows = solve(level, show_stage)
    wide_console(132).print(table(rows))
    if json_path is not None:
        write_json(json_path, level.name, rows)
    if not all(row.passed for row in rows):
        context.exit(1)
